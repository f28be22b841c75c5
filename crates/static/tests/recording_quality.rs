//! What a recording itself gives reason to doubt, on recordings with one fault each and on one with none.

use proofmass_static::{PoseResidual, Samples, Segment, clipping, frozen, temperature_drift};
use proofmass_uncertainty::{Finding, Severity};

const N: usize = 600;

/// Three outputs that turn.
fn turning() -> [Vec<f64>; 3] {
    [0.0, 2.0, 4.0].map(|phase| (0..N).map(|k| (0.1 * k as f64 + phase).sin()).collect())
}

fn segment(start: usize, end: usize) -> Segment {
    Segment {
        start,
        end,
        attitude: None,
        force_uncertainty: None,
        label: None,
    }
}

/// All findings of outputs with a declared range of ±1.5 and a standstill from 100 to 200.
fn of([x, y, z]: &[Vec<f64>; 3]) -> Vec<Finding> {
    let samples = Samples::new(x, y, z).unwrap();
    let mut found = clipping(&samples, (-1.5, 1.5), &[segment(100, 200)]);
    found.extend(frozen(&samples));
    found
}

#[test]
fn known_sound_outputs_raise_nothing() {
    assert!(of(&turning()).is_empty());
}

#[test]
fn known_clipped_outputs_are_a_decision_inside_a_standstill() {
    for (from, severity) in [(150, Severity::Decision), (300, Severity::Note)] {
        let mut outputs = turning();
        outputs[1][from..from + 20].fill(1.5);
        let found = of(&outputs);
        assert_eq!(found[0].code(), "clipped");
        assert_eq!(found[0].severity(), severity);
        assert_eq!(found.len(), 1);
    }
}

#[test]
fn known_output_that_stands_still_while_others_move() {
    let mut outputs = turning();
    outputs[2][50..250].fill(0.2);
    let found = of(&outputs);
    assert_eq!(found[0].code(), "frozen");
    assert_eq!(found.len(), 1);
}

#[test]
fn known_temperature_that_drifts_across_the_standstills() {
    let segments = [segment(0, 100), segment(250, 350), segment(500, 600)];
    let residuals: Vec<PoseResidual> = segments
        .iter()
        .map(|s| PoseResidual {
            name: String::new(),
            samples: (s.start, s.end),
            output: [0.0; 3],
            acceleration: [0.0; 3],
            magnitude_residual: 0.0,
            noise: 0.0,
            vector_residual: None,
            studentised: None,
        })
        .collect();
    let of = |rise: f64| {
        let temperature: Vec<f64> = (0..N).map(|k| 20.0 + rise * k as f64 / N as f64).collect();
        temperature_drift(&temperature, &segments, &residuals)
    };
    assert_eq!(of(1.0), None);
    for (rise, severity) in [(5.0, Severity::Warning), (30.0, Severity::Decision)] {
        let found = of(rise).unwrap();
        assert_eq!(found.code(), "temperature-dependence");
        assert_eq!(found.severity(), severity);
    }
}
