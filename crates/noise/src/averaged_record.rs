//! A record in some thousand averages, in which slow courses are sought: sinusoids of few cycles, transients, the lag behind a
//! temperature.

use crate::FitOptions;
use crate::Term;
use crate::cosine_spectrum::{CosineSpectrum, Form};
use crate::effects::Effects;
use crate::fit_record::FitRecord;
use crate::markov;
use crate::term_density::{Process, column};
use crate::variance_fit::{Likelihood, Minimum};

/// Averages of a record, at least, where it has as many samples.
const AVERAGES: usize = 4096;

/// The averages, and what stands beside them.
pub(crate) struct AveragedRecord {
    pub(crate) stretches: Vec<Vec<f64>>,
    /// Middle of the first average of each stretch, s.
    pub(crate) starts: Vec<f64>,
    pub(crate) sample_rate: f64,
    /// Samples in an average.
    pub(crate) factor: usize,
    /// Length of the record in s, gaps included.
    pub(crate) span: f64,
    /// What stands beside: the temperature, and what was found.
    pub(crate) known: Vec<Form>,
}

impl AveragedRecord {
    /// Of a record, beside forms over all its samples.
    pub(crate) fn of(record: &FitRecord<'_>, known: &[Form], sample_rate: f64) -> Self {
        let factor = (record.samples() / AVERAGES).max(1);
        let middle = 0.5 * (factor - 1) as f64;
        Self {
            stretches: record.stretches.iter().map(|s| means(s, factor)).collect(),
            starts: record
                .starts()
                .iter()
                .map(|s| (*s as f64 + middle) / sample_rate)
                .collect(),
            sample_rate: sample_rate / factor as f64,
            factor,
            span: record.span() as f64 / sample_rate,
            known: known
                .iter()
                .map(|form| Form {
                    samples: form.samples.iter().map(|s| means(s, factor)).collect(),
                    highest: form.highest,
                })
                .collect(),
        }
    }

    /// Averages of each stretch.
    pub(crate) fn lengths(&self) -> Vec<usize> {
        self.stretches.iter().map(Vec::len).collect()
    }

    /// The spectrum beside what is known and further forms.
    pub(crate) fn spectrum(&self, further: &[Form]) -> CosineSpectrum {
        let parts: Vec<&[f64]> = self.stretches.iter().map(Vec::as_slice).collect();
        let forms: Vec<Form> = self.known.iter().chain(further).cloned().collect();
        CosineSpectrum::beside(&parts, &forms, self.sample_rate, &[])
    }
}

/// Means of so many neighbours each.
pub(crate) fn means(samples: &[f64], factor: usize) -> Vec<f64> {
    samples
        .chunks_exact(factor)
        .map(|c| c.iter().sum::<f64>() / factor as f64)
        .collect()
}

/// The terms of the model over the bins of the averages.
pub(crate) struct AveragedFit {
    columns: Vec<Vec<f64>>,
    /// Slope of a ramp that is not fitted.
    given: Option<f64>,
    held: Vec<Option<f64>>,
    /// Which columns grow towards low frequencies.
    coloured: Vec<usize>,
}

impl AveragedFit {
    /// `None` where the averages are too few to tell anything.
    pub(crate) fn new(averages: &AveragedRecord, options: &FitOptions) -> Option<Self> {
        let spectrum = averages.spectrum(&[]);
        if spectrum.bins.len() < 12 {
            return None;
        }
        let averaged = options.averaged * averages.factor;
        let mut terms: Vec<Term> = options.terms.clone();
        terms.retain(|t| crate::quick_fit::POWERS.contains(t));
        let mut held: Vec<Option<f64>> = terms
            .iter()
            .map(|t| options.fixed(*t).map(|c| c * c))
            .collect();
        let mut columns: Vec<Vec<f64>> = terms
            .iter()
            .map(|t| column(&spectrum, Process::Power(*t), averaged))
            .collect();
        if options.seeks(Term::GaussMarkov) {
            let search = markov::Search {
                spectrum: &spectrum,
                highest: 0.5 * averages.sample_rate,
                walk: terms.iter().position(|t| *t == Term::RandomWalk),
                front_end: None,
            };
            let plain = Likelihood::new(&spectrum, columns);
            columns = search.add(plain, &held, options).0.columns;
            held.resize(columns.len(), None);
        }
        let coloured = (0..columns.len())
            .filter(|t| !matches!(terms.get(*t), Some(Term::Quantisation | Term::White)))
            .filter(|t| held[*t].is_none())
            .collect();
        Some(Self {
            columns,
            given: match options.fixed(Term::Ramp) {
                Some(slope) => Some(slope),
                None => (!options.seeks(Term::Ramp)).then_some(0.0),
            },
            held,
            coloured,
        })
    }

    /// The likelihood of the averages beside further forms, and how many forms stand before these.
    pub(crate) fn likelihood(
        &self,
        averages: &AveragedRecord,
        further: &[Form],
    ) -> (Likelihood, usize) {
        let spectrum = averages.spectrum(further);
        let likelihood = Likelihood::new(&spectrum, self.columns.clone());
        let likelihood = match self.given {
            Some(slope) => likelihood.given(0, slope),
            None => likelihood,
        };
        let before = likelihood.forms - further.len();
        (likelihood, before)
    }

    /// Least −2 ln L of a likelihood of these averages; its first so many forms are at their best and all others integrated out.
    pub(crate) fn minimum(&self, likelihood: &Likelihood, at_best: usize) -> Option<Minimum> {
        let effects = match at_best {
            0 => Effects::Restricted,
            n => Effects::Best(n),
        };
        let crude = likelihood.start();
        let weak: Vec<f64> = crude.iter().map(|v| 0.03 * v).collect();
        likelihood.minimise(&[&crude, &weak], &self.held, effects)
    }

    /// The same without noise that grows towards low frequencies.
    pub(crate) fn without_colour(&self, likelihood: &Likelihood) -> Option<Minimum> {
        let mut held = self.held.clone();
        for t in &self.coloured {
            held[*t] = Some(0.0);
        }
        let crude = likelihood.start();
        likelihood.minimise(&[&crude], &held, Effects::Restricted)
    }

    /// Least −2 ln L with further forms at their best.
    pub(crate) fn least(&self, averages: &AveragedRecord, further: &[Form]) -> Option<Minimum> {
        let (likelihood, before) = self.likelihood(averages, further);
        let mut order: Vec<usize> = (before..likelihood.forms).collect();
        order.extend(0..before);
        self.minimum(&likelihood.with_forms(&order), further.len())
    }
}
