//! What goes to the terminal, results to standard output, everything else to standard error; or to the host in whose process the command runs.

use crate::Failure;
use crate::host::{self, Host};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use proofmass::core::Visible;
use proofmass::io::Input;
use proofmass::jobs::{StoredResult, Watch};
use proofmass::report::{Report, terminal};
use proofmass::uncertainty::{Finding, Severity};
use std::io::{IsTerminal, Write};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Prints a report as text, as wide as the terminal, with colour where a person looks at it.
pub(crate) fn show(report: &Report) -> Result<(), Failure> {
    show_as(report, Shown::WHOLE)
}

/// What of a result is printed.
#[derive(Clone, Copy)]
pub(crate) struct Shown {
    /// Whether it was written to a folder.
    pub(crate) filed: bool,
    /// Whether every table is printed, not the opening alone.
    pub(crate) details: bool,
}

impl Shown {
    /// Everything of what no folder holds.
    pub(crate) const WHOLE: Self = Self {
        filed: false,
        details: true,
    };
}

fn show_as(report: &Report, shown: Shown) -> Result<(), Failure> {
    let out = std::io::stdout();
    let options = terminal::Options {
        width: width(),
        colour: out.is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty()),
        filed: shown.filed,
        details: shown.details,
    };
    print(&terminal::render(report, &options)?)
}

/// Prints the summary of a result; a host is given the result itself.
pub(crate) fn show_result(result: &StoredResult, shown: Shown) -> Result<(), Failure> {
    match host::tell(|host| host.result(result.clone())) {
        true => Ok(()),
        false => show_as(&result.summary(), shown),
    }
}

/// Prints text to standard output; a reader that went away is an error of its own kind.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    drop(read());
    if host::tell(|host| host.output(text.as_bytes())) {
        return Ok(());
    }
    let mut out = anstream::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()?;
    Ok(())
}

