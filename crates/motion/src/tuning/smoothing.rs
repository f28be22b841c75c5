//! Velocity by the tuned model, the uncertainty of its parameters and constants included.

use super::Tuned;
use super::doubt::not_white;
use crate::counting::CountingTuned;
use crate::diffuse::{Prepared, Trajectory, Unknowns};
use crate::whiteness::autocorrelation;
use crate::{MotionRecord, Whiteness};
use proofmass_core::Error;

/// What a smoother does with offset, gain and latency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Constants {
    /// Found from the record it smooths.
    Fitted,
    /// Held as they were tuned.
    Held,
}

impl Tuned {
    /// Puts the noise that was found from the edges of counts in place of that of all readings.
    pub(crate) fn counted(
        &mut self,
        found: &CountingTuned,
        innovations: &[f64],
        part: &MotionRecord,
    ) -> Result<(), Error> {
        self.model.acceleration_noise = found.model.acceleration_noise;
        self.log_q_interval = found.log_q_interval;
        self.findings
            .retain(|f| !matches!(f.code(), "innovations-correlated" | "rounding-repeats"));
        if innovations.len() >= 20 {
            self.whiteness = Whiteness::test(innovations)?;
            self.autocorrelation = autocorrelation(innovations, self.whiteness.lags);
            let readings = part.reading.iter().flatten().count() as f64;
            let by_rounding = self.effective_readings < 0.5 * readings;
            let found = not_white(part.accelerometer, &self.whiteness, &[], by_rounding);
            self.findings.extend(found);
        }
        Ok(())
    }

    /// Takes back a shift of the accelerometer that was made before the tuning: what is told is all of the latency, and
    /// the smoother starts from the shift.
    pub(crate) fn shifted_before(&mut self, shift: f64) {
        self.shift = shift;
        if let Some(latency) = &mut self.latency {
            latency.value += shift;
        }
    }

    /// The time by which the accelerometer is late at which the readings are most probable with this noise, within 0.3 s:
    /// a correlation of motions of seconds tells it less well.
    pub(crate) fn likely_latency(&self, part: &MotionRecord) -> Option<f64> {
        const FARTHEST: f64 = 0.3;
        let step = part.sample_time * (0.02 / part.sample_time).ceil();
        let noise = self.noise();
        let unknowns = Unknowns {
            offset: true,
            latency: true,
            ..self.unknowns
        };
        let reach = (FARTHEST / step) as i32;
        let mut best: Option<(f64, f64)> = None;
        for k in -reach..=reach {
            let shift = step * f64::from(k);
            let moved = part.corrected(1.0, shift);
            let sums = Prepared::new(&moved, &self.model).sums(&noise, true);
            let Some(solution) = sums.solve(&moved, unknowns) else {
                continue;
            };
            let value = sums.log_likelihood(&solution);
            let latency = solution.latency().map_or(0.0, |(t, _)| t);
            // The slope is good for about a step.
            let at = shift + latency.clamp(-step, step);
            if best.is_none_or(|(_, v)| value > v) {
                best = Some((at, value));
            }
        }
        best.map(|(at, _)| at).filter(|at| at.abs() < FARTHEST)
    }

    /// The record with gain and latency of the accelerometer put right as found.
    pub fn corrected(&self, record: &MotionRecord) -> MotionRecord {
        record.corrected(
            self.gain.map_or(1.0, |g| g.value),
            self.latency.map_or(0.0, |t| t.value),
        )
    }

    /// Velocity by the smoother of the found model, the uncertainty of its parameters and constants included.
    ///
    /// Mean over the nodes around the maximum; the variance is the mean variance plus the spread of the values. Offset,
    /// gain and latency are found anew from all of the record, or held as they were found (a record with slip).
    ///
    /// # Errors
    /// Of the record; [`Error::TooFew`] when its readings do not determine the constants; [`Error::NotFinite`].
    pub(crate) fn smooth(
        &self,
        record: &MotionRecord,
        constants: Constants,
    ) -> Result<Trajectory, Error> {
        record.check()?;
        let walks = self.nodes.iter().any(|n| n.walk.is_some());
        let (unknowns, corrected) = match constants {
            Constants::Fitted if self.shift == 0.0 => (self.unknowns, None),
            Constants::Fitted => (self.unknowns, Some(record.corrected(1.0, self.shift))),
            Constants::Held => {
                let mut corrected = self.corrected(record);
                if !walks {
                    let offset = self.offset.map_or(0.0, |b| b.value);
                    corrected.acceleration.iter_mut().for_each(|a| *a -= offset);
                }
                let unknowns = Unknowns {
                    offset: walks,
                    ..Unknowns::default()
                };
                (unknowns, Some(corrected))
            }
        };
        let record = corrected.as_ref().unwrap_or(record);
        let prepared = Prepared::new(record, &self.model);
        let n = record.reading.len();
        let share = 1.0 / self.nodes.len() as f64;
        let few = || Error::TooFew {
            name: "readings for the constants of the model",
            needed: 8,
            got: record.reading.iter().flatten().count(),
        };
        let mut runs = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let noise = node.noise(self.model.noise_form);
            let sums = prepared.sums(&noise, unknowns.gain || unknowns.latency);
            let mut solution = sums.solve(record, unknowns).ok_or_else(few)?;
            let repeated = (sums.n as f64 / self.effective_readings).max(1.0);
            solution.widen(repeated, record.gain_uncertainty);
            runs.push(prepared.smooth(&noise, &solution)?);
        }
        let mix = |value: &Series| {
            let (mut mean, mut u) = (vec![0.0; n], vec![0.0; n]);
            for run in &runs {
                for (m, v) in mean.iter_mut().zip(value(run).0) {
                    *m += share * v;
                }
            }
            for run in &runs {
                let (v, own) = value(run);
                for k in 0..n {
                    u[k] += share * (own[k] * own[k] + (v[k] - mean[k]).powi(2));
                }
            }
            u.iter_mut().for_each(|u| *u = u.sqrt());
            (mean, u)
        };
        let (velocity, uncertainty) = mix(&|t| (&t.velocity, &t.uncertainty));
        let offset = runs[0].offset.is_some().then(|| {
            mix(&|t| match &t.offset {
                Some((v, u)) => (v, u),
                None => (&t.velocity, &t.uncertainty),
            })
        });
        Ok(Trajectory {
            velocity,
            uncertainty,
            offset,
            innovations: runs.swap_remove(0).innovations,
        })
    }
}

/// One series of a trajectory with its uncertainty.
type Series = dyn Fn(&Trajectory) -> (&[f64], &[f64]);
