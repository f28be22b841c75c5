//! The results as tables.

use crate::device_output::DeviceOutput;
use crate::trouble::Result;
use proofmass_io::{Cell, Table};
use proofmass_shaker::check_standard::CheckPoint;
use proofmass_shaker::derived::Expanded;
use proofmass_shaker::single_axis::{ComparisonRow, SingleAxis};

pub(super) fn check_table(points: &[CheckPoint]) -> Result<Table> {
    let mut table = Table::new([
        "frequency_Hz",
        "known",
        "measured",
        "departure_%",
        "u_departure_%",
        "E_n",
        "phase_departure_deg",
        "u_phase_departure_deg",
        "E_n_phase",
    ]);
    for p in points {
        let [modulus, phase] = p.e_n();
        let mut cells: Vec<Cell> = [p.frequency, p.known, p.measured].map(Cell::from).to_vec();
        cells.extend([p.modulus, p.modulus_uncertainty].map(|v| Cell::from(100.0 * v)));
        cells.push(modulus.into());
        cells.extend([p.phase, p.phase_uncertainty].map(|v| Cell::from(v.to_degrees())));
        cells.push(phase.into());
        table.push(cells)?;
    }
    Ok(table)
}

/// Sensitivities, run by run where the runs are given.
pub(super) fn sensitivity(
    runs: Option<&[ComparisonRow]>,
    output: DeviceOutput,
    results: &[SingleAxis],
    coverage_factor: Option<f64>,
) -> Result<Table> {
    let unit = output.unit().replace('²', "2");
    let mut header = vec!["frequency_Hz".to_owned()];
    header.extend(
        ["real", "imaginary", "modulus", "u_modulus", "U_modulus"].map(|n| format!("{n}_{unit}")),
    );
    header.extend(["k", "nu_eff", "phase_deg", "u_phase_deg", "U_phase_deg"].map(str::to_owned));
    if runs.is_some() {
        header.insert(0, "run".to_owned());
    }
    let mut table = Table::new(header);
    for (i, result) in results.iter().enumerate() {
        let get = |name: &str| {
            let quantity = result.estimate.get(name)?;
            Some(Expanded::of(quantity, coverage_factor))
        };
        let Some(m) = get("modulus") else {
            continue;
        };
        let phase = get("phase");
        // Without a phase the complex number has a size alone.
        let part = |v: f64| Cell::from(phase.as_ref().map(|_| v));
        let mut cells: Vec<Cell> = runs
            .iter()
            .map(|runs| Cell::from(runs[i].run.as_str()))
            .collect();
        cells.push(Cell::from(result.frequency));
        cells.extend([part(result.sensitivity.re), part(result.sensitivity.im)]);
        cells.extend(
            [
                m.value,
                m.standard_uncertainty,
                m.expanded,
                m.coverage_factor,
            ]
            .map(Cell::from),
        );
        cells.push(Cell::from(m.dof));
        let degrees =
            |of: fn(&Expanded) -> f64| Cell::from(phase.as_ref().map(|p| of(p).to_degrees()));
        cells.extend([
            degrees(|p| p.value),
            degrees(|p| p.standard_uncertainty),
            degrees(|p| p.expanded),
        ]);
        table.push(cells)?;
    }
    Ok(table)
}
