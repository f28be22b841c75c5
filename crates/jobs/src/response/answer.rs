//! What opens the report of a frequency response without a model: resonances and lines that the input explains, each with U.

use super::ResponseOutcome;
use crate::page::answer::with_unit;
use proofmass_documents::StatedQuantity;
use proofmass_dynamic::modes::Resonance;
use proofmass_report::number::plain;
use proofmass_signal::transfer::ResponseEstimate;
use proofmass_uncertainty::{DegreesOfFreedom, Quantity, student_quantile};

/// Coherence from which on most of the output comes from the input. What is read below it is no result.
pub(super) const EXPLAINED: f64 = 0.75;
/// Chance with which unrelated signals reach the coherence that is asked for.
const CHANCE: f64 = 1e-3;
/// Times the modulus of the lowest line from which on a greatest one is told where there is no resonance.
const TALL: f64 = 1.25;

/// What a resonance needs: of n independent averages, unrelated signals reach a coherence of 1 − p^(1/(n−1)) with the chance p.
///
/// Their coherence is distributed as Beta(1, n − 1). It is told from noise by all its lines, and its intervals have the noise; a line that is
/// wider than the resonance lowers its coherence. **Source** `[BendatPiersol2010] 9.2`.
fn by_chance(averages: f64) -> f64 {
    match averages > 1.0 {
        true => 1.0 - CHANCE.powf(1.0 / (averages - 1.0)),
        false => 0.0,
    }
}

/// The coherence that a single line needs.
fn needed(averages: f64) -> f64 {
    EXPLAINED.max(by_chance(averages))
}

/// Points of single sines have no coherence: each was measured by itself.
pub(super) fn explained(coherence: Option<f64>, averages: f64) -> bool {
    coherence.is_none_or(|c| c >= needed(averages))
}

/// The line of a response that is stated: the one nearest to a frequency, else the lowest one, of those that the input explains
/// and that are told from zero.
pub(super) fn stated_line(
    response: &ResponseEstimate,
    averages: f64,
    wanted: Option<f64>,
) -> Option<usize> {
    let told = |k: &usize| {
        let expanded = student_quantile(0.975, response.dof[*k]) * response.polar_uncertainty(*k).0;
        expanded < response.value[*k].norm()
            && explained(response.coherence.get(*k).copied(), averages)
    };
    let mut lines = (0..response.lines()).filter(told);
    match wanted {
        Some(wanted) => nearest(response, lines, wanted),
        None => lines.next(),
    }
}

/// The one of some lines that is nearest to a frequency.
fn nearest(
    response: &ResponseEstimate,
    lines: impl Iterator<Item = usize>,
    frequency: f64,
) -> Option<usize> {
    let apart = |k: &usize| (response.frequency[*k] - frequency).abs();
    lines.min_by(|a, b| apart(a).total_cmp(&apart(b)))
}

/// Whether the input explains the line nearest to a frequency.
pub(super) fn explained_at(response: &ResponseEstimate, averages: f64, frequency: f64) -> bool {
    let line = nearest(response, 0..response.lines(), frequency);
    line.is_none_or(|k| explained(response.coherence.get(k).copied(), averages))
}

impl ResponseOutcome {
    /// Standard uncertainty of the modulus of a line, that of the input included.
    pub(super) fn modulus_uncertainty(&self, k: usize) -> f64 {
        let noise = self.input_noise.as_ref();
        let noise = noise.map_or(0.0, |n| n.standard_uncertainty(self.response.frequency[k]));
        let common = self.request.input_uncertainty.hypot(noise) * self.response.value[k].norm();
        self.response.polar_uncertainty(k).0.hypot(common)
    }

    /// Whether the input explains a resonance, and its damping is told from zero.
    pub(super) fn supported(&self, mode: &Resonance) -> bool {
        let expanded = student_quantile(0.975, mode.freedom) * mode.damping_uncertainty;
        let least = by_chance(self.independent);
        mode.coherence.is_none_or(|c| c >= least) && expanded < mode.damping
    }

    /// The lowest resonance that the data support.
    fn first_resonance(&self) -> Option<&Resonance> {
        self.modes.iter().find(|mode| self.supported(mode))
    }

