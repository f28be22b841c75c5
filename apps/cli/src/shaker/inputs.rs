//! What campaigns on the shaker state, in the words of the mathematics: certificate, corrections, budget, plan.

use crate::Failure;
use proofmass::calibration::shaker::geometry::published_plan;
use proofmass::calibration::shaker::reference::{ReferencePoint, ReferenceTable};
use proofmass::calibration::shaker::{
    Acts, Budget, Complex64, Configuration, Correction, Input, Key, Spurious, SpuriousTable,
};
use proofmass::jobs::campaign::{
    BudgetInput, Certificate, Plan, ShakerBudget, SpuriousFile, SpuriousRow,
};

pub(crate) fn reference(certificate: &Certificate) -> Result<ReferenceTable, Failure> {
    let points = certificate.points.iter().map(|p| ReferencePoint {
        frequency: p.frequency_hz,
        sensitivity: p.sensitivity,
        phase: p.phase,
        modulus_uncertainty: p.u_relative,
        phase_uncertainty: p.u_phase,
    });
    Ok(ReferenceTable::new(points.collect())?)
}

pub(crate) fn correction(file: &SpuriousFile) -> Correction {
    let entries = file.rows.iter().map(|r| Spurious {
        inclination: r.inclination,
        frequency: r.frequency_hz,
        ratio: r.ratio.map(|[re, im]| Complex64::new(re, im)),
        covariance: r.covariance,
    });
    Correction {
        label: file.label.clone(),
        table: SpuriousTable {
            entries: entries.collect(),
        },
    }
}

/// Rows of `spurious.csv` from a table that was measured.
pub(crate) fn spurious_rows(table: &SpuriousTable) -> Vec<SpuriousRow> {
    let row = |e: &Spurious| SpuriousRow {
        line: 0,
        inclination: e.inclination,
        frequency_hz: e.frequency,
        ratio: e.ratio.map(|z| [z.re, z.im]),
        covariance: e.covariance,
    };
    table.entries.iter().map(row).collect()
}

pub(crate) fn budget(stated: &ShakerBudget, has_certificate: bool) -> Result<Budget, Failure> {
    match stated {
        ShakerBudget::Inputs(inputs, _) => {
            let inputs = inputs.iter().map(input).collect::<Result<Vec<_>, _>>()?;
            Ok(Budget::new(inputs)?)
        }
        ShakerBudget::Bench(_) => {
            let mut budget = Budget::published_bench();
            if has_certificate {
                // The certificate at hand counts, not the one that was printed.
                budget.inputs.retain(|i| i.acts != Acts::ReferenceModulus);
            }
            Ok(budget)
        }
    }
}

fn input(stated: &BudgetInput) -> Result<Input, Failure> {
    let unknown = |what: &str, word: &str| {
        Failure::new(format!(
            "budget input {}: unknown {what} {word}",
            stated.name
        ))
    };
    let acts = match stated.acts.as_str() {
        "reference-modulus" => Acts::ReferenceModulus,
        "reference-phase" => Acts::ReferencePhase,
        "output-modulus" => Acts::OutputModulus,
        "output-phase" => Acts::OutputPhase,
        "output-additive" => Acts::OutputAdditive,
        "inclination" => Acts::Inclination,
        "rotation" => Acts::Rotation,
        other => return Err(unknown("action", other)),
    };
    let varies_with = stated
        .varies_with
        .iter()
        .map(|key| match key.as_str() {
            "frequency" => Ok(Key::Frequency),
            "inclination" => Ok(Key::Inclination),
            "rotation" => Ok(Key::Rotation),
            "channel" => Ok(Key::Channel),
            "run" => Ok(Key::Run),
            other => Err(unknown("grouping key", other)),
        })
        .collect::<Result<Vec<_>, _>>()?;
    Ok(Input {
        key: stated.name.clone(),
        description: stated.description.clone(),
        acts,
        distribution: stated.distribution.clone(),
        evaluation: stated.evaluation,
        dof: stated.dof,
        varies_with,
        at_frequencies: Vec::new(),
    })
}

pub(crate) fn plan(plan: &Plan) -> Vec<Configuration> {
    match plan {
        Plan::Published => published_plan(),
        Plan::Configurations(list) => list
            .iter()
            .map(|&[inclination, rotation]| Configuration {
                inclination,
                rotation,
            })
            .collect(),
    }
}
