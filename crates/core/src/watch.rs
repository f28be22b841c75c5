//! Who is told how far a long calculation is, and may stop it.

use core::ops::ControlFlow;

/// An onlooker of a long calculation: a progress bar, a server's event stream, a key that cancels.
///
/// It is called from whatever thread happens to be at work, so it takes `&self`; it is called often, so it should be
/// quick. A calculation that is told [`ControlFlow::Break`] ends with [`Error::Cancelled`](crate::Error::Cancelled)
/// within about a second.
///
/// ```
/// use core::ops::ControlFlow;
/// use proofmass_core::Watch;
/// use std::sync::atomic::{AtomicU64, Ordering};
///
/// struct Patience(AtomicU64);
/// impl Watch for Patience {
///     fn progress(&self, _stage: &'static str, _done: u64, _of: u64) -> ControlFlow<()> {
///         match self.0.fetch_add(1, Ordering::Relaxed) {
///             0..3 => ControlFlow::Continue(()),
///             _ => ControlFlow::Break(()),
///         }
///     }
/// }
/// let watch = Patience(AtomicU64::new(0));
/// assert!(watch.step("fit", 0, 10).is_ok());
/// ```
pub trait Watch: Sync {
    /// `done` of `of` steps of `stage` are behind; `of` = 0 where their number is not known.
    fn progress(&self, stage: &'static str, done: u64, of: u64) -> ControlFlow<()>;

    /// The same for use with `?`.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled) when the onlooker wants the calculation to stop.
    fn step(&self, stage: &'static str, done: u64, of: u64) -> Result<(), crate::Error> {
        match self.progress(stage, done, of) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(crate::Error::Cancelled { stage }),
        }
    }
}

/// Nobody looks on, nothing is stopped.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwatched;

impl Watch for Unwatched {
    fn progress(&self, _stage: &'static str, _done: u64, _of: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}
