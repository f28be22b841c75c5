use super::*;
use proofmass_signal::PulseShape;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

const RATE: f64 = 50e3;

struct Noise {
    rng: Xoshiro256PlusPlus,
    pole: f64,
    state: f64,
}

impl Noise {
    fn new(seed: u64, pole: f64) -> Self {
        let rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        Self {
            rng,
            pole,
            state: 0.0,
        }
    }

    fn next(&mut self) -> f64 {
        let white: f64 = StandardNormal.sample(&mut self.rng);
        self.state = self.pole * self.state + (1.0 - self.pole * self.pole).sqrt() * white;
        self.state
    }
}

/// 1000 m/s² for 2 ms at 40 ms, 3000 samples, with a device of sensitivity 0.01 V/(m/s²).
fn pair(seed: u64, noise: f64, pole: f64) -> (Vec<f64>, Vec<f64>) {
    let clean = PulseShape::HalfSine.record(1000.0, 2e-3, 0.04, 3000, RATE);
    let (mut n1, mut n2) = (Noise::new(seed, pole), Noise::new(seed + 1_000_000, pole));
    let reference = clean.iter().map(|a| a + 0.3 + noise * n1.next()).collect();
    let output = clean
        .iter()
        .map(|a| 0.01 * (a + 7.0 + 2.0 * noise * n2.next()))
        .collect();
    (reference, output)
}

fn calibrate(r: &[f64], o: &[f64]) -> Result<ShockCalibration, String> {
    ShockCalibration::evaluate(
        r,
        o,
        RATE,
        "V",
        &PulseSearch::default(),
        &ShockReference::default(),
    )
    .map_err(|e| format!("{e:?}"))
}

fn codes(findings: &[proofmass_uncertainty::Finding]) -> Vec<&str> {
    findings.iter().map(|f| f.code()).collect()
}

#[test]
fn known_measures_of_classical_pulses() {
    for (shape, tolerance) in [
        (PulseShape::HalfSine, 1e-4),
        (PulseShape::Haversine, 1e-3),
        (PulseShape::Trapezoid { rise: 0.2 }, 2e-2),
    ] {
        let (peak, duration) = (500.0, 4e-3);
        let clean = shape.record(peak, duration, 0.03, 4000, RATE);
        let mut noise = Noise::new(3, 0.0);
        let record: Vec<f64> = clean
            .iter()
            .map(|a| a - 2.0 + 1e-3 * noise.next())
            .collect();
        let pulse = PulseSearch::default().find(&record).unwrap().unwrap();
        let m = pulse.measure(&record, RATE);
        assert!((m.peak / peak - 1.0).abs() < tolerance, "{shape:?} {m:?}");
        let expected = shape.tenth_duration() * duration;
        // Passages by straight lines between samples 20 µs apart, of a curve: well below a sample.
        assert!(
            (m.duration.unwrap() - expected).abs() < 2e-6,
            "{shape:?} {m:?}"
        );
        let dv = shape.area() * peak * duration;
        assert!(
            (m.velocity_change.unwrap() / dv - 1.0).abs() < 2e-3,
            "{shape:?} {m:?}"
        );
        let tolerance = Tolerance {
            shape,
            peak,
            duration,
            ..Tolerance::default()
        };
        let judged = tolerance
            .judge(&pulse, &record, RATE, m.velocity_change)
            .unwrap();
        assert!(judged.kept && judged.largest_departure < 0.05, "{judged:?}");
        let other = Tolerance {
            peak: 1.3 * peak,
            ..tolerance
        };
        assert!(
            !other
                .judge(&pulse, &record, RATE, m.velocity_change)
                .unwrap()
                .kept
        );
    }
}

