//! What a row of the table of runs says about the device or the motion, beside name, frequency and data.

use proofmass_io::Source;
use proofmass_io::sheet::{ACCELERATION, ANGLE, PERCENT, Place, Sheet, SheetRow};
use proofmass_io::{Input, Result};
use proofmass_shaker::Configuration;
use proofmass_shaker::transverse::Motion;

/// Inclination and rotation of the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    /// Inclination and rotation.
    pub(crate) configuration: Configuration,
    /// Acceleration wanted, m/s².
    pub(crate) target: Option<f64>,
    /// Transverse motion relative to the excitation.
    pub(crate) transverse: Option<f64>,
}

/// A single-axis device on the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingleAxisSeat {
    /// Acceleration wanted, m/s².
    pub(crate) target: Option<f64>,
    /// Transverse motion relative to the excitation.
    pub(crate) transverse: Option<f64>,
}

/// A single-axis device along the vibration or across it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransverseSeat {
    /// Along which direction it is shaken.
    pub(crate) motion: Motion,
    /// Acceleration wanted, m/s².
    pub(crate) target: Option<f64>,
    /// Transverse motion relative to the excitation.
    pub(crate) transverse: Option<f64>,
}

/// A motion of the seat, measured beside the reference.
#[derive(Clone, Debug, PartialEq)]
pub struct SpuriousSeat {
    /// Inclination in radians.
    pub(crate) inclination: f64,
    /// Axis of the bench, 0 for x′ to 2 for z′; none where the channels are those of axes.
    pub(crate) axis: Option<usize>,
    /// Label of the measurement it belongs to.
    pub(crate) measurement: String,
}

/// What a row says beside run, frequency and data.
pub(crate) trait Seat: Sized {
    /// Whether the outputs may be moduli without phases.
    const MODULI: bool = false;
    type Columns;
    fn find(sheet: &mut Sheet) -> Result<Self::Columns>;
    fn complete(sheet: &Sheet, columns: &Self::Columns) -> Result<()>;
    fn read(columns: &Self::Columns, row: &SheetRow) -> Result<Self>;
}

/// A transverse motion is a size.
fn motion_across(row: &SheetRow, place: Option<Place>) -> Result<Option<f64>> {
    let value = row.optional(place)?;
    match (value, place) {
        (Some(v), Some(place)) if v < 0.0 => Err(row
            .refuse(
                place,
                format!("a transverse motion of {} is out of range: it must not be negative", row.text(place)),
            )
            .with_hint("its size relative to the motion along the axis, per cent; leave it empty where it was not measured")),
        _ => Ok(value),
    }
}

fn inclination(row: &SheetRow, place: Place) -> Result<f64> {
    let value = row.number(place)?;
    if (-1e-9..=std::f64::consts::PI + 1e-9).contains(&value) {
        return Ok(value);
    }
    Err(row
        .refuse(
            place,
            format!(
                "an inclination of {} is out of range: from 0° to 180°",
                row.text(place)
            ),
        )
        .with_hint("0° is on the table; the heading says degrees (_deg) or radians (_rad)"))
}

impl Seat for Mounting {
    const MODULI: bool = true;
    type Columns = [Option<Place>; 4];

    fn find(sheet: &mut Sheet) -> Result<Self::Columns> {
        Ok([
            sheet.quantity("inclination", ANGLE)?,
            sheet.quantity("rotation", ANGLE)?,
            sheet.quantity("target", ACCELERATION)?,
            sheet.quantity("transverse", PERCENT)?,
        ])
    }

    fn complete(sheet: &Sheet, columns: &Self::Columns) -> Result<()> {
        sheet.required(columns[0], "inclination_deg")?;
        sheet.required(columns[1], "rotation_deg")?;
        Ok(())
    }

    fn read(columns: &Self::Columns, row: &SheetRow) -> Result<Self> {
        let [Some(tilt), Some(turn), target, transverse] = *columns else {
            return Err(row.refuse_row("inclination and rotation are needed"));
        };
        let rotation = row.number(turn)?;
        if rotation.abs() > std::f64::consts::TAU + 1e-9 {
            return Err(row
                .refuse(
                    turn,
                    format!("a rotation of {} is more than a turn", row.text(turn)),
                )
                .with_hint(
                    "from −360° to 360°; the heading says degrees (_deg) or radians (_rad)",
                ));
        }
        Ok(Self {
            configuration: Configuration {
                inclination: inclination(row, tilt)?,
                rotation,
            },
            target: row.optional(target)?,
            transverse: motion_across(row, transverse)?,
        })
    }
}

impl Seat for SingleAxisSeat {
    type Columns = [Option<Place>; 2];

    fn find(sheet: &mut Sheet) -> Result<Self::Columns> {
        Ok([
            sheet.quantity("target", ACCELERATION)?,
            sheet.quantity("transverse", PERCENT)?,
        ])
    }

