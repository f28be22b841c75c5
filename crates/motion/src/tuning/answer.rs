//! Everything that is told about the chosen model.

use super::doubt::{at_bound, not_white, resting, rounding_explains, rounding_repeats};
use super::spread::{LN10, parameters, shifted};
use super::{NoiseNode, Point, Search, Tuned, TunedValue};
use crate::diffuse::Noise;
use crate::whiteness::autocorrelation;
use crate::{BiasModel, KalmanModel, Whiteness};
use proofmass_core::Error;

impl Search<'_> {
    /// Everything that is told about the chosen model.
    pub(super) fn tuned(
        mut self,
        mut point: Point,
        repeats: Option<f64>,
        readings: usize,
    ) -> Result<Tuned, Error> {
        if point.noise.colour.is_some() {
            self.known = Some(point.noise.r);
        }
        if self.effective < self.readings {
            let repeated = self.readings / self.effective;
            point.solution.widen(repeated, self.held());
        }
        let profile = self.profile(&point)?;
        let d = parameters(&point.noise);
        let curvature = self.curvature(&point, d)?;
        let interval = if d == 1 {
            self.interval(&point)?
        } else {
            // With the other parameters at their best: the quadratic form.
            curvature.as_ref().map(|spread| {
                let variance: f64 = spread.iter().map(|x| x[0] * x[0]).sum();
                let half = 1.96 * variance.sqrt() * LN10;
                (half, half)
            })
        };
        let mut nodes = Vec::new();
        if let Some(spread) = &curvature {
            for direction in spread {
                for sign in [-1.0, 1.0] {
                    let by: Vec<f64> = direction
                        .iter()
                        .map(|x| sign * (d as f64).sqrt() * x)
                        .collect();
                    let noise = shifted(&point.noise, &by);
                    if let Some(p) = self.best(&noise, &[point.unknowns])? {
                        nodes.push(NoiseNode::of(&p.noise));
                    }
                }
            }
        }
        if nodes.is_empty() {
            nodes.push(NoiseNode::of(&point.noise));
        }
        // Another maximum counts as much as the one with all its surroundings.
        let own = nodes.len();
        for other in &point.alike {
            nodes.extend(std::iter::repeat_n(NoiseNode::of(other), own));
        }
        let innovations = self.prepared.innovations(&point.noise, &point.solution);
        let whiteness = Whiteness::test(&innovations)?;
        let correlation = autocorrelation(&innovations, whiteness.lags);
        let found = |pair: Option<(f64, f64)>| {
            pair.map(|(value, uncertainty)| TunedValue { value, uncertainty })
        };
        let offset = found(point.solution.offset());
        // An offset behind two stages is a bend of what was given back, and the state of the filter is the offset.
        let start = match (self.record.behind_two_stages(), point.solution.parabola()) {
            (Some(corner), Some((bend, u))) => {
                let one = corner.of_offset();
                found(Some((bend / one, u / one)))
            }
            _ => offset,
        };
        let gain = point.solution.gain().map(|(g, u)| {
            let gain = 1.0 / (1.0 - g);
            TunedValue {
                value: gain,
                uncertainty: u * gain * gain,
            }
        });
        let mut findings = Vec::new();
        if let Some(r) = repeats {
            findings.extend(rounding_repeats(r, point.noise.r));
        }
        if self.record.accelerometer {
            findings.extend(at_bound(&point.noise, self.unit()));
        }
        findings.extend(resting(self.record));
        let samples = whiteness.samples as f64;
        let by_rounding = rounding_explains(self.record, point.noise.r, self.effective, samples);
        let accelerometer = self.record.accelerometer;
        findings.extend(not_white(
            accelerometer,
            &whiteness,
            &correlation,
            by_rounding,
        ));
        let model = KalmanModel {
            acceleration_noise: point.noise.q,
            noise_form: point.noise.form,
            // On line the correlated part counts as white.
            reading_noise: point.noise.r + point.noise.colour.map_or(0.0, |(v, _)| v),
            bias: start.map(|b| BiasModel::RandomWalk {
                density: self.walked(&point.noise),
                initial: 3.0 * b.value.abs() + 3.0 * b.uncertainty,
            }),
            interpolation: self.tuning.interpolation,
        };
        Ok(Tuned {
            model,
            offset,
            ramp: found(point.solution.ramp()),
            bend: found(point.solution.parabola()),
            gain,
            latency: found(point.solution.latency()),
            coloured: NoiseNode::of(&point.noise).coloured,
            log_likelihood: point.log_likelihood,
            noise_floor: self.floor,
            effective_readings: self.effective.min(readings as f64),
            log_q_interval: interval,
            profile,
            whiteness,
            autocorrelation: correlation,
            passes: self.passes,
            findings,
            nodes,
            unknowns: point.unknowns,
            shift: 0.0,
        })
    }

    /// Density of the walk; none where it adds to nothing over the record beside the noise of the samples.
    fn walked(&self, noise: &Noise) -> f64 {
        let duration = self.record.sample_time * self.record.reading.len() as f64;
        let shows = |density: &f64| density * duration > 1e-12 * noise.q;
        noise.walk.filter(shows).unwrap_or(0.0)
    }
}
