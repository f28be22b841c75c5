//! What do faults of sensor and session do to the intervals of a hand-held calibration, and from which size on are they found?
//!
//! Prints the tables of docs/multi-position.md: `cargo run --release -p proofmass-static --example faults`. A recording is simulated with a
//! fault, its rests are found by the search of the command, and the intervals are held against the truth. Arguments are the
//! number of recordings per cell (1000) and the only number of attitudes; with 0 the second table alone is made.

use proofmass_core::Gravity;
use proofmass_rig::{HandHeld, HandHeldRecording};
use proofmass_static::{
    Model, MultiPosition, MultiPositionFit, Samples, Segment, Standstill, StandstillCalibration,
    StandstillEstimator,
};
use rayon::prelude::*;

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// Nothing.
    None,
    /// Scatter of each rest for itself, mm/s².
    Scatter,
    /// Biases walk, µg/√s.
    Walk,
    /// A bias with the sign of the last change of each axis, ± µg.
    Hysteresis,
    /// A term in the square of the acceleration, ppm of 1 g at 1 g.
    Square,
    /// A term in the third power, ppm of 1 g at 1 g.
    Cube,
    /// A rest whose mean is off along gravity, mg: it was leant on.
    Touch,
    /// A face that was given another direction than it has, by this angle in degrees.
    Turned,
    /// Gravity that is stated wrong, ppm; biases alone are fitted.
    Gravity,
}

impl Fault {
    fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Scatter => "scatter between rests / (mm/s²)",
            Self::Walk => "walk of the biases / (µg/√s)",
            Self::Hysteresis => "hysteresis / (± µg)",
            Self::Square => "square / (ppm of 1 g)",
            Self::Cube => "cube / (ppm of 1 g)",
            Self::Touch => "one rest off along gravity / mg",
            Self::Turned => "one face turned / °",
            Self::Gravity => "gravity stated wrong / ppm",
        }
    }

    /// Codes of findings that tell of it.
    fn codes(self) -> &'static [&'static str] {
        match self {
            Self::None => &[],
            Self::Scatter => &["excess-residuals"],
            Self::Walk => &["bias-walk", "bias-drift", "warm-up"],
            Self::Hysteresis => &["last-motion"],
            Self::Square | Self::Cube => &["nonlinear-output"],
            Self::Touch => &["standstill-out-of-line"],
            Self::Turned => &["wrong-label", "standstill-out-of-line"],
            Self::Gravity => &["model-too-small"],
        }
    }
}

const UG: f64 = 9.80665e-6;
/// Biases of the sensor of nominal scale factors, m/s².
const OFFSET: [f64; 3] = [0.1, -0.2, 0.15];

/// One place of the map.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// What is wrong.
    pub fault: Fault,
    /// Its size in its unit.
    pub size: f64,
    /// Number of attitudes.
    pub attitudes: usize,
    /// Mean duration of a rest, s.
    pub rest: f64,
}

/// What came of its recordings.
#[derive(Clone, Debug, Default)]
pub struct Cell {
    /// Share of the intervals of biases, scale factors and misalignments that hold the truth.
    pub coverage: [f64; 3],
    /// That of the worst parameter.
    pub worst: f64,
    /// Share of recordings with a finding that tells of the fault.
    pub named: f64,
    /// Share of recordings with a finding of another term.
    pub misnamed: f64,
    /// Median U of bias.x, mm/s², and of scale.x, ppm.
    pub expanded: [f64; 2],
    /// Recordings that were refused.
    pub refused: usize,
}

struct Run {
    held: Vec<bool>,
    expanded: [f64; 2],
    codes: Vec<String>,
}

impl Place {
    fn rig(&self) -> HandHeld {
        let of = |fault| if self.fault == fault { self.size } else { 0.0 };
        HandHeld {
            rests: self.attitudes,
            rest: self.rest,
            wander: 1e-3 * of(Fault::Scatter),
            walk: UG * of(Fault::Walk),
            hysteresis: UG * of(Fault::Hysteresis),
            curvature: [1e-6 * of(Fault::Square), 1e-6 * of(Fault::Cube)],
            ..HandHeld::default()
        }
    }

    /// Whether its attitudes are given.
    fn given(&self) -> bool {
        self.fault == Fault::Turned
    }

