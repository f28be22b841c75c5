//! Do the intervals of a multi-position fit hold the truth when the rests are searched for, as the command does?
//!
//! Prints the table of docs/multi-position.md: `cargo run --release -p proofmass-static --example rest_search`. A hand-held recording is
//! simulated, its rests are found by the search itself, and the fit is held against the truth and against the fit of the
//! rests as they were. Arguments are the number of recordings per
//! cell (1000) and how many cells are passed over (0).

use proofmass_core::{Gravity, SensorModel};
use proofmass_rig::{HandHeld, HandHeldRecording};
use proofmass_static::{
    MultiPosition, MultiPositionFit, Samples, Segment, Standstill, StandstillCalibration,
    StandstillEstimator,
};
use rayon::prelude::*;

/// One place of the map.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Sampling rate, Hz.
    pub rate: f64,
    /// Number of attitudes.
    pub attitudes: usize,
    /// Mean duration of a rest, s.
    pub rest: f64,
    /// Standard deviation of a sample in steps of the converter.
    pub noise: f64,
    /// Standard deviation between rests in mm/s².
    pub wander: f64,
    /// Tremor or gusts within a rest in mm/s².
    pub tremor: f64,
    /// Share of the rests that are touched.
    pub touched: f64,
    /// Bits of the converter over ±8 g; the noise is in its steps.
    pub bits: i32,
}

/// What came of the recordings of one place.
#[derive(Clone, Debug, Default)]
pub struct Cell {
    /// Recordings.
    pub recordings: usize,
    /// Those that were refused.
    pub refused: usize,
    /// Share of the intervals that hold the truth.
    pub mean: f64,
    /// That of the worst parameter.
    pub worst: f64,
    /// Median over the recordings of U over that from the rests as they were.
    pub width: f64,
    /// Share of recordings in which as many rests were found as there were.
    pub found: f64,
    /// First refusal.
    pub reason: Option<String>,
}

/// What came of one recording.
struct Run {
    /// Whether the interval of each parameter holds the truth.
    held: Vec<bool>,
    /// U over that from the rests as they were.
    width: f64,
    /// Whether as many rests were found as there were.
    found: bool,
}

impl Place {
    fn rig(&self) -> HandHeld {
        // ±8 g.
        let step = 16.0 * 9.80665 / 2f64.powi(self.bits);
        HandHeld {
            tremor: self.tremor * 1e-3,
            touched: self.touched,
            rate: self.rate,
            rests: self.attitudes,
            rest: self.rest,
            noise: self.noise,
            wander: self.wander * 1e-3,
            sensor: SensorModel::new(
                proofmass_core::Matrix3(
                    [
                        [1.01, 0.004, -0.006],
                        [0.0, 0.985, 0.008],
                        [0.0, 0.0, 1.006],
                    ]
                    .map(|row| row.map(|v| v / step)),
                ),
                [120.0, -50.0, 200.0].map(|b| b * 2f64.powi(self.bits - 16)),
            )
            .unwrap_or_else(|error| unreachable!("{error}")),
            ..HandHeld::default()
        }
    }

    /// Runs many recordings.
    pub fn cell(&self, recordings: usize) -> Cell {
        let rig = self.rig();
        let gravity =
            Gravity::given(rig.gravity, 0.0).unwrap_or_else(|error| unreachable!("{error}"));
        let settings = MultiPosition::new(gravity).output_unit("count");
        let results: Vec<Result<Run, String>> = (0..recordings as u64)
            .into_par_iter()
            .map(|seed| one(&rig, &rig.simulate(seed), &settings))
            .collect();
        let good: Vec<_> = results.iter().filter_map(|r| r.as_ref().ok()).collect();
        let parameters = good.first().map_or(0, |r| r.held.len());
        let shares: Vec<f64> = (0..parameters)
            .map(|p| good.iter().filter(|r| r.held[p]).count() as f64 / good.len() as f64)
            .collect();
        let mut widths: Vec<f64> = good.iter().map(|r| r.width).collect();
        widths.sort_by(f64::total_cmp);
        Cell {
            recordings,
            refused: recordings - good.len(),
            mean: shares.iter().sum::<f64>() / parameters.max(1) as f64,
            worst: shares.iter().copied().fold(1.0, f64::min),
            width: widths.get(widths.len() / 2).copied().unwrap_or(0.0),
            found: good.iter().filter(|r| r.found).count() as f64 / good.len().max(1) as f64,
            reason: results.iter().find_map(|r| r.as_ref().err().cloned()),
        }
    }
}

