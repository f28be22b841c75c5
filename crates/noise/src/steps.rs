//! How far a calculation of this crate is, and whether its loops go on.

use proofmass_core::{Error, Unwatched, Watch};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Steps of a calculation, told to an onlooker. Once that one wants an end, every loop that asks ends.
pub(crate) struct Steps<'a> {
    watch: &'a dyn Watch,
    stage: &'static str,
    of: u64,
    done: AtomicU64,
    stopped: AtomicBool,
}

impl<'a> Steps<'a> {
    pub(crate) fn new(watch: &'a dyn Watch, stage: &'static str, of: u64) -> Self {
        Self {
            watch,
            stage,
            of,
            done: AtomicU64::new(0),
            stopped: AtomicBool::new(false),
        }
    }

    /// Nobody looks on.
    pub(crate) fn unwatched() -> Self {
        Self::new(&Unwatched, "", 0)
    }

    /// One more step is behind.
    pub(crate) fn one(&self) -> Result<(), Error> {
        self.done.fetch_add(1, Ordering::Relaxed);
        self.check()
    }

    /// Whether a loop goes on; what it made is of no use where it does not, and [`Self::check`] says so afterwards.
    pub(crate) fn goes_on(&self) -> bool {
        if self.stopped.load(Ordering::Relaxed) {
            return false;
        }
        let done = self.done.load(Ordering::Relaxed);
        let on = self.watch.progress(self.stage, done, self.of).is_continue();
        if !on {
            self.stopped.store(true, Ordering::Relaxed);
        }
        on
    }

    /// The same for use with `?`.
    pub(crate) fn check(&self) -> Result<(), Error> {
        match self.goes_on() {
            true => Ok(()),
            false => Err(Error::Cancelled { stage: self.stage }),
        }
    }
}
