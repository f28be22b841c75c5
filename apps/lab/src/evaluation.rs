//! The result so far, by the code of the desk on the folder that is recorded.

use crate::clock::today;
use proofmass::jobs::campaign::Campaign;
use proofmass::jobs::{StoredResult, Trouble, Watch};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// Evaluates a folder as `proofmass calibrate FOLDER` does.
///
/// # Errors
/// As the campaign and its files say.
pub fn evaluate(folder: &Path, date: &str, watch: &dyn Watch) -> Result<StoredResult, Trouble> {
    Campaign::open(folder)?.evaluate(Some(date.to_owned()), watch)
}

/// What is known so far.
#[derive(Clone, Default)]
pub struct Evaluated {
    /// The last result, and the number of runs in it.
    pub result: Option<(Arc<StoredResult>, usize)>,
    /// Why there is none yet.
    pub lacks: Option<String>,
    /// Runs that the evaluation under way has; none where none is.
    pub at_work: Option<usize>,
}

/// Stops an evaluation when the program ends.
#[derive(Default)]
struct Patience(AtomicBool);

impl Watch for Patience {
    fn progress(&self, _stage: &'static str, _done: u64, _of: u64) -> ControlFlow<()> {
        match self.0.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
}

/// A thread that evaluates, so that nothing waits for it.
pub struct Evaluator {
    orders: Option<Sender<usize>>,
    known: Arc<Mutex<Evaluated>>,
    patience: Arc<Patience>,
    thread: Option<JoinHandle<()>>,
}

impl Evaluator {
    /// An evaluator of a folder.
    pub fn new(folder: PathBuf) -> Self {
        let (orders, given) = channel();
        let known = Arc::new(Mutex::new(Evaluated::default()));
        let patience = Arc::new(Patience::default());
        let (to, watch) = (known.clone(), patience.clone());
        Self {
            orders: Some(orders),
            known,
            patience,
            thread: Some(std::thread::spawn(move || {
                work(&folder, &given, &to, &watch)
            })),
        }
    }

    /// Asks for a result of the runs so far.
    pub fn ask(&self, runs: usize) {
        self.known().at_work = Some(runs);
        if let Some(orders) = &self.orders {
            let _ = orders.send(runs);
        }
    }

    /// What is known so far.
    pub fn known(&self) -> MutexGuard<'_, Evaluated> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The place of what is known, for others.
    pub fn shared(&self) -> Arc<Mutex<Evaluated>> {
        self.known.clone()
    }
}

impl Drop for Evaluator {
    fn drop(&mut self) {
        self.patience.0.store(true, Ordering::Relaxed);
        self.orders = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn work(folder: &Path, orders: &Receiver<usize>, known: &Mutex<Evaluated>, watch: &Patience) {
    while let Ok(runs) = orders.recv() {
        // Only the latest order counts.
        let runs = orders.try_iter().last().unwrap_or(runs);
        let found = evaluate(folder, &today(), watch);
        let mut known = known.lock().unwrap_or_else(PoisonError::into_inner);
        known.at_work = known.at_work.filter(|w| *w > runs);
        match found {
            Ok(result) => {
                known.result = Some((Arc::new(result), runs));
                known.lacks = None;
            }
            Err(trouble) => {
                let mut text = trouble.to_string();
                if let Some(hint) = trouble.hint() {
                    text = format!("{text}; {hint}");
                }
                known.lacks = Some(text);
            }
        }
    }
}
