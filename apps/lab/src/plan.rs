//! The plan of a campaign folder: what is to be measured, by which reference, with which limits.

use crate::files::{Refusal, refuse};
use crate::limits::Limits;
use proofmass::dynamic::reference_table::ReferenceTable;
use proofmass::jobs::campaign::{Certificate, CertificateOptions};
use proofmass::jobs::{Folder, Store};
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// Whole plan in the folder that is recorded into.
pub const PLAN: &str = "lab-plan.csv";
/// Largest table of runs.
const LARGEST: u64 = 16 << 20;

/// One run of the plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedRun {
    /// Name.
    pub name: String,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Inclination in degrees.
    pub inclination: Option<f64>,
    /// Rotation in degrees.
    pub rotation: Option<f64>,
    /// Level in m/s².
    pub target: f64,
    /// File of its recording.
    pub file: String,
    /// The row as it stands in the plan, without columns of phasors.
    pub row: Vec<String>,
}

impl PlannedRun {
    /// How the device is mounted: what an operator changes by hand.
    pub fn mounting(&self) -> (Option<f64>, Option<f64>) {
        (self.inclination, self.rotation)
    }
}

/// A campaign that can be measured.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Title of the campaign.
    pub title: String,
    /// Text of campaign.toml.
    pub text: String,
    /// Name of the table of runs.
    pub runs_file: String,
    /// Bytes of the plan.
    pub table: Vec<u8>,
    /// Headings of the table that is written.
    pub header: Vec<String>,
    /// Place of `file` among them.
    pub file_column: usize,
    /// Runs in the order of the plan.
    pub runs: Vec<PlannedRun>,
    /// Channels of a recording, in their order in the file.
    pub channels: Vec<String>,
    /// Sampling rate in Hz.
    pub rate: f64,
    /// The certificate of the reference.
    pub reference: ReferenceTable,
    /// Other files that the campaign names.
    pub companions: Vec<String>,
    /// Limits of `[shaker]`, where it has any: acceleration, velocity, displacement.
    pub shaker: [Option<f64>; 3],
    folder: PathBuf,
}

impl Plan {
    /// Reads the plan of a folder: campaign.toml, the table of runs, the certificate of the reference.
    ///
    /// # Errors
    /// What is missing or wrong, where, and what to do.
    pub fn open(folder: &Path) -> Result<Self, Refusal> {
        let place = folder.join("campaign.toml");
        let text = read_text(&place)?;
        let campaign: Table = toml::from_str(&text).map_err(|e| {
            refuse(
                &place,
                e.message(),
                "`proofmass init` writes a sound example",
            )
        })?;
        let kind = string(&campaign, &["kind"]).unwrap_or_default();
        let names: &[&str] = match kind.as_str() {
            "shaker-triaxial" => &["reference", "x", "y", "z"],
            "shaker-single" => &["reference", "device"],
            other => {
                return Err(refuse(
                    &place,
                    format!("the live bench does not measure kind = {other:?}"),
                    "it measures shaker-triaxial and shaker-single",
                ));
            }
        };
        let runs_file = string(&campaign, &["runs", "file"]).ok_or_else(|| {
            refuse(
                &place,
                "[runs] names no file",
                "add [runs] with file = \"runs.csv\": the table is the plan",
            )
        })?;
        let inside = Folder::new(folder).contained();
        let companions = companions(&campaign, &runs_file, &inside, &place)?;
        // A folder that was begun keeps the whole plan beside the runs that are done.
        let begun = folder.join(PLAN);
        let plan_place = match begun.is_file() {
            true => begun,
            false => folder.join(plain(&runs_file, &place)?),
        };
        let table = read_text(&plan_place)?.into_bytes();
        let (channels, rate) = recording(&campaign, names, &place)?;
        let mut plan = Self {
            title: string(&campaign, &["title"]).unwrap_or_else(|| kind.clone()),
            runs_file,
            header: Vec::new(),
            file_column: 0,
            runs: Vec::new(),
            channels,
            rate,
            reference: reference(&campaign, folder, &place)?,
            companions,
            shaker: shaker(&campaign),
            table,
            text,
            folder: folder.to_owned(),
        };
        let amplitude = number(&campaign, &["plan", "amplitude_m_per_s2"]);
        plan.read_runs(&plan_place, amplitude)?;
        Ok(plan)
    }

