//! The results as tables.

use crate::trouble::Result;
use proofmass_io::{Cell, StatedQuantity, Table};
use proofmass_shaker::derived::{Expanded, SensitivityTerm};
use proofmass_shaker::recording::{CHANNELS, RunInput};
use proofmass_shaker::{
    FrequencyCheck, FrequencyResult, MethodResult, OutputUnit, ShakerCalibration, ShakerMethod,
};
use proofmass_uncertainty::{DegreesOfFreedom, Verdict};

/// Moduli and phases of S and A at one frequency, by names such as `S.xx.modulus[frequency=10]`.
pub(super) fn quantities(f: &FrequencyResult) -> Vec<StatedQuantity> {
    f.sensitivity
        .iter()
        .chain(&f.exploitation)
        .flat_map(|t| std::iter::once(&t.modulus).chain(t.phase.as_ref()))
        .chain(&f.transverse)
        .chain(&f.intrinsic)
        .map(|e| stated(e, f.frequency))
        .collect()
}

/// A quantity at one frequency, as a result states it.
pub(crate) fn stated(e: &Expanded, frequency: f64) -> StatedQuantity {
    StatedQuantity {
        name: format!("{}[frequency={frequency}]", e.name),
        unit: e.unit.clone(),
        value: e.value,
        u: Some(e.standard_uncertainty),
        expanded: e.expanded,
        k: Some(e.coverage_factor),
        nu_eff: Some(
            e.dof
                .and_then(DegreesOfFreedom::new)
                .unwrap_or(DegreesOfFreedom::INFINITE),
        ),
        probability: e.probability,
        interval: None,
        method: None,
    }
}

pub(super) fn word(method: ShakerMethod) -> &'static str {
    match method {
        ShakerMethod::PublishedMagnitude => "published",
        ShakerMethod::Complex => "complex",
        ShakerMethod::Joint => "joint",
    }
}

/// A unit as headings spell it.
fn ascii(unit: &str) -> String {
    unit.replace('²', "2")
}

/// Tables of the matrices, their budgets and the residuals.
pub(super) fn tables(
    calibration: &ShakerCalibration,
    output: OutputUnit,
) -> Result<Vec<(String, Table)>> {
    let results = &calibration.results;
    let unit = &ascii(output.sensitivity());
    Ok(vec![
        (
            "sensitivity.csv".to_owned(),
            matrix(
                results,
                unit,
                |f| &f.sensitivity,
                |p| (p.sensitivity, p.sensitivity_expanded),
            )?,
        ),
        (
            "exploitation.csv".to_owned(),
            matrix(
                results,
                &ascii(output.exploitation()),
                |f| &f.exploitation,
                |p| (p.exploitation, p.exploitation_expanded),
            )?,
        ),
        ("derived.csv".to_owned(), derived(results)?),
        ("budget.csv".to_owned(), budget(results, unit)?),
        ("residuals.csv".to_owned(), residuals(results, unit)?),
    ])
}

/// Method and correction, which every row begins with.
fn begin(result: &MethodResult, frequency: f64) -> Vec<Cell> {
    vec![
        Cell::from(word(result.method)),
        Cell::from(result.correction.as_str()),
        Cell::from(frequency),
    ]
}

type Published = proofmass_shaker::published::PublishedFit;
/// Values and expanded uncertainties of nine terms.
type Terms = ([[f64; 3]; 3], [[Option<f64>; 3]; 3]);

