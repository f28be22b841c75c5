//! How many attitudes, and how long a rest in each.

use super::needed::{Known, Needed, What};
use super::noise::{rounded_up, short, spoken};
use super::{PROBABILITY, Way};
use crate::data_sheet::ReadLimit;
use crate::trouble::{Result, Trouble};
use proofmass_core::{Gravity, Matrix3, STANDARD_GRAVITY, SensorModel, Watch};
use proofmass_rig::{HandHeld, TurnedAxis};
use proofmass_static::static_test::Tilt;
use proofmass_static::{MultiPosition, Pose, Segment};
use proofmass_uncertainty::{Quantity, normal_quantile};
use std::f64::consts::TAU;

/// Numbers of attitudes, or of angles of one axis, that are tried; with fewer than twelve the intervals are several times as wide.
const ATTITUDES: [usize; 4] = [12, 16, 24, 40];

/// Shortest and longest rest, s.
const REST: [f64; 2] = [3.0, 600.0];

/// From one length that is tried to the next.
const STEP: f64 = 1.5;

/// Time to turn the sensor, s.
const TURN: f64 = 10.0;

/// Calibrations that are simulated for each length.
const RUNS: u64 = 32;

/// What the calibrations of one plan gave: the error of a quantity, and its expanded uncertainty.
#[derive(Default)]
struct Runs {
    bias: Vec<(f64, f64)>,
    scale: Vec<(f64, f64)>,
    angle: Vec<(f64, f64)>,
    /// How many gave no result.
    refused: usize,
}

impl Runs {
    fn of(&self, what: What) -> &[(f64, f64)] {
        match what {
            What::Bias => &self.bias,
            What::Scale => &self.scale,
            What::Angle => &self.angle,
        }
    }

    /// Share of the quantities that a device this far from its limit has decided: error and guard band within the margin.
    fn decided(&self, what: What, margin: f64, r: f64) -> f64 {
        let all = self.of(what);
        // An error has either sign as often.
        let within = all
            .iter()
            .flat_map(|(error, u)| [error + r * u, r * u - error]);
        let within = within.filter(|d| *d <= margin).count();
        let per_run = all.len() / (RUNS as usize - self.refused).max(1);
        within as f64 / (2 * (all.len() + self.refused * per_run)).max(1) as f64
    }
}

