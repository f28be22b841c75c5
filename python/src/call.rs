//! One command in the process of the interpreter: run beside it, watched by it, stopped by its signals.

use crate::buffer::Bytes;
use crate::stored_result::StoredResult;
use proofmass::io::{Content, lend};
use proofmass::jobs::campaign::Campaign;
use proofmass::jobs::{
    AnyData, AnyJob, Memory, Record, StoredResult as Inner, Trouble, TroubleKind, Watch,
};
use proofmass::uncertainty::Finding;
use proofmass_cli::{Host, no_threads, today};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// How long a signal may wait until the interpreter sees it.
const SIGNALS: Duration = Duration::from_millis(50);
/// How long a calculation that is told to stop may go on before nobody waits for it any more. It then ends by itself, and writes nothing.
const PATIENCE: Duration = Duration::from_millis(500);

/// What a command said.
#[derive(Default)]
struct Said {
    results: Vec<Arc<Inner>>,
    output: Vec<u8>,
    findings: Vec<Finding>,
    notes: Vec<String>,
    /// Stage, steps behind, steps in all.
    progress: Option<(&'static str, u64, u64)>,
}

/// Keeps what a command says, and stops it where it is told to.
#[derive(Default)]
pub(crate) struct Listener {
    said: Mutex<Said>,
    stop: AtomicBool,
}

impl Listener {
    fn with(&self, keep: impl FnOnce(&mut Said)) {
        if let Ok(mut said) = self.said.lock() {
            keep(&mut said);
        }
    }
}

impl Host for Listener {
    fn result(&self, result: Inner) {
        self.with(|said| said.results.push(Arc::new(result)));
    }

    fn output(&self, text: &[u8]) {
        self.with(|said| said.output.extend_from_slice(text));
    }

    fn finding(&self, finding: &Finding) {
        self.with(|said| said.findings.push(finding.clone()));
    }

    fn note(&self, text: &str) {
        self.with(|said| said.notes.push(text.to_owned()));
    }

    fn progress(&self, stage: &'static str, done: u64, of: u64) -> ControlFlow<()> {
        // Whoever comes while another thread tells something tells it next time.
        if let Ok(mut said) = self.said.try_lock() {
            said.progress = Some((stage, done, of));
        }
        match self.stop.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
}

impl Watch for Listener {
    fn progress(&self, stage: &'static str, done: u64, of: u64) -> ControlFlow<()> {
        Host::progress(self, stage, done, of)
    }
}

/// What a command said, and why it failed where it did.
#[pyclass(frozen)]
pub(crate) struct Call {
    said: Said,
    trouble: Option<Trouble>,
}

#[pymethods]
impl Call {
    /// Kind, sentence, places and remedy of the error, where there was one.
    #[getter]
    fn error(&self) -> Option<(&'static str, String, Vec<String>, Option<String>)> {
        let trouble = self.trouble.as_ref()?;
        let kind = match trouble.kind() {
            TroubleKind::Request => "request",
            TroubleKind::Output => "output",
            TroubleKind::Cancelled => "cancelled",
            _ => "data",
        };
        let hint = trouble.hint().map(str::to_owned);
        let read = trouble.read().iter().map(|line| format!("Read  {line}"));
        let place = read.chain(trouble.place().iter().cloned()).collect();
        Some((kind, trouble.to_string(), place, hint))
    }

    #[getter]
    fn results(&self) -> Vec<StoredResult> {
        self.said
            .results
            .iter()
            .cloned()
            .map(StoredResult)
            .collect()
    }

    #[getter]
    fn output<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.said.output)
    }

    /// Findings that stand in no result, as JSON.
    #[getter]
    fn findings(&self) -> PyResult<String> {
        serde_json::to_string(&self.said.findings)
            .map_err(|e| PyRuntimeError::new_err(e.to_string()))
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.said.notes.clone()
    }
}

/// The process that began the threads of the calculation.
static PROCESS: OnceLock<u32> = OnceLock::new();
/// Those of a process that was forked, with its number: the ones of its parent are not there.
static FORKED: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Threads to calculate with, where they are not those that every thread of the process shares.
fn threads() -> Result<Option<Arc<ThreadPool>>, Trouble> {
    let process = std::process::id();
    if *PROCESS.get_or_init(|| process) == process {
        return Ok(None);
    }
    let mut known = FORKED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((owner, pool)) = &*known
        && *owner == process
    {
        return Ok(Some(Arc::clone(pool)));
    }
    let pool = ThreadPoolBuilder::new().build().map_err(no_threads)?;
    let pool = Arc::new(pool);
    // What is left of a parent waits for no end.
    std::mem::forget(known.replace((process, Arc::clone(&pool))));
    Ok(Some(pool))
}

