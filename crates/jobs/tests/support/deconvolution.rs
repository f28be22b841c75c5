//! A device that is one oscillator, its model as fitted, and the job that turns its output back.

use proofmass_dynamic::model::{
    FitProblem, Mode, ModelFit, ModelStructure, ResponsePoints, TransducerModel,
};
use proofmass_jobs::deconvolution::{DeconvolutionData, DeconvolutionJob, DeconvolutionOutcome};
use proofmass_jobs::{Channel, Job, Trouble, Unwatched};

/// V/(m/s²).
pub const SENSITIVITY: f64 = 1.4e-3;

/// The device, and its model fitted to sixty points up to one and a half resonances with 0.1 %.
pub fn fitted(frequency: f64, damping: f64) -> (TransducerModel, ModelFit) {
    let mode = Mode {
        frequency,
        damping,
        share: 1.0,
    };
    let model = TransducerModel {
        modes: vec![mode],
        ..TransducerModel::flat(SENSITIVITY)
    };
    let f: Vec<f64> = (1..=60).map(|k| 0.025 * frequency * f64::from(k)).collect();
    let response: Vec<_> = f.iter().map(|f| model.response(*f)).collect();
    let modulus: Vec<f64> = response.iter().map(|s| s.norm()).collect();
    let phase: Vec<f64> = response.iter().map(|s| s.arg()).collect();
    let u: Vec<f64> = modulus.iter().map(|m| 1e-3 * m).collect();
    let points = ResponsePoints::polar(f, &modulus, &u, &phase, &[1e-3; 60], "V/(m/s²)");
    let fit = FitProblem::new(ModelStructure::modes(1)).fit(&points.expect("points"));
    (model, fit.expect("a fit"))
}

/// Asks for the acceleration behind volts.
pub fn asked(
    job: &DeconvolutionJob,
    fit: &ModelFit,
    volts: &[f64],
    rate: f64,
) -> Result<DeconvolutionOutcome, Trouble> {
    let data = DeconvolutionData {
        fit,
        unit: "V/(m/s²)",
        channel: Channel {
            name: "u",
            unit: "V",
            data: volts,
        },
        rate,
        findings: &[],
        name: "shock",
    };
    job.evaluate(&data, &Unwatched)
}
