//! A session: device, acquisition, walk and folder together, with or without a page.

use crate::acquisition::{Acquisition, Shared};
use crate::device::{Device, Identity};
use crate::evaluation::{Evaluated, Evaluator};
use crate::files::{Refusal, refuse};
use crate::plan::Plan;
use crate::recorder::Recorder;
use crate::status::SharedStatus;
use crate::walk::{Choice, Click, Walk};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// What runs behind the page.
pub struct Session {
    /// Flags and times of the threads.
    pub shared: Arc<Shared>,
    /// What the walk says.
    pub status: SharedStatus,
    /// The device.
    pub identity: Identity,
    /// Title of the campaign.
    pub title: String,
    /// The folder that is recorded.
    pub folder: PathBuf,
    clicks: Sender<Click>,
    evaluated: Arc<Mutex<Evaluated>>,
    threads: Mutex<Vec<JoinHandle<()>>>,
}

impl Session {
    /// Opens the folder and starts the threads. Nothing is driven before somebody clicks.
    ///
    /// # Errors
    /// A folder, a plan or a device that does not fit.
    pub fn open(
        plan: Plan,
        folder: &Path,
        device: Box<dyn Device>,
        choice: Choice,
    ) -> Result<Self, Refusal> {
        let identity = device.identity().clone();
        identity.check().map_err(|e| {
            refuse(
                plan.folder(),
                e.to_string(),
                "look at the adapter of the device",
            )
        })?;
        if (identity.rate / plan.rate - 1.0).abs() > 1e-9 {
            return Err(refuse(
                &plan.folder().join("campaign.toml"),
                format!(
                    "[recording] says {} Hz, the device samples with {} Hz",
                    plan.rate, identity.rate
                ),
                "set sampling_rate_Hz to that of the device, or the device to it",
            ));
        }
        if identity.drive.is_none() {
            return Err(refuse(
                plan.folder(),
                "the device has no drive",
                "a shaker run needs one: use a device with an output",
            ));
        }
        let title = plan.title.clone();
        let total = plan.runs.len();
        let recorder = Recorder::open(folder, plan, &identity.channels)?;
        let shared = Arc::new(Shared::default());
        let status = SharedStatus::default();
        status.lock().total = total;
        let (orders, given) = channel();
        let (told, messages) = channel();
        let (clicks, clicked) = channel();
        let acquisition = Acquisition::new(device, shared.clone(), told);
        let evaluator = Evaluator::new(folder.to_owned());
        let evaluated = evaluator.shared();
        let walk = Walk {
            shared: shared.clone(),
            status: status.clone(),
            recorder,
            identity: identity.clone(),
            choice,
            orders,
            messages,
            clicks: clicked,
            evaluator,
        };
        let threads = vec![
            std::thread::spawn(move || acquisition.run(&given)),
            std::thread::spawn(move || walk.run()),
        ];
        Ok(Self {
            shared,
            status,
            identity,
            title,
            folder: folder.to_owned(),
            clicks,
            evaluated,
            threads: Mutex::new(threads),
        })
    }

    /// Hands a click to the walk.
    pub fn click(&self, click: Click) {
        let _ = self.clicks.send(click);
    }

    /// Stops: the acquisition sees it before its next block.
    pub fn stop(&self) {
        self.shared.stop();
    }

    /// The result so far.
    pub fn evaluated(&self) -> MutexGuard<'_, Evaluated> {
        self.evaluated
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Stops, and waits until the drive is at zero and the folder is written.
    pub fn close(&self) {
        self.stop();
        self.click(Click::Quit);
        let threads =
            std::mem::take(&mut *self.threads.lock().unwrap_or_else(PoisonError::into_inner));
        for thread in threads {
            let _ = thread.join();
        }
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.close();
    }
}
