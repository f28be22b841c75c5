//! Records that end with the sweep, and those that go on until the response has decayed.

use crate::Outcome;
use crate::response::tests::{RATE, device, evaluate, output_of};
use crate::response::{Excitation, ResponseJob, ResponseOutcome};
use proofmass_uncertainty::{Severity, student_quantile};
use std::f64::consts::TAU;

/// Seconds of a sweep from 20 Hz to 3 kHz, or down, and of nothing after it.
fn swept(linear: bool, down: bool, duration: f64, after: f64, seed: u64) -> ResponseOutcome {
    let n = (duration * RATE) as usize;
    let (from, to) = if down { (3000.0, 20.0) } else { (20.0, 3000.0) };
    let mut x: Vec<f64> = (0..n)
        .map(|k| k as f64 / RATE)
        .map(|t| match linear {
            true => TAU * (from * t + 0.5 * (to - from) / duration * t * t),
            false => {
                let l = duration / f64::ln(to / from);
                TAU * from * l * ((t / l).exp() - 1.0)
            }
        })
        .map(f64::sin)
        .collect();
    let recorded = n + (after * RATE) as usize;
    // The response is that of a record without end: nothing of it comes back at the beginning.
    x.resize(recorded + 20_000, 0.0);
    let y = output_of(&device(), &x, 2e-6, seed);
    let pair = (x[..recorded].to_vec(), y[..recorded].to_vec());
    evaluate(&ResponseJob::new(Excitation::Sweep), &[pair]).unwrap()
}

/// Frequencies, and of each line departure and U of the modulus over the true one.
fn lines(outcome: &ResponseOutcome) -> Vec<(f64, f64, f64)> {
    let r = outcome.response();
    (0..r.lines())
        .map(|k| {
            let truth = device().response(r.frequency[k]).norm();
            let u = student_quantile(0.975, r.dof[k]) * r.polar_uncertainty(k).0;
            let off = (r.value[k].norm() - truth).abs();
            (r.frequency[k], off / truth, u / truth)
        })
        .collect()
}

fn severity(outcome: &ResponseOutcome, code: &str) -> Option<Severity> {
    let mut findings = outcome.findings().iter();
    findings.find(|f| f.code() == code).map(|f| f.severity())
}

#[test]
fn coverage_of_lines_where_the_record_ends_with_the_sweep() {
    let (mut held, mut all) = (0, 0);
    for linear in [false, true] {
        for down in [false, true] {
            for (seed, duration) in [(1, 8.0), (2, 25.0)] {
                let outcome = swept(linear, down, duration, 0.0, seed);
                let said = severity(&outcome, "record-ends-early");
                assert!(said.is_some(), "{linear} {down} {duration}");
                for (f, off, u) in lines(&outcome) {
                    held += usize::from(off <= u);
                    all += 1;
                    assert!(off < 1.5, "{linear} {down} {duration}: {f} Hz {off} {u}");
                }
                // The end of a logarithmic sweep upwards has the most lines to lose.
                if !linear && !down {
                    assert_eq!(said, Some(Severity::Warning));
                    let highest = *outcome.response().frequency.last().unwrap();
                    assert!(highest > 1500.0 && highest < 2900.0, "{highest}");
                }
            }
        }
    }
    // 95 % of 2 400 and more lines: 94 % at least (1e-2).
    assert!(all > 2400 && held * 100 > 94 * all, "{held} of {all}");
}

#[test]
fn healthy_sweeps_that_decay_have_no_such_finding() {
    let mut fired = 0;
    for seed in 0..40 {
        let (linear, down) = (seed % 2 == 1, seed % 4 > 1);
        let outcome = swept(linear, down, 8.0, 0.8, seed);
        let codes = ["record-ends-early", "record-starts-late", "low-coherence"];
        fired += codes
            .into_iter()
            .filter(|c| severity(&outcome, c).is_some_and(|s| s != Severity::Note))
            .count();
        fired += usize::from(severity(&outcome, "record-ends-early").is_some());
        let highest = lines(&outcome).last().map_or(0.0, |l| l.0);
        assert!(highest > 2700.0, "{seed} {linear} {down} {highest}");
    }
    assert_eq!(fired, 0);
}
