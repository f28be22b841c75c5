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
use std::sync::{Arc, Mutex};
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
/// A stage whose steps are counted, and one whose end is not known before it is reached.
const COUNTED: &str = "{spinner} {msg} [{wide_bar}] {percent} %, {eta} to go";
const OPEN: &str = "{spinner} {msg}, step {pos}, {elapsed}";

/// What a person sees of a long calculation: a line on standard error that appears after a second and says what is done and
/// how far it is, also where a step is long. Where no terminal shows it, one sentence tells how long a stage of more than a
/// minute will take.
pub(crate) struct Progress {
    bar: ProgressBar,
    stage: Mutex<Stage>,
    /// Who is told in the place of a person.
    host: Option<Arc<dyn Host>>,
    /// Dropped with the bar, which tells who waits to show it.
    _over: Sender<()>,
}

/// The stage that is at work.
struct Stage {
    name: &'static str,
    counted: bool,
    began: Instant,
    told: bool,
}

impl Stage {
    fn new(name: &'static str, counted: bool) -> Self {
        Self {
            name,
            counted,
            began: Instant::now(),
            told: false,
        }
    }
}

impl Progress {
    pub(crate) fn new() -> Self {
        let (bar, over) = (ProgressBar::hidden(), mpsc::channel());
        let host = host::host();
        if host.is_none() && std::io::stderr().is_terminal() {
            let shown = bar.clone();
            std::thread::spawn(move || {
                if over.1.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                    shown.set_draw_target(ProgressDrawTarget::stderr());
                    shown.enable_steady_tick(PATIENCE / 4);
                }
            });
        }
        let progress = Self {
            bar,
            stage: Mutex::new(Stage::new("starting", false)),
            host,
            _over: over.0,
        };
        progress.begin(&Stage::new("starting", false));
        progress
    }

    fn begin(&self, stage: &Stage) {
        let style = match stage.counted {
            true => ProgressStyle::with_template(COUNTED),
            false => ProgressStyle::with_template(OPEN),
        };
        self.bar
            .set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        self.bar.set_message(stage.name);
        self.bar.set_position(0);
        self.bar.reset_eta();
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
        if (stage.name, stage.counted) != (name, of > 0) {
            *stage = Stage::new(name, of > 0);
            self.begin(&stage);
        }
        if of > 0 {
            self.bar.set_length(of);
        }
        self.bar
            .set_position(if of > 0 { done.min(of) } else { done });
        if self.bar.is_hidden() && !std::io::stderr().is_terminal() {
            self.estimate(&mut stage, done, of);
        }
        ControlFlow::Continue(())
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
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
