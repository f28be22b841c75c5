//! Transducers by their construction: closed forms, uncertainties against solving again, recordings that give the device back.

use proofmass_jobs::simulate::{
    SimulateJob, SimulatedExcitation, SimulatedTransducer, TransducerConstruction,
};
use proofmass_jobs::{Gathered, Job, Sink, Store, Unwatched};
use std::f64::consts::{PI, TAU};

const VACUUM: f64 = 8.854_187_812_8e-12;

/// One device of every construction, as a file has it.
fn all() -> Vec<(&'static str, String)> {
    let beam = "beam_length_um = 300\nbeam_width_um = 60\nbeam_thickness_um = 15\nyoung_GPa = 169\ndensity_kg_per_m3 = 2330\n";
    let comb = "mass_ug = 2\nstiffness_N_per_m = 1.6\nfingers = 40\noverlap_um = 120\nthickness_um = 20\ngap_um = 2\n";
    let gauges = "mass_ug = 100\npoisson = 0.28\npiezoresistance = 120\ndamping_ratio = 0.1\nstop_um = 2\ntemperature_per_K = -1.5e-3\n";
    let piezo = "mass_g = 5\narea_mm2 = 40\nthickness_mm = 1\nleak_GOhm = 1\ncable_pF = 300\ndamping_ratio = 0.02\n";
    vec![
        ("capacitive-gap", format!("{comb}viscosity_uPa_s = 18.5\npressure_kPa = 101.325\n")),
        ("capacitive-area", format!("{comb}damping_ratio = 0.3\n")),
        (
            "capacitive-plate",
            "mass_ug = 20\nstiffness_N_per_m = 20\nlength_um = 400\nwidth_um = 400\ngap_um = 4\nviscosity_uPa_s = 18.5\npressure_kPa = 101.325\n".into(),
        ),
        (
            "capacitive-cantilever",
            format!("{beam}plate_length_um = 400\nplate_width_um = 400\nplate_thickness_um = 15\ngap_um = 5\ndamping_ratio = 0.7\n"),
        ),
        ("piezoresistive-bridge", format!("{beam}{gauges}gauge_at_um = 20\narms = \"full\"\nexcitation_V = 5\n")),
        (
            "piezoresistive-series",
            format!("{beam}{gauges}resistance_kOhm = 2\ncurrent_mA = 1\nmismatch_percent = 0.5\ndrift_per_K = 2e-3\n"),
        ),
        (
            "piezoelectric",
            format!("{piezo}cut = \"shear\"\ncharge_pC_per_N = 550\npermittivity = 1700\nmodulus_GPa = 22\nelements = 3\n"),
        ),
        (
            "piezoelectric",
            format!("{piezo}cut = \"compression\"\ncharge_pC_per_N = 370\npermittivity = 1800\nmodulus_GPa = 63\nelements = 2\n"),
        ),
        (
            "thermal",
            "cavity_mm = 1\nheater_K = 150\ngas_K = 300\nviscosity_mm2_per_s = 16\ndiffusivity_mm2_per_s = 22\nresponse = 2e-3\n\
             resistors_per_K = 2e-3\nexcitation_V = 5\nrange_m_per_s2 = 100\n"
                .into(),
        ),
        ("resonant", format!("{beam}mass_ug = 1000\nstiffness_N_per_m = 500\nlever = 2\ndamping_ratio = 0.7\nstop_um = 0.5\n")),
        ("tunnelling", "mass_ug = 30\nstiffness_N_per_m = 20\ncurrent_nA = 1.4\nbarrier_eV = 0.5\ngap_nm = 1\ndamping_ratio = 0.5\n".into()),
        (
            "shutter",
            "mass_ug = 100000\nstiffness_N_per_m = 300\npower_mW = 1\nresponsivity_A_per_W = 0.5\nwidth_um = 100\ndamping_ratio = 0.6\n".into(),
        ),
    ]
}