fn matrix(
    results: &[MethodResult],
    unit: &str,
    terms: impl Fn(&FrequencyResult) -> &[SensitivityTerm],
    published: impl Fn(&Published) -> Terms,
) -> Result<Table> {
    let mut header = ["method", "correction", "frequency_Hz", "term"]
        .map(str::to_owned)
        .to_vec();
    header.extend(
        ["real", "imaginary", "modulus", "u_modulus", "U_modulus"].map(|n| format!("{n}_{unit}")),
    );
    header.extend(["k", "nu_eff", "phase_deg", "u_phase_deg", "U_phase_deg"].map(str::to_owned));
    let mut table = Table::new(header);
    for result in results {
        for f in &result.frequencies {
            for t in terms(f) {
                let mut row = begin(result, f.frequency);
                row.push(Cell::from(t.name.as_str()));
                row.extend([t.re, t.im].map(Cell::from));
                let m = &t.modulus;
                row.extend(
                    [
                        m.value,
                        m.standard_uncertainty,
                        m.expanded,
                        m.coverage_factor,
                    ]
                    .map(Cell::from),
                );
                row.push(Cell::from(m.dof));
                let phase = t.phase.as_ref();
                let degrees =
                    |of: fn(&Expanded) -> f64| Cell::from(phase.map(|p| of(p).to_degrees()));
                row.extend([
                    degrees(|p| p.value),
                    degrees(|p| p.standard_uncertainty),
                    degrees(|p| p.expanded),
                ]);
                table.push(row)?;
            }
        }
        for p in &result.published {
            let (value, expanded) = published(&p.fit);
            for i in 0..3 {
                for j in 0..3 {
                    let mut row = begin(result, p.frequency);
                    row.push(Cell::Text(term(i, j)));
                    row.extend([Cell::Missing, Cell::Missing, Cell::from(value[i][j])]);
                    let expanded = expanded[i][j];
                    row.extend([
                        Cell::from(expanded.map(|u| 0.5 * u)),
                        Cell::from(expanded),
                        Cell::from(2.0),
                    ]);
                    row.extend([Cell::Missing, Cell::Missing, Cell::Missing, Cell::Missing]);
                    table.push(row)?;
                }
            }
        }
    }
    Ok(table)
}

fn term(i: usize, j: usize) -> String {
    let axes = ["x", "y", "z"];
    format!("{}{}", axes[i], axes[j])
}

/// Normalised matrices, transverse sensitivity, leaning of the axes, intrinsic properties.
fn derived(results: &[MethodResult]) -> Result<Table> {
    let mut table = Table::new([
        "method",
        "correction",
        "frequency_Hz",
        "quantity",
        "unit",
        "value",
        "u",
        "U",
        "k",
        "nu_eff",
    ]);
    for result in results {
        for f in &result.frequencies {
            for e in f
                .normalised
                .iter()
                .chain(&f.normalised_exploitation)
                .chain(&f.transverse)
                .chain(&f.misalignment)
                .chain(&f.intrinsic)
            {
                let mut row = begin(result, f.frequency);
                row.extend([Cell::from(e.name.as_str()), Cell::from(e.unit.as_str())]);
                row.extend(
                    [
                        e.value,
                        e.standard_uncertainty,
                        e.expanded,
                        e.coverage_factor,
                    ]
                    .map(Cell::from),
                );
                row.push(Cell::from(e.dof));
                table.push(row)?;
            }
        }
    }
    Ok(table)
}

/// One row per term of S and input.
fn budget(results: &[MethodResult], unit: &str) -> Result<Table> {
    let contribution = format!("contribution_{unit}");
    let mut table = Table::new([
        "method",
        "correction",
        "frequency_Hz",
        "term",
        "input",
        "description",
        "distribution",
        "dof",
        &contribution,
        "share",
    ]);
    for result in results {
        for f in &result.frequencies {
            for t in &f.sensitivity {
                for line in &t.budget {
                    let mut row = begin(result, f.frequency);
                    row.extend(
                        [&t.name, &line.key, &line.description, &line.distribution]
                            .map(|s| Cell::from(s.as_str())),
                    );
                    // Infinite degrees of freedom are an empty field.
                    row.push(Cell::from(
                        (!line.dof.is_infinite()).then(|| line.dof.get()),
                    ));
                    row.extend([line.contribution, line.share].map(Cell::from));
                    table.push(row)?;
                }
            }
        }
    }
    Ok(table)
}

fn residuals(results: &[MethodResult], unit: &str) -> Result<Table> {
    let mut header: Vec<String> = [
        "method",
        "correction",
        "frequency_Hz",
        "run",
        "direction_x",
        "direction_y",
        "direction_z",
    ]
    .map(str::to_owned)
    .to_vec();
    for axis in ["x", "y", "z"] {
        header.extend([
            format!("error_real_{axis}_{unit}"),
            format!("error_imaginary_{axis}_{unit}"),
            format!("studentised_real_{axis}"),
            format!("studentised_imaginary_{axis}"),
        ]);
    }
    header.extend(["chi_squared_6", "influence"].map(str::to_owned));
    let mut table = Table::new(header);
    for result in results {
        for r in &result.runs {
            let mut row = begin(result, r.frequency);
            row.push(Cell::from(r.run.as_str()));
            row.extend(r.direction.map(Cell::from));
            for (error, studentised) in r.prediction_error.iter().zip(&r.studentised) {
                row.extend(error.iter().chain(studentised).map(|v| finite(*v)));
            }
            row.extend([finite(r.statistic), finite(r.influence)]);
            table.push(row)?;
        }
    }
    Ok(table)
}

