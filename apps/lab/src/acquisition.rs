//! The thread between device and program: it owns the drive, and brings it to zero by itself.
//!
//! It knows nothing of page, server and files. Whatever these do, it looks at the flag of the stop and at the signs of
//! life before every block, fades the drive within one block and sends zeros from then on.

use crate::device::{Arrangement, Block, Device, DeviceError, Identity};
use crate::ending::Ending;
use crate::guard::Guard;
use crate::level::{Level, Verdict};
use crate::limits::Limits;
use crate::tone::Tone;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Silence of controller or page after which the drive goes to zero.
pub const WATCHDOG: Duration = Duration::from_millis(500);
/// Longest wait for a block.
const WAIT: Duration = Duration::from_millis(250);
/// Blocks that may wait for the recorder.
const QUEUE: usize = 200;
/// Seconds of every channel that the page may look at.
const SHOWN: f64 = 1.0;

/// What is measured next.
#[derive(Clone, Debug)]
pub struct RunOrder {
    /// How the device is mounted, and the frequency.
    pub arrangement: Arrangement,
    /// Level in m/s².
    pub target: f64,
    /// Sensitivity of the reference at the frequency, V/(m/s²).
    pub sensitivity: f64,
    /// Place of the reference among the channels.
    pub reference: usize,
    /// Samples to record.
    pub samples: usize,
    /// Limits of the bench.
    pub limits: Limits,
    /// Whether the page must give signs of life.
    pub attended: bool,
}

/// From the acquisition to the controller.
#[derive(Debug)]
pub enum Message {
    /// The level holds after so many seconds of the device's time.
    Settled(f64),
    /// Samples to be recorded, channel by channel.
    Samples(Vec<Vec<f64>>),
    /// All samples of the run are recorded and the drive is at zero; the level it was measured at, m/s².
    Done(f64),
    /// The run ended before its last sample, and the drive is at zero or the alarm is on.
    Ended(Ending),
}

/// What the page shows of the present.
#[derive(Clone, Debug, Default)]
pub struct Live {
    /// The last samples of each channel, V.
    pub channels: Vec<VecDeque<f64>>,
    /// Acceleration of the reference, m/s².
    pub acceleration: Option<f64>,
    /// Amplitude of the drive, V.
    pub drive: f64,
    /// What the acquisition does: idle, levelling, recording, fading.
    pub phase: &'static str,
    /// Share of the recording that is behind.
    pub recorded: f64,
}

/// What the threads share. Flags and times are atomic: no thread waits for another to stop the drive.
pub struct Shared {
    origin: Instant,
    stop: AtomicBool,
    controller: AtomicU64,
    page: AtomicU64,
    acquisition: AtomicU64,
    driving: AtomicBool,
    alarmed: AtomicBool,
    queued: AtomicUsize,
    /// When zero drive was last commanded after a run, ms.
    silent: AtomicU64,
    live: Mutex<Live>,
}

impl Default for Shared {
    fn default() -> Self {
        Self {
            origin: Instant::now(),
            stop: AtomicBool::new(false),
            controller: AtomicU64::new(0),
            page: AtomicU64::new(0),
            acquisition: AtomicU64::new(0),
            driving: AtomicBool::new(false),
            alarmed: AtomicBool::new(false),
            queued: AtomicUsize::new(0),
            silent: AtomicU64::new(0),
            live: Mutex::new(Live::default()),
        }
    }
}

impl Shared {
    fn now(&self) -> u64 {
        self.origin.elapsed().as_millis() as u64
    }

    /// Stops the run, from any thread.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::SeqCst);
    }

    /// Whether a stop is asked for.
    pub fn stopping(&self) -> bool {
        self.stop.load(Ordering::SeqCst)
    }

    /// Takes a stop back, before a run.
    pub fn clear_stop(&self) {
        self.stop.store(false, Ordering::SeqCst);
    }

    /// A sign of life of the controller.
    pub fn controller_beat(&self) {
        self.controller.store(self.now(), Ordering::SeqCst);
    }

    /// A sign of life of the page.
    pub fn page_beat(&self) {
        self.page.store(self.now(), Ordering::SeqCst);
    }

    /// Whether a page gave a sign of life in the last half second.
    pub fn page_is_there(&self) -> bool {
        self.age(&self.page) < WATCHDOG
    }

    /// Whether a drive leaves.
    pub fn driving(&self) -> bool {
        self.driving.load(Ordering::SeqCst)
    }

    /// Why nobody can say that the drive is at zero; `None` while all is well.
    pub fn alarm(&self) -> Option<&'static str> {
        if self.alarmed.load(Ordering::SeqCst) {
            return Some("the device takes no command: switch the power amplifier off by hand");
        }
        let hanging = self.driving() && self.age(&self.acquisition) > WATCHDOG;
        hanging.then_some(
            "the device does not answer while it is driven: switch the power amplifier off by hand",
        )
    }

    /// When zero drive was last commanded at the end of a run.
    pub fn silent_at(&self) -> Instant {
        self.origin + Duration::from_millis(self.silent.load(Ordering::SeqCst))
    }

    /// The samples of a message are written.
    pub fn written(&self) {
        self.queued.fetch_sub(1, Ordering::SeqCst);
    }

    /// What the page shows of the present.
    pub fn live(&self) -> MutexGuard<'_, Live> {
        self.live.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn age(&self, beat: &AtomicU64) -> Duration {
        Duration::from_millis(self.now().saturating_sub(beat.load(Ordering::SeqCst)))
    }
}