fn one(
    rig: &HandHeld,
    recording: &HandHeldRecording,
    settings: &MultiPosition,
) -> Result<Run, String> {
    let [x, y, z] = &recording.outputs;
    let samples = Samples::new(x, y, z).map_err(|e| e.to_string())?;
    let found = StandstillCalibration::run(
        &samples,
        recording.rate,
        &[],
        &Standstill::default(),
        settings,
    )
    .map_err(|e| e.to_string())?;
    let given: Vec<Segment> = recording
        .rests
        .iter()
        .map(|rest| Segment {
            start: rest.start,
            end: rest.end,
            attitude: None,
            force_uncertainty: None,
            label: None,
        })
        .collect();
    let given = StandstillCalibration::of_segments(
        &samples,
        given,
        settings,
        StandstillEstimator::LeastSquares,
    )
    .map_err(|e| format!("rests as they were: {e}"))?;
    let held = found
        .fit
        .quantities()
        .iter()
        .map(|q| (q.value - of(&rig.sensor, &q.name)).abs() <= q.expanded(0.95))
        .collect();
    let width = |fit: &MultiPositionFit| {
        fit.quantities()
            .iter()
            .map(|q| q.expanded(0.95).ln())
            .sum::<f64>()
    };
    let parameters = found.fit.quantities().len() as f64;
    let ratio = ((width(&found.fit) - width(&given.fit)) / parameters).exp();
    Ok(Run {
        held,
        width: ratio,
        found: found.sweep.segments.len() == recording.rests.len(),
    })
}

fn of(sensor: &SensorModel<f64>, name: &str) -> f64 {
    let axis = |c: char| "xyz".find(c).unwrap_or(0);
    let letters: Vec<char> = name.rsplit('.').next().unwrap_or("").chars().collect();
    let (i, k) = (axis(letters[0]), sensor.k().0);
    match name.split('.').next() {
        Some("bias") => sensor.bias()[i],
        Some("scale") => k[i][i],
        _ => k[i][axis(letters[1])] / k[i][i],
    }
}

fn main() {
    let argument = |i| std::env::args().nth(i).and_then(|a| a.parse().ok());
    let (recordings, passed) = (argument(1).unwrap_or(1000), argument(2).unwrap_or(0));
    println!(
        "| rate / Hz | attitudes | rest / s | bits | noise / step | between rests / (mm/s²) | tremor / (mm/s²) | touched / % | coverage / % (worst) | U against given | found all / % | refused / % |"
    );
    println!("|{}", "---|".repeat(12));
    for place in &PLACES[passed.min(PLACES.len())..] {
        let cell = place.cell(recordings);
        println!(
            "| {} | {} | {} | {} | {} | {} | {} | {} | {:.1} ({:.1}) | {:.2} | {:.0} | {:.1} | {}",
            place.rate,
            place.attitudes,
            place.rest,
            place.bits,
            place.noise,
            place.wander,
            place.tremor,
            100.0 * place.touched,
            100.0 * cell.mean,
            100.0 * cell.worst,
            cell.width,
            100.0 * cell.found,
            100.0 * cell.refused as f64 / cell.recordings as f64,
            cell.reason.unwrap_or_default()
        );
    }
}

const fn place(rate: f64, attitudes: usize, rest: f64, noise: f64, wander: f64) -> Place {
    Place {
        rate,
        attitudes,
        rest,
        noise,
        wander,
        tremor: 0.0,
        touched: 0.0,
        bits: 16,
    }
}

const fn coarse(bits: i32, noise: f64) -> Place {
    Place {
        bits,
        ..place(50.0, 16, 10.0, noise, 1.0)
    }
}

/// The map.
pub const PLACES: [Place; 31] = [
    place(50.0, 12, 10.0, 4.0, 0.0),
    place(50.0, 12, 10.0, 4.0, 1.0),
    place(50.0, 16, 10.0, 4.0, 5.0),
    place(100.0, 12, 30.0, 4.0, 0.0),
    place(100.0, 12, 30.0, 4.0, 3.0),
    place(100.0, 24, 4.0, 4.0, 1.0),
    place(100.0, 16, 2.0, 4.0, 0.0),
    place(100.0, 24, 1.5, 4.0, 0.0),
    place(100.0, 24, 1.5, 4.0, 2.0),
    place(5.0, 16, 10.0, 4.0, 0.0),
    place(5.0, 12, 30.0, 4.0, 1.0),
    place(10.0, 12, 10.0, 4.0, 1.0),
    place(25.0, 10, 10.0, 4.0, 1.0),
    place(50.0, 12, 10.0, 0.05, 1.0),
    place(50.0, 12, 10.0, 0.2, 1.0),
    place(50.0, 12, 10.0, 0.5, 1.0),
    place(50.0, 12, 10.0, 1.0, 1.0),
    place(50.0, 12, 10.0, 10.0, 1.0),
    place(5.0, 12, 4.5, 4.0, 1.0),
    place(10.0, 16, 3.5, 4.0, 1.0),
    place(25.0, 16, 3.5, 4.0, 1.0),
    coarse(8, 0.05),
    coarse(8, 0.5),
    coarse(10, 0.2),
    coarse(12, 0.05),
    coarse(12, 0.2),
    coarse(12, 2.0),
    Place {
        tremor: 20.0,
        ..place(50.0, 12, 10.0, 4.0, 1.0)
    },
    Place {
        tremor: 100.0,
        ..place(100.0, 24, 4.0, 4.0, 1.0)
    },
    Place {
        touched: 0.2,
        ..place(50.0, 12, 10.0, 4.0, 1.0)
    },
    Place {
        tremor: 20.0,
        touched: 0.3,
        ..place(100.0, 24, 4.0, 4.0, 1.0)
    },
];