    fn one(&self, rig: &HandHeld, seed: u64) -> Option<Run> {
        let mut recording = rig.simulate(seed);
        let victim = seed as usize % self.attitudes;
        if self.fault == Fault::Touch {
            let HandHeldRecording { outputs, rests, .. } = &mut recording;
            let rest = rests[victim];
            let push = rig
                .sensor
                .k()
                .times(rest.attitude)
                .map(|v| v * 1e3 * UG * self.size);
            for (output, push) in outputs.iter_mut().zip(push) {
                output[rest.start..rest.end]
                    .iter_mut()
                    .for_each(|v| *v += push);
            }
        }
        let mut settings = MultiPosition::new(
            Gravity::given(
                rig.gravity
                    * (1.0
                        + 1e-6
                            * if self.fault == Fault::Gravity {
                                self.size
                            } else {
                                0.0
                            }),
                0.0,
            )
            .ok()?,
        )
        .output_unit("count");
        let mut outputs = recording.outputs.clone();
        if self.fault == Fault::Gravity {
            // A sensor of nominal scale factors.
            let k = rig.sensor.k_inverse();
            let nominal = k.times(rig.sensor.bias());
            for i in 0..outputs[0].len() {
                let v = std::array::from_fn(|a| recording.outputs[a][i]);
                let a = k.times(v);
                (0..3).for_each(|axis| outputs[axis][i] = a[axis] - nominal[axis] + OFFSET[axis]);
            }
            settings = settings
                .model(Model::Bias)
                .nominal_sensitivity(1.0)
                .output_unit("m/s²");
        }
        let [x, y, z] = &outputs;
        let time: Vec<f64> = (0..x.len()).map(|i| i as f64 / recording.rate).collect();
        let samples = Samples::new(x, y, z).ok()?.at_times(&time).ok()?;
        let found = match self.given() {
            false => {
                let search = Standstill::default();
                StandstillCalibration::run(&samples, recording.rate, &[], &search, &settings)
            }
            true => {
                let segments = recording.rests.iter().enumerate().map(|(i, rest)| Segment {
                    start: rest.start,
                    end: rest.end,
                    attitude: Some(match i == victim {
                        true => turned(rest.attitude, self.size.to_radians()),
                        false => rest.attitude,
                    }),
                    force_uncertainty: None,
                    label: None,
                });
                let settings = settings.model(Model::Full);
                StandstillCalibration::of_segments(
                    &samples,
                    segments.collect(),
                    &settings,
                    StandstillEstimator::LeastSquares,
                )
            }
        };
        let fit = found.ok()?.fit;
        let mean = rig.sensor.k().times(recording.walked);
        let truth = |name: &str| of(&fit, rig, mean, name);
        let quantity = |name: &str| fit.quantity(name).map_or(0.0, |q| q.expanded(0.95));
        let scale = rig.sensor.k().0[0][0];
        Some(Run {
            held: fit
                .quantities()
                .iter()
                .map(|q| (q.value - truth(&q.name)).abs() <= q.expanded(0.95))
                .collect(),
            expanded: [
                1e3 * quantity("bias.x") / scale,
                1e6 * quantity("scale.x") / scale,
            ],
            codes: fit.findings().iter().map(|f| f.code().to_owned()).collect(),
        })
    }

    /// Runs many recordings.
    pub fn cell(&self, recordings: usize) -> Cell {
        let rig = self.rig();
        let runs: Vec<Option<Run>> = (0..recordings as u64)
            .into_par_iter()
            .map(|seed| self.one(&rig, seed))
            .collect();
        let good: Vec<&Run> = runs.iter().flatten().collect();
        let n = good.len().max(1) as f64;
        let parameters = good.first().map_or(0, |r| r.held.len());
        let shares: Vec<f64> = (0..parameters)
            .map(|p| good.iter().filter(|r| r.held[p]).count() as f64 / n)
            .collect();
        let group = |k: usize| {
            let part = &shares[(3 * k).min(parameters)..(3 * k + 3).min(parameters)];
            part.iter().sum::<f64>() / part.len().max(1) as f64
        };
        const TERMS: [&str; 6] = [
            "bias-drift",
            "warm-up",
            "nonlinear-output",
            "last-motion",
            "temperature-dependence",
            "model-too-small",
        ];
        let with = |wanted: &dyn Fn(&str) -> bool| {
            good.iter()
                .filter(|r| r.codes.iter().any(|c| wanted(c)))
                .count() as f64
                / n
        };
        let median = |k: usize| {
            let mut all: Vec<f64> = good.iter().map(|r| r.expanded[k]).collect();
            all.sort_by(f64::total_cmp);
            all.get(all.len() / 2).copied().unwrap_or(0.0)
        };
        let own = self.fault.codes();
        Cell {
            coverage: [group(0), group(1), group(2)],
            worst: shares.iter().copied().fold(1.0, f64::min),
            named: with(&|c| own.contains(&c)),
            misnamed: with(&|c| TERMS.contains(&c) && !own.contains(&c)),
            expanded: [median(0), median(1)],
            refused: recordings - good.len(),
        }
    }
}

