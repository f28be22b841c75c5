//! The map of steps of docs/dynamic-tests.md, cut down, and the simulated transducers: each step is answered, or refused for a reason that
//! its record proves.

#[path = "../examples/step_map.rs"]
#[allow(dead_code, reason = "its printed table")]
mod program;

use program::{Place, Rise};
use proofmass_jobs::step::{StepData, StepJob};
use proofmass_jobs::{Channel, Job, Outcome, Unwatched};
use proofmass_rig::{Transducer, TransducerBench, TransducerMotion};

fn place(damping: f64, samples: f64, noise: f64) -> Place {
    Place {
        damping,
        noise,
        samples,
        after: 10.0,
        before: 2.0,
        rise: Rise::None,
        pole: 0.0,
    }
}

/// From a swing to a creep, 5 to 50 samples to a period.
#[test]
fn coverage_of_frequency_damping_and_gain() {
    let (mut held, mut answers, mut records) = ([0; 3], 0, 0);
    for damping in [0.05, 0.2, 0.7, 1.0, 1.5] {
        for samples in [5.0, 10.0, 20.0, 50.0] {
            let cell = place(damping, samples, 1e-4).cell(4, 0);
            records += cell.recordings;
            answers += cell.recordings - cell.refused;
            for (sum, held) in held
                .iter_mut()
                .zip([cell.held[0], cell.held[1], cell.height_held])
            {
                *sum += held;
            }
            // A creep of which a period is five samples is one pole.
            if cell.refused > 0 {
                let reason = cell.reason.unwrap_or_default();
                assert!(
                    damping >= 1.0 && samples <= 5.0,
                    "{damping} {samples}: {reason}"
                );
                assert!(reason.contains("first-order element"), "{reason}");
            }
        }
    }
    assert!(records == 80 && answers >= 72, "{answers}");
    // 95 % of 72: 62 and more (1e-3).
    assert!(
        held.iter().all(|h| *h * 100 >= 86 * answers),
        "{held:?} of {answers}"
    );
}

/// Every simulated principle as `simulate transducer --motion step` has it, in an eighth of its samples.
#[test]
fn known_steps_of_every_principle() {
    for transducer in Transducer::examples() {
        let name = transducer.name.clone();
        let (frequency, damping) = (
            transducer.mass.natural_frequency(),
            transducer.mass.damping_ratio(),
        );
        let unit = transducer.unit();
        let bench = TransducerBench {
            motion: TransducerMotion::Step {
                height: 0.2 * transducer.limits().acceleration,
            },
            rate: 50.0 * frequency,
            duration: 8192.0 / (50.0 * frequency),
            temperature: 0.0,
            noise: 1e-5,
            reference_noise: 0.0,
            bits: 24,
            transducer,
        };
        let recording = bench.simulate(1).unwrap();
        let channel = Channel {
            name: "output",
            unit,
            data: &recording.output,
        };
        let data = StepData {
            channel,
            rate: bench.rate,
            findings: &[],
            name: &name,
        };
        let outcome = StepJob::default().evaluate(&data, &Unwatched);
        if name.starts_with("thermal") {
            // A time constant of 5 ms hides a mass of 10 kHz: in this record hardly a tenth of it is over.
            let refusal = outcome.map(|_| ()).unwrap_err().to_string();
            assert!(refusal.contains("first-order element"), "{refusal}");
            continue;
        }
        let outcome = outcome.unwrap_or_else(|e| panic!("{name}: {e}"));
        let doubted = outcome
            .findings()
            .iter()
            .any(|f| f.code() == "model-does-not-describe");
        // A gap that closes, a charge that leaks and a tunnel are no straight lines.
        let crooked = ["capacitive", "piezoelectric", "tunnelling"];
        assert_eq!(
            doubted,
            crooked.iter().any(|c| name.starts_with(c)),
            "{name}"
        );
        if !doubted {
            for (quantity, truth) in [("frequency", frequency), ("damping", damping)] {
                let all = outcome.quantities();
                let q = all.iter().find(|q| q.name == quantity).unwrap();
                assert!(
                    (q.value - truth).abs() < 2.0 * q.expanded,
                    "{name} {quantity}: {q:?}"
                );
            }
        }
    }
}