/// Runs a command; `lent` are names, heads and buffers of what is in memory.
#[pyfunction]
pub(crate) fn call(
    py: Python<'_>,
    arguments: Vec<String>,
    lent: Vec<(String, Vec<u8>, Bound<'_, PyAny>)>,
    watch: Option<Bound<'_, PyAny>>,
) -> PyResult<Call> {
    let lent = lent
        .into_iter()
        .map(|(name, head, buffer)| Ok((name, Content::new(head, Bytes::of(&buffer)?))))
        .collect::<PyResult<Vec<_>>>()?;
    watched(py, watch, move |listener| {
        let _loans: Vec<_> = lent.into_iter().map(|(name, c)| lend(name, c)).collect();
        let program = std::iter::once("proofmass".to_owned());
        proofmass_cli::call(
            program.chain(arguments),
            Arc::clone(listener) as Arc<dyn Host>,
        )
    })
}

/// Evaluates a campaign whose files are in memory, `campaign.toml` among them.
#[pyfunction]
pub(crate) fn campaign(
    py: Python<'_>,
    files: Vec<(String, Vec<u8>)>,
    watch: Option<Bound<'_, PyAny>>,
) -> PyResult<Call> {
    watched(py, watch, move |listener| {
        let files = files.into_iter();
        let store = files.fold(Memory::new(), |store, (name, bytes)| {
            store.file(name, bytes)
        });
        let campaign = Campaign::read(Arc::new(store), "campaign.toml")?;
        for (_, campaign) in campaign.of_each_device() {
            listener.result(campaign.evaluate(Some(today()), listener.as_ref())?);
        }
        Ok(())
    })
}

/// Evaluates a request that needs no data.
#[pyfunction]
pub(crate) fn request(
    py: Python<'_>,
    json: Vec<u8>,
    watch: Option<Bound<'_, PyAny>>,
) -> PyResult<Call> {
    watched(py, watch, move |listener| {
        let job = AnyJob::from_json(&json)?;
        let record = Record {
            date: Some(today()),
            ..Record::default()
        };
        let result = job.evaluate(&AnyData::None, record, listener.as_ref())?;
        listener.result(result);
        Ok(())
    })
}

/// Does a work beside the interpreter, which goes on in its other threads; its signals are seen within a twentieth of a second.
pub(crate) fn watched(
    py: Python<'_>,
    watch: Option<Bound<'_, PyAny>>,
    work: impl FnOnce(&Arc<Listener>) -> Result<(), Trouble> + Send + 'static,
) -> PyResult<Call> {
    let listener = Arc::new(Listener::default());
    let (told, mut ended) = mpsc::channel();
    let heard = Arc::clone(&listener);
    let work = move || {
        let ended = catch_unwind(AssertUnwindSafe(|| work(&heard))).unwrap_or_else(|panic| {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
            Err(Trouble::data(format!(
                "proofmass failed where it should not: {}",
                text.unwrap_or_default()
            ))
            .with_hint("tell its developers what you called, and with which data"))
        });
        let _ = told.send(ended);
    };
    // A thread of its own: it waits for no other calculation to end.
    let begin = move || {
        let pool = threads()?;
        let work = move || match pool {
            Some(pool) => pool.install(work),
            None => work(),
        };
        std::thread::Builder::new().spawn(work).map_err(no_threads)
    };
    if let Err(trouble) = py.detach(begin) {
        return Ok(Call {
            said: Said::default(),
            trouble: Some(trouble),
        });
    }
    let mut stopped: Option<(PyErr, Instant)> = None;
    let ended = loop {
        let waited;
        (ended, waited) = py.detach(move || {
            let waited = ended.recv_timeout(SIGNALS);
            (ended, waited)
        });
        match (waited, stopped.take()) {
            (Ok(_), Some((error, _))) => return Err(error),
            (Ok(result), None) => break result,
            (Err(RecvTimeoutError::Disconnected), _) => {
                break Err(Trouble::data("the calculation ended without an answer"));
            }
            (Err(RecvTimeoutError::Timeout), Some((error, since))) => {
                if since.elapsed() > PATIENCE {
                    return Err(error);
                }
                stopped = Some((error, since));
            }
            (Err(RecvTimeoutError::Timeout), None) => {
                let stop = py
                    .check_signals()
                    .and_then(|()| tell(&listener, watch.as_ref()));
                if let Err(error) = stop {
                    listener.stop.store(true, Ordering::Relaxed);
                    stopped = Some((error, Instant::now()));
                }
            }
        }
    };
    let said = listener
        .said
        .lock()
        .map(|mut said| std::mem::take(&mut *said));
    let said = said.map_err(|_| PyRuntimeError::new_err("what was said is lost"))?;
    Ok(Call {
        said,
        trouble: ended.err(),
    })
}

/// Calls the function that wants to know how far it is; what it raises stops the command.
fn tell(listener: &Listener, watch: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
    let Some(watch) = watch else {
        return Ok(());
    };
    let mut now = None;
    listener.with(|said| now = said.progress);
    match now {
        Some((stage, done, of)) => watch.call1((stage, done, of)).map(drop),
        None => Ok(()),
    }
}

/// Does a work beside the interpreter that answers with a value; a signal stops it.
pub(crate) fn beside<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&dyn Watch) -> T + Send + 'static,
) -> PyResult<T> {
    let kept = Arc::new(Mutex::new(None));
    let answer = Arc::clone(&kept);
    let call = watched(py, None, move |listener| {
        let done = work(listener.as_ref());
        answer
            .lock()
            .map(|mut answer| *answer = Some(done))
            .map_err(|_| Trouble::data("the answer is lost"))
    })?;
    let answer = kept.lock().ok().and_then(|mut answer| answer.take());
    answer.ok_or_else(|| {
        let why = call.trouble.map_or_else(String::new, |t| t.to_string());
        PyRuntimeError::new_err(why)
    })
}
