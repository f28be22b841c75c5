//! Whether a target can hold what recordings hold, how they are written, and what is lost.

use super::devices::Device;
use super::{ConvertJob, GapTreatment, Seen, named};
use crate::plural::count;
use crate::trouble::{Result, Trouble};
use proofmass_io::formats::write::{WavForm, uff_name, uff_stored};
use proofmass_io::{ConversionPlan, Filling, RowClock, Surveyed, TargetForm, Unit};

/// Missing samples for each that is there, beyond which times are rather damaged than a recording with gaps.
const MOST_MISSING: u64 = 100;

/// Scatter of time stamps that is no more than rounding, intervals.
const UNTOLD: f64 = 1e-6;

/// How recordings are written.
pub(super) struct Plan {
    pub(super) writing: ConversionPlan,
    /// Columns or channels of the target.
    pub(super) columns: Vec<String>,
    /// The recordings, for messages.
    pub(super) recordings: String,
    /// What the target lost.
    pub(super) lost: Vec<String>,
    /// What was left or put in, and loses nothing that was measured.
    pub(super) notes: Vec<String>,
}

impl Plan {
    /// Refuses what the target cannot hold and nobody said how to put.
    pub(super) fn of(
        job: &ConvertJob,
        form: TargetForm,
        surveyed: &Surveyed,
        seen: &[Seen<'_>],
        device: Option<&Device>,
    ) -> Result<Self> {
        let check = Check {
            job,
            form,
            surveyed,
            recordings: named(seen),
        };
        check.treatment()?;
        check.units()?;
        check.absent()?;
        let filling = match job.gaps {
            Some(GapTreatment::Hold) => Some(Filling::Hold),
            Some(GapTreatment::Nan) => Some(Filling::Absent),
            _ => None,
        };
        if filling.is_some() {
            check.fills()?;
        }
        let mut lost = check.columns_lost();
        let (rate, start) = match form.holds_times() {
            true => (None, 0.0),
            false => check.one_rate(&mut lost)?,
        };
        let mut notes = check.notes(seen);
        check.gaps(&mut lost, &mut notes);
        let words = device.map(Device::words).unwrap_or_default();
        let columns = words.iter().map(|(name, _)| name.clone());
        Ok(Self {
            columns: columns.chain(check.columns()).collect(),
            recordings: check.recordings,
            writing: ConversionPlan::new(form, surveyed, filling, rate, start).with_words(words),
            lost,
            notes,
        })
    }
}

struct Check<'a> {
    job: &'a ConvertJob,
    form: TargetForm,
    surveyed: &'a Surveyed,
    recordings: String,
}