#[test]
fn coverage_shock_sensitivity() {
    // 400 runs at 95 %: the binomial bound at 0.1 % to either side is 365…395 of 400.
    for pole in [0.0, 0.9] {
        let mut inside = [0; 3];
        let runs = 400;
        for seed in 0..runs {
            let (r, o) = pair(seed, 5.0, pole);
            let result = calibrate(&r, &o).unwrap();
            for (count, q) in inside.iter_mut().zip(result.estimate.quantities()) {
                if (q.value - 0.01).abs() <= q.expanded(0.95) {
                    *count += 1;
                }
            }
        }
        for count in inside {
            assert!((365..=396).contains(&count), "pole {pole}: {inside:?}");
        }
    }
}

#[test]
fn known_healthy_pulses_raise_nothing() {
    let mut raised = 0;
    for seed in 0..400 {
        let (r, o) = pair(50_000 + seed, 5.0, if seed % 2 == 0 { 0.0 } else { 0.9 });
        let result = calibrate(&r, &o).unwrap();
        raised += usize::from(!result.findings.is_empty());
    }
    assert!(raised <= 8, "{raised} of 400");
}

#[test]
fn known_faults_are_named() {
    let (r, o) = pair(1, 1.0, 0.0);
    let of = |r: &[f64], o: &[f64]| {
        let result = calibrate(r, o).unwrap();
        codes(&result.findings).join(" ")
    };
    // Cut off on the falling flank.
    let end = 2000 + 80;
    assert!(of(&r[..end], &o[..end]).contains("record-ends-early"));
    // A rebound of half the height.
    let rebound = PulseShape::HalfSine.record(500.0, 2e-3, 0.052, 3000, RATE);
    let add = |x: &[f64], by: f64| -> Vec<f64> {
        x.iter().zip(&rebound).map(|(v, b)| v + by * b).collect()
    };
    assert!(of(&add(&r, 1.0), &add(&o, 0.01)).contains("more-than-one-pulse"));
    // The converter ends at 8 V.
    let clipped: Vec<f64> = o.iter().map(|v| v.min(8.0)).collect();
    assert!(of(&r, &clipped).contains("clipped"));
    // The amplifier stays off by 3 % of the peak.
    let shifted: Vec<f64> = o
        .iter()
        .enumerate()
        .map(|(k, v)| if k > 2050 { v + 0.3 } else { *v })
        .collect();
    assert!(of(&r, &shifted).contains("zero-shift"));
    // The anvil rings at 6 kHz.
    let ring: Vec<f64> = r
        .iter()
        .enumerate()
        .map(|(k, v)| {
            let t = (k as f64 - 2000.0) / RATE;
            let swing = (std::f64::consts::TAU * 6e3 * t).sin() * (-t / 4e-3).exp();
            v + if t > 0.0 { 150.0 * swing } else { 0.0 }
        })
        .collect();
    let rung = of(&ring, &o);
    assert!(rung.contains("ringing"), "{rung}");
    assert!(!rung.contains("more-than-one-pulse"), "{rung}");
    let turned: Vec<f64> = o.iter().map(|v| -v).collect();
    assert!(of(&r, &turned).contains("opposite-sign"));
    // Swapped: what is called output comes first.
    let late: Vec<f64> = (0..3000)
        .map(|k| if k < 3 { o[0] } else { o[k - 3] })
        .collect();
    assert!(!of(&r, &late).contains("output-leads"));
    assert!(of(&late, &r).contains("output-leads"));
}

#[test]
fn refuses_records_without_a_pulse() {
    for pole in [0.0, 0.99] {
        let mut noise = Noise::new(9, pole);
        let record: Vec<f64> = (0..20_000).map(|_| 4.0 + noise.next()).collect();
        assert!(PulseSearch::default().find(&record).unwrap().is_err());
    }
    let sine: Vec<f64> = (0..5000).map(|k| (0.1 * f64::from(k)).sin()).collect();
    assert!(PulseSearch::default().find(&sine).unwrap().is_err());
    assert!(PulseSearch::default().find(&[1.0; 100]).is_err());
    assert!(PulseSearch::default().find(&[1.0; 3]).is_err());
    let (r, o) = pair(1, 1.0, 0.0);
    assert!(calibrate(&r[..100], &o).is_err());
    assert!(calibrate(&r[1995..], &o[1995..]).is_err());
}
