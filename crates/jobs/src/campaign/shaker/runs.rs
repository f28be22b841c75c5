//! `runs.csv`: one row per run, with its recording or its phasors.

use super::seat::Seat;
use crate::campaign::CampaignFile;
use proofmass_io::sheet::{
    ACCELERATION, ANGLE, COUNT, Endings, FREQUENCY, Place, Sheet, SheetRow, VELOCITY, VOLTAGE,
};
use proofmass_io::{Input, Result};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::PathBuf;

/// `[runs]`.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RunsTable {
    /// The table, relative to the campaign.
    pub(crate) file: String,
    /// Names of runs that somebody decided to leave out.
    #[serde(default)]
    pub(crate) exclude: Vec<String>,
}

/// What a phasor is the amplitude of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PhasorQuantity {
    /// V.
    Voltage,
    /// m/s².
    Acceleration,
    /// m/s.
    Velocity,
    /// Counts of a converter.
    Count,
}

impl PhasorQuantity {
    fn endings(self) -> Endings {
        match self {
            Self::Voltage => VOLTAGE,
            Self::Acceleration => ACCELERATION,
            Self::Velocity => VELOCITY,
            Self::Count => COUNT,
        }
    }
}

/// Complex peak amplitude.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RunPhasor {
    /// Peak amplitude in V, m/s², m/s or counts.
    pub(crate) amplitude: f64,
    /// Phase in radians.
    pub(crate) phase: f64,
    /// Standard uncertainty of its real and of its imaginary part.
    pub(crate) standard_uncertainty: f64,
}

/// Where the phasors of a run come from.
#[derive(Clone, Debug, PartialEq)]
pub enum RunData {
    /// A recording, by the name in the store of the campaign.
    Recording(String),
    /// Ready phasors, in the order of the channels of the kind.
    Phasors(Vec<RunPhasor>),
}

/// One run, with the seat of its kind.
#[derive(Clone, Debug, PartialEq)]
pub struct ShakerRun<S> {
    /// Name.
    pub(crate) run: String,
    /// Line of the table.
    pub(crate) line: u64,
    /// Session in which it was measured, where the table has them.
    pub(crate) session: Option<String>,
    /// Nominal frequency in Hz; a recording of several has a run of each.
    pub(crate) frequency_hz: f64,
    /// How the device was mounted, or which motion was measured.
    pub(crate) seat: S,
    /// Samples or phasors.
    pub(crate) data: RunData,
    /// The sensor's own file beside the recording of the bench.
    pub(crate) output_file: Option<String>,
}

/// `runs.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct RunTable<S> {
    /// The campaign that names it, from whose store the recordings are read.
    pub(crate) source: CampaignFile,
    /// Path as given.
    pub(crate) path: PathBuf,
    /// Path and digest.
    pub(crate) input: Input,
    /// Rows.
    pub(crate) runs: Vec<ShakerRun<S>>,
    /// Quantity of each channel of a phasor table; empty for recordings, whose channels are voltages.
    pub(crate) quantities: Vec<PhasorQuantity>,
    /// Whether the table has moduli and no phases.
    pub(crate) moduli: bool,
}

impl<S> RunTable<S> {
    /// Names of the runs to be left out: of a recording of several frequencies the name of its row stands for all.
    pub(crate) fn excluded(&self, names: &[String]) -> Vec<String> {
        let named = |run: &&ShakerRun<S>| {
            let row = run.run.rsplit_once('@').map(|(row, _)| row);
            names
                .iter()
                .any(|n| *n == run.run || Some(n.as_str()) == row)
        };
        self.runs
            .iter()
            .filter(named)
            .map(|r| r.run.clone())
            .collect()
    }
}

/// Name of a channel and what it may be the amplitude of.
pub(crate) type Channel<'a> = (&'a str, &'a [PhasorQuantity]);

struct ChannelColumns {
    amplitude: Option<Place>,
    phase: Option<Place>,
    uncertainty: Option<Place>,
    quantity: PhasorQuantity,
}