/// A run under way.
struct Running {
    order: RunOrder,
    tone: Tone,
    level: Level,
    trip: f64,
    blocks: u64,
    recorded: usize,
    settled: bool,
    /// Why it ends, once it does; `None` inside is the good end.
    end: Option<Option<Ending>>,
}

/// The thread.
pub struct Acquisition {
    device: Box<dyn Device>,
    identity: Identity,
    shared: Arc<Shared>,
    messages: Sender<Message>,
    guard: Guard,
    running: Option<Running>,
    /// Whether the device failed and must be started anew.
    failed: bool,
}

impl Acquisition {
    /// A thread that owns the device.
    pub fn new(device: Box<dyn Device>, shared: Arc<Shared>, messages: Sender<Message>) -> Self {
        Self {
            identity: device.identity().clone(),
            device,
            shared,
            messages,
            guard: Guard::default(),
            running: None,
            failed: true,
        }
    }

    /// Works until the other end of `orders` is gone; the last thing is zero drive.
    pub fn run(mut self, orders: &Receiver<RunOrder>) {
        loop {
            self.shared
                .acquisition
                .store(self.shared.now(), Ordering::SeqCst);
            if self.running.is_none() {
                // An idle device is looked at as well; one that failed waits for the next order.
                let patience = match (self.failed, self.identity.paced) {
                    (true, _) => 50,
                    (false, true) => 0,
                    (false, false) => 10,
                };
                match orders.recv_timeout(Duration::from_millis(patience)) {
                    Ok(order) => self.begin(order),
                    Err(RecvTimeoutError::Timeout) if self.failed => continue,
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => break,
                }
                if self.failed {
                    continue;
                }
            }
            self.block();
        }
        let _ = self.device.silence(WAIT);
    }

    fn begin(&mut self, order: RunOrder) {
        // What was lost between two runs is missed by none.
        self.guard.restart();
        let ready = match self.failed {
            true => self.device.start(),
            false => Ok(()),
        };
        if let Err(error) = ready.and_then(|()| self.device.arrange(&order.arrangement)) {
            self.failed = true;
            return self.say(Message::Ended(Ending::Device(error)));
        }
        self.failed = false;
        self.shared.alarmed.store(false, Ordering::SeqCst);
        let f = order.arrangement.frequency;
        let mut tone = Tone::new(f, self.identity.rate);
        let scale = (f, self.identity.rate);
        let level = Level::new(scale, order.target, order.sensitivity, order.limits);
        level.begin(&mut tone);
        self.running = Some(Running {
            trip: order.limits.trip(f, order.target),
            order,
            tone,
            level,
            blocks: 0,
            recorded: 0,
            settled: false,
            end: None,
        });
    }

    /// Sends a block of drive and looks at a block of samples.
    fn block(&mut self) {
        let mut drive = vec![0.0; self.identity.block];
        if let Some(running) = &mut self.running {
            if running.end.is_none()
                && let Some(ending) = wanted_end(&self.shared, running, &self.identity)
            {
                running.finish(Some(ending), self.identity.block);
            }
            running.tone.fill(&mut drive);
            if drive.iter().any(|v| v.abs() > running.order.limits.drive) {
                drive.fill(0.0);
                running.tone.fade(0);
                running.end = Some(Some(Ending::DriveLimit));
            }
            let driving = drive.iter().any(|v| *v != 0.0) || running.tone.amplitude() != 0.0;
            self.shared.driving.store(driving, Ordering::SeqCst);
        }
        match self.device.exchange(&drive, WAIT) {
            Ok(block) => self.look(block),
            Err(error) => self.device_failed(error),
        }
        self.close();
    }

    /// The drive is at zero: the run is over.
    fn close(&mut self) {
        let over = |r: &mut Running| r.end.is_some() && r.tone.amplitude() == 0.0;
        if let Some(mut running) = self.running.take_if(over) {
            self.shared.driving.store(false, Ordering::SeqCst);
            self.shared
                .silent
                .store(self.shared.now(), Ordering::SeqCst);
            let reached = running.level.acceleration();
            self.say(match running.end.take().flatten() {
                Some(ending) => Message::Ended(ending),
                None => Message::Done(reached.unwrap_or(running.order.target)),
            });
            let mut live = self.shared.live();
            (live.phase, live.drive, live.acceleration) = ("idle", 0.0, None);
        }
    }