    fn complete(_: &Sheet, _: &Self::Columns) -> Result<()> {
        Ok(())
    }

    fn read(columns: &Self::Columns, row: &SheetRow) -> Result<Self> {
        Ok(Self {
            target: row.optional(columns[0])?,
            transverse: motion_across(row, columns[1])?,
        })
    }
}

impl Seat for TransverseSeat {
    type Columns = [Option<Place>; 4];

    fn find(sheet: &mut Sheet) -> Result<Self::Columns> {
        Mounting::find(sheet)
    }

    fn complete(sheet: &Sheet, columns: &Self::Columns) -> Result<()> {
        Mounting::complete(sheet, columns)
    }

    fn read(columns: &Self::Columns, row: &SheetRow) -> Result<Self> {
        let Some(tilt) = columns[0] else {
            return Err(row.refuse_row("inclination and rotation are needed"));
        };
        // Along the axis a rotation means nothing and may be left empty.
        let inclination = inclination(row, tilt)?;
        if inclination.abs() < 1e-6 {
            return Ok(Self {
                motion: Motion::Axial,
                target: row.optional(columns[2])?,
                transverse: motion_across(row, columns[3])?,
            });
        }
        if (inclination - std::f64::consts::FRAC_PI_2).abs() > 1e-6 {
            return Err(row
                .refuse(
                    tilt,
                    format!("an inclination of {} is neither along the axis nor across it", row.text(tilt)),
                )
                .with_hint(
                    "0 along the sensitive axis, 90 across it; on wedges between them use kind = \"shaker-triaxial\"",
                ));
        }
        let Mounting {
            configuration,
            target,
            transverse,
        } = Mounting::read(columns, row)?;
        Ok(Self {
            motion: Motion::Transverse {
                rotation: configuration.rotation,
            },
            target,
            transverse,
        })
    }
}

impl Seat for SpuriousSeat {
    type Columns = [Option<Place>; 3];

    fn find(sheet: &mut Sheet) -> Result<Self::Columns> {
        Ok([
            sheet.quantity("inclination", ANGLE)?,
            sheet.text("axis"),
            sheet.text("measurement"),
        ])
    }

    fn complete(sheet: &Sheet, columns: &Self::Columns) -> Result<()> {
        sheet.required(columns[0], "inclination_deg")?;
        Ok(())
    }

    fn read(columns: &Self::Columns, row: &SheetRow) -> Result<Self> {
        let [Some(tilt), axis, measurement] = *columns else {
            return Err(row.refuse_row("the inclination is needed"));
        };
        let number = |axis| {
            let word = row.text(axis).trim_end_matches(['\'', '′']);
            let number = ["x", "y", "z"].iter().position(|a| a == &word);
            number.ok_or_else(|| {
                row.refuse(axis, format!("\"{}\" is not an axis", row.text(axis)))
                    .with_hint("write x, y or z: the axes of the bench, z along the excitation")
            })
        };
        Ok(Self {
            inclination: inclination(row, tilt)?,
            axis: axis.map(number).transpose()?,
            measurement: measurement
                .map(|m| row.text(m))
                .filter(|t| !t.is_empty())
                .unwrap_or("measurement")
                .to_owned(),
        })
    }
}

/// The plan of a campaign.
#[derive(Default)]
pub(crate) struct CampaignPlan {
    pub(crate) configurations: Vec<Configuration>,
    /// Session of each configuration; empty where the plan has none.
    pub(crate) sessions: Vec<String>,
    /// The file it was read from.
    pub(crate) input: Option<Input>,
}

/// A plan of configurations.
pub(crate) fn read_plan(source: Source) -> Result<CampaignPlan> {
    let mut sheet = Sheet::from_source(source, "plan")?;
    let tilt = sheet.quantity("inclination", ANGLE)?;
    let turn = sheet.quantity("rotation", ANGLE)?;
    let session = sheet.text("session");
    sheet.text("configuration");
    sheet.finish()?;
    let tilt = sheet.required(tilt, "inclination_deg")?;
    let turn = sheet.required(turn, "rotation_deg")?;
    let (mut configurations, mut sessions) = (vec![], vec![]);
    for row in sheet.rows() {
        configurations.push(Configuration {
            inclination: inclination(&row, tilt)?,
            rotation: row.number(turn)?,
        });
        if let Some(column) = session {
            let word = row.text(column);
            if word.is_empty() {
                return Err(row
                    .refuse(column, "the configuration names no session")
                    .with_hint("a word for the session of every configuration; without sessions leave the column out"));
            }
            sessions.push(word.to_owned());
        }
    }
    Ok(CampaignPlan {
        configurations,
        sessions,
        input: Some(sheet.input.clone()),
    })
}
