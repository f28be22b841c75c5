//! Every static test.

use crate::agreement::check;
use crate::ask;
use crate::calibrations::hand_held;
use proofmass_core::{Gravity, STANDARD_GRAVITY};
use proofmass_documents::AnyCalibration;
use proofmass_jobs::AnyData;
use proofmass_jobs::static_test::{StaticTest, StaticTestData, StaticTestInput, StaticTestJob};
use proofmass_static::static_test::{
    Centrifuge, DatedEstimate, Linearity, Mounting, Orthogonality, Sensitivity, Stability, Tilt,
    ZeroG,
};

/// One axis with a bias of 0.2 V and 0.1 V/(m/s²).
fn outputs(accelerations: impl Iterator<Item = f64>) -> Vec<f64> {
    let noise = |k: usize| 1e-4 * (7.3 * k as f64).sin();
    let all = accelerations.enumerate();
    all.map(|(k, a)| 0.2 + 0.1 * a + noise(k)).collect()
}

pub fn static_test(kind: &str) {
    let gravity = Gravity::given(STANDARD_GRAVITY, 1e-5).expect("gravity");
    let g = STANDARD_GRAVITY;
    let angles: Vec<f64> = (0..12).map(|k| f64::from(30 * k).to_radians()).collect();
    let tilted = outputs(angles.iter().map(|t| g * t.cos()));
    let ends: Vec<f64> = (0..8).map(|k| f64::from(1 - 2 * (k % 2))).collect();
    let turned = outputs(ends.iter().map(|e| g * e));
    let levels: Vec<f64> = (-10..=10).map(f64::from).collect();
    let straight = outputs(levels.iter().copied());
    let speeds: Vec<f64> = (1..=20).map(f64::from).collect();
    let arm = Centrifuge::new(0.5);
    let spun = outputs(speeds.iter().map(|w| arm.acceleration(*w)));
    let axis = |level: f64, step: f64| -> Vec<f64> {
        (0..500)
            .map(|k| level + 1e-3 * (step * f64::from(k)).sin())
            .collect()
    };
    let rest = [axis(0.02, 7.1), axis(-0.01, 3.3), axis(g + 0.03, 5.7)];
    // A vehicle that stands, accelerates and brakes.
    let travel = |k: usize| match k {
        200..300 => 2.0,
        400..500 => -2.5,
        _ => 0.0,
    };
    let moved = [0.1, 0.02, 0.0].map(|share| {
        (0..500)
            .map(|k| share * travel(k) + 1e-2 * (7.1 * k as f64 + share).sin())
            .collect::<Vec<f64>>()
    });
    let drive: [Vec<f64>; 3] = [
        moved[0]
            .iter()
            .enumerate()
            .map(|(k, v)| v + travel(k) + 0.3)
            .collect(),
        moved[1].iter().map(|v| v - 0.5).collect(),
        moved[2].iter().map(|v| v + g).collect(),
    ];
    let mut mounting = Mounting::default();
    mounting.rest = [0, 200];
    mounting.forward = vec![[200, 300]];
    mounting.braking = vec![[400, 500]];
    let AnyCalibration::Constant(file) = &hand_held().1 else {
        panic!("a triaxial calibration");
    };
    let history: Vec<DatedEstimate> = (0..6)
        .map(|k| DatedEstimate {
            day: 100.0 * f64::from(k),
            estimate: file.estimate.clone(),
            name: format!("calibration {k}"),
        })
        .collect();
    let readings = |input, output| StaticTestInput::Readings {
        input,
        output,
        temperature: None,
        uncertainty: None,
        unit: "V",
    };
    for (test, input) in [
        (
            StaticTest::Tilt(Tilt::new(gravity)),
            readings(&angles, &tilted),
        ),
        (
            StaticTest::Sensitivity(Sensitivity::new(gravity)),
            readings(&ends, &turned),
        ),
        (
            StaticTest::ZeroG(ZeroG::new(gravity)),
            StaticTestInput::Recording(rest.each_ref().map(Vec::as_slice)),
        ),
        (
            StaticTest::Mounting(mounting),
            StaticTestInput::Recording(drive.each_ref().map(Vec::as_slice)),
        ),
        (
            StaticTest::Orthogonality(Orthogonality::default()),
            StaticTestInput::Calibration(file),
        ),
        (
            StaticTest::Linearity(Linearity::default()),
            readings(&levels, &straight),
        ),
        (
            StaticTest::Centrifuge(arm.clone()),
            readings(&speeds, &spun),
        ),
        (
            StaticTest::Stability(Stability::default()),
            StaticTestInput::History(&history),
        ),
    ] {
        let result = check(kind, &|watch| {
            let data = StaticTestData {
                input,
                findings: &[],
                name: "memory",
            };
            ask(
                StaticTestJob::new(test.clone()),
                &AnyData::StaticTest(data),
                watch,
            )
        });
        assert!(!result.quantities().is_empty(), "{}", test.name());
    }
}
