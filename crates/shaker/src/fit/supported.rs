//! The budget as the runs have it: every declared uncertainty they can tell, where it is too small, and how well they tell.

use crate::adjustment::Adjustment;
use crate::budget::{Acts, Budget};
use crate::derived::PROBABILITY;
use crate::observation::{Basis, PhasorRow, Share, Spurious, SpuriousTable};
use proofmass_core::Error;
use proofmass_uncertainty::{DegreesOfFreedom, dof_of_coverage_factor};
use serde::Serialize;

/// A kind of error of which the runs tell how large it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct VarianceComponent {
    /// Key of the input; `readings` for all that differs from run to run, with its noise.
    pub key: String,
    /// Frequency in Hz, where it is that of one frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency: Option<f64>,
    /// Standard uncertainty by the runs over the declared one.
    pub estimated: f64,
    /// The one that was used over the declared one: the larger of the two.
    pub used: f64,
    /// Degrees of freedom that the runs have for it, with those of the declaration where it has any.
    pub freedom: f64,
    /// Degrees of freedom in the result: those with which t·û is the half width, or infinite where the declared one with
    /// the normal factor is larger; no more than `freedom` where the declaration has degrees of freedom.
    pub dof: DegreesOfFreedom,
}

/// What a gain or a phase of an output differs by from session to session, which nobody declared, as the runs have it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct BetweenSessions {
    /// Whether it is that of the phase, in rad, or of the modulus, relative.
    pub phase: bool,
    /// Standard deviation from session to session.
    pub standard_uncertainty: f64,
    /// Its degrees of freedom.
    pub dof: DegreesOfFreedom,
}

/// Runs and budget with the uncertainties that were used.
pub(crate) struct Supported {
    pub(crate) rows: Vec<PhasorRow>,
    pub(crate) budget: Budget,
    pub(crate) components: Vec<VarianceComponent>,
    /// What sessions differ by that nobody declared.
    pub(crate) between: Vec<BetweenSessions>,
    /// Degrees of freedom of the readings, by frequency.
    readings: Vec<f64>,
    /// Degrees of freedom of each input of the budget.
    inputs: Vec<f64>,
    /// The motion of the bench, with what the runs tell of what nobody measured.
    pub(crate) spurious: SpuriousTable,
    /// Degrees of freedom of the motion that nobody measured, where the runs tell it: of what each wedge has by itself by frequency.
    motion: Vec<(Share, Option<usize>, DegreesOfFreedom)>,
    /// Whether anything has another uncertainty than declared.
    changed: bool,
}

/// Key of what differs from run to run.
const READINGS: &str = "readings";

impl Supported {
    /// U = max(t(ν) û, 1.96 u) for each kind of error by itself, u the declared uncertainty: what the readings say with
    /// the freedom they have, or what was declared, and nothing is decided in between. What nobody declares, as the motion of
    /// the bench that nobody measured or what sessions differ by, is what the runs say, t(ν) û, as far as they tell it.
    ///
    /// **Source** restricted maximum likelihood `[Harville1977]` for û; the rule is that of
    /// [`BetweenScatter`](proofmass_uncertainty::BetweenScatter).
    pub(crate) fn new(
        adjustment: &Adjustment,
        rows: &[PhasorRow],
        spurious: &SpuriousTable,
        budget: &Budget,
    ) -> Result<Self, Error> {
        let found = adjustment.components(budget)?;
        let mut supported = Self {
            rows: rows.to_vec(),
            budget: budget.clone(),
            components: vec![],
            between: vec![],
            readings: vec![f64::INFINITY; adjustment.frequencies.len()],
            inputs: budget.inputs.iter().map(|i| i.dof.get()).collect(),
            spurious: spurious.clone(),
            motion: vec![],
            changed: false,
        };
        // `declared`: degrees of freedom of the declaration, which are in `freedom`.
        // `floor`: ratio below which the declared variance stands; zero where nobody declares one.
        let told = |key: &str, frequency, declared: f64, floor: f64, ratio: f64, freedom: f64| {
            let used = ratio.max(floor);
            let t = DegreesOfFreedom::new(freedom)
                .unwrap_or(DegreesOfFreedom::INFINITE)
                .coverage_factor(PROBABILITY);
            let dof = match dof_of_coverage_factor(t * (ratio / used).sqrt(), PROBABILITY) {
                dof if declared.is_finite() => dof.min(freedom),
                dof => dof,
            };
            let component = VarianceComponent {
                key: key.to_owned(),
                frequency,
                estimated: ratio.sqrt(),
                used: used.sqrt(),
                freedom,
                dof: DegreesOfFreedom::new(dof).unwrap_or(DegreesOfFreedom::INFINITE),
            };
            (component, dof)
        };
        let only = match adjustment.frequencies[..] {
            [frequency] => Some(frequency),
            _ => None,
        };
        let mut enlarged = vec![1.0; adjustment.frequencies.len()];
        for (f, component) in found.readings.iter().enumerate() {
            if let Some(c) = component {
                let frequency = Some(adjustment.frequencies[f]);
                let (component, dof) =
                    told(READINGS, frequency, f64::INFINITY, 1.0, c.ratio, c.freedom);
                supported.components.push(component);
                supported.readings[f] = dof;
                enlarged[f] = c.ratio.max(1.0);
            }
        }
        let mut factors = vec![1.0; budget.inputs.len()];
        for (index, component) in found.inputs.iter().enumerate() {
            let input = &budget.inputs[index];
            if input.assumed {
                let (ratio, freedom) = component.map_or((0.0, 1.0), |c| (c.ratio, c.freedom));
                factors[index] = ratio.sqrt();
                if component.is_some() {
                    let (told, dof) = told("", None, f64::INFINITY, 0.0, ratio, freedom);
                    supported.inputs[index] = dof;
                    supported.between.push(BetweenSessions {
                        phase: input.acts == Acts::OutputPhase,
                        standard_uncertainty: ratio.sqrt() * input.standard_uncertainty(),
                        dof: told.dof,
                    });
                }
            } else if let Some(c) = component {
                let (component, dof) =
                    told(&input.key, only, input.dof.get(), 1.0, c.ratio, c.freedom);
                supported.components.push(component);
                supported.inputs[index] = dof;
                factors[index] = c.ratio.max(1.0).sqrt();
            }
        }
        let declared = |e: &Spurious| e.basis.contains(&Basis::Declared);
        let floor = f64::from(u8::from(spurious.entries.iter().any(declared)));
        let mut moved = false;
        for motion in &found.motion {
            let dofs = motion.ways.iter().flatten().map(|c| {
                let (component, _) = told("", None, f64::INFINITY, floor, c.ratio, c.freedom);
                component.dof
            });
            let dof = dofs.fold(DegreesOfFreedom::INFINITE, |a, b| if b < a { b } else { a });
            supported.motion.push((motion.share, motion.frequency, dof));
            let factors = motion.ways.map(|c| c.map_or(1.0, |c| c.ratio.max(floor)));
            moved |= factors != [1.0; 2];
            let frequency = adjustment.frequency_of(motion);
            supported.spurious.scale(motion.share, frequency, factors);
        }
        let enlarges = enlarged.iter().chain(&factors).any(|&f| f != 1.0);
        supported.changed = enlarges || moved;
        if enlarges {
            let largest = enlarged.iter().copied().fold(1.0, f64::max).sqrt();
            for (input, factor) in supported.budget.inputs.iter_mut().zip(&factors) {
                if input.within_a_run() {
                    let at = adjustment.frequencies.iter().zip(&enlarged);
                    let at = at.map(|(&f, e)| (f, input.standard_uncertainty_at(f) * e.sqrt()));
                    input.at_frequencies = at.collect();
                    input.distribution = input.distribution.scaled(largest, 0.0);
                } else {
                    input.scale(*factor);
                }
            }
            for (row, &f) in supported.rows.iter_mut().zip(&adjustment.of_row) {
                for v in row.covariance.iter_mut().flatten() {
                    *v *= enlarged[f];
                }
            }
        }
        // What nobody declared and the runs do not tell is in no result.
        let mut kept = factors.iter().map(|f| *f > 0.0);
        supported.inputs.retain(|_| kept.next().unwrap_or(true));
        let mut kept = factors.iter().map(|f| *f > 0.0);
        let inputs = &mut supported.budget.inputs;
        inputs.retain(|_| kept.next().unwrap_or(true));
        Ok(supported)
    }

