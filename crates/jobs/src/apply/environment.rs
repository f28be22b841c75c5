//! Columns of humidity, pressure or supply voltage, for a calibration that follows them.

use crate::data_sheet::unit_ratio;
use crate::temperature::EnvironmentalRequest;
use crate::trouble::{Result, Trouble};
use proofmass_documents::{AnyCalibration, EnvironmentBlock};
use proofmass_io::{ColumnRef, Layout, ReadQuantity};
use proofmass_report::scientific;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// Which column holds a quantity of the surroundings that the calibration follows: `humidity`, `7:%`, `humidity=rh:%`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FollowedColumn {
    /// The quantity as the calibration calls it; the name of the column without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quantity: Option<String>,
    /// The column.
    pub column: ColumnRef,
    /// Its unit, where the heading does not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
}

impl FromStr for FollowedColumn {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (quantity, column) = match text.split_once('=') {
            None => (None, text),
            Some((quantity, column)) => (Some(quantity.trim().to_owned()), column),
        };
        let named = quantity.as_ref().is_none_or(|q| !q.is_empty());
        if !named || column.contains('=') {
            return Err("write COLUMN, or NAME=COLUMN:UNIT, such as humidity=rh:%".to_owned());
        }
        let read: EnvironmentalRequest = column.parse()?;
        Ok(Self {
            quantity,
            column: read.column,
            unit: read.unit,
        })
    }
}

/// The quantities that a calibration follows beside the temperature.
pub(super) fn followed(calibration: &AnyCalibration) -> &[EnvironmentBlock] {
    match calibration {
        AnyCalibration::Constant(file) => &file.environment,
        _ => &[],
    }
}

/// A column as it is read.
pub(super) struct Followed {
    pub(super) index: usize,
    /// To the unit in which the calibration knows it.
    pub(super) factor: f64,
    pub(super) read: ReadQuantity,
}

/// The column of each quantity that the calibration follows.
///
/// # Errors
/// A quantity without a column, with two, or one that the calibration does not follow; a unit that nobody says, or of another kind.
pub(super) fn columns(
    requests: &[FollowedColumn],
    calibration: &AnyCalibration,
    layout: &Layout,
) -> Result<Vec<Followed>> {
    let blocks = followed(calibration);
    let mut found: Vec<Option<Followed>> = blocks.iter().map(|_| None).collect();
    for request in requests {
        let index = layout.find(&request.column)?;
        let (heading, unit) =
            EnvironmentalRequest::heading(&layout.name(index), layout.unit(index));
        let name = request.quantity.as_ref().unwrap_or(&heading);
        let Some(k) = blocks.iter().position(|b| b.name == *name) else {
            return Err(match blocks {
                [] => Trouble::request(format!(
                    "{name} is named, and the calibration follows no quantity of the surroundings but the temperature"
                ))
                .with_hint("leave --environment out: it was not measured (`proofmass test temperature --environment`), or --at states its value"),
                _ => Trouble::request(format!("the calibration does not follow {name}"))
                    .with_hint(format!(
                        "it follows {}: write --environment {}=COLUMN",
                        names(blocks),
                        blocks[0].name
                    )),
            });
        };
        let block = &blocks[k];
        let column = match &request.column {
            ColumnRef::Index(i) => i.to_string(),
            ColumnRef::Name(name) => name.clone(),
        };
        let stated = request.unit.clone().or(unit).ok_or_else(|| {
            Trouble::data(format!("the unit of {name} is not said")).with_hint(format!(
                "add it: --environment {}={column}:{}, if that is its unit",
                block.name, block.unit
            ))
        })?;
        let factor = unit_ratio(&stated, &block.unit).ok_or_else(|| {
            Trouble::data(format!(
                "{name} is in {stated}, and the calibration knows it in {}",
                block.unit
            ))
            .with_hint("correct the heading, or state the unit of the column: NAME=COLUMN:UNIT")
        })?;
        let read = ReadQuantity::of(layout, index, &block.name, &stated, request.unit.is_some());
        let followed = Followed {
            index,
            factor,
            read,
        };
        if found[k].replace(followed).is_some() {
            return Err(Trouble::request(format!("{name} has two columns"))
                .with_hint("name each quantity once"));
        }
    }
    let missing: Vec<EnvironmentBlock> = blocks
        .iter()
        .zip(&found)
        .filter(|(_, column)| column.is_none())
        .map(|(block, _)| block.clone())
        .collect();
    let mut trouble = match missing.first() {
        None => return Ok(found.into_iter().flatten().collect()),
        Some(first) => Trouble::request(format!(
            "the calibration follows {}, and no column is named for it",
            names(&missing)
        ))
        .with_hint(format!(
            "add --environment {0}=COLUMN, or state the value that it had: --at {0}=VALUE",
            first.name
        )),
    };
    for block in &missing {
        trouble = trouble.detail(format!(
            "{}: measured from {} to {} {}",
            block.name,
            scientific(block.range[0], 5),
            scientific(block.range[1], 5),
            block.unit
        ));
    }
    Err(trouble)
}

fn names(blocks: &[EnvironmentBlock]) -> String {
    let names: Vec<&str> = blocks.iter().map(|b| b.name.as_str()).collect();
    names.join(" and ")
}
