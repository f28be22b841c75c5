//! Findings of this room: what is wrong with a record is told, and its sound twin is left in peace.

use num_complex::Complex64;
use proofmass_dynamic::model::{FitProblem, Mode, ModelStructure, ResponsePoints, TransducerModel};
use proofmass_dynamic::shock::{PulseSearch, ShockCalibration, ShockReference};
use proofmass_signal::PulseShape;
use proofmass_uncertainty::Finding;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

fn insist(code: &str, found: &[Finding]) {
    assert!(found.iter().any(|f| f.code() == code), "{code}: {found:#?}");
}

/// A reference and an output of 0.01 V/(m/s²), whose pulse comes `later` by so many seconds and grows by `bent` at its peak.
fn shock(rate: f64, later: f64, bent: f64) -> Vec<Finding> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let n = (0.06 * rate) as usize;
    let pulse = |at: f64| PulseShape::HalfSine.record(1000.0, 2e-3, at, n, rate);
    let reference: Vec<f64> = pulse(0.04).iter().map(|a| a + 0.3 + normal()).collect();
    let output: Vec<f64> = pulse(0.04 + later)
        .iter()
        .map(|a| 0.01 * (a * (1.0 + bent * a / 1000.0) + normal()))
        .collect();
    let search = PulseSearch::default();
    let calibration = ShockCalibration::evaluate(
        &reference,
        &output,
        rate,
        "V",
        &search,
        &ShockReference::default(),
    );
    calibration.map_err(|e| format!("{e:?}")).unwrap().findings
}

#[test]
fn known_faults_of_a_shock() {
    assert!(shock(50e3, 0.0, 0.0).is_empty());
    insist("few-samples", &shock(4e3, 0.0, 0.0));
    insist("pulses-apart", &shock(50e3, 8e-3, 0.0));
    insist("peak-and-integral-differ", &shock(50e3, 0.0, 0.2));
}

/// A device of 1200 Hz, measured up to `highest` with a relative noise.
fn fitted(highest: f64, noise: f64) -> Vec<Finding> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let device = TransducerModel {
        modes: vec![Mode {
            frequency: 1200.0,
            damping: 0.08,
            share: 1.0,
        }],
        ..TransducerModel::flat(0.01)
    };
    let mut points = ResponsePoints::default();
    points.unit = "V/(m/s²)".into();
    for k in 0..30 {
        let f = 50.0 * (highest / 50.0).powf(f64::from(k) / 29.0);
        let s = device.response(f);
        let u = noise * s.norm();
        points.frequency.push(f);
        points
            .value
            .push(s + Complex64::new(u * normal(), u * normal()));
        points.covariance.push([u * u, 0.0, u * u]);
    }
    let problem = FitProblem::new(ModelStructure::default());
    problem.fit(&points).unwrap().findings
}

#[test]
fn known_resonance_beyond_the_points() {
    assert!(fitted(3000.0, 2e-3).is_empty());
    let below = fitted(600.0, 2e-3);
    insist("model-extrapolated", &below);
    insist("parameter-ill-determined", &fitted(300.0, 2e-2));
}

/// A step of 3 V at 40 ms, answered by an oscillator of 120 Hz; the record is this part of it.
#[test]
fn known_step_without_a_quiet_stretch_or_an_end() {
    use proofmass_dynamic::step::{StepFit, step_response};
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let record: Vec<f64> = (0..2000)
        .map(|k| {
            let noise: f64 = StandardNormal.sample(&mut rng);
            let t = f64::from(k) / 10e3 - 0.040_03;
            0.2 + 3.0 * step_response(t, 120.0, 0.2) + 0.02 * noise
        })
        .collect();
    let of = |part: std::ops::Range<usize>| {
        StepFit::of(&record[part], 10e3, "V")
            .expect("a fit")
            .findings
    };
    assert!(of(0..2000).is_empty());
    insist("record-starts-late", &of(392..2000));
    insist("record-ends-early", &of(0..520));
}

/// ζ from width and phase against that of a fit which another mode has misled.
#[test]
fn known_damping_ratios_that_disagree() {
    use proofmass_dynamic::model::ResponseFigures;
    let device = TransducerModel {
        modes: vec![Mode {
            frequency: 1200.0,
            damping: 0.08,
            share: 1.0,
        }],
        ..TransducerModel::flat(0.01)
    };
    let mut points = ResponsePoints::default();
    points.unit = "V/(m/s²)".into();
    for k in 0..2000 {
        let f = 20.0 * 150f64.powf(f64::from(k) / 1999.0);
        let s = device.response(f);
        let u = 1e-6 * s.norm();
        points.frequency.push(f);
        points.value.push(s);
        points.covariance.push([u * u, 0.0, u * u]);
    }
    let of = |fitted: f64| {
        let figures = ResponseFigures::of(&points, None, Some((fitted, 1e-4)));
        figures.expect("figures").findings
    };
    insist("dampings-disagree", &of(0.12));
    assert!(of(0.08).is_empty());
}

/// The acceleration over a force has no level at low frequencies to which the phase at resonance could refer.
#[test]
fn known_damping_by_phase_of_an_accelerance() {
    use proofmass_dynamic::model::ResponseFigures;
    let device = TransducerModel {
        modes: vec![Mode {
            frequency: 1200.0,
            damping: 0.08,
            share: 1.0,
        }],
        ..TransducerModel::flat(0.01)
    };
    let of = |power: i32| {
        let mut points = ResponsePoints::default();
        points.unit = "m/s²/N".into();
        for k in 0..2000 {
            let f = 20.0 * 150f64.powf(f64::from(k) / 1999.0);
            let s = device.response(f) * (f / 1200.0).powi(power);
            let u = 1e-6 * s.norm();
            points.frequency.push(f);
            points.value.push(s);
            points.covariance.push([u * u, 0.0, u * u]);
        }
        let mut figures = ResponseFigures::of(&points, None, None).expect("figures");
        figures.findings.clear();
        figures.beside(0.08, 1e-4);
        figures
    };
    let accelerance = of(2);
    let phase = accelerance
        .damping
        .iter()
        .find(|d| d.method == "phase at resonance");
    assert!(phase.unwrap().damping < 0.001, "{:?}", accelerance.damping);
    insist("dampings-disagree", &accelerance.findings);
    assert!(of(0).findings.is_empty());
}