    fn device_failed(&mut self, error: DeviceError) {
        self.failed = true;
        self.guard.restart();
        if self.device.silence(WAIT).is_err() && self.running.is_some() {
            self.shared.alarmed.store(true, Ordering::SeqCst);
        }
        if let Some(running) = &mut self.running {
            running.tone = Tone::new(running.order.arrangement.frequency, self.identity.rate);
            running.end = Some(running.end.take().flatten().or(Some(Ending::Device(error))));
        }
    }

    fn look(&mut self, block: Block) {
        let checked = self.guard.check(&block, &self.identity);
        if checked.is_ok() {
            self.show(&block);
        }
        let Some(running) = &mut self.running else {
            return;
        };
        running.blocks += 1;
        if running.end.is_some() {
            return;
        }
        if let Err(ending) = checked {
            return running.finish(Some(ending), self.identity.block);
        }
        if let Some(ending) = Guard::overload(&block, &self.identity) {
            return running.finish(Some(ending), self.identity.block);
        }
        let volts = &block.channels[running.order.reference];
        if let Some(ending) = running.beyond(volts) {
            return running.finish(Some(ending), self.identity.block);
        }
        let was_settled = running.settled;
        match running.level.take(volts, &mut running.tone) {
            Verdict::Failed(ending) => return running.finish(Some(ending), self.identity.block),
            Verdict::Settled => running.settled = true,
            Verdict::Seeking => {}
        }
        if !running.settled {
            return;
        }
        if !was_settled {
            let seconds = running.blocks as f64 * self.identity.block_seconds();
            return self.say(Message::Settled(seconds));
        }
        self.record(block);
    }

    fn record(&mut self, block: Block) {
        let Some(running) = &mut self.running else {
            return;
        };
        let left = running.order.samples - running.recorded;
        let take = left.min(self.identity.block);
        running.recorded += take;
        if running.recorded >= running.order.samples {
            running.finish(None, self.identity.block);
        }
        let mut channels = block.channels;
        channels.iter_mut().for_each(|c| c.truncate(take));
        let queued = self.shared.queued.fetch_add(1, Ordering::SeqCst);
        if queued >= QUEUE
            && let Some(running) = &mut self.running
        {
            running.finish(Some(Ending::Behind), self.identity.block);
        }
        self.say(Message::Samples(channels));
        // A simulation that is faster than the disk waits for it.
        let begun = Instant::now();
        while !self.identity.paced
            && self.shared.queued.load(Ordering::SeqCst) > QUEUE / 4
            && begun.elapsed() < WATCHDOG
        {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn show(&self, block: &Block) {
        let keep = (SHOWN * self.identity.rate) as usize;
        let mut live = self.shared.live();
        live.channels.resize(block.channels.len(), VecDeque::new());
        for (kept, new) in live.channels.iter_mut().zip(&block.channels) {
            kept.extend(new);
            let surplus = kept.len().saturating_sub(keep);
            kept.drain(..surplus);
        }
        if let Some(running) = &self.running {
            live.acceleration = running.level.acceleration();
            live.drive = running.tone.amplitude();
            live.recorded = running.recorded as f64 / running.order.samples.max(1) as f64;
            live.phase = match (running.end.is_some(), running.settled) {
                (true, _) => "fading",
                (false, true) => "recording",
                (false, false) => "levelling",
            };
        }
    }

    fn say(&self, message: Message) {
        // A controller that is gone is seen by its silence.
        let _ = self.messages.send(message);
    }
}

impl Running {
    /// Ends the run: the drive fades within a block.
    fn finish(&mut self, ending: Option<Ending>, block: usize) {
        self.end = Some(ending);
        self.tone.fade(block);
    }

    /// An acceleration above the limit.
    fn beyond(&self, volts: &[f64]) -> Option<Ending> {
        let mean = volts.iter().sum::<f64>() / volts.len().max(1) as f64;
        // Of a slow sine a block is a part, whose mean is no offset.
        let whole = self.order.arrangement.frequency * volts.len() as f64 > self.tone.rate();
        let offset = if whole { mean } else { 0.0 };
        let peak = volts.iter().fold(0.0f64, |m, v| m.max((v - offset).abs()));
        let seen = peak / self.order.sensitivity;
        (seen > self.trip).then_some(Ending::Limit {
            seen,
            limit: self.trip,
        })
    }
}

/// Whether the run is to end: by a stop, or because nobody is there.
fn wanted_end(shared: &Shared, running: &Running, identity: &Identity) -> Option<Ending> {
    if shared.stopping() {
        return Some(Ending::Stopped);
    }
    // The block of the fade and one more belong to the half second.
    let margin = Duration::from_secs_f64((2.5 * identity.block_seconds()).min(0.25));
    let patience = WATCHDOG - margin;
    if shared.age(&shared.controller) > patience {
        return Some(Ending::Controller);
    }
    let alone = running.order.attended && shared.age(&shared.page) > patience;
    alone.then_some(Ending::Page)
}