    /// The lowest resonance, and the modulus and phase of one line.
    pub(super) fn read_off(&self) -> Vec<StatedQuantity> {
        let mut list = Vec::new();
        let mut add = |name: String, unit: &str, value: f64, u: f64, dof: f64| {
            if u.is_finite() {
                let quantity = Quantity {
                    name,
                    unit: unit.to_owned(),
                    value,
                    standard_uncertainty: u,
                    dof: DegreesOfFreedom::new(dof).unwrap_or(DegreesOfFreedom::INFINITE),
                };
                list.push(StatedQuantity::new(&quantity, 0.95));
            }
        };
        if let Some(mode) = self.first_resonance() {
            let dof = mode.freedom;
            let (f, uf) = (mode.frequency, mode.frequency_uncertainty);
            add("resonance.frequency".to_owned(), "Hz", f, uf, dof);
            let (zeta, u) = (mode.damping, mode.damping_uncertainty);
            add("resonance.damping".to_owned(), "1", zeta, u, dof);
        }
        let r = &self.response;
        if let Some(k) = stated_line(r, self.independent, self.request.reference_frequency) {
            let at = plain(r.frequency[k]);
            let (modulus, u) = (r.value[k].norm(), self.modulus_uncertainty(k));
            let name = format!("modulus[frequency={at}]");
            add(name, &self.unit, modulus, u, r.dof[k]);
            let (phase, u) = (r.value[k].arg(), r.polar_uncertainty(k).1);
            add(format!("phase[frequency={at}]"), "rad", phase, u, r.dof[k]);
        }
        list
    }

    /// Where the first resonance lies that the input explains, or what is known where there is none.
    pub(super) fn what_was_read(&self) -> String {
        let stated = self.read_off();
        let said = |beginning: &str| stated.iter().find(|q| q.name.starts_with(beginning));
        let Some(modulus) = said("modulus") else {
            return self.nothing_explained();
        };
        let resonance = match (said("resonance.frequency"), said("resonance.damping")) {
            (Some(frequency), Some(damping)) => format!(
                "The first resonance lies at {}, its damping ratio is {}.",
                with_unit(frequency),
                with_unit(damping)
            ),
            _ if self.response.lines() == 1 => format!("{}.", modulus_in_words(modulus)),
            _ => format!(
                "No resonance was found in the band{}. {}.",
                self.greatest(),
                modulus_in_words(modulus)
            ),
        };
        resonance + &self.unexplained()
    }

    /// What is seen of a peak to which no oscillator could be fitted.
    fn greatest(&self) -> String {
        let peak = self.figures.as_ref().and_then(|f| f.resonance);
        match peak.filter(|(_, gain)| *gain > TALL) {
            Some((frequency, gain)) => format!(
                ", though the modulus at {} Hz is {gain:.2} times that of the lowest line: no oscillator fits the lines there",
                plain(frequency)
            ),
            None => String::new(),
        }
    }

    /// Peaks below the first resonance that is stated, or all of them, where the data do not show one.
    fn unexplained(&self) -> String {
        let until = self
            .first_resonance()
            .map_or(f64::INFINITY, |r| r.frequency);
        let peaks: Vec<_> = self.modes.iter().filter(|m| m.frequency < until).collect();
        let Some(first) = peaks.first() else {
            return String::new();
        };
        let needed = by_chance(self.independent);
        let coherence = first.coherence.filter(|c| *c < needed);
        let coherence = coherence.map_or(String::new(), |c| {
            format!(", where the coherence is {c:.3} and {needed:.3} is needed,")
        });
        let lowest = first.frequency;
        match (peaks.len(), coherence.as_str()) {
            (1, _) => {
                format!(" A peak near {lowest:.0} Hz{coherence} is not supported by the data.")
            }
            (n, "") => format!(
                " {n} peaks, the lowest near {lowest:.0} Hz, are not supported by the data."
            ),
            (n, _) => format!(
                " {n} peaks, the lowest near {lowest:.0} Hz{coherence} are not supported by the data."
            ),
        }
    }

    fn nothing_explained(&self) -> String {
        let best = self.response.coherence.iter().zip(&self.response.frequency);
        let needed = needed(self.independent);
        match best.max_by(|a, b| a.0.total_cmp(b.0)) {
            Some((coherence, frequency)) if *coherence < needed => format!(
                "No line is supported by the data: the coherence is {coherence:.2} at most, at {} Hz, and {needed:.2} is needed.",
                plain(*frequency)
            ),
            _ => "No frequency line differs significantly from zero.".to_owned(),
        }
    }
}

fn modulus_in_words(q: &StatedQuantity) -> String {
    let at = crate::page::answer::label(&q.name);
    let at = at.trim_start_matches("modulus ");
    format!("The modulus {at} is {}", with_unit(q))
}