/// Reads `runs.csv` with the channels of a kind.
pub(crate) fn read_runs<S: Seat + Clone>(
    source: &CampaignFile,
    table: &RunsTable,
    channels: &[Channel<'_>],
) -> Result<RunTable<S>> {
    let path = source.resolve(&table.file);
    let mut sheet = Sheet::from_source(source.source(&table.file)?, "table of runs")?;
    let run = sheet.text("run");
    let session = sheet.text("session");
    let frequency = sheet.quantity("frequency", FREQUENCY)?;
    let seat = S::find(&mut sheet)?;
    let file = sheet.text("file");
    let output_file = sheet.text("output_file");
    let columns = channels
        .iter()
        .map(|channel| ChannelColumns::find(&mut sheet, channel))
        .collect::<Result<Vec<_>>>()?;
    sheet.finish()?;
    let run = sheet.required(run, "run")?;
    let frequency = sheet.required(frequency, "frequency_Hz")?;
    S::complete(&sheet, &seat)?;
    let ready = columns.iter().any(|c| c.amplitude.is_some());
    let moduli = S::MODULI && ready && columns.iter().all(|c| c.phase.is_none());
    if file.is_some() && ready {
        return Err(sheet
            .header_error("file", "recordings and phasors exclude each other")
            .with_hint("keep the column `file`, or the columns of the phasors"));
    }
    if output_file.is_some() && file.is_none() {
        return Err(sheet
            .header_error(
                "output_file",
                "the sensor's file has no recording of the reference beside it",
            )
            .with_hint("add a column `file` with the recordings of the bench"));
    }
    if file.is_none() {
        if !ready {
            return Err(sheet
                    .header_error("file", "the table of runs names neither recordings nor phasors")
                    .with_hint("add a column `file`, or amplitude and phase of every channel (x_V, x_phase_deg)"));
        }
        for (column, (name, quantities)) in columns.iter().zip(channels) {
            let ending = quantities[0].endings()[0].0;
            sheet.required(column.amplitude, &format!("{name}_{ending}"))?;
            if !moduli {
                sheet.required(column.phase, &format!("{name}_phase_deg"))?;
            }
        }
    }
    let mut runs: Vec<ShakerRun<S>> = Vec::new();
    let mut names: HashMap<String, u64> = HashMap::new();
    let mut files: HashMap<String, u64> = HashMap::new();
    for row in sheet.rows() {
        let name = row.text(run);
        if name.is_empty() {
            return Err(row
                .refuse(run, "the run has no name")
                .with_hint("give every run a name of its own; messages call it by that"));
        }
        if let Some(line) = names.insert(name.to_owned(), row.line) {
            return Err(row
                .refuse(run, format!("run \"{name}\" stands in line {line} already"))
                .with_hint("take one of the two out; a true repeat needs a name of its own"));
        }
        let session = session.map(|column| session_name(&row, column, name));
        let session = session.transpose()?;
        let frequencies = row.positives(frequency)?;
        let several = frequencies.len() > 1;
        if several && file.is_none() {
            return Err(row
                .refuse(
                    frequency,
                    format!("run \"{name}\" has several frequencies, and a phasor has one"),
                )
                .with_hint("give the phasors of every frequency a row of their own"));
        }
        let place = S::read(&seat, &row)?;
        let data = match file {
            Some(column) => {
                RunData::Recording(recording_name(source, &row, column, name, &mut files)?)
            }
            None => RunData::Phasors(
                columns
                    .iter()
                    .map(|c| c.phasor(&row, name))
                    .collect::<Result<_>>()?,
            ),
        };
        let output_file = output_file
            .map(|column| recording_name(source, &row, column, name, &mut files))
            .transpose()?;
        for (k, &frequency_hz) in frequencies.iter().enumerate() {
            if frequencies[..k].contains(&frequency_hz) {
                return Err(row
                    .refuse(
                        frequency,
                        format!("run \"{name}\" names {frequency_hz} Hz twice"),
                    )
                    .with_hint("every frequency of a recording once"));
            }
            runs.push(ShakerRun {
                run: match several {
                    true => format!("{name}@{frequency_hz}"),
                    false => name.to_owned(),
                },
                line: row.line,
                session: session.clone(),
                frequency_hz,
                seat: place.clone(),
                data: data.clone(),
                output_file: output_file.clone(),
            });
        }
    }
    for name in &table.exclude {
        if !names.contains_key(name) && !runs.iter().any(|r| r.run == *name) {
            let near = proofmass_io::spelling::nearest(name, names.keys().map(String::as_str))
                .map_or(String::new(), |k| format!("did you mean \"{k}\"? "));
            return Err(source
                .refuse("runs", "exclude", format!("there is no run \"{name}\""))
                .with_hint(format!("{near}names stand in {}", path.display())));
        }
    }
    Ok(RunTable {
        quantities: if file.is_some() {
            Vec::new()
        } else {
            columns.iter().map(|c| c.quantity).collect()
        },
        input: sheet.input.clone(),
        source: source.clone(),
        path,
        runs,
        moduli,
    })
}

fn session_name(row: &SheetRow, column: Place, run: &str) -> Result<String> {
    match row.text(column) {
        "" => Err(row
            .refuse(column, format!("run \"{run}\" names no session"))
            .with_hint(
                "a word for the day or the set-up of every run, such as 2026-03-01 or morning; without sessions leave the column out",
            )),
        word => Ok(word.to_owned()),
    }
}

fn recording_name(
    source: &CampaignFile,
    row: &SheetRow,
    column: Place,
    name: &str,
    files: &mut HashMap<String, u64>,
) -> Result<String> {
    let word = row.text(column);
    if word.is_empty() {
        return Err(row
            .refuse(column, format!("run \"{name}\" names no recording"))
            .with_hint("write the name of its recording, or take the row out"));
    }
    if let Some(line) = files.insert(word.to_owned(), row.line) {
        return Err(row
            .refuse(
                column,
                format!("run \"{name}\" names the recording of line {line}"),
            )
            .with_hint(
                "every run has a recording of its own; of one with several frequencies name them all in its row, \"10 20 40\"",
            ));
    }
    if source.holds(word) {
        return Ok(word.to_owned());
    }
    let path = source.resolve(word);
    Err(row
        .refuse(
            column,
            format!("run \"{name}\": there is no recording {}", path.display()),
        )
        .with_hint("names of recordings are taken relative to the folder of campaign.toml; take the row out when the run was not measured"))
}

impl ChannelColumns {
    fn find(sheet: &mut Sheet, (name, quantities): &Channel<'_>) -> Result<Self> {
        let mut found: Option<(Place, PhasorQuantity)> = None;
        for &quantity in *quantities {
            if let Some(place) = sheet.quantity(name, quantity.endings())?
                && found.replace((place, quantity)).is_some()
            {
                return Err(sheet
                    .header_error(name, "the channel stands in two columns of different units")
                    .with_hint("keep one of the two"));
            }
        }
        let quantity = found.map_or(quantities[0], |f| f.1);
        Ok(Self {
            amplitude: found.map(|f| f.0),
            phase: sheet.quantity(&format!("{name}_phase"), ANGLE)?,
            uncertainty: sheet.quantity(&format!("u_{name}"), quantity.endings())?,
            quantity,
        })
    }

    fn phasor(&self, row: &SheetRow, run: &str) -> Result<RunPhasor> {
        let Some(amplitude) = self.amplitude else {
            return Err(row.refuse_row("a phasor needs an amplitude"));
        };
        let value = row.number(amplitude)?;
        if value < 0.0 {
            return Err(row
                .refuse(
                    amplitude,
                    format!("run \"{run}\": an amplitude is not negative"),
                )
                .with_hint("an inverted signal has a positive amplitude and a phase near 180°"));
        }
        let Some(phase) = self.phase else {
            return Ok(RunPhasor {
                amplitude: value,
                phase: 0.0,
                standard_uncertainty: row.uncertainty(self.uncertainty)?,
            });
        };
        if row.text(phase).is_empty() {
            return Err(row
                .refuse(phase, format!("run \"{run}\" has no phase, and the table has a column of phases"))
                .with_hint("give the phase of every run; where moduli alone were read, take out all columns of phases"));
        }
        let angle = row.number(phase)?;
        // One turn either way, with grace for sums of phases.
        if angle.abs() > 2.01 * std::f64::consts::TAU {
            return Err(row
                .refuse(
                    phase,
                    format!(
                        "run \"{run}\": a phase of {} is more than two turns",
                        row.text(phase)
                    ),
                )
                .with_hint("if the phases are in degrees, the heading has to end with _deg"));
        }
        Ok(RunPhasor {
            amplitude: value,
            phase: angle,
            standard_uncertainty: row.uncertainty(self.uncertainty)?,
        })
    }
}