fn read(principle: &str, body: &str, uncertainty: &str) -> TransducerConstruction {
    let text = format!("[device]\nprinciple = \"{principle}\"\n{body}[uncertainty]\n{uncertainty}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("device.toml");
    std::fs::write(&path, text).unwrap();
    TransducerConstruction::open(&path).unwrap()
}

fn figure(device: &TransducerConstruction, name: &str) -> (f64, f64) {
    let figures = device.figures().unwrap();
    let q = figures.get(name).unwrap_or_else(|| panic!("{name}"));
    (q.value, q.standard_uncertainty)
}

fn near(found: f64, exact: f64, tolerance: f64) {
    assert!((found / exact - 1.0).abs() < tolerance, "{found} {exact}");
}

/// S = 2C₀m/(kd) of a varying gap, 2C₀m/(kl) of a varying area; c = 2Nc₁ of the films in a comb. Small cubic parts are left.
#[test]
fn known_combs() {
    let all = all();
    let gap = read(all[0].0, &all[0].1, "");
    let rest = VACUUM * 40.0 * 120e-6 * 20e-6 / 2e-6;
    let per = 2e-9 / 1.6;
    near(
        figure(&gap, "sensitivity").0,
        1e12 * 2.0 * rest * per / 2e-6,
        1e-6,
    );
    near(
        figure(&gap, "natural-frequency").0,
        (1.6f64 / 2e-9).sqrt() / TAU,
        1e-12,
    );
    // A strip 6 : 1: [1 − 0.6302/6 …].
    let c = 80.0 * 18.5e-6 * 120e-6 * 20e-6f64.powi(3) / 2e-6f64.powi(3) * (1.0 - 0.6302 / 6.0);
    near(
        figure(&gap, "damping-ratio").0,
        c / (2.0 * (1.6f64 * 2e-9).sqrt()),
        1e-3,
    );
    let area = read(all[1].0, &all[1].1, "");
    near(
        figure(&area, "sensitivity").0,
        1e12 * 2.0 * rest * per / 120e-6,
        1e-9,
    );
    // Plates that slide: c = 2Nμlt/d.
    let sliding = all[1]
        .1
        .replace("damping_ratio = 0.3", "viscosity_uPa_s = 18.5");
    let sliding = read(all[1].0, &sliding, "");
    let c = 80.0 * 18.5e-6 * 120e-6 * 20e-6 / 2e-6;
    near(
        figure(&sliding, "damping-ratio").0,
        c / (2.0 * (1.6f64 * 2e-9).sqrt()),
        1e-9,
    );
}

/// A square plate: c = 0.4217 μ a⁴/d³. A plate on a cantilever bends it as its closed form says, and turns.
#[test]
fn known_plates() {
    let all = all();
    let plate = read(all[2].0, &all[2].1, "");
    let c = 0.421_7 * 18.5e-6 * 400e-6f64.powi(4) / 4e-6f64.powi(3);
    near(
        figure(&plate, "damping-ratio").0,
        c / (2.0 * (20.0f64 * 20e-9).sqrt()),
        1e-4,
    );
    let lever = read(all[3].0, &all[3].1, "");
    let ei = 169e9 * 60e-6 * 15e-6f64.powi(3) / 12.0;
    let (l, s) = (300e-6f64, 200e-6f64);
    let k = ei / (l.powi(3) / 3.0 + s * l * l + s * s * l);
    let m = 2330.0 * (400e-6 * 400e-6 * 15e-6 + 33.0 / 140.0 * 300e-6 * 60e-6 * 15e-6);
    near(
        figure(&lever, "natural-frequency").0,
        (k / m).sqrt() / TAU,
        1e-9,
    );
    // To first order a tilt about the centre changes nothing: S = C₀m/(kd).
    let rest = VACUUM * 400e-6 * 400e-6 / 5e-6;
    near(
        figure(&lever, "sensitivity").0,
        1e12 * rest * m / (k * 5e-6),
        1e-5,
    );
}

/// Strain at the gauge, gauge factor 1 + 2ν + π, full bridge U·Kε; four of five in series 4·I·R·K·ε.
#[test]
fn known_gauges() {
    let all = all();
    let bridge = read(all[4].0, &all[4].1, "");
    let ei = 169e9 * 60e-6 * 15e-6f64.powi(3) / 12.0;
    let beam = 2330.0 * 300e-6 * 60e-6 * 15e-6;
    let m = 100e-9 + 33.0 / 140.0 * beam;
    // ε = M h/2EI with M = F (L − s).
    let strain = m * 280e-6 * 7.5e-6 / ei;
    near(
        figure(&bridge, "sensitivity").0,
        5.0 * 121.56 * strain,
        1e-9,
    );
    near(
        figure(&bridge, "natural-frequency").0,
        (3.0 * ei / 300e-6f64.powi(3) / m).sqrt() / TAU,
        1e-9,
    );
    let series = read(all[5].0, &all[5].1, "");
    let m = 100e-9 + 4.0 * 13.0 / 35.0 * beam;
    // A quarter of the force on a guided beam: M = F L/2 at its end.
    let strain = 0.25 * m * 150e-6 * 7.5e-6 / ei;
    near(
        figure(&series, "sensitivity").0,
        2.0 * 4.0 * 121.56 * strain,
        1e-9,
    );
}

/// q = dF over all that holds charge; the leak makes a corner of 1/(2πRC).
#[test]
fn known_piezoelectric_elements() {
    let all = all();
    let (a, t) = (40e-6, 1e-3);
    for (index, n, d, eps, modulus) in [
        (6, 3.0, 550e-12, 1700.0, 22e9),
        (7, 2.0, 370e-12, 1800.0, 63e9),
    ] {
        let device = read(all[index].0, &all[index].1, "");
        let shear = index == 6;
        let capacitance = n * VACUUM * eps * a / t + 300e-12;
        let charge = if shear { d } else { n * d };
        let k = modulus * a / t * if shear { n } else { 1.0 / n };
        near(
            figure(&device, "sensitivity").0,
            charge * 5e-3 / capacitance,
            1e-9,
        );
        near(
            figure(&device, "lower-corner").0,
            1.0 / (TAU * 1e9 * capacitance),
            1e-9,
        );
        near(
            figure(&device, "natural-frequency").0,
            (k / 5e-3f64).sqrt() / TAU,
            1e-9,
        );
    }
}

#[test]
fn known_thermal_resonant_and_light() {
    let all = all();
    let thermal = read(all[8].0, &all[8].1, "");
    let grashof = 150.0 / 300.0 * 1e-9 / (16e-6f64 * 16e-6);
    near(
        figure(&thermal, "sensitivity").0,
        5.0 / 4.0 * 2e-3 * 2e-3 * grashof * 150.0,
        1e-9,
    );
    near(
        figure(&thermal, "upper-corner").0,
        PI / 2.0 * 22e-6 / 1e-6,
        1e-9,
    );
    let resonant = read(all[9].0, &all[9].1, "");
    let ei = 169e9 * 60e-6 * 15e-6f64.powi(3) / 12.0;
    let f0 = 4.730_040_745f64.powi(2) / (TAU * 9e-8) * (ei / (2330.0 * 60e-6 * 15e-6)).sqrt();
    // f₀ √(1 + 0.97 N/N_c) with N_c = 4π²EI/L², N = 2 m a.
    let slope = 0.5 * f0 * 0.97 * 2.0 * 1e-6 * 9e-8 / (4.0 * PI * PI * ei);
    near(figure(&resonant, "sensitivity").0, slope, 1e-6);
    let shutter = read(all[11].0, &all[11].1, "");
    // In mA.
    near(
        figure(&shutter, "sensitivity").0,
        0.5 * 1e-4 / 300.0 / 100e-6,
        1e-9,
    );
}

/// Uncertainties against what a parameter that is changed by u makes of the figures.
#[test]
fn crosscheck_uncertainty_by_changing_a_parameter() {
    for (principle, body) in all() {
        let (key, value) = body
            .lines()
            .find_map(|l| {
                let (key, value) = l.split_once(" = ")?;
                Some((key.to_owned(), value.parse::<f64>().ok()?))
            })
            .unwrap();
        let u = 1e-3 * value;
        let device = read(principle, &body, &format!("{key} = {u}"));
        let other = body.replacen(
            &format!(
                "{key} = {}",
                body.lines()
                    .find(|l| l.starts_with(&key))
                    .unwrap()
                    .split_once(" = ")
                    .unwrap()
                    .1
            ),
            &format!("{key} = {}", value + u),
            1,
        );
        let other = read(principle, &other, "");
        for name in ["sensitivity", "natural-frequency", "damping-ratio"] {
            let ((at, u), (changed, _)) = (figure(&device, name), figure(&other, name));
            // Second order: a share of 10⁻³ of the change, times the powers of a gap. Beside it the digits that a small change of a large
            // frequency leaves.
            assert!(
                ((changed - at).abs() - u).abs() < 5e-3 * u + 1e-7 * at.abs(),
                "{principle} {name} by {key}: {at} {changed} {u}"
            );
        }
    }
}

/// A recording gives the device back: a step settles at S·a, and the recorded transfer is that of the table.
#[test]
fn law_recordings_show_the_device() {
    for (principle, body) in all() {
        let device = read(principle, &body, "");
        let built = device.build().unwrap();
        let natural = built.mass.natural_frequency();
        let mut job = SimulatedTransducer::default();
        job.construction = Some(device.clone());
        job.motion = SimulatedExcitation::Step;
        job.noise = 0.0;
        job.bits = 0;
        let height = 1e-3 * built.limits().acceleration;
        job.level = Some(height);
        let zeta = built.mass.damping_ratio();
        let settle = 20.0 / (natural * zeta.min(1.0 / zeta))
            + built.principle.low_pass().map_or(0.0, |f| 4.0 / f);
        job.duration = Some(settle);
        job.rate = Some(20_000.0 / settle);
        let files = Gathered::default();
        let outcome = SimulateJob::Transducer(job)
            .evaluate(&(&files as &dyn Sink), &Unwatched)
            .unwrap();
        let truth = outcome.truth();
        let figures = device.figures().unwrap();
        let s = figures.get("sensitivity").unwrap().value;
        near(truth["sensitivity"].as_f64().unwrap(), s, 1e-9);
        assert_eq!(truth["samples_beyond_range"], 0, "{principle}");
        assert_eq!(truth["model"][0]["name"], "sensitivity");
        let recording = files.into_memory();
        let text_of = |name: &str| {
            let source = recording.open(name).unwrap();
            String::from_utf8(source.into_bytes(1 << 30).unwrap().0.to_vec()).unwrap()
        };
        let text = text_of("recording.csv");
        let last = |line: &str| line.rsplit(',').next().unwrap().parse::<f64>().unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let (rest, end) = (last(lines[1]), last(lines[lines.len() - 1]));
        if built.principle.high_pass().is_none() {
            // Over a thousandth of the range the tunnel current bends most: by half of ln I/I₀ = 0.007.
            near(end - rest, s * height, 0.005);
        }
        let table = text_of("transfer.csv");
        assert!(table.starts_with("frequency_Hz,sensitivity_"), "{table}");
        assert!(
            table.lines().count() > 5 && !table.contains("NaN") && !table.contains("inf"),
            "{principle}: {table}"
        );
    }
}

#[test]
fn refuses_constructions_that_make_no_device() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("device.toml");
    let all = all();
    let said = |principle: &str, body: &str, uncertainty: &str| {
        let text =
            format!("[device]\nprinciple = \"{principle}\"\n{body}[uncertainty]\n{uncertainty}");
        std::fs::write(&path, text).unwrap();
        let error = TransducerConstruction::open(&path).unwrap_err();
        format!("{error} {error:?}")
    };
    let (comb, body) = (&all[0].0, &all[0].1);
    for (body, uncertainty, word) in [
        (body.replace("gap_um = 2", "gap_um = -2"), "", "gap_um"),
        (body.replace("gap_um = 2", "gap_um = nan"), "", "gap_um"),
        (body.replace("mass_ug = 2", "mass_ug = 0"), "", "mass_ug"),
        (
            format!("{body}damping_ratio = 0.1\n"),
            "",
            "twice or not at all",
        ),
        (
            body.replace("viscosity_uPa_s = 18.5\n", ""),
            "",
            "twice or not at all",
        ),
        (body.replace("gap_um = 2", "gap = 2"), "", "gap"),
        (
            body.replace("pressure_kPa = 101.325", "pressure_kPa = 1e-3"),
            "",
            "compressed",
        ),
        (body.clone(), "gap_mm = 1", "no such number"),
        (body.clone(), "gap_um = -1", "not negative"),
    ] {
        let text = said(comb, &body, uncertainty);
        assert!(text.contains(word), "{word}: {text}");
    }
    assert!(said("magic", body, "").contains("magic"));
    let mut job = SimulatedTransducer::default();
    job.construction = Some(read(comb, body, ""));
    job.damping = Some(0.5);
    assert!(
        job.device()
            .unwrap_err()
            .to_string()
            .contains("natural frequency")
    );
}
