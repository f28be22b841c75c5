//! `proofmass records`: devices, standards and results over time.

mod add;
mod give;

use crate::{Failure, Outcome, clock, console};
use proofmass::documents::DigitalCertificate;
use proofmass::io::Source;
use proofmass::records::{Content, FiledSupersession, Filing, Records as Ledger, day_of, page};
use proofmass::report::Report;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Keep devices, standards and results over time; find what is due, what drifts, and what to recall.
///
/// Records stand in a file (SQLite), or in PostgreSQL with --records postgresql://…. Nothing is changed: a result that was
/// wrong is superseded. `add` makes the file where it is not there.
#[derive(clap::Args)]
pub(crate) struct Records {
    /// File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here]
    #[arg(long, value_name = "FILE|URL", global = true)]
    records: Option<String>,
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    Add(add::Add),
    List(List),
    Show(Show),
    History(History),
    Due(Due),
    Check(Check),
    Recall(Recall),
    Supersede(Supersede),
    Import(Import),
    Export(give::Export),
    Backup(give::Backup),
    Upgrade(Upgrade),
    Forget(Forget),
}

/// List devices and standards, with what is overdue
#[derive(clap::Args)]
struct List {
    /// Standards alone
    #[arg(long)]
    standards: bool,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// Show a device or standard with all it rests on, or a result by its number
#[derive(clap::Args)]
struct Show {
    /// Serial number, owner's number or number here (#12) of a device, or `result:17`
    what: String,
    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
}

/// Show every quantity of a device over time: drift, jumps, control charts
///
/// The drift is a weighted regression since the last repair or adjustment. Calibrations against the same certificate share its
/// error, which cancels in the drift.
#[derive(clap::Args)]
struct History {
    /// Serial number, owner's number or number here (#12)
    device: String,
    /// Quantities whose name begins so, such as S.modulus
    #[arg(long, value_name = "NAME")]
    quantity: Option<String>,
    /// Write the page with the control charts
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// List what is due, by the rule of each device
///
/// Ends with exit code 3 under --strict where a device is overdue.
#[derive(clap::Args)]
struct Due {
    /// Days to look ahead
    #[arg(long, value_name = "DAYS", default_value_t = 30)]
    within: i64,
    /// Exit with code 3 when a device is overdue
    #[arg(long)]
    strict: bool,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// Check that the records are what was filed: chain, index, files, signatures
///
/// With --recompute a result is computed again from its campaign and recordings: the same version must give the same bytes,
/// of another version each quantity is judged by its U. Ends with exit code 1 where something is damaged.
#[derive(clap::Args)]
struct Check {
    /// Result to compute again, by its number; may be repeated
    #[arg(long, value_name = "NUMBER")]
    recompute: Vec<i64>,
    /// Print JSON instead of text
    #[arg(long)]
    json: bool,
}

/// List every result that used a standard while it may have been wrong, with the effect on each
///
/// Where a check failed, that is from the last good check of the same quantity before it to the first good one after it; else since
/// the last good check of a sensitivity, or the certificate.
///
/// The effect follows from the part of the standard in the budget that each result keeps. Results that used others as their
/// reference are followed too.
#[derive(clap::Args)]
struct Recall {
    /// Serial number, owner's number or number here (#12) of the standard
    standard: String,
    /// Relative error of its sensitivity in percent, measured over certificate: 1.5 where it is 1.5 % larger than its certificate says
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true)]
    error: Option<f64>,
    /// First day [default: the last good check before the failed one, else the certificate]
    #[arg(long, value_name = "DATE")]
    since: Option<String>,
    /// Day as of which it is asked, and the last one where --since is given [default: today]
    #[arg(long, value_name = "DATE")]
    until: Option<String>,
    /// Write the page
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// State that a result no longer counts, and why
///
/// A check, an event, a certificate, a rule or an earlier supersession is taken back in the same way.
#[derive(clap::Args)]
struct Supersede {
    /// Number of the result, or of another entry, as it was printed when it was added
    result: i64,
    /// Why
    #[arg(long, value_name = "TEXT")]
    reason: String,
    /// Result in its place, by its number
    #[arg(long, value_name = "NUMBER")]
    by_result: Option<i64>,
}

/// Add whole trees of result folders, a spreadsheet of old calibrations, or an exported folder
///
/// A folder is searched for result.json; what is here already is left. A table (.csv) has columns serial, date and either quantity, value,
/// unit, u (or U and k), or sensitivity_mV/(m/s2) with frequency_Hz and U_relative_%; values without U are marked. A digital calibration
/// certificate (.xml) is a result of its item. A folder
/// of `records export --folder` becomes new records.
#[derive(clap::Args)]
struct Import {
    /// Folders of results, tables, digital calibration certificates, or an exported folder
    #[arg(required = true)]
    places: Vec<PathBuf>,
    #[command(flatten)]
    filing: Filing,
}

/// Bring records of an older version of proofmass to this one, after a copy was kept
#[derive(clap::Args)]
struct Upgrade {}

/// Remove the name of a person; entries and chain stay
#[derive(clap::Args)]
struct Forget {
    /// The name
    name: String,
}

/// Shows a page, or what it is made from as JSON.
fn show(json: bool, page: &Report, data: &impl Serialize) -> Result<(), Failure> {
    if !json {
        return console::show(page);
    }
    let bytes = serde_json::to_vec_pretty(data)
        .map_err(|e| Failure::new(format!("it has no form in JSON: {e}")))?;
    console::print_json(&bytes)
}

/// Writes a page where one is asked for.
fn write_page(place: Option<&Path>, page: &Report, records: &str) -> Result<(), Failure> {
    if let Some(place) = place {
        let html = proofmass::report::html::render(page)?;
        // A page of ours may be written anew.
        let ours = std::fs::read(place).map(|old| old.starts_with(give::PAGE));
        if let Ok(false) = ours {
            return Err(
                Failure::new(format!("{} is there already, and no page", place.display()))
                    .hint("name another file"),
            );
        }
        give::write_file(place, html.as_bytes(), records, true)?;
    }
    Ok(())
}

/// Records that are made where there are none; a command that fails leaves no empty ones behind.
fn made<T>(
    place: &str,
    work: impl FnOnce(&mut Ledger) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let is_new = !place.contains("://") && !Path::new(place).exists();
    let mut records = Ledger::open_or_make(place)?;
    let done = work(&mut records);
    if done.is_err() && is_new && records.entries(1).is_ok_and(|entries| entries.is_empty()) {
        drop(records);
        for end in ["", "-wal", "-shm"] {
            let _ = std::fs::remove_file(format!("{place}{end}"));
        }
        let _ = std::fs::remove_dir_all(format!("{place}.files"));
    }
    done
}

impl Records {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let stated = || {
            std::env::var("PROOFMASS_RECORDS")
                .ok()
                .filter(|place| !place.is_empty())
        };
        let place = self
            .records
            .or_else(stated)
            .unwrap_or_else(|| "lab.records".to_owned());
        let today = clock::today();
        match self.command {
            Command::Add(add) => return add.run(&place, &today),
            Command::Import(import) => return import.run(&place, &today),
            Command::List(list) => {
                let mut records = Ledger::open(&place)?;
                let devices = records.devices(list.standards)?;
                show(
                    list.json,
                    &page::list(&mut records, list.standards, &today)?,
                    &devices,
                )?;
            }
            Command::Show(what) => what.run(&mut Ledger::open(&place)?, &today)?,
            Command::History(history) => {
                let mut records = Ledger::open(&place)?;
                let device = records.device(&history.device)?;
                let page = page::history(&mut records, device, history.quantity.as_deref())?;
                write_page(history.html.as_deref(), &page, &place)?;
                show(
                    history.json,
                    &page.of(proofmass::report::Place::Summary),
                    &records.history(device)?,
                )?;
            }
            Command::Due(due) => {
                let mut records = Ledger::open(&place)?;
                let day = day_of(&today)?;
                let list = records.due(day + due.within)?;
                show(
                    due.json,
                    &page::due(&mut records, &today, due.within)?,
                    &list,
                )?;
                if due.strict && list.iter().any(|d| d.is_over(day)) {
                    return Ok(Outcome::Doubtful);
                }
            }
            Command::Check(check) => check.run(&mut Ledger::open(&place)?)?,
            Command::Recall(recall) => recall.run(&mut Ledger::open(&place)?, &place, &today)?,
            Command::Supersede(s) => {
                let what = Ledger::open(&place)?.named_entry(s.result)?;
                let superseded = FiledSupersession {
                    old: s.result,
                    new: s.by_result,
                    reason: s.reason,
                };
                let filed = Ledger::open_to_add(&place)?.file_content(
                    &today,
                    None,
                    Content::Supersession(superseded),
                )?;
                filed.findings.iter().for_each(console::finding);
                console::note(format!("{what} no longer counts"));
            }
            Command::Export(export) => export.run(&mut Ledger::open(&place)?, &place, &today)?,
            Command::Backup(backup) => backup.run(&mut Ledger::open(&place)?)?,
            Command::Upgrade(_) => match Ledger::upgrade(&place)? {
                Some(copy) => {
                    console::note(format!("brought to this version; as they were: {copy}"))
                }
                None => console::note("the records have this version already"),
            },
            Command::Forget(person) => {
                Ledger::open_to_add(&place)?.forget(&person.name)?;
                console::note("the name was removed");
            }
        }
        Ok(Outcome::Done)
    }
}

impl Show {
    fn run(self, records: &mut Ledger, today: &str) -> Result<(), Failure> {
        if let Some(number) = self.what.strip_prefix("result:") {
            let number = number.trim().parse().map_err(|_| {
                Failure::new(format!("{number:?} is no number of a result"))
                    .hint("write it as in result:17")
            })?;
            let page = page::result(records, number)?;
            return show(self.json, &page, &records.entry(number)?);
        }
        let device = records.device(&self.what)?;
        let page = page::device(records, device, today)?;
        let mut rests = Vec::new();
        for result in records.results_of(device)? {
            rests.extend(records.rests_on(result)?);
        }
        show(
            self.json,
            &page,
            &(
                records.filed_device(device)?,
                records.due_of(device)?,
                rests,
            ),
        )
    }
}

impl Check {
    fn run(self, records: &mut Ledger) -> Result<(), Failure> {
        let check = records.check()?;
        show(self.json, &page::check(&check), &check)?;
        let mut differs = Vec::new();
        for number in self.recompute {
            let found = records.recompute(number)?;
            show(self.json, &page::recomputed(number, &found), &found)?;
            if let proofmass::records::Recomputed::Differs { .. } = found {
                differs.push(number.to_string());
            }
        }
        if let Some(first) = check.damage.first() {
            return Err(Failure::new("the records are not what was filed")
                .detail(first.clone())
                .hint(
                    "take the last backup; `records check --json` lists everything that is damaged",
                ));
        }
        if !differs.is_empty() {
            return Err(Failure::new(format!("computed again, these results have other bytes: {}", differs.join(", ")))
                .hint("the same version gives the same bytes on the same kind of processor: compare the processors, and whether the program was changed"));
        }
        Ok(())
    }
}

impl Recall {
    fn run(self, records: &mut Ledger, place: &str, today: &str) -> Result<(), Failure> {
        let standard = records.device(&self.standard)?;
        let until = day_of(self.until.as_deref().unwrap_or(today))?;
        let since = self.since.as_deref().map(day_of).transpose()?;
        let error = self.error.map(|percent| percent / 100.0);
        let recall = records.recall(standard, until, since, error)?;
        let page = page::recall(&recall);
        write_page(self.html.as_deref(), &page, place)?;
        show(
            self.json,
            &page.of(proofmass::report::Place::Summary),
            &recall,
        )
    }
}

impl Import {
    fn run(self, place: &str, today: &str) -> Result<Outcome, Failure> {
        if let Some(gone) = self.places.iter().find(|place| !place.exists()) {
            return Err(Failure::new(format!(
                "{}: there is no such file or folder",
                gone.display()
            ))
            .hint("name folders of results, a table (.csv), or an exported folder"));
        }
        made(place, |records| self.add_to(records, today))
    }