fn turned(up: [f64; 3], angle: f64) -> [f64; 3] {
    // About the axis that is least along it.
    let axis = (0..3)
        .min_by(|a, b| up[*a].abs().total_cmp(&up[*b].abs()))
        .unwrap_or(0);
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut out = up;
    out[i] = up[i] * angle.cos() - up[j] * angle.sin();
    out[j] = up[i] * angle.sin() + up[j] * angle.cos();
    out
}

fn of(fit: &MultiPositionFit, rig: &HandHeld, walked: [f64; 3], name: &str) -> f64 {
    let axis = |c: char| "xyz".find(c).unwrap_or(0);
    let letters: Vec<char> = name.rsplit('.').next().unwrap_or("").chars().collect();
    let (i, k) = (axis(letters[0]), rig.sensor.k().0);
    let acceleration = fit.are_accelerations();
    match name.split('.').next() {
        Some("bias") if acceleration => OFFSET[i],
        Some("bias") => rig.sensor.bias()[i] + walked[i],
        Some("scale") => k[i][i],
        _ => k[i][axis(letters[1])] / k[i][i],
    }
}

/// The smallest size of a ladder of factors 1.25 that nine of ten recordings name.
pub fn found_in_nine_of_ten(
    fault: Fault,
    attitudes: usize,
    start: f64,
    recordings: usize,
) -> Option<f64> {
    (0..24).map(|i| start * 1.25f64.powi(i)).find(|&size| {
        let place = Place {
            fault,
            size,
            attitudes,
            rest: 4.0,
        };
        place.cell(recordings).named >= 0.9
    })
}

/// Faults, their sizes and rests, for each number of attitudes.
pub const COVERAGE: [(Fault, f64, f64); 10] = [
    (Fault::None, 0.0, 4.0),
    (Fault::Scatter, 1.0, 4.0),
    (Fault::Scatter, 3.0, 4.0),
    (Fault::Walk, 20.0, 4.0),
    (Fault::Walk, 20.0, 20.0),
    (Fault::Walk, 100.0, 4.0),
    (Fault::Hysteresis, 150.0, 4.0),
    (Fault::Hysteresis, 300.0, 4.0),
    (Fault::Square, 500.0, 4.0),
    (Fault::Cube, 500.0, 4.0),
];

#[allow(dead_code)]
fn main() {
    let argument = |i| {
        std::env::args()
            .nth(i)
            .and_then(|a| a.parse::<usize>().ok())
    };
    let recordings = argument(1).unwrap_or(1000);
    println!(
        "| fault | size | attitudes | rest / s | bias, scale, misalignment hold / % (worst) | U(bias.x) / (mm/s²) | U(scale.x) / ppm | named / % | another term named / % |"
    );
    println!("|{}", "---|".repeat(9));
    for attitudes in [12, 16, 24, 40] {
        if argument(2).is_some_and(|only| only != attitudes) {
            continue;
        }
        for (fault, size, rest) in COVERAGE {
            let place = Place {
                fault,
                size,
                attitudes,
                rest,
            };
            let cell = place.cell(recordings);
            let [b, s, m] = cell.coverage.map(|c| 100.0 * c);
            println!(
                "| {} | {} | {} | {} | {b:.1}, {s:.1}, {m:.1} ({:.1}) | {:.2} | {:.0} | {:.1} | {:.1} |",
                fault.name(),
                size,
                attitudes,
                rest,
                100.0 * cell.worst,
                cell.expanded[0],
                cell.expanded[1],
                100.0 * cell.named,
                100.0 * cell.misnamed,
            );
        }
    }
    if argument(2).is_some_and(|only| only > 0) {
        return;
    }
    println!("\n| fault | 16 attitudes | 24 | 40 |");
    println!("|---|---|---|---|");
    for (fault, start) in [
        (Fault::Cube, 200.0),
        (Fault::Square, 200.0),
        (Fault::Hysteresis, 50.0),
        (Fault::Walk, 5.0),
        (Fault::Touch, 0.2),
        (Fault::Turned, 0.005),
        (Fault::Gravity, 20.0),
    ] {
        let sizes = [16, 24, 40].map(|attitudes| {
            found_in_nine_of_ten(fault, attitudes, start, recordings / 4)
                .map_or("–".to_owned(), |s| format!("{s:.3}"))
        });
        println!("| {} | {} |", fault.name(), sizes.join(" | "));
    }
}
