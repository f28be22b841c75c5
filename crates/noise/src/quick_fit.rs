//! The best model of a spectrum without intervals, and a record without its known forms.

use crate::cosine_spectrum::{CosineSpectrum, Form};
use crate::effects::Effects;
use crate::fit_record::FitRecord;
use crate::slow_sinusoid;
use crate::term_density::{Process, column};
use crate::variance_fit::Likelihood;
use crate::{NoiseModel, Term};

/// The four terms with a density.
pub(crate) const POWERS: [Term; 4] = [
    Term::Quantisation,
    Term::White,
    Term::Flicker,
    Term::RandomWalk,
];

/// The best model of a spectrum, without intervals and over its whole band.
pub(crate) fn quick_model(spectrum: &CosineSpectrum, averaged: usize) -> NoiseModel {
    quick_fit(spectrum, averaged).0
}

/// The best model of a spectrum, and the sizes of its known forms.
pub(crate) fn quick_fit(spectrum: &CosineSpectrum, averaged: usize) -> (NoiseModel, Vec<f64>) {
    let columns = POWERS
        .iter()
        .map(|t| column(spectrum, Process::Power(*t), averaged))
        .collect();
    let likelihood = Likelihood::new(spectrum, columns);
    let mut model = NoiseModel::default();
    let mut sizes = vec![0.0; spectrum.forms];
    let start = likelihood.start();
    if let Some(best) = likelihood.minimise(&[&start], &[None; 4], Effects::Restricted) {
        if let Some(density) = likelihood.density(&best.squares) {
            sizes = likelihood.eliminated(&density, Effects::Restricted).sizes();
        }
        for (term, v) in POWERS.into_iter().zip(best.squares) {
            model.set(term, v.sqrt());
        }
    }
    (model, sizes)
}

/// Stretches without forms of these sizes.
pub(crate) fn without_forms(stretches: &[&[f64]], forms: &[Form], sizes: &[f64]) -> Vec<Vec<f64>> {
    let mut freed: Vec<Vec<f64>> = stretches.iter().map(|s| s.to_vec()).collect();
    for (form, size) in forms.iter().zip(sizes) {
        for (stretch, course) in freed.iter_mut().zip(&form.samples) {
            for (y, x) in stretch.iter_mut().zip(course) {
                *y -= size * x;
            }
        }
    }
    freed
}

/// Cosine and sine over the stretches of a record.
pub(crate) fn sinusoid_forms(
    record: &FitRecord<'_>,
    sample_rate: f64,
    frequency: f64,
) -> [Form; 2] {
    let (lengths, starts) = record.lengths_and_starts(sample_rate);
    slow_sinusoid::forms(&lengths, &starts, sample_rate, frequency)
}
