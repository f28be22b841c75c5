//! Primary calibration by laser interferometry, from raw files to the result.

use proofmass_documents::AnyCalibration;
use proofmass_jobs::campaign::Campaign;
use proofmass_jobs::simulate::{SimulateJob, SimulatedPrimary};
use proofmass_jobs::{Gathered, Job, Memory, Sink, StoredResult, Trouble, Unwatched};
use proofmass_rig::{PrimaryBench, QuadratureInterferometer};
use proofmass_uncertainty::Severity;
use std::sync::Arc;

/// A simulation, and its truth.
fn simulated(change: impl FnOnce(&mut SimulatedPrimary)) -> (Memory, serde_json::Value) {
    let mut job = SimulatedPrimary::default();
    (job.duration, job.repeats) = (0.1, 1);
    change(&mut job);
    let files = Gathered::default();
    let outcome = SimulateJob::Primary(job)
        .evaluate(&(&files as &dyn Sink), &Unwatched)
        .unwrap();
    (files.into_memory(), outcome.truth().clone())
}

fn calibrate(files: Memory) -> Result<StoredResult, Trouble> {
    Campaign::read(Arc::new(files), "campaign.toml")?.evaluate(None, &Unwatched)
}

const CAMPAIGN: &str = "kind = \"shaker-primary\"\n[runs]\nfile = \"runs.csv\"\n[recording]\nformat = \"f32\"\n\
    sampling_rate_Hz = 200000\nfull_scale_V = 10\nchannels = { cosine = 1, sine = 2, output = 3 }\n";

/// A campaign of one recording.
fn recorded(
    campaign: &str,
    frequency: f64,
    channels: &[Vec<f64>; 3],
) -> Result<StoredResult, Trouble> {
    several(campaign, frequency, &[channels])
}

/// A campaign of recordings at one frequency.
fn several(
    campaign: &str,
    frequency: f64,
    recordings: &[&[Vec<f64>; 3]],
) -> Result<StoredResult, Trouble> {
    let mut runs = "run,frequency_Hz,file\n".to_owned();
    let mut files = Memory::new().file("campaign.toml", campaign.as_bytes());
    for (k, channels) in recordings.iter().enumerate() {
        runs += &format!("{k},{frequency},{k}.f32\n");
        // Written here, for the writer of the library refuses what the reader has to.
        let samples =
            (0..channels[0].len()).flat_map(|k| channels.iter().map(move |c| c[k] as f32));
        let bytes: Vec<u8> = samples.flat_map(f32::to_le_bytes).collect();
        files = files.file(format!("{k}.f32"), bytes);
    }
    calibrate(files.file("runs.csv", runs.as_bytes()))
}

/// A recording at 160 Hz with 12 µm.
fn sound(frequency: f64, amplitude: f64, laser: QuadratureInterferometer) -> [Vec<f64>; 3] {
    let bench = PrimaryBench {
        interferometer: laser,
        ..PrimaryBench::default()
    };
    let s = |_: f64| num_complex::Complex64::new(0.01, 0.0);
    bench.record(frequency, amplitude, 0.1, s, 3)
}

fn codes(result: &StoredResult) -> Vec<&str> {
    result.findings().iter().map(|f| f.code()).collect()
}

/// From 10 Hz to 10 kHz at the stated noise: within U, and no error beyond what the map allows.
#[test]
fn law_the_simulation_returns_its_truth() {
    let (files, truth) = simulated(|job| {
        job.frequencies = vec![10.0, 80.0, 315.0, 2000.0, 10_000.0];
        (job.u_voltage, job.u_wavelength) = (0.0, 0.0);
    });
    let result = calibrate(files).unwrap();
    assert!(
        result
            .findings()
            .iter()
            .all(|f| f.severity() == Severity::Note || f.code() == "tone-beside-drive"),
        "{:?}",
        result.findings()
    );
    let quantities = result.quantities();
    for point in truth["S_V/(m/s2)"].as_array().unwrap() {
        let f = point["frequency_Hz"].as_f64().unwrap();
        let stated = |name: &str| {
            let name = format!("S.{name}[frequency={f}]");
            quantities.iter().find(|q| q.name == name).unwrap()
        };
        let (modulus, phase) = (stated("modulus"), stated("phase"));
        let relative = modulus.value / point["modulus"].as_f64().unwrap() - 1.0;
        let turned = phase.value.to_degrees() - point["phase_deg"].as_f64().unwrap();
        println!(
            "{f} Hz: {relative:.1e}, {turned:.1e}°, U {:.1e}",
            modulus.expanded / modulus.value
        );
        assert!(
            relative.abs() < 1e-4 && turned.abs() < 0.05,
            "{f}: {relative} {turned}"
        );
        // Ten intervals of 95 %: none is missed by more than its own half.
        assert!(
            relative.abs() * modulus.value < 1.5 * modulus.expanded,
            "{f}"
        );
        assert!(turned.to_radians().abs() < 1.5 * phase.expanded, "{f}");
    }
    // The file is one that every user of a comparison takes.
    let files = result.files().unwrap();
    let file = files
        .iter()
        .find(|(name, _)| name == "calibration.json")
        .unwrap();
    assert!(matches!(
        AnyCalibration::from_json(&file.1),
        Ok(AnyCalibration::FrequencyResponse(_))
    ));
}