    fn add_to(&self, records: &mut Ledger, today: &str) -> Result<Outcome, Failure> {
        let (mut filed, mut known, mut refused) = (0, 0, 0);
        let mut whole = false;
        for given in &self.places {
            if given.join("entries.jsonl").is_file() {
                whole = true;
                let count = records.import_folder(given)?;
                console::note(format!("{count} entries from {}", given.display()));
                continue;
            }
            if given.is_file()
                && given
                    .extension()
                    .is_some_and(|e| e.eq_ignore_ascii_case("csv"))
            {
                for result in records.add_spreadsheet(
                    Source::open(given)?,
                    self.filing.by.as_deref(),
                    today,
                )? {
                    result.findings.iter().for_each(console::finding);
                    *(if result.known { &mut known } else { &mut filed }) += 1;
                }
                continue;
            }
            if given.is_file() && DigitalCertificate::is_named(given) {
                let result = records
                    .add_digital(Source::open(given)?, &self.filing, today)
                    .map_err(|trouble| trouble.detail(given.display().to_string()))?;
                result.findings.iter().for_each(console::finding);
                *(if result.known { &mut known } else { &mut filed }) += 1;
                continue;
            }
            for result in results_in(given) {
                match records.add_result(&result, &self.filing, today) {
                    Ok(done) => {
                        done.findings.iter().for_each(console::finding);
                        *(if done.known { &mut known } else { &mut filed }) += 1;
                    }
                    Err(trouble) => {
                        refused += 1;
                        console::note(format!("not filed: {}: {trouble}", result.display()));
                    }
                }
            }
        }
        if !whole || filed + known + refused > 0 {
            console::note(format!(
                "{filed} filed, {known} here already, {refused} refused"
            ));
        }
        if !whole && filed + known + refused == 0 {
            return Err(Failure::new("no result was found there")
                .hint("a result is a folder with result.json; a table ends in .csv, a digital certificate in .xml"));
        }
        match refused {
            0 => Ok(Outcome::Done),
            n => Err(Failure::new(format!("{n} results were not filed"))
                .hint("look at the reasons above; what was filed stays")),
        }
    }
}

/// Every result.json below a folder, in the order of their paths.
fn results_in(place: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![place.to_path_buf()];
    while let Some(folder) = open.pop() {
        if folder.join("result.json").is_file() {
            found.push(folder.join("result.json"));
        }
        let inside = std::fs::read_dir(&folder).into_iter().flatten().flatten();
        // Links are not followed: they may lead round.
        open.extend(
            inside
                .filter(|e| e.file_type().is_ok_and(|t| t.is_dir()))
                .map(|e| e.path()),
        );
    }
    if place.is_file() {
        found.push(place.to_path_buf());
    }
    found.sort();
    found
}
