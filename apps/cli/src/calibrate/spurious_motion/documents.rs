//! The results as files: result.json, the corrections and tables.

use super::Measurement;
use crate::shaker::inputs;
use crate::shaker::runs::Observed;
use crate::{Failure, clock};
use proofmass::calibration::shaker::spurious::{Average, CircularStatistics, Comparison};
use proofmass::io::{Cell, Input, ResultDocument, Table};
use proofmass::jobs::campaign::{Certificate, SpuriousFile, SpuriousMotionCampaign};
use proofmass::uncertainty::Finding;
use serde::Serialize;

/// One ratio in result.json.
#[derive(Serialize)]
struct Ratio<'a> {
    measurement: &'a str,
    inclination_deg: f64,
    frequency_hz: f64,
    axis: &'a str,
    runs: &'a [String],
    /// Real and imaginary part of every repeat; along z′ of the whole motion.
    repeats: Vec<[f64; 2]>,
    phases: CircularStatistics,
    averaged: bool,
    mean: Option<[f64; 2]>,
    covariance: Option<[f64; 3]>,
    degrees_of_freedom: Option<f64>,
}

fn collected(measurements: &[Measurement]) -> Vec<Ratio<'_>> {
    let mut list = Vec::new();
    for m in measurements {
        for ((repeats, runs), summary) in m.repeats.iter().zip(&m.runs).zip(&m.summaries) {
            let estimate = match &summary.average {
                Average::Coherent(estimate) => Some(estimate),
                Average::Incoherent { .. } => None,
            };
            list.push(Ratio {
                measurement: &m.label,
                inclination_deg: repeats.inclination.to_degrees(),
                frequency_hz: repeats.frequency,
                axis: summary.axis,
                runs,
                repeats: repeats.ratios.iter().map(|z| [z.re, z.im]).collect(),
                phases: summary.phases,
                averaged: estimate.is_some(),
                mean: estimate.map(|e| [e.mean.re, e.mean.im]),
                covariance: estimate.map(|e| e.covariance),
                degrees_of_freedom: estimate.map(|e| e.dof),
            });
        }
    }
    list
}

fn files<'a>(
    campaign: &'a SpuriousMotionCampaign,
    certificate: Option<&'a Certificate>,
    observed: &'a Observed,
) -> impl Iterator<Item = &'a Input> {
    std::iter::once(&campaign.source.input)
        .chain(certificate.map(|c| &c.input))
        .chain(&observed.inputs)
}

/// Files for the report; many recordings stand in result.json, one by one.
pub(super) fn listed(
    campaign: &SpuriousMotionCampaign,
    certificate: Option<&Certificate>,
    observed: &Observed,
) -> Vec<(String, String)> {
    let recordings = observed.inputs.len() - 1;
    let small = files(campaign, certificate, observed).count() - recordings;
    let mut list: Vec<(String, String)> = files(campaign, certificate, observed)
        .take(small)
        .map(|i| (i.path.clone(), i.sha256.clone()))
        .collect();
    if recordings > 0 {
        list.push((
            format!("{recordings} recordings"),
            "each in result.json".to_owned(),
        ));
    }
    list
}

pub(super) fn result(
    title: &str,
    campaign: &SpuriousMotionCampaign,
    certificate: Option<&Certificate>,
    observed: &Observed,
    measurements: &[Measurement],
    comparisons: &[(&str, Vec<Comparison>)],
    findings: &[Finding],
) -> Result<Vec<u8>, Failure> {
    let mut document = ResultDocument::new("spurious-motion")
        .title(title)
        .device(&campaign.device)
        .findings(findings);
    for input in files(campaign, certificate, observed) {
        document = document.input(input.clone());
    }
    Ok(document
        .section("date", &clock::today())?
        .section("ratios", &collected(measurements))?
        .section("comparisons", &comparisons)?
        .to_json()?)
}

/// `spurious.csv`, as a campaign on the shaker reads it.
pub(super) fn correction(measurement: &Measurement) -> Result<Table, Failure> {
    Ok(SpuriousFile::table(&inputs::spurious_rows(
        &measurement.table,
    ))?)
}

pub(super) fn ratios(measurements: &[Measurement]) -> Result<Table, Failure> {
    let mut table = Table::new([
        "measurement",
        "inclination_deg",
        "frequency_Hz",
        "axis",
        "repeats",
        "averaged",
        "real",
        "imaginary",
        "u_real",
        "u_imaginary",
        "mean_resultant_length",
        "rayleigh_p",
        "circular_standard_deviation_deg",
    ]);
    for r in collected(measurements) {
        let mut row = vec![
            Cell::from(r.measurement),
            Cell::from(r.inclination_deg),
            Cell::from(r.frequency_hz),
            Cell::from(r.axis),
            Cell::from(r.repeats.len()),
            Cell::from(if r.averaged { "yes" } else { "no" }),
        ];
        row.extend([0, 1].map(|k| Cell::from(r.mean.map(|m| m[k]))));
        row.extend([0, 2].map(|k| Cell::from(r.covariance.map(|c| c[k].sqrt()))));
        row.extend(
            [
                r.phases.resultant,
                r.phases.rayleigh_p,
                r.phases.standard_deviation.to_degrees(),
            ]
            .map(Cell::from),
        );
        table.push(row)?;
    }
    Ok(table)
}

pub(super) fn comparison(
    first: &str,
    comparisons: &[(&str, Vec<Comparison>)],
) -> Result<Table, Failure> {
    let mut table = Table::new([
        "first",
        "second",
        "inclination_deg",
        "frequency_Hz",
        "axis",
        "difference",
        "E_n",
    ]);
    for (label, list) in comparisons {
        for c in list {
            table.push([
                Cell::from(first),
                Cell::from(*label),
                Cell::from(c.inclination.to_degrees()),
                Cell::from(c.frequency),
                Cell::from(c.axis),
                Cell::from(c.difference),
                Cell::from(c.e_n),
            ])?;
        }
    }
    Ok(table)
}
