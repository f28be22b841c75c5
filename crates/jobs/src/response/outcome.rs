//! What a frequency response came to.

use super::page::ResponseReport;
use super::{COMMON, ResponseJob};
use crate::frequency_response;
use crate::outcome::{Outcome, section};
use crate::record::Record;
use crate::trouble::Result;
use proofmass_dynamic::FrequencyResponse;
use proofmass_dynamic::model::{ModelFit, ResponseFigures};
use proofmass_dynamic::modes::Resonance;
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_io::{AnyCalibration, Cell, StatedQuantity, Table, Unit};
use proofmass_report::Report;
use proofmass_signal::transfer::{CrossSpectra, ResponseEstimate};
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, EstimateSeries, Evaluation, Finding,
    Influence, SeriesPoint, SharedEffect, student_quantile,
};
use serde::{Deserialize, Serialize};

/// Lines that a calibration file holds; of more, every n-th.
const MOST_LINES: usize = 400;

/// Densities of input and output.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResponsePower {
    /// Hz.
    pub frequency: Vec<f64>,
    /// Input, U²/Hz.
    pub input: Vec<f64>,
    /// Output, U²/Hz.
    pub output: Vec<f64>,
    /// Root mean square of input and output within the band.
    pub rms: [f64; 2],
}

impl ResponsePower {
    pub(super) fn of(spectra: &CrossSpectra, low: f64, high: f64) -> Self {
        let mut power = Self::default();
        let width = spectra.frequency.get(1).copied().unwrap_or(0.0);
        let mut sums = [0.0; 2];
        for (k, f) in spectra.frequency.iter().enumerate() {
            let Some(output) = spectra.outputs.first() else {
                break;
            };
            if !(low..=high).contains(f) {
                continue;
            }
            power.frequency.push(*f);
            power.input.push(spectra.input[k]);
            power.output.push(output.auto[k]);
            sums[0] += spectra.input[k] * width;
            sums[1] += output.auto[k] * width;
        }
        power.rms = sums.map(f64::sqrt);
        power
    }

    /// With the acceleration behind the volts of the input; lines that its calibration does not reach are left out.
    pub(super) fn seen_by(&mut self, standard: &ReferenceTable) -> Result<()> {
        let width = match self.frequency.as_slice() {
            [a, b, ..] => b - a,
            _ => 0.0,
        };
        let [low, high] = standard.reach();
        let keep: Vec<usize> = (0..self.frequency.len())
            .filter(|k| (low..=high).contains(&self.frequency[*k]))
            .collect();
        let input = keep.iter().map(|k| {
            let s = standard.at(self.frequency[*k])?.sensitivity;
            Ok(self.input[*k] / (s * s))
        });
        self.input = input.collect::<Result<_>>()?;
        self.output = keep.iter().map(|k| self.output[*k]).collect();
        self.frequency = keep.iter().map(|k| self.frequency[*k]).collect();
        let rms = |of: &[f64]| (width * of.iter().sum::<f64>()).sqrt();
        self.rms = [rms(&self.input), rms(&self.output)];
        Ok(())
    }
}

/// The answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResponseOutcome {
    request: ResponseJob,
    channels: [(String, String); 2],
    unit: String,
    independent: f64,
    response: ResponseEstimate,
    power: Option<ResponsePower>,
    modes: Vec<Resonance>,
    figures: Option<ResponseFigures>,
    fit: Option<ModelFit>,
    findings: Vec<Finding>,
}

impl ResponseOutcome {
    #[allow(clippy::too_many_arguments)] // The fields, once.
    pub(super) fn new(
        request: ResponseJob,
        channels: [(String, String); 2],
        unit: String,
        independent: f64,
        response: ResponseEstimate,
        power: Option<ResponsePower>,
        modes: Vec<Resonance>,
        figures: Option<ResponseFigures>,
        fit: Option<ModelFit>,
        findings: Vec<Finding>,
    ) -> Self {
        Self {
            request,
            channels,
            unit,
            independent,
            response,
            power,
            modes,
            figures,
            fit,
            findings,
        }
    }

    /// The frequency response by lines.
    pub fn response(&self) -> &ResponseEstimate {
        &self.response
    }

    /// Unit of the response.
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// Resonances, the lowest first.
    pub fn modes(&self) -> &[Resonance] {
        &self.modes
    }

    /// The fitted model, where one was asked for.
    pub fn fit(&self) -> Option<&ModelFit> {
        self.fit.as_ref()
    }

    /// Bandwidths, resonance, dampings.
    pub fn figures(&self) -> Option<&ResponseFigures> {
        self.figures.as_ref()
    }

    fn page(&self, record: &Record) -> ResponseReport<'_> {
        ResponseReport {
            head: record.head(self.title(record), &self.findings),
            channels: &self.channels,
            unit: &self.unit,
            independent: self.independent,
            response: &self.response,
            power: self.power.as_ref().map(|p| {
                (
                    p.frequency.as_slice(),
                    p.input.as_slice(),
                    p.output.as_slice(),
                    p.rms,
                )
            }),
            modes: &self.modes,
            figures: self.figures.as_ref(),
            fit: self.fit.as_ref(),
        }
    }
}

impl Outcome for ResponseOutcome {
    const KIND: &'static str = "frequency-response-test";

