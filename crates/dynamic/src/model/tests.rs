use super::*;
use num_complex::Complex64;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

fn device() -> TransducerModel {
    TransducerModel {
        modes: vec![Mode {
            frequency: 1200.0,
            damping: 0.08,
            share: 1.0,
        }],
        ..TransducerModel::flat(-0.01)
    }
}

fn grid(low: f64, high: f64, n: usize) -> Vec<f64> {
    (0..n)
        .map(|k| low * (high / low).powf(k as f64 / (n - 1) as f64))
        .collect()
}

/// Points of a model with a relative noise, and a reference that is wrong by `reference` at all of them.
fn points(
    model: &TransducerModel,
    f: &[f64],
    noise: f64,
    reference: f64,
    seed: u64,
) -> ResponsePoints {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let scale = 1.0 + reference * normal();
    let mut points = ResponsePoints {
        frequency: f.to_vec(),
        unit: "V/(m/s²)".into(),
        ..ResponsePoints::default()
    };
    for f in f {
        let s = model.response(*f);
        let u = noise * s.norm();
        points
            .value
            .push(s * scale + Complex64::new(u * normal(), u * normal()));
        points.covariance.push([u * u, 0.0, u * u]);
    }
    points.with_reference(reference, 0.0, None)
}

#[test]
fn coverage_model_parameters() {
    // 1000 calibrations at 30 frequencies, noise 0.5 %, reference 1 %: of 1000 intervals at 95 %, 929 to 971 hold (0.1 %).
    let f = grid(50.0, 3000.0, 30);
    let problem = FitProblem::new(ModelStructure::default());
    let truth = [-0.01, 1200.0, 0.08];
    let mut inside = [0; 3];
    let mut doubted = 0;
    for seed in 0..1000 {
        let fit = problem
            .fit(&points(&device(), &f, 5e-3, 1e-2, seed))
            .unwrap();
        for ((count, q), t) in inside.iter_mut().zip(fit.estimate.quantities()).zip(truth) {
            *count += usize::from((q.value - t).abs() <= q.expanded(0.95));
        }
        doubted += usize::from(!fit.findings.is_empty());
    }
    assert!(inside.iter().all(|c| (929..=971).contains(c)), "{inside:?}");
    // One in a thousand by design: 8 of 1000 would be a chance of 1e-5.
    assert!(doubted < 8, "{doubted}");
}

#[test]
fn known_every_element_is_found_again() {
    let mut model = device();
    model.modes[0].share = 0.9;
    model.modes.push(Mode {
        frequency: 2100.0,
        damping: 0.01,
        share: 0.1,
    });
    model.high_pass = Some(2.0);
    model.delay = 2e-5;
    let f = grid(0.5, 4000.0, 160);
    let structure = ModelStructure::modes(2).with_high_pass().with_delay();
    let fit = FitProblem::new(structure)
        .fit(&points(&model, &f, 1e-4, 0.0, 3))
        .unwrap();
    for (q, t) in fit
        .estimate
        .quantities()
        .iter()
        .zip([-0.01, 1200.0, 0.08, 2100.0, 0.01, 0.1, 2.0, 2e-5])
    {
        assert!(
            (q.value - t).abs() < 5.0 * q.standard_uncertainty,
            "{q:?} {t}"
        );
        assert!((q.value / t - 1.0).abs() < 0.01, "{q:?} {t}");
    }
    assert!(fit.chi_square < fit.limit);
    let filtered = TransducerModel {
        low_pass: Some((4, 2500.0)),
        modes: Vec::new(),
        ..TransducerModel::flat(3.0)
    };
    let structure = ModelStructure::modes(0).with_low_pass(4);
    let fit = FitProblem::new(structure)
        .fit(&points(&filtered, &f, 1e-4, 0.0, 3))
        .unwrap();
    let corner = fit.estimate.get("low_pass.corner").unwrap();
    assert!((corner.value / 2500.0 - 1.0).abs() < 1e-3, "{corner:?}");
}

#[test]
fn known_a_model_that_does_not_describe_is_said_so() {
    // A delay of 20 µs turns the phase by 0.38 rad at 3 kHz.
    let model = TransducerModel {
        delay: 2e-5,
        ..device()
    };
    let f = grid(50.0, 3000.0, 30);
    let p = points(&model, &f, 5e-3, 0.0, 1);
    let without = FitProblem::new(ModelStructure::default()).fit(&p).unwrap();
    assert_eq!(without.findings[0].code(), "model-does-not-describe");
    assert!(without.misfit > 5e-3);
    let with = FitProblem::new(ModelStructure::default().with_delay())
        .fit(&p)
        .unwrap();
    assert!(with.findings.is_empty(), "{:?}", with.findings);
}