    /// The folder it was read from.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Limits of the bench: those of `[shaker]`, else ten times the largest level; and a drive in V.
    pub fn limits(&self, drive: f64) -> Limits {
        let largest = self.runs.iter().fold(0.0f64, |m, r| m.max(r.target));
        let [acceleration, velocity, displacement] = self.shaker;
        Limits {
            drive,
            drive_rate: drive,
            acceleration: acceleration.unwrap_or(10.0 * largest),
            velocity,
            displacement,
        }
    }

    /// Each mounting once, in the order of the plan, degrees; and each frequency.
    pub fn grid(&self) -> (Vec<(f64, f64)>, Vec<f64>) {
        let (mut seats, mut frequencies) = (Vec::new(), Vec::new());
        for run in &self.runs {
            let seat = (run.inclination.unwrap_or(0.0), run.rotation.unwrap_or(0.0));
            if !seats.contains(&seat) {
                seats.push(seat);
            }
            if !frequencies.contains(&run.frequency) {
                frequencies.push(run.frequency);
            }
        }
        (seats, frequencies)
    }

    /// Places of the runs in the order in which they are measured: mounting by mounting.
    pub fn order(&self) -> Vec<usize> {
        let mut seats: Vec<_> = Vec::new();
        for run in &self.runs {
            if !seats.contains(&run.mounting()) {
                seats.push(run.mounting());
            }
        }
        let mut order: Vec<usize> = (0..self.runs.len()).collect();
        order.sort_by_key(|&i| seats.iter().position(|s| *s == self.runs[i].mounting()));
        order
    }

    /// Sensitivity of the reference for a run, V/(m/s²).
    ///
    /// # Errors
    /// The certificate does not reach the frequency.
    pub fn sensitivity(&self, run: &PlannedRun) -> Result<f64, String> {
        let point = self.reference.at(run.frequency);
        point.map(|p| p.sensitivity).map_err(|e| {
            format!(
                "the certificate of the reference does not reach run {} at {} Hz: {e}",
                run.name, run.frequency
            )
        })
    }