/// Declared inputs stand in the budget, and U holds what was drawn of them.
#[test]
fn law_declared_inputs_are_in_u() {
    let (files, truth) = simulated(|job| {
        job.frequencies = vec![160.0];
        (job.repeats, job.u_voltage) = (3, 1e-3);
    });
    let result = calibrate(files).unwrap();
    let modulus = &result.quantities()[0];
    let u = modulus.u.unwrap() / modulus.value;
    assert!((u / 1e-3 - 1.0).abs() < 0.01, "{u}");
    let drawn = truth["voltage_error_relative"].as_f64().unwrap();
    let relative = modulus.value / truth["S_V/(m/s2)"][0]["modulus"].as_f64().unwrap() - 1.0;
    assert!((relative - drawn).abs() < 5e-5, "{relative} {drawn}");
}

#[test]
fn known_faults_have_their_names() {
    let standard = QuadratureInterferometer::default;
    let still = || QuadratureInterferometer {
        vibration: [0.0, 23.0],
        drift: 0.0,
        ..standard()
    };
    // A motion within a part of a fringe: the ellipse is not determined, or its uncertainty is told.
    let small = recorded(CAMPAIGN, 4000.0, &sound(4000.0, 0.1e-6, still())).unwrap();
    assert!(
        codes(&small).contains(&"quadrature-arc"),
        "{:?}",
        codes(&small)
    );
    let smaller = recorded(CAMPAIGN, 4000.0, &sound(4000.0, 5e-9, still())).unwrap_err();
    assert!(
        smaller.to_string().contains("no run gives a motion"),
        "{smaller}"
    );
    // Light lost, in one of two runs.
    let mut dark = sound(160.0, 12e-6, standard());
    for k in 5000..5040 {
        (dark[0][k], dark[1][k]) = (0.08, -0.05);
    }
    let lost = recorded(CAMPAIGN, 160.0, &dark).unwrap_err();
    assert!(
        lost.place().iter().any(|p| p.contains("lost its signal")),
        "{lost:?}"
    );
    // Too fast: the rate that would do is told.
    let fast = recorded(CAMPAIGN, 160.0, &sound(160.0, 48e-6, standard())).unwrap_err();
    let hint = fast.hint().unwrap();
    assert!(hint.contains("sample at"), "{hint}");
    let needed: f64 = hint.split_whitespace().nth(2).unwrap().parse().unwrap();
    // Seven tenths of half a turn for the largest step: 4π s Ω/λ over 0.7 π.
    let step = 4.0 * std::f64::consts::PI * 48e-6 * std::f64::consts::TAU * 160.0 / 632.8e-9;
    assert!(
        (needed / (step / (0.7 * std::f64::consts::PI)) - 1.0).abs() < 0.02,
        "{needed}"
    );
    // Exchanged signals: the motion is the other way round.
    let [a, b, out] = sound(160.0, 12e-6, standard());
    // Among others a run that cannot be used is left out, with its reason.
    let flat = [a.clone(), vec![0.1; b.len()], out.clone()];
    let swift = sound(160.0, 48e-6, standard());
    let among = several(
        CAMPAIGN,
        160.0,
        &[&[a.clone(), b.clone(), out.clone()], &dark, &swift, &flat],
    )
    .unwrap();
    for code in [
        "signal-dropout",
        "phase-too-fast",
        "interferometer-unusable",
    ] {
        let found = among.findings().iter().find(|f| f.code() == code);
        assert_eq!(found.unwrap().severity(), Severity::Decision, "{code}");
    }
    let exchanged = recorded(CAMPAIGN, 160.0, &[b.clone(), a.clone(), out.clone()]).unwrap();
    assert!(codes(&exchanged).contains(&"motion-inverted"));
    assert!(codes(&exchanged).contains(&"wavelength-assumed"));
    let against = format!("{CAMPAIGN}[interferometer]\nmotion = \"against\"\n");
    let stated = recorded(&against, 160.0, &[b.clone(), a.clone(), out.clone()]).unwrap();
    assert!(!codes(&stated).contains(&"motion-inverted"));
    // Noise of a tenth: no clean circle.
    let noisy = QuadratureInterferometer {
        noise: 0.07,
        ..standard()
    };
    let noisy = recorded(CAMPAIGN, 160.0, &sound(160.0, 10e-6, noisy)).unwrap();
    assert!(
        codes(&noisy).contains(&"quadrature-residual"),
        "{:?}",
        codes(&noisy)
    );
    // Another frequency than that of the table.
    let other = recorded(CAMPAIGN, 250.0, &[a, b, out]).unwrap();
    assert!(
        codes(&other).contains(&"frequency-mismatch"),
        "{:?}",
        codes(&other)
    );
}