#[test]
fn known_figures_of_an_oscillator() {
    let f = grid(20.0, 3000.0, 2000);
    let p = points(&device(), &f, 1e-6, 0.0, 1);
    let fit = FitProblem::new(ModelStructure::default()).fit(&p).unwrap();
    let zeta = fit.estimate.get("mode.1.damping").unwrap();
    let figures =
        ResponseFigures::of(&p, None, Some((zeta.value, zeta.standard_uncertainty))).unwrap();
    assert_eq!(figures.damping.len(), 4, "{figures:?}");
    for d in &figures.damping {
        // The width is 2ζ to second order in ζ: 1 − ζ².
        assert!((d.damping / 0.08 - 1.0).abs() < 0.02, "{d:?}");
    }
    let (resonance, gain) = figures.resonance.unwrap();
    // f √(1 − 2ζ²) and 1/(2ζ√(1 − ζ²)).
    assert!((resonance / (1200.0 * (1.0f64 - 0.0128).sqrt()) - 1.0).abs() < 1e-4);
    assert!((gain / 6.270 - 1.0).abs() < 1e-3, "{gain}");
    // |S| = 1.05: r² = 1 − 1/1.05 nearly; −3 dB beyond the resonance: r² = 1 + √2 nearly.
    let upper = |k: usize| figures.bandwidths[k].upper.unwrap() / 1200.0;
    assert!((upper(1) - 0.2199).abs() < 2e-3, "{}", upper(1));
    assert!((upper(0) - 1.5509).abs() < 5e-3, "{}", upper(0));
}

#[test]
fn regress_a_damping_that_lines_do_not_resolve_is_not_stated() {
    // 0.02 at 1200 Hz: a half-power width of 48 Hz, with lines 2 to 200 Hz apart that lie anywhere against the peak.
    let mut model = device();
    model.modes[0].damping = 0.02;
    let (mut stated, mut disagree) = (0, 0);
    for spacing in [2.0, 10.0, 20.0, 40.0, 80.0, 200.0] {
        for seed in 0..40 {
            let first = 40.0 + spacing * seed as f64 / 40.0;
            let f: Vec<f64> = (0..)
                .map(|k| first + spacing * f64::from(k))
                .take_while(|f| *f < 3000.0)
                .collect();
            let p = points(&model, &f, 1e-4, 0.0, seed);
            let figures = ResponseFigures::of(&p, None, None).unwrap();
            for d in &figures.damping {
                stated += 1;
                let off = (d.damping - 0.02).abs();
                assert!(
                    off < 4.0 * d.standard_uncertainty + 2e-3 * 0.02,
                    "{spacing} {seed} {d:?}"
                );
            }
            disagree += usize::from(!figures.findings.is_empty());
        }
    }
    // Three ways where the lines are close, one where they are not.
    assert!(stated > 400 && disagree <= 2, "{stated} {disagree}");
}

#[test]
fn refuses_what_cannot_be_fitted() {
    let f = grid(50.0, 3000.0, 30);
    let good = points(&device(), &f, 5e-3, 0.0, 1);
    let fit = |p: &ResponsePoints, s: ModelStructure| FitProblem::new(s).fit(p);
    assert!(fit(&good, ModelStructure::modes(5)).is_err());
    assert!(fit(&good, ModelStructure::default().with_low_pass(0)).is_err());
    let mut bad = good.clone();
    bad.value[3].re = f64::NAN;
    assert!(fit(&bad, ModelStructure::default()).is_err());
    let mut bad = good.clone();
    bad.covariance[3] = [0.0; 3];
    assert!(fit(&bad, ModelStructure::default()).is_err());
    let mut bad = good.clone();
    bad.frequency[0] = -1.0;
    assert!(fit(&bad, ModelStructure::default()).is_err());
    // Two points cannot hold five parameters; a band with a flat response no resonance.
    let few = points(&device(), &f[..2], 5e-3, 0.0, 1);
    assert!(fit(&few, ModelStructure::default().with_delay()).is_err());
    let flat = points(&TransducerModel::flat(1.0), &f, 1e-2, 0.0, 1);
    match fit(&flat, ModelStructure::modes(2).with_delay()) {
        Err(_) => {}
        Ok(fit) => assert!(!fit.findings.is_empty(), "{:?}", fit.estimate.quantities()),
    }
}

#[test]
fn law_a_certificate_is_fitted_with_what_its_lines_may_share() {
    use crate::FrequencyResponse;
    use crate::reference_table::{ReferencePoint, ReferenceTable};
    let lines = grid(20.0, 2000.0, 24)
        .into_iter()
        .map(|frequency| {
            let s = device().response(frequency);
            ReferencePoint {
                frequency,
                sensitivity: s.norm(),
                phase: s.arg(),
                modulus_uncertainty: 0.01,
                phase_uncertainty: 0.01,
            }
        })
        .collect();
    let response = FrequencyResponse::try_from(&ReferenceTable::new(lines).unwrap()).unwrap();
    let points = ResponsePoints::of_response(&response, 0, 0).unwrap();
    let fit = FitProblem::new(ModelStructure::default())
        .fit(&points)
        .unwrap();
    let s = fit.estimate.get("sensitivity").unwrap();
    assert!((s.value + 0.01).abs() < 1e-6, "{s:?}");
    // Nothing is gained by the number of lines: the common error stays whole.
    assert!(
        s.standard_uncertainty >= 1e-4 && s.standard_uncertainty < 1.3e-4,
        "{s:?}"
    );
    assert!(ResponsePoints::of_response(&response, 0, 1).is_err());
}