    fn title(&self, record: &Record) -> String {
        record.title("Frequency response of", "Frequency response")
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        let fitted = self.fit.iter().flat_map(|f| f.estimate.quantities());
        fitted.map(|q| StatedQuantity::new(&q, 0.95)).collect()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn estimate(&self) -> Option<&Estimate> {
        self.fit.as_ref().map(|f| &f.estimate)
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![
            section("modes", &self.modes)?,
            section("figures", &self.figures)?,
        ])
    }

    fn tables(&self) -> Result<Vec<(String, Table)>> {
        let unit = &self.unit;
        let mut table = Table::new([
            "frequency_Hz".to_owned(),
            format!("modulus_{unit}"),
            "phase_deg".to_owned(),
            format!("modulus_u_{unit}"),
            "phase_u_deg".to_owned(),
            format!("modulus_U95_{unit}"),
            "coherence".to_owned(),
            "dof".to_owned(),
        ]);
        let r = &self.response;
        for k in 0..r.lines() {
            let (u, turn) = r.polar_uncertainty(k);
            let reference = self.request.input_uncertainty * r.value[k].norm();
            let u = u.hypot(reference);
            table.push([
                Cell::Number(r.frequency[k]),
                Cell::Number(r.value[k].norm()),
                Cell::Number(r.value[k].arg().to_degrees()),
                Cell::Number(u),
                Cell::Number(turn.to_degrees()),
                Cell::Number(student_quantile(0.975, r.dof[k]) * u),
                r.coherence.get(k).copied().into(),
                Cell::Number(r.dof[k]),
            ])?;
        }
        let mut tables = vec![("response.csv".to_owned(), table)];
        if !self.modes.is_empty() {
            let mut table = Table::new(["frequency_Hz", "u_Hz", "damping", "u", "coherence"]);
            for m in &self.modes {
                table.push([
                    Cell::Number(m.frequency),
                    Cell::Number(m.frequency_uncertainty),
                    Cell::Number(m.damping),
                    Cell::Number(m.damping_uncertainty),
                    m.coherence.into(),
                ])?;
            }
            tables.push(("modes.csv".to_owned(), table));
        }
        if let Some(p) = &self.power {
            let mut table = Table::new(["frequency_Hz", "input_U2/Hz", "output_U2/Hz"]);
            for ((f, a), b) in p.frequency.iter().zip(&p.input).zip(&p.output) {
                table.push([*f, *a, *b])?;
            }
            tables.push(("densities.csv".to_owned(), table));
        }
        Ok(tables)
    }

    fn calibration(&self, record: &Record) -> Result<Option<AnyCalibration>> {
        let [(_, input), (_, output)] = &self.channels;
        let (Some(unit), "m/s²") = (Unit::recognise(output), input.as_str()) else {
            return Ok(None);
        };
        let r = &self.response;
        let every = r.independent_every.max(1) * r.lines().div_ceil(MOST_LINES).max(1);
        let mut points = Vec::new();
        let mut shared = COMMON.map(|(key, _)| SharedEffect {
            key: key.into(),
            effects: Vec::new(),
        });
        for k in (0..r.lines()).step_by(every) {
            let (z, [rr, ri, ii]) = (r.value[k], r.covariance[k]);
            let components = vec![
                Component::new("K.re", self.unit.clone(), z.re),
                Component::new("K.im", self.unit.clone(), z.im),
            ];
            let mut influences = vec![Influence {
                key: "noise".into(),
                description: "noise of the recording, and the width of its lines".into(),
                evaluation: Evaluation::A,
                distribution: "normal".into(),
                dof: DegreesOfFreedom::new(r.dof[k]).unwrap_or(DegreesOfFreedom::INFINITE),
                effect: Effect::Joint {
                    covariance: Covariance::try_from_rows(2, &[rr, ri, ri, ii])?,
                },
            }];
            let common = self.request.common(r.frequency[k])?;
            for (i, (relative, (key, description))) in common.iter().zip(COMMON).enumerate() {
                let effect = relative * z;
                shared[i].effects.push(vec![effect.re, effect.im]);
                if effect.norm() > 0.0 {
                    influences.push(Influence {
                        key: key.into(),
                        description: description.into(),
                        evaluation: Evaluation::B,
                        distribution: "normal".into(),
                        dof: DegreesOfFreedom::INFINITE,
                        effect: Effect::Scalar {
                            value: 0.0,
                            unit: "1".into(),
                            standard_uncertainty: relative.norm(),
                            sensitivity: [effect.re, effect.im]
                                .map(|v| v / relative.norm())
                                .to_vec(),
                        },
                    });
                }
            }
            points.push(SeriesPoint {
                at: r.frequency[k],
                estimate: Estimate::new(components, influences)?,
            });
        }
        if points.is_empty() {
            return Ok(None);
        }
        let shared = shared
            .into_iter()
            .filter(|s| s.effects.iter().any(|e| e.iter().any(|v| *v != 0.0)))
            .collect();
        let axis = vec!["axis".to_owned()];
        let series = EstimateSeries::new(points, Some(shared))?;
        let response = FrequencyResponse::new(axis.clone(), axis, series)?;
        let file = frequency_response::to_file(&response, "frequency response test", unit, record);
        Ok(Some(file.into()))
    }

    fn summary(&self, record: &Record) -> Report {
        self.page(record).summary()
    }

    fn report(&self, record: &Record) -> Report {
        self.page(record).full()
    }
}
