//! Noise of a counted axis by the likelihood of its edges.

use super::{Counted, CountingModel, CountingTuned};
use crate::ProcessNoise;
use crate::floor::{noise_floor, variance};
use crate::search::{line, simplex};
use crate::tuning::PRIOR;
use crate::velocity::tied;
use proofmass_core::{Error, Watch};
use std::f64::consts::LN_10;

impl Counted<'_> {
    /// Variance of the place of an edge that stands where it should, counts²: a thousandth of a count does not show in
    /// samples, to a clock it does.
    fn exact(&self) -> f64 {
        if self.record.edges.is_some() {
            1e-8
        } else {
            1e-6
        }
    }

    /// Finds q and the variance of an edge's place from the counts, q held by the accelerometer's own floor: that of
    /// its samples as they were recorded (`heard`), since putting a latency right takes noise off them.
    ///
    /// # Errors
    /// [`Error::Cancelled`], and of the record.
    pub fn tune(&self, heard: &[f64], watch: &dyn Watch) -> Result<CountingTuned, Error> {
        let a = heard;
        if !self.record.accelerometer {
            return self.tune_alone(watch);
        }
        let ceiling = variance(a).max(f64::MIN_POSITIVE);
        let floor = noise_floor(a)
            .filter(|q| *q > 0.0)
            .unwrap_or(1e-3 * ceiling);
        let mean = a.iter().sum::<f64>() / a.len() as f64;
        let offset = 3.0 * mean.abs() + 3.0 * ceiling.sqrt();
        let prior = |q: f64| {
            let off = (q / floor).ln();
            -0.5 * (off / if off < 0.0 { PRIOR.0 } else { PRIOR.1 }).powi(2)
        };
        // Where the noise was integrated, the offset walks by it.
        let form = ProcessNoise::SampleConstant;
        let model = |log: f64, edge: f64| {
            let q = 10f64.powf(log);
            CountingModel {
                acceleration_noise: q,
                edge,
                offset,
                walk: tied(self.record, q, form).unwrap_or(0.0),
            }
        };
        let mut passes = 0;
        let mut value = |log: f64, edge: f64| -> Result<f64, Error> {
            passes += 1;
            watch.step("likelihood of the edges", passes, 0)?;
            let model = model(log, edge);
            Ok(self.log_likelihood(&model)? + prior(model.acceleration_noise))
        };
        let centre = floor.log10();
        let high = ceiling.log10().min(centre + 2.0).max(centre + 0.1);
        let exact = self.exact();
        let mut best = (f64::NEG_INFINITY, centre, exact);
        for edge in [exact, 1e-6, 1e-4, 5e-4, 2e-3, 5e-3, 2e-2] {
            let found = line(centre - 2.0, high, 0.5, 0.02, |log| value(log, edge))?;
            // An edge is where it should be unless the likelihood says otherwise.
            if found.value > best.0 + if edge > exact { 2.0 } else { 0.0 } {
                best = (found.value, found.at, edge);
            }
        }
        let (top, at, edge) = best;
        let curvature = -(value(at + 0.1, edge)? - 2.0 * top + value(at - 0.1, edge)?) / 0.01;
        let sigma = (1.0 / curvature.max(4.0)).sqrt();
        let half = 1.96 * sigma * LN_10;
        // The filter at the edges takes the interval of a count for normal while it rests: its likelihood is sharper than it is right, and
        // off by more where rests are long. What the floor of the accelerometer is held by is the least that is stated.
        let stated = |floor: f64| half.max(1.96 * floor);
        Ok(CountingTuned {
            model: model(at, edge),
            log_q_interval: Some((stated(PRIOR.0), stated(PRIOR.1))),
            nodes: vec![model(at - sigma, edge), model(at + sigma, edge)],
        })
    }

    /// The same where there is no accelerometer: the acceleration is a random walk with noise beside it, and the counts
    /// alone tell how much of each.
    fn tune_alone(&self, watch: &dyn Watch) -> Result<CountingTuned, Error> {
        let dt = self.record.sample_time;
        // One count per sample squared.
        let unit = self.increment / (dt * dt);
        let model = |x: &[f64; 2], edge: f64| CountingModel {
            acceleration_noise: 10f64.powf(x[0]) * unit * unit,
            edge,
            offset: unit,
            walk: 10f64.powf(x[1]) * unit * unit / dt,
        };
        let mut passes = 0;
        let mut value = |x: &[f64; 2], edge: f64| -> Result<f64, Error> {
            passes += 1;
            watch.step("likelihood of the edges", passes, 0)?;
            if x.iter().any(|x| !(-24.0..3.0).contains(x)) {
                return Ok(-1e300);
            }
            self.log_likelihood(&model(x, edge))
        };
        let exact = self.exact();
        let mut best = (f64::NEG_INFINITY, [-6.0, -9.0], exact);
        for edge in [exact, 5e-3] {
            let mut start = ([-6.0, -9.0], f64::NEG_INFINITY);
            for q in [-12.0, -8.0, -4.0, -1.0] {
                for walk in [-16.0, -13.0, -10.0, -7.0, -4.0] {
                    let found = value(&[q, walk], edge)?;
                    if found > start.1 {
                        start = ([q, walk], found);
                    }
                }
            }
            let found = simplex(start.0, 1.0, 150, |x| value(x, edge))?;
            if found.value > best.0 + if edge > exact { 2.0 } else { 0.0 } {
                best = (found.value, found.at, edge);
            }
        }
        let (top, at, edge) = best;
        let mut nodes = Vec::new();
        let mut half = 0.0;
        for i in 0..2 {
            let moved = |by: f64| {
                let mut x = at;
                x[i] += by;
                x
            };
            let bend = -(value(&moved(0.1), edge)? - 2.0 * top + value(&moved(-0.1), edge)?) / 0.01;
            // Half a decade at most, also where the difference found no maximum.
            let sigma = (1.0 / bend.max(4.0)).sqrt();
            if i == 0 {
                half = 1.96 * sigma * LN_10;
            }
            let by = 2f64.sqrt() * sigma;
            nodes.extend([model(&moved(-by), edge), model(&moved(by), edge)]);
        }
        Ok(CountingTuned {
            model: model(&at, edge),
            log_q_interval: Some((half, half)),
            nodes,
        })
    }
}
