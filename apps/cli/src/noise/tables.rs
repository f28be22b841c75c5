//! The tables and the list of findings of a noise analysis.

use crate::Failure;
use proofmass::io::{Cell, Table};
use proofmass::noise::Analysis;
use proofmass::uncertainty::Finding;

/// Those of the recording, of the whole analysis, and of each channel with its name.
pub(super) fn findings(recording: &[Finding], analysis: &Analysis) -> Vec<Finding> {
    let mut findings = recording.to_vec();
    findings.extend(analysis.findings.iter().cloned());
    for channel in &analysis.channels {
        findings.extend(channel.findings.iter().map(|f| {
            Finding::new(
                f.severity(),
                f.code(),
                format!("{}: {}", channel.name, f.what()),
            )
            .evidence(f.evidence_text())
            .advice(f.advice_text())
        }));
    }
    findings
}

/// Every curve of every channel.
pub(super) fn deviations(analysis: &Analysis) -> Result<Vec<u8>, Failure> {
    let mut table = Table::new([
        "channel",
        "unit",
        "statistic",
        "factor",
        "tau_s",
        "deviation",
        "low",
        "high",
        "edf",
    ]);
    for channel in &analysis.channels {
        let curves = channel.curve.iter().chain(&channel.further);
        for (curve, p) in curves.flat_map(|c| c.points.iter().map(move |p| (c, p))) {
            table.push([
                Cell::from(channel.name.as_str()),
                Cell::from(channel.unit.as_str()),
                Cell::from(curve.statistic.abbreviation()),
                Cell::from(p.factor),
                Cell::from(p.tau),
                Cell::from(p.deviation),
                Cell::from(p.interval.map(|i| i.0)),
                Cell::from(p.interval.map(|i| i.1)),
                Cell::from(p.edf),
            ])?;
        }
    }
    Ok(table.to_csv()?)
}

/// The spectrum of every channel.
pub(super) fn spectra(analysis: &Analysis) -> Result<Vec<u8>, Failure> {
    let mut table = Table::new([
        "channel",
        "unit",
        "frequency_Hz",
        "density_one_sided",
        "low",
        "high",
    ]);
    for channel in &analysis.channels {
        for p in &channel.spectrum {
            table.push([
                Cell::from(channel.name.as_str()),
                Cell::from(format!("({})²/Hz", channel.unit).as_str()),
                Cell::from(p.frequency),
                Cell::from(p.density),
                Cell::from(p.interval.map(|i| i.0)),
                Cell::from(p.interval.map(|i| i.1)),
            ])?;
        }
    }
    Ok(table.to_csv()?)
}