/// Prints a value as JSON to standard output.
pub(crate) fn print_json(bytes: &[u8]) -> Result<(), Failure> {
    drop(read());
    if host::tell(|host| host.output(bytes)) {
        return Ok(());
    }
    let mut out = std::io::stdout().lock();
    out.write_all(bytes)?;
    if !bytes.ends_with(b"\n") {
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// Writes to standard error; one that nobody reads or that is full is no reason to fail.
pub(crate) fn complain(text: &str) {
    drop(read());
    let mut err = anstream::stderr().lock();
    let _ = err.write_all(text.as_bytes());
    let _ = err.flush();
}

/// Whether something stands at the place of a file that would be lost with it.
pub(crate) fn stands(file: &Path) -> bool {
    std::fs::metadata(file).is_ok_and(|m| m.is_file() && m.len() > 0)
}

/// Whether a file may be replaced: where that is agreed, else by a person who answers `y`; without one at the terminal it may not.
pub(crate) fn may_replace(file: &Path, agreed: bool) -> bool {
    if agreed {
        return true;
    }
    let is_a_person = std::io::stdin().is_terminal() && std::io::stderr().is_terminal();
    if !is_a_person || host::host().is_some() {
        return false;
    }
    let question = format!("replace {}?", file.display());
    complain(&format!("{} [y/N] ", Visible(&question)));
    let mut answer = String::new();
    let read = std::io::stdin().read_line(&mut answer);
    read.is_ok() && matches!(answer.trim(), "y" | "Y" | "yes")
}

/// Refuses to replace a file that nobody said may go.
pub(crate) fn keep(file: &Path, force: bool) -> Result<(), Failure> {
    if !stands(file) || may_replace(file, force) {
        return Ok(());
    }
    Err(Failure::new(format!("{} is there already", file.display()))
        .hint("name another file, or replace it with --force"))
}

/// Says on standard error what was written where.
pub(crate) fn note(text: impl AsRef<str>) {
    if host::tell(|host| host.note(text.as_ref())) {
        return;
    }
    complain(&format!("{}\n", Visible(text.as_ref())));
}

/// Warns that a signature goes with the results that are replaced.
pub(crate) fn unsigned(place: &str, key: &str, signed_anew: bool) {
    let now = match signed_anew {
        true => "the new results are signed by another key",
        false => "the new results are not: sign them with --sign",
    };
    note(format!(
        "warning: what stands at {place} is signed by {key}; {now}"
    ));
}

/// Says what a file that was read is doubted for, where no result says it.
pub(crate) fn doubt(input: &Input) {
    input.findings().for_each(|f| finding(&f));
}

/// Says a finding on standard error.
pub(crate) fn finding(finding: &Finding) {
    if host::tell(|host| host.finding(finding)) {
        return;
    }
    let text = match finding.evidence_text() {
        "" => format!("{}: {}", finding.severity(), finding.what()),
        evidence => format!("{}: {}; {evidence}", finding.severity(), finding.what()),
    };
    note(text);
}

/// Whether one of the findings needs a decision.
pub(crate) fn needs_decision(findings: &[Finding]) -> bool {
    findings.iter().any(|f| f.severity() == Severity::Decision)
}

/// After this time a person is told what is going on.
const PATIENCE: Duration = Duration::from_secs(1);
/// The time that is left is a guess before so much of a stage is done, and so long it took.
const TELLING: (f64, Duration) = (0.02, Duration::from_secs(2));
/// A stage of one step, or that has not begun to count.
const OPEN: &str = "{spinner} {msg}, {elapsed}";
/// A stage whose end is not known before it is reached.
const ENDLESS: &str = "{spinner} {msg}, step {pos}, {elapsed}";
/// A stage whose steps are counted, before it tells how long it will take.
const EARLY: &str = "{spinner} {msg} [{wide_bar}] {percent} %, {elapsed}";
/// The same once it tells.
const COUNTED: &str = "{spinner} {msg} [{wide_bar}] {percent} %, {eta} to go";
/// All steps are done, and what comes of them is calculated.
const BEHIND: &str = "{spinner} {msg}: done, evaluating, {elapsed}";

/// What is shown of a stage: a share and a time that is left only where both are known.
fn template(done: u64, of: u64, elapsed: Duration) -> &'static str {
    let (share, least) = TELLING;
    match (done, of) {
        (0, 0) | (_, 1) => OPEN,
        (_, 0) => ENDLESS,
        _ if done >= of => BEHIND,
        _ if elapsed < least || (done as f64) < share * of as f64 => EARLY,
        _ => COUNTED,
    }
}

/// The line that says which files are read, until something else is shown.
static READING: Mutex<Option<Shy>> = Mutex::new(None);

/// Says that files are read, where it takes long.
pub(crate) fn reading(files: &[&Path]) {
    if host::host().is_some() || !std::io::stderr().is_terminal() {
        return;
    }
    let name = |path: &Path| {
        let name = path.file_name().unwrap_or(path.as_os_str());
        Visible(&name.to_string_lossy()).to_string()
    };
    let what = match files {
        [] => return,
        [one] => format!("reading {}", name(one)),
        [first, more @ ..] => format!("reading {} and {} more", name(first), more.len()),
    };
    let line = Shy::new();
    line.show(OPEN);
    line.bar.set_message(what);
    *locked(&READING) = Some(line);
}

/// Takes the line away.
fn read() -> Option<Shy> {
    locked(&READING).take()
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A line on standard error that appears where a person has waited for a second.
struct Shy {
    bar: ProgressBar,
    /// Dropped with the bar, which tells who waits to show it.
    _over: Sender<()>,
}

impl Shy {
    fn new() -> Self {
        let (bar, over) = (ProgressBar::hidden(), mpsc::channel());
        let shown = bar.clone();
        std::thread::spawn(move || {
            if over.1.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                shown.set_draw_target(ProgressDrawTarget::stderr());
                shown.enable_steady_tick(PATIENCE / 4);
            }
        });
        Self { bar, _over: over.0 }
    }

    fn show(&self, template: &str) {
        let style = ProgressStyle::with_template(template);
        self.bar
            .set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    }
}

impl Drop for Shy {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// What a person sees of a long calculation: a line on standard error that appears after a second and says what is done and
/// how far it is, also where a step is long. Where no terminal shows it, one sentence tells how long a stage of more than a
/// minute will take.
pub(crate) struct Progress {
    /// Where a person sees it.
    line: Option<Shy>,
    stage: Mutex<Stage>,
    /// Who is told in the place of a person.
    host: Option<Arc<dyn Host>>,
}

/// The stage that is at work.
struct Stage {
    name: &'static str,
    counted: bool,
    began: Instant,
    told: bool,
    shown: &'static str,
}

impl Stage {
    fn new(name: &'static str, counted: bool) -> Self {
        Self {
            name,
            counted,
            began: Instant::now(),
            told: false,
            shown: OPEN,
        }
    }
}

impl Progress {
    pub(crate) fn new() -> Self {
        let host = host::host();
        let is_a_person = host.is_none() && std::io::stderr().is_terminal();
        // What is read goes on being read until the first stage begins.
        let line = is_a_person.then(|| {
            read().unwrap_or_else(|| {
                let line = Shy::new();
                line.show(OPEN);
                line.bar.set_message("starting");
                line
            })
        });
        Self {
            line,
            stage: Mutex::new(Stage::new("starting", false)),
            host,
        }
    }

    fn show(line: &Shy, stage: &mut Stage, done: u64, of: u64) {
        let template = template(done, of, stage.began.elapsed());
        if template != stage.shown {
            stage.shown = template;
            line.show(template);
        }
        if of > 0 {
            line.bar.set_length(of);
        }
        line.bar
            .set_position(if of > 0 { done.min(of) } else { done });
    }

    /// Says once how long a stage will take, as soon as that can be told.
    fn estimate(&self, stage: &mut Stage, done: u64, of: u64) {
        if let (false, Some(left)) = (stage.told, time_left(stage.began.elapsed(), done, of)) {
            stage.told = true;
            let minutes = left.as_secs_f64() / 60.0;
            note(format!("{}: about {minutes:.0} min to go", stage.name));
        }
    }
}

/// Time that is left of a stage, where it is more than a minute and enough was done to tell.
fn time_left(elapsed: Duration, done: u64, of: u64) -> Option<Duration> {
    if done == 0 || done >= of || elapsed < Duration::from_secs(2) {
        return None;
    }
    let left = elapsed.as_secs_f64() * ((of - done) as f64 / done as f64);
    (left > 60.0).then(|| Duration::try_from_secs_f64(left).unwrap_or(Duration::MAX))
}

impl Watch for Progress {
    fn progress(&self, name: &'static str, done: u64, of: u64) -> ControlFlow<()> {
        if let Some(host) = &self.host {
            return host.progress(name, done, of);
        }
        // Whoever comes while another thread tells something tells it next time.
        let Ok(mut stage) = self.stage.try_lock() else {
            return ControlFlow::Continue(());
        };
        let begins = (stage.name, stage.counted) != (name, of > 0);
        if begins {
            *stage = Stage::new(name, of > 0);
        }
        match &self.line {
            Some(line) => {
                if begins {
                    line.show(OPEN);
                    line.bar.set_message(name);
                    line.bar.reset_eta();
                }
                Self::show(line, &mut stage, done, of);
            }
            None => self.estimate(&mut stage, done, of),
        }
        ControlFlow::Continue(())
    }
}

/// Columns of the terminal, of COLUMNS where there is none, or a hundred.
fn width() -> usize {
    let terminal = terminal_size::terminal_size().map(|(width, _)| usize::from(width.0));
    let stated = || std::env::var("COLUMNS").ok()?.parse().ok();
    terminal.or_else(stated).unwrap_or(100).clamp(40, 140)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_time_left_is_shown_only_where_it_is_known() {
        let seconds = Duration::from_secs;
        assert_eq!(template(0, 1, seconds(9)), OPEN, "one step");
        assert_eq!(template(1, 1, seconds(9)), OPEN);
        assert_eq!(template(0, 0, seconds(9)), OPEN, "nothing is counted yet");
        assert_eq!(template(7, 0, seconds(9)), ENDLESS);
        assert_eq!(template(0, 3, seconds(9)), EARLY);
        assert_eq!(template(50, 100, seconds(1)), EARLY, "too early to tell");
        assert_eq!(template(1, 100, seconds(9)), EARLY, "too little is done");
        assert_eq!(template(2, 100, seconds(9)), COUNTED);
        assert_eq!(template(100, 100, seconds(9)), BEHIND);
        for shown in [OPEN, ENDLESS, EARLY, COUNTED, BEHIND] {
            assert!(ProgressStyle::with_template(shown).is_ok(), "{shown}");
            assert_eq!(shown.contains("{eta}"), shown == COUNTED, "{shown}");
            assert_ne!(shown.contains("{elapsed}"), shown == COUNTED, "{shown}");
        }
    }

    #[test]
    fn law_the_time_left_is_told_when_it_is_long() {
        let seconds = Duration::from_secs;
        assert_eq!(time_left(seconds(10), 1, 61), Some(seconds(600)));
        assert_eq!(time_left(seconds(10), 30, 61), None, "short");
        assert_eq!(
            time_left(seconds(1), 1, 1_000_000),
            None,
            "too early to tell"
        );
        assert_eq!(time_left(seconds(10), 0, 100), None, "nothing done yet");
        assert_eq!(time_left(seconds(10), 5, 0), None, "no end is known");
        assert!(time_left(seconds(u64::MAX / 2), 1, u64::MAX).is_some());
    }
}