    fn read_runs(&mut self, place: &Path, amplitude: Option<f64>) -> Result<(), Refusal> {
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .from_reader(self.table.as_slice());
        let odd = |e: csv::Error| {
            refuse(
                place,
                e.to_string(),
                "every row needs as many fields as the heading",
            )
        };
        let header: Vec<String> = reader
            .headers()
            .map_err(odd)?
            .iter()
            .map(String::from)
            .collect();
        let column = |name: &str| header.iter().position(|h| h == name);
        let needed = |name: &str| {
            column(name).ok_or_else(|| {
                refuse(place, format!("there is no column {name}"), "the plan is a table of runs with run, frequency_Hz and, for three axes, inclination_deg and rotation_deg")
            })
        };
        let (name, frequency) = (needed("run")?, needed("frequency_Hz")?);
        let (inclination, rotation) = (column("inclination_deg"), column("rotation_deg"));
        let (target, file) = (column("target_m/s2"), column("file"));
        let phasor = |h: &String| {
            ["_V", "_mV", "_phase_deg", "_phase_rad"]
                .iter()
                .any(|e| h.ends_with(e))
                || h == "output_file"
        };
        let kept: Vec<usize> = (0..header.len()).filter(|&i| !phasor(&header[i])).collect();
        self.header = kept.iter().map(|&i| header[i].clone()).collect();
        self.file_column = match self.header.iter().position(|h| h == "file") {
            Some(place) => place,
            None => {
                self.header.push("file".into());
                self.header.len() - 1
            }
        };
        for (line, record) in reader.records().enumerate() {
            let record = record.map_err(odd)?;
            let what = |column: usize, what: &str| {
                refuse(
                    place,
                    format!(
                        "line {}, {}: {:?} {what}",
                        line + 2,
                        header[column],
                        &record[column]
                    ),
                    "mend the plan",
                )
            };
            let number = |column: usize| {
                let value = record[column].parse::<f64>().ok().filter(|v| v.is_finite());
                value.ok_or_else(|| {
                    what(
                        column,
                        "is no number; a run of the live bench has one frequency",
                    )
                })
            };
            let named = &record[name];
            let own_file = match file.map(|f| &record[f]).filter(|f| !f.is_empty()) {
                Some(given) => given.to_owned(),
                None => format!("{named}.f32"),
            };
            if named.is_empty()
                || self
                    .runs
                    .iter()
                    .any(|r| r.name == named || r.file == own_file)
            {
                return Err(what(
                    name,
                    "is no name of its own, or its file is named twice",
                ));
            }
            let target = match target.map(&number).transpose()?.or(amplitude) {
                Some(level) if level > 0.0 => level,
                _ => {
                    return Err(refuse(
                        place,
                        format!("line {}: no level is stated", line + 2),
                        "add a column target_m/s2, or amplitude_m_per_s2 to [plan]",
                    ));
                }
            };
            let f = number(frequency)?;
            if !(f > 0.0 && f < 0.4 * self.rate) {
                return Err(what(
                    frequency,
                    "is out of range: above zero and below 0.4 of the sampling rate",
                ));
            }
            let mut row: Vec<String> = kept.iter().map(|&i| record[i].to_owned()).collect();
            row.resize(self.header.len(), String::new());
            row[self.file_column].clone_from(&own_file);
            self.runs.push(PlannedRun {
                name: named.to_owned(),
                frequency: f,
                inclination: inclination.map(&number).transpose()?,
                rotation: rotation.map(&number).transpose()?,
                target,
                file: plain(&own_file, place)?.to_owned(),
                row,
            });
        }
        match self.runs.is_empty() {
            true => Err(refuse(
                place,
                "the plan has no run",
                "add a row for each run",
            )),
            false => Ok(()),
        }
    }
}

/// A name that stays in its folder and is no file of the program.
fn plain<'a>(name: &'a str, place: &Path) -> Result<&'a str, Refusal> {
    let fine = |c: char| c.is_alphanumeric() || "-_.@ +".contains(c);
    let reserved = name.starts_with('.') || name.starts_with("lab-") || name == "campaign.toml";
    match !name.is_empty() && name.len() < 200 && name.chars().all(fine) && !reserved {
        true => Ok(name),
        false => Err(refuse(
            place,
            format!("{name:?} is no plain file name"),
            "letters, digits, points, dashes; no folder before it, and no name that begins with a point or lab-",
        )),
    }
}

fn read_text(place: &Path) -> Result<String, Refusal> {
    let size = std::fs::metadata(place).map(|m| m.len());
    if size.is_ok_and(|s| s > LARGEST) {
        return Err(refuse(
            place,
            "the file is larger than 16 MB",
            "name the plan, not a recording",
        ));
    }
    std::fs::read_to_string(place).map_err(|e| {
        refuse(place, e.to_string(), "name the folder of a campaign; `proofmass simulate shaker -o FOLDER` makes one for practice")
    })
}

fn value<'a>(table: &'a Table, path: &[&str]) -> Option<&'a Value> {
    let (last, tables) = path.split_last()?;
    let inner = tables
        .iter()
        .try_fold(table, |t, name| t.get(*name)?.as_table());
    inner?.get(*last)
}

fn string(table: &Table, path: &[&str]) -> Option<String> {
    value(table, path)?.as_str().map(str::to_owned)
}

fn number(table: &Table, path: &[&str]) -> Option<f64> {
    let found = value(table, path)?;
    found
        .as_float()
        .or_else(|| found.as_integer().map(|i| i as f64))
}