#[test]
fn refuses_bad_input_with_a_word() {
    let [a, b, out] = sound(160.0, 12e-6, QuadratureInterferometer::default());
    let said = |campaign: &str, channels: &[Vec<f64>; 3]| {
        let trouble = recorded(campaign, 160.0, channels).expect_err("a refusal");
        format!("{trouble} {:?} {:?}", trouble.place(), trouble.hint())
    };
    let good = [a.clone(), b.clone(), out.clone()];
    let missing = CAMPAIGN.replace(", sine = 2", "");
    assert!(said(&missing, &good).contains("the channel \"sine\" is missing"));
    let flat = vec![0.3; a.len()];
    assert!(said(CAMPAIGN, &[a.clone(), flat, out.clone()]).contains("channel sine is constant"));
    let other = said(CAMPAIGN, &[a.clone(), out.clone(), b.clone()]);
    assert!(other.contains("draw no ellipse"), "{other}");
    let mut hole = a.clone();
    hole[77] = f64::NAN;
    assert!(said(CAMPAIGN, &[hole, b.clone(), out.clone()]).contains("NaN"));
    let cut = good.clone().map(|c| c[..5000].to_vec());
    let short = said(CAMPAIGN, &cut);
    assert!(
        short.contains("4.0 periods of 160 Hz, and 5 are needed"),
        "{short}"
    );
    let laser = |line: &str| format!("{CAMPAIGN}[interferometer]\n{line}\n");
    let metres = said(&laser("wavelength_nm = 6.328e-7"), &good);
    assert!(metres.contains("write wavelength_nm = 632.8"), "{metres}");
    let key = said(&laser("wavelength_m = 632.8e-9"), &good);
    assert!(key.contains("did you mean `wavelength_nm`"), "{key}");
    let bare = said(&laser("wavelength_nm = 632.8"), &good);
    assert!(
        bare.contains("the uncertainty of the wavelength is not stated"),
        "{bare}"
    );
}

/// What a primary calibration gives is the reference of a secondary one, and stands in a comparison of two laboratories.
#[test]
fn law_the_result_is_the_reference_of_a_comparison() {
    let calibrated = |seed: u64| {
        let (files, _) = simulated(|job| {
            job.frequencies = vec![160.0];
            (job.seed, job.repeats) = (seed, 2);
        });
        calibrate(files).unwrap()
    };
    let first = calibrated(1);
    let written = first.files().unwrap();
    let bytes = |name: &str| &written.iter().find(|(file, _)| file == name).unwrap().1;
    let secondary = "kind = \"shaker-single\"\n[runs]\nfile = \"runs.csv\"\n[reference]\nfile = \"result.json\"\n[reading]\n\
         u_relative = 1e-3\nu_phase_deg = 0.1\n";
    let runs = "run,frequency_Hz,transverse_%,reference_mV,reference_phase_deg,output_mV,output_phase_deg\na,160,1,100,0,200,1\n";
    let files = Memory::new()
        .file("campaign.toml", secondary.as_bytes())
        .file("runs.csv", runs.as_bytes())
        .file("result.json", bytes("result.json").as_slice());
    let result = calibrate(files).unwrap();
    let reference = first.quantities()[0].value;
    assert!((result.quantities()[0].value / (2.0 * reference) - 1.0).abs() < 1e-9);
    let other = calibrated(2);
    let response = |result: &StoredResult| match result.calibration() {
        Some(AnyCalibration::FrequencyResponse(file)) => {
            proofmass_jobs::frequency_response::of_file(file).unwrap()
        }
        _ => panic!("a frequency response"),
    };
    let [a, b] = [response(&first), response(&other)];
    assert!(a.frequencies().eq(b.frequencies()));
}