impl Known<'_> {
    /// The attitudes and rests after which the limits are decided, the quickest of those tried; where none decides all of them, those
    /// that decide most. What is tried are simulated calibrations by the estimator of `calibrate` itself. Longer is not always better: a
    /// bias that walks moves the rests against each other meanwhile.
    pub(super) fn positions(
        &self,
        limits: &[(&ReadLimit, &Needed)],
        watch: &dyn Watch,
    ) -> Result<Vec<Way>> {
        let targets: Vec<(What, f64)> = limits
            .iter()
            .map(|(limit, needed)| {
                let (what, si) = self.in_si(limit);
                (what, si * needed.margin)
            })
            .collect();
        let meets = |runs: &Runs, (what, margin): &(What, f64)| {
            runs.decided(*what, *margin, self.r()) >= self.given.decided
        };
        let [shortest, longest] = REST;
        let rests = std::iter::successors(Some(shortest), |t| Some(t * STEP));
        let rests = rests
            .take_while(|t| *t < STEP * longest)
            .map(|t| rounded_up(t.min(longest)));
        let mut tried: Vec<(usize, f64)> = rests
            .flat_map(|t| ATTITUDES.into_iter().map(move |n| (n, t)))
            .collect();
        let time = |(n, t): (usize, f64)| n as f64 * (t + TURN);
        tried.sort_by(|a, b| time(*a).total_cmp(&time(*b)));
        let mut chosen: Option<((usize, f64), Vec<bool>)> = None;
        for plan in tried {
            let runs = self.runs(plan.0, plan.1, watch)?;
            let met: Vec<bool> = targets.iter().map(|t| meets(&runs, t)).collect();
            let count = |met: &[bool]| met.iter().filter(|m| **m).count();
            let all = count(&met) == met.len();
            if chosen
                .as_ref()
                .is_none_or(|(_, best)| count(&met) > count(best))
            {
                chosen = Some((plan, met));
            }
            if all {
                break;
            }
        }
        let Some((plan, met)) = chosen else {
            return Ok(Vec::new());
        };
        let told = match self.given.axes {
            1 => format!(
                "{} angles, {}° apart, each at rest for {}",
                plan.0,
                short(360.0 / plan.0 as f64),
                spoken(plan.1)
            ),
            _ => format!("{} attitudes, each at rest for {}", plan.0, spoken(plan.1)),
        };
        Ok(limits
            .iter()
            .zip(met)
            .map(|((limit, _), met)| match met {
                true => Way {
                    positions: Some(plan),
                    ..Way::of(told.clone(), Some(time(plan)))
                },
                false => Way::out_of_reach(
                    told.clone(),
                    format!(
                        "{}: up to 40 rests of up to {} do not suffice; what is left is gravity, what varies between the attitudes, and slow noise",
                        limit.characteristic.name(),
                        spoken(longest)
                    ),
                ),
            })
            .collect())
    }

    /// Simulated calibrations of an ideal sensor with this noise.
    fn runs(&self, attitudes: usize, rest: f64, watch: &dyn Watch) -> Result<Runs> {
        let noise = self.noise.unwrap_or_default();
        let (of_mean, between) = noise.of_mean(rest);
        // A walk moves the rests against each other over the whole campaign.
        let whole = attitudes as f64 * (rest + TURN);
        let between = between + noise.walk.powi(2) * whole / 6.0 + self.given.wander.powi(2);
        match self.given.axes {
            1 => self.runs_of_one_axis(attitudes, of_mean + between, watch),
            _ => self.runs_of_three_axes(attitudes, of_mean, between, watch),
        }
    }

    /// Gravity as it is taken in a run: wrong by every quantile of its uncertainty once.
    fn gravity(&self, seed: u64) -> Result<Gravity> {
        let u = self.given.gravity_uncertainty.unwrap_or(0.0);
        let wrong = u * normal_quantile((seed as f64 + 0.5) / RUNS as f64);
        Ok(Gravity::given(STANDARD_GRAVITY + wrong, u)?)
    }

    /// One axis turned through angles evenly around a circle; a mean over a rest has this variance.
    fn runs_of_one_axis(&self, angles: usize, variance: f64, watch: &dyn Watch) -> Result<Runs> {
        let fixture = self.given.fixture_angle.unwrap_or(0.0).to_radians();
        let turn = |k: usize| TAU * k as f64 / angles as f64;
        let mut rig = TurnedAxis::default();
        rig.angles = (0..angles).map(turn).collect();
        (rig.bias, rig.sensitivity, rig.misalignment) = (0.0, 1.0, 0.0);
        rig.gravity = STANDARD_GRAVITY;
        // One sample stands for a rest.
        (rig.rate, rig.rest, rig.turn) = (1.0, 1.0, 0.0);
        rig.noise = variance.sqrt();
        let mut all = Runs::default();
        for seed in 0..RUNS {
            watch.step("limits", 0, self.limits.len() as u64)?;
            let recording = rig.simulate(seed + 1);
            // The sensitive axis is off the plane of turning by every quantile of that angle once, in another order than gravity.
            let off =
                normal_quantile(((7 * seed + 3) % RUNS) as f64 / RUNS as f64 + 0.5 / RUNS as f64);
            let seen = (fixture * off).cos();
            let output: Vec<f64> = recording.output.iter().map(|v| v * seen).collect();
            let mut tilt = Tilt::new(self.gravity(seed)?);
            (tilt.lean, tilt.out_of_plane) = (fixture, fixture);
            let Ok(fit) = tilt.fit(&rig.angles, &output, "m/s²") else {
                all.refused += 1;
                continue;
            };
            for q in fit.estimate.quantities() {
                match q.name.as_str() {
                    "bias" => all.bias.push((q.value, q.expanded(PROBABILITY))),
                    "sensitivity" => all.scale.push((q.value - 1.0, q.expanded(PROBABILITY))),
                    _ => {}
                }
            }
        }
        Ok(all)
    }

    fn runs_of_three_axes(
        &self,
        attitudes: usize,
        of_mean: f64,
        between: f64,
        watch: &dyn Watch,
    ) -> Result<Runs> {
        let ideal = Matrix3([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let rig = HandHeld {
            sensor: SensorModel::new(ideal, [0.0; 3]).map_err(Trouble::from)?,
            gravity: STANDARD_GRAVITY,
            // Four samples of a rest, whose mean has the noise of the rest.
            rate: 1.0,
            rest: 4.0,
            turn: 0.0,
            rests: attitudes,
            noise: 2.0 * of_mean.sqrt(),
            wander: between.sqrt(),
            resolution: 0.0,
            ..HandHeld::default()
        };
        let mut all = Runs::default();
        for seed in 0..RUNS {
            // So that it can be stopped between two of them.
            watch.step("limits", 0, self.limits.len() as u64)?;
            let recording = rig.simulate(seed + 1);
            let poses: Vec<Pose> = recording
                .rests
                .iter()
                .map(|r| {
                    let n = (r.end - r.start).max(1) as f64;
                    let mean = std::array::from_fn(|i| {
                        recording.outputs[i][r.start..r.end].iter().sum::<f64>() / n
                    });
                    let segment = Segment {
                        start: r.start,
                        end: r.end,
                        attitude: None,
                        force_uncertainty: None,
                        label: None,
                    };
                    let v = rig.noise.powi(2) / n;
                    Pose {
                        covariance: Some([[v, 0.0, 0.0], [0.0, v, 0.0], [0.0, 0.0, v]]),
                        ..Pose::reading(segment, mean)
                    }
                })
                .collect();
            let fit = MultiPosition::new(self.gravity(seed)?)
                .nominal_sensitivity(1.0)
                .output_unit("m/s²")
                .probability(PROBABILITY)
                .fit(&poses);
            let Ok(fit) = fit else {
                all.refused += 1;
                continue;
            };
            for q in fit.quantities() {
                let of = |truth: f64, q: &Quantity| (q.value - truth, q.expanded(PROBABILITY));
                match q.name.split('.').next() {
                    Some("bias") => all.bias.push(of(0.0, q)),
                    Some("scale") => all.scale.push(of(1.0, q)),
                    Some("misalignment") => all.angle.push(of(0.0, q)),
                    _ => {}
                }
            }
        }
        Ok(all)
    }
}