/// Channels in their order in the file, and the sampling rate.
fn recording(
    campaign: &Table,
    names: &[&str],
    place: &Path,
) -> Result<(Vec<String>, f64), Refusal> {
    let hint = "add [recording] with format = \"f32\", sampling_rate_Hz = 51200, full_scale_V = 10 and channels = { reference = 1, x = 2, y = 3, z = 4 }";
    let lacks = |what: &str| refuse(place, what, hint);
    if string(campaign, &["recording", "format"]).as_deref() != Some("f32") {
        return Err(lacks(
            "the live bench records in the format f32 of [recording]",
        ));
    }
    let drive = string(campaign, &["recording", "drive"]);
    if drive.is_some_and(|d| d != "sine") {
        return Err(lacks("the live bench drives one sine at a time"));
    }
    let rate = number(campaign, &["recording", "sampling_rate_Hz"]).filter(|r| *r > 0.0);
    let rate = rate.ok_or_else(|| lacks("[recording] states no sampling_rate_Hz"))?;
    let mut channels = vec![String::new(); names.len()];
    for name in names {
        let number = value(campaign, &["recording", "channels", name]).and_then(Value::as_integer);
        let slot = number.and_then(|n| channels.get_mut(usize::try_from(n).ok()?.checked_sub(1)?));
        match slot {
            Some(slot) if slot.is_empty() => *slot = (*name).to_owned(),
            _ => {
                return Err(lacks(
                    "[recording] channels must number the channels from one on",
                ));
            }
        }
    }
    Ok((channels, rate))
}

fn reference(campaign: &Table, folder: &Path, place: &Path) -> Result<ReferenceTable, Refusal> {
    let file = string(campaign, &["reference", "file"])
        .or_else(|| string(campaign, &["reference", "certificate"]))
        .ok_or_else(|| {
            refuse(
                place,
                "[reference] names no certificate",
                "add [reference] with file = \"reference.csv\": the level is controlled by it",
            )
        })?;
    let model = string(campaign, &["reference", "model"]).map(|m| m.parse());
    let model = model
        .transpose()
        .map_err(|e: String| refuse(place, e, "elements joined by +, such as 1mode+delay"))?;
    let mut options = CertificateOptions::default();
    options.coverage = number(campaign, &["reference", "k"]);
    options.axis = string(campaign, &["reference", "axis"]);
    options.accept_unchecked_signature =
        string(campaign, &["reference", "accept_unchecked_signature"]);
    options.model = model;
    let source = Folder::new(folder).contained().open(&file);
    let source = source.map_err(|e| {
        refuse(
            place,
            e.to_string(),
            "put the certificate beside campaign.toml",
        )
    })?;
    let certificate = Certificate::from_document(source, &options).map_err(|e| {
        refuse(
            &folder.join(&file),
            e.to_string(),
            e.hint()
                .unwrap_or("`proofmass calibrate` reads it in the same way"),
        )
    })?;
    Ok(certificate.table)
}

/// Files that the campaign names, beside the runs: they go with it.
fn companions(
    campaign: &Table,
    runs: &str,
    inside: &Folder,
    place: &Path,
) -> Result<Vec<String>, Refusal> {
    fn strings<'a>(value: &'a Value, into: &mut Vec<&'a str>) {
        match value {
            Value::String(s) => into.push(s),
            Value::Array(a) => a.iter().for_each(|v| strings(v, into)),
            Value::Table(t) => t.values().for_each(|v| strings(v, into)),
            _ => {}
        }
    }
    let mut named = Vec::new();
    campaign.values().for_each(|v| strings(v, &mut named));
    named.sort_unstable();
    named.dedup();
    let mut found = Vec::new();
    for name in named.into_iter().filter(|n| *n != runs && !n.is_empty()) {
        if !inside.describe(name).is_file() {
            continue;
        }
        if inside.leads_out(name) {
            return Err(refuse(
                place,
                format!("{name:?} lies outside of the folder of the campaign"),
                "copy it beside campaign.toml: the recorded folder holds all that it needs",
            ));
        }
        found.push(name.to_owned());
    }
    Ok(found)
}

fn shaker(campaign: &Table) -> [Option<f64>; 3] {
    [
        number(campaign, &["shaker", "acceleration_m_per_s2"]),
        number(campaign, &["shaker", "velocity_m_per_s"]),
        // Half of the way from peak to peak.
        number(campaign, &["shaker", "stroke_mm"]).map(|mm| 0.5e-3 * mm),
    ]
}