impl Check<'_> {
    fn data(&self, what: impl AsRef<str>) -> Trouble {
        Trouble::data(format!("{} {}", self.recordings, what.as_ref()))
    }

    /// Refuses a treatment that the target has no place for.
    fn treatment(&self) -> Result<()> {
        let name = self.form.name();
        match self.job.gaps {
            Some(GapTreatment::Close) if self.form.holds_times() => {
                Err(Trouble::request(format!(
                    "{name} holds the time of every row, so that no gap has to be closed"
                ))
                .with_hint("leave --gaps out, or fill the gaps with --gaps hold or --gaps nan"))
            }
            Some(GapTreatment::Nan) if !self.form.holds_absent() => {
                Err(Trouble::request(format!("{name} has no sign for an absent sample"))
                    .with_hint("--gaps hold puts the number before in its place, --gaps close leaves gaps out; csv, npy and parquet hold absent samples"))
            }
            _ => Ok(()),
        }
    }

    /// Signals whose unit is known.
    fn with_units(&self) -> Vec<String> {
        let layout = &self.surveyed.layout;
        let pairs = layout.names.iter().zip(&layout.units);
        let known =
            pairs.filter_map(|(name, unit)| Some((name, unit.filter(|u| *u != Unit::One)?)));
        known
            .map(|(name, unit)| format!("{name} in {unit}"))
            .collect()
    }

    fn units(&self) -> Result<()> {
        let known = self.with_units();
        if self.form.holds_units() || self.job.without_units || known.is_empty() {
            return Ok(());
        }
        Err(self
            .data(format!(
                "states units, and {} has no place for them: {}",
                self.form.name(),
                shortened(&known)
            ))
            .with_hint("--without-units writes the numbers as they are and lists what is lost; csv, uff and parquet hold units"))
    }

    fn absent(&self) -> Result<()> {
        let hold = self.job.gaps == Some(GapTreatment::Hold);
        if self.form.holds_absent() || hold || self.surveyed.absent.iter().all(|n| *n == 0) {
            return Ok(());
        }
        Err(self
            .data(format!(
                "has absent samples, and {} has no sign for them: {}",
                self.form.name(),
                shortened(&self.absent_samples())
            ))
            .with_hint("--gaps hold puts the number before in their place; csv, npy and parquet hold absent samples; `proofmass inspect --damage` lists them"))
    }

    fn absent_samples(&self) -> Vec<String> {
        let pairs = self.surveyed.absent.iter().zip(&self.surveyed.layout.names);
        let some = pairs.filter(|(n, _)| **n > 0);
        some.map(|(n, name)| format!("{n} of {name}")).collect()
    }

    /// Refuses to put in samples that nobody can place, or that are rather the fault of a clock.
    fn fills(&self) -> Result<()> {
        let somewhere = self.surveyed.missing_somewhere();
        if somewhere > 0 {
            return Err(self
                .data(format!(
                    "misses about {somewhere} samples, and nothing tells where they belong"
                ))
                .with_hint(
                    "write csv, npy or parquet without --gaps: they keep the times as they are",
                ));
        }
        let (missing, rows) = (self.surveyed.missing(), self.surveyed.rows);
        if missing / MOST_MISSING > rows {
            return Err(self
                .data(format!(
                    "misses {missing} samples beside the {rows} that are there"
                ))
                .with_hint("look at its times with `proofmass inspect`; write the parts by themselves with --between FROM TO"));
        }
        Ok(())
    }

    /// The one rate that a target states, Hz, and the time of its first sample, s.
    fn one_rate(&self, lost: &mut Vec<String>) -> Result<(Option<f64>, f64)> {
        let surveyed = self.surveyed;
        if let Some(question) = &surveyed.layout.no_clock {
            return Err(self
                .data(format!("cannot become {}: {question}", self.form.name()))
                .with_hint("add --time COLUMN or --rate HZ"));
        }
        if let (Some(why), None) = (surveyed.uneven(), self.job.gaps) {
            return Err(self
                .data(format!("{why}; {} holds one steady rate", self.form.name()))
                .with_hint("--gaps hold puts the number before in the place of each missing sample, --gaps close lets the rows follow one another as if no time had passed; csv, npy and parquet hold the times"));
        }
        let Some(rate) = surveyed.rate_hz() else {
            return Err(self
                .data("has too few times to tell a rate")
                .with_hint("say it with --rate HZ"));
        };
        let (start, far) = surveyed.start_s();
        let scatters = |s: &f64| s * rate > UNTOLD;
        if let Some(scatter) = surveyed.scatter_s().filter(scatters) {
            lost.push(format!(
                "the time stamps: they scatter by {:.1e} s about even steps of {:e} s",
                scatter,
                1.0 / rate
            ));
        }
        let is_wav = matches!(self.form, TargetForm::Wav(_));
        if start != 0.0 && (far || is_wav) {
            lost.push(format!(
                "the time of the first sample, {start} s: it is at zero"
            ));
        }
        match is_wav {
            true => Ok((Some(self.whole_rate(rate, lost)?), 0.0)),
            false => {
                let start = if far { 0.0 } else { start };
                let kept = 1.0 / uff_stored(1.0 / rate);
                if kept != rate {
                    lost.push(format!(
                        "digits of the rate: {rate} Hz is read again as {kept} Hz"
                    ));
                }
                if uff_stored(start) != start {
                    let kept = uff_stored(start);
                    lost.push(format!(
                        "digits of the first time: {start} s is read again as {kept} s"
                    ));
                }
                Ok((Some(rate), start))
            }
        }
    }

    /// The rate of a WAV file, which is a whole number: as near as samples are told apart.
    fn whole_rate(&self, rate: f64, lost: &mut Vec<String>) -> Result<f64> {
        let whole = rate.round();
        let within = (1.0..=f64::from(u32::MAX)).contains(&whole);
        let late = (rate / whole - 1.0).abs() * self.surveyed.rows as f64;
        if !within || late >= 0.5 {
            return Err(self
                .data(format!(
                    "was sampled at {rate} Hz, and a WAV file states a whole number of hertz"
                ))
                .with_hint(
                    "uff holds any rate, csv, npy and parquet hold times; --rate HZ writes another one",
                ));
        }
        if whole != rate {
            lost.push(format!(
                "digits of the rate: {rate} Hz is written as {whole} Hz"
            ));
        }
        Ok(whole)
    }

    /// Columns or channels of the target, by what a person finds there.
    fn columns(&self) -> Vec<String> {
        let layout = &self.surveyed.layout;
        let timed = self.form.holds_times() && layout.clock != RowClock::Order;
        let time = timed.then(|| "time in s".to_owned());
        let signals = layout.names.iter().zip(&layout.units);
        let signals = signals.map(|(name, unit)| match unit {
            Some(unit) => format!("{name} in {unit}"),
            None => name.clone(),
        });
        time.into_iter().chain(signals).collect()
    }

    /// What of columns, names and numbers is lost.
    fn columns_lost(&self) -> Vec<String> {
        let (layout, form) = (&self.surveyed.layout, self.form);
        let mut lost = Vec::new();
        if !layout.left_out.is_empty() {
            lost.push(format!(
                "columns without numbers: {}",
                layout.left_out.join(", ")
            ));
        }
        if let Some(times) = &layout.times_set_aside {
            lost.push(format!(
                "the times of column {times}, and gaps in them: --rate stands for them"
            ));
        }
        if !form.holds_names() {
            let word = if form.holds_times() {
                "column"
            } else {
                "channel"
            };
            let columns = self.columns();
            let columns = columns.iter().enumerate();
            let columns = columns.map(|(i, name)| format!("{} is {name}", i + 1));
            let and_units = if self.with_units().is_empty() {
                ""
            } else {
                " and units"
            };
            lost.push(format!(
                "names{and_units}: {word} {}",
                columns.collect::<Vec<_>>().join(", ")
            ));
        }
        if form == TargetForm::Uff {
            let cut = layout.names.iter().filter(|name| uff_name(name) != **name);
            let cut: Vec<String> = cut
                .map(|n| format!("\"{n}\" is read again as \"{}\"", uff_name(n)))
                .collect();
            if !cut.is_empty() {
                lost.push(format!("parts of names: {}", cut.join(", ")));
            }
        }
        if let (TargetForm::Npy | TargetForm::Parquet, (start, true)) =
            (form, self.surveyed.start_s())
        {
            lost.push(format!(
                "the start of the times: zero is {start} s of the recording"
            ));
        }
        if self.surveyed.rounded > 0 {
            lost.push(format!(
                "digits of {}: each is rounded by a share of {:.1e} at most",
                count(self.surveyed.rounded as usize, "number"),
                self.surveyed.departure
            ));
        }
        lost
    }

    /// What is not written and could not be.
    fn notes(&self, seen: &[Seen<'_>]) -> Vec<String> {
        let mut notes = Vec::new();
        if let Some(format) = seen.iter().find_map(|s| s.format.as_ref()) {
            notes.push(format!(
                "what the {format} file says beside names, units and times of these signals is not written"
            ));
        }
        if self.surveyed.layout.clock == RowClock::Order && self.form.holds_times() {
            notes.push(
                "no times are written, for nobody states them: --time COLUMN or --rate HZ would"
                    .to_owned(),
            );
        }
        notes
    }

    /// What became of gaps and absent samples.
    fn gaps(&self, lost: &mut Vec<String>, notes: &mut Vec<String>) {
        let sign = match self.form {
            TargetForm::Csv => "as empty fields",
            TargetForm::Parquet => "as nulls",
            _ => "as NaN",
        };
        let absent = self.absent_samples();
        if !absent.is_empty() {
            let (to, how) = match self.job.gaps {
                Some(GapTreatment::Hold) => (&mut *lost, "the number before stands in its place"),
                _ => (&mut *notes, sign),
            };
            to.push(format!("absent samples, {how}: {}", absent.join(", ")));
        }
        let (gaps, missing) = (self.surveyed.gaps.len(), self.surveyed.missing());
        if gaps > 0 {
            let (gaps, missing) = (
                count(gaps, "gap"),
                count(missing as usize, "missing sample"),
            );
            match self.job.gaps {
                Some(GapTreatment::Hold) => lost.push(format!(
                    "{gaps}: the number before stands in the place of each of {missing}"
                )),
                Some(GapTreatment::Nan) => notes.push(format!("{gaps}: {missing} put in {sign}")),
                Some(GapTreatment::Close) => lost.push(format!("{gaps}: the time of {missing}")),
                None => notes.push(format!("{gaps} kept, which the times show: {missing}")),
            }
        }
    }
}

/// A list, the first few of it.
fn shortened(all: &[String]) -> String {
    const SHOWN: usize = 6;
    let mut words: Vec<String> = all.iter().take(SHOWN).cloned().collect();
    if all.len() > SHOWN {
        words.push(format!("and {} more", all.len() - SHOWN));
    }
    words.join(", ")
}

/// Word for the form of a target and its samples.
pub(super) fn word(form: TargetForm) -> &'static str {
    match form {
        TargetForm::Csv => "CSV",
        TargetForm::Npy => "npy, double precision",
        TargetForm::Uff => "UFF 58b, double precision",
        TargetForm::Parquet => "Parquet, double precision",
        TargetForm::Wav(WavForm::Int16) => "WAV, whole numbers of 16 bits",
        TargetForm::Wav(WavForm::Int24) => "WAV, whole numbers of 24 bits",
        TargetForm::Wav(WavForm::Int32) => "WAV, whole numbers of 32 bits",
        TargetForm::Wav(WavForm::Float32) => "WAV, single precision",
        TargetForm::Wav(WavForm::Float64) => "WAV, double precision",
        _ => "another form",
    }
}