/// A number, or an empty field where it does not exist.
fn finite(value: f64) -> Cell {
    Cell::from(Some(value).filter(|v| v.is_finite()))
}

/// Phasors as they went into the fit, in the form of a table of runs.
pub(super) fn phasors(runs: &[RunInput], acceleration: bool, output: OutputUnit) -> Result<Table> {
    let of_outputs = ascii(output.symbol());
    let mut header = ["run", "frequency_Hz", "inclination_deg", "rotation_deg"]
        .map(str::to_owned)
        .to_vec();
    for (k, name) in CHANNELS.iter().enumerate() {
        let unit = match (k, acceleration) {
            (0, true) => "m/s2",
            (0, false) => "V",
            _ => &of_outputs,
        };
        header.extend([
            format!("{name}_{unit}"),
            format!("{name}_phase_deg"),
            format!("u_{name}_{unit}"),
        ]);
    }
    let mut table = Table::new(header);
    for run in runs {
        let mut row = vec![
            Cell::from(run.run.as_str()),
            Cell::from(run.frequency),
            Cell::from(run.configuration.inclination.to_degrees()),
            Cell::from(run.configuration.rotation.to_degrees()),
        ];
        let phasors = std::iter::once(&run.reference).chain(&run.outputs);
        for (z, [rr, _, ii]) in phasors.zip(&run.covariance) {
            row.extend([z.norm(), z.arg().to_degrees(), (0.5 * (rr + ii)).sqrt()].map(Cell::from));
        }
        table.push(row)?;
    }
    Ok(table)
}

/// What the samples of each recording said beside the phasors.
pub(super) fn recordings(runs: &[RunInput]) -> Result<Table> {
    let mut header = [
        "run",
        "frequency_Hz",
        "measured_frequency_Hz",
        "distortion_%",
    ]
    .map(str::to_owned)
    .to_vec();
    header.extend(CHANNELS.map(|name| format!("snr_{name}_dB")));
    header.push("clipped".to_owned());
    let mut table = Table::new(header);
    for run in runs {
        let q = &run.quality;
        let Some(measured) = q.measured_frequency else {
            continue;
        };
        let mut row = vec![
            Cell::from(run.run.as_str()),
            Cell::from(run.frequency),
            Cell::from(measured),
            Cell::from(q.distortion.map(|d| 100.0 * d)),
        ];
        row.extend(q.signal_to_noise.iter().map(|v| finite(*v)));
        let clipped: Vec<&str> = q.clipped.iter().map(|&k| CHANNELS[k]).collect();
        row.push(Cell::Text(clipped.join(" ")));
        table.push(row)?;
    }
    Ok(table)
}

pub(super) fn monte_carlo(checks: &[FrequencyCheck], output: OutputUnit) -> Result<Table> {
    let unit = ascii(output.sensitivity());
    let mut header = ["frequency_Hz", "component", "trials"]
        .map(str::to_owned)
        .to_vec();
    header.extend(
        [
            "u_propagated",
            "u_monte_carlo",
            "lower_propagated",
            "lower_monte_carlo",
            "upper_propagated",
            "upper_monte_carlo",
            "tolerance",
        ]
        .map(|name| format!("{name}_{unit}")),
    );
    header.push("validated".to_owned());
    let mut table = Table::new(header);
    for c in checks {
        for v in &c.components {
            let mut row = vec![
                Cell::from(c.frequency),
                Cell::from(v.component.as_str()),
                Cell::from(c.trials as usize),
            ];
            row.extend(
                [
                    Some(v.linear),
                    v.monte_carlo,
                    Some(v.linear_interval[0]),
                    Some(v.interval[0]),
                    Some(v.linear_interval[1]),
                    Some(v.interval[1]),
                    Some(v.validation.tolerance),
                ]
                .map(Cell::from),
            );
            row.push(Cell::from(match v.validation.verdict {
                Verdict::Validated => "yes",
                Verdict::NotValidated => "no",
                Verdict::Undecided => "undecided",
            }));
            table.push(row)?;
        }
    }
    Ok(table)
}
