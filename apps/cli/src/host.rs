//! A program that runs commands in its own process, and is told what a terminal would show.

use crate::{Failure, Outcome, begun, commands};
use proofmass::jobs::{StoredResult, Trouble, TroubleKind};
use proofmass::uncertainty::Finding;
use std::cell::RefCell;
use std::ffi::OsString;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Who is told what a command says, in the place of standard output and standard error.
///
/// Each method does nothing unless it is written anew.
pub trait Host: Send + Sync {
    /// A result, as it would be summarised; its files are written only where the command was given a folder.
    fn result(&self, _result: StoredResult) {}

    /// Text for standard output: JSON, a listing, a recording that was asked for at `-`.
    fn output(&self, _text: &[u8]) {}

    /// A finding that stands in no result, such as that of a file that was read.
    fn finding(&self, _finding: &Finding) {}

    /// What was read, what was written, what was assumed, in a line.
    fn note(&self, _text: &str) {}

    /// `done` of `of` steps of `stage` are behind; [`ControlFlow::Break`] stops the command.
    fn progress(&self, _stage: &'static str, _done: u64, _of: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

thread_local! {
    /// The host of the command that runs in this thread; the terminal where there is none.
    static HOST: RefCell<Option<Arc<dyn Host>>> = const { RefCell::new(None) };
}

/// The host of the command that runs in this thread.
pub(crate) fn host() -> Option<Arc<dyn Host>> {
    HOST.with_borrow(Clone::clone)
}

/// Puts the host back that was there before, also where the command panics.
struct Before(Option<Arc<dyn Host>>);

impl Drop for Before {
    fn drop(&mut self) {
        HOST.set(self.0.take());
    }
}

/// Runs one command for a host, the name of the program first.
///
/// Nothing goes to the terminal, nobody is asked, no signal is taken.
///
/// # Errors
/// What the command line would print: what is wrong, where, what to do. Arguments that are no command are a
/// [`TroubleKind::Request`](proofmass::jobs::TroubleKind::Request).
pub fn call<I, T>(arguments: I, host: Arc<dyn Host>) -> Result<(), Trouble>
where
    I: IntoIterator<Item = T>,
    T: Into<OsString> + Clone,
{
    let _before = Before(HOST.replace(Some(host)));
    let parsed = crate::read(&mut commands(), arguments);
    let arguments = parsed.map_err(|wrong| {
        let failure = crate::number_arguments::no_number(&wrong);
        failure.map_or_else(|| refused(&wrong), Trouble::from)
    })?;
    let person = arguments.command.typed_by();
    match begun(arguments) {
        Ok(Outcome::Done | Outcome::Doubtful) => Ok(()),
        Err(failure) => Err(failure.read_by(person).into()),
    }
}

/// What clap says, its first paragraph as what is wrong and the others as where and what to do.
fn refused(wrong: &clap::Error) -> Trouble {
    let text = wrong.render().to_string();
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let what = lines.next().unwrap_or_default();
    let mut trouble = Trouble::request(what.trim_start_matches("error: "));
    let of_help =
        |line: &&str| line.starts_with("Usage:") || line.starts_with("For more information");
    for line in lines.take_while(|line| !of_help(line)) {
        trouble = match line.strip_prefix("tip: ") {
            Some(tip) => trouble.with_hint(tip),
            None => trouble.detail(line),
        };
    }
    trouble
}

/// Refuses to go on where the host wants the command to stop: before a result takes its place.
pub(crate) fn go_on() -> Result<(), Failure> {
    let goes_on = host().is_none_or(|host| host.progress("writing", 0, 0).is_continue());
    match goes_on {
        true => Ok(()),
        false => Err(Trouble::new(TroubleKind::Cancelled, "stopped: nothing was written").into()),
    }
}

/// Tells the host of this thread where there is one; whether there is.
pub(crate) fn tell(say: impl FnOnce(&dyn Host)) -> bool {
    let host = host();
    if let Some(host) = &host {
        say(host.as_ref());
    }
    host.is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[derive(Default)]
    struct Listener {
        said: Mutex<Vec<String>>,
    }

    impl Host for Listener {
        fn result(&self, result: StoredResult) {
            self.said.lock().unwrap().push(result.kind().to_owned());
        }

        fn output(&self, text: &[u8]) {
            let text = String::from_utf8_lossy(text).into_owned();
            self.said.lock().unwrap().push(text);
        }
    }

    fn ask(arguments: &[&str]) -> (Result<(), Trouble>, Vec<String>) {
        let listener = Arc::new(Listener::default());
        let all = ["proofmass"].iter().chain(arguments);
        let ended = call(all, listener.clone());
        let said = std::mem::take(&mut *listener.said.lock().unwrap());
        (ended, said)
    }

    #[test]
    fn a_host_is_given_the_result_and_the_text() {
        let model = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/tests/data/uncertainty/mass.toml"
        );
        let (ended, said) = ask(&["uncertainty", model, "--trials", "1000"]);
        assert!(
            ended.is_ok() && said == ["uncertainty"],
            "{ended:?} {said:?}"
        );
        let (ended, said) = ask(&["formats", "--json"]);
        assert!(ended.is_ok() && said[0].starts_with('['), "{ended:?}");
        assert!(host().is_none());
    }

    #[test]
    fn what_is_no_command_is_refused_with_place_and_hint() {
        let (ended, said) = ask(&["noise", "rest.csv", "--statistik", "oadev"]);
        let trouble = ended.unwrap_err();
        assert!(said.is_empty());
        assert!(trouble.to_string().contains("--statistik"), "{trouble}");
        assert!(
            trouble
                .hint()
                .is_some_and(|hint| hint.contains("--statistic"))
        );
        let trouble = ask(&["noise", "there-is-none.csv"]).0.unwrap_err();
        assert!(
            trouble.to_string().contains("there-is-none.csv"),
            "{trouble}"
        );
    }

    #[test]
    fn a_host_stops_a_command() {
        struct Impatient;
        impl Host for Impatient {
            fn progress(&self, _: &'static str, _: u64, _: u64) -> ControlFlow<()> {
                ControlFlow::Break(())
            }
        }
        let model = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/tests/data/uncertainty/mass.toml"
        );
        let ended = call(["proofmass", "uncertainty", model], Arc::new(Impatient));
        let kind = ended.unwrap_err().kind();
        assert_eq!(kind, proofmass::jobs::TroubleKind::Cancelled);
    }
}