    /// The budget as declared, with what nobody declared as the runs have it; `None` where all of it is declared.
    pub(crate) fn as_declared(&self, budget: &Budget) -> Option<Budget> {
        budget.inputs.iter().any(|i| i.assumed).then(|| {
            let mut declared = budget.clone();
            declared.inputs.retain(|i| !i.assumed);
            let assumed = self.budget.inputs.iter().filter(|i| i.assumed);
            declared.inputs.extend(assumed.cloned());
            declared
        })
    }

    /// What runs of one session are judged by: readings and mountings as the runs have them, between sessions what is declared.
    pub(super) fn within_sessions(&self, budget: &Budget) -> Budget {
        let mut within = self.budget.clone();
        within.inputs.retain(|i| !i.assumed);
        for input in &mut within.inputs {
            let declared = budget.inputs.iter().find(|i| i.key == input.key);
            if let Some(declared) = declared.filter(|i| i.varies_between_sessions()) {
                input.clone_from(declared);
            }
        }
        within
    }

    /// The adjustment with what the runs say; `None` where the declared one is it.
    pub(crate) fn adjusted(&self) -> Result<Option<Adjustment>, Error> {
        let again = || Adjustment::new(&self.rows, &self.spurious, &self.budget);
        self.changed.then(again).transpose()
    }

    /// The same uncertainties as if nobody had estimated them.
    pub(crate) fn taken_as_declared(self) -> Self {
        Self {
            readings: vec![f64::INFINITY; self.readings.len()],
            motion: vec![],
            inputs: self.budget.inputs.iter().map(|i| i.dof.get()).collect(),
            ..self
        }
    }

    /// Degrees of freedom of the motion of the bench that nobody measured, at a frequency: the fewer of across and along.
    pub(super) fn motion_dof(&self, f: usize, share: Share) -> DegreesOfFreedom {
        let of = |m: &&(Share, Option<usize>, _)| m.0 == share && m.1.is_none_or(|own| own == f);
        let found = self.motion.iter().find(of);
        found.map_or(DegreesOfFreedom::INFINITE, |m| m.2)
    }

    /// Degrees of freedom of an influence at a frequency: of an input of the budget, or of the noise of the phasors
    /// (`None`). What differs from run to run is known as one thing, of which each influence has its `share`.
    pub(super) fn dof(&self, f: usize, input: Option<usize>, share: f64) -> DegreesOfFreedom {
        let readings = self.readings[f] * share;
        let nu = match input {
            Some(k) if self.budget.inputs[k].within_a_run() => self.inputs[k].min(readings),
            Some(k) => self.inputs[k],
            None => readings,
        };
        DegreesOfFreedom::new(nu).unwrap_or(DegreesOfFreedom::INFINITE)
    }
}
