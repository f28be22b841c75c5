//! The walk through the plan: mounting by mounting, run by run.

use crate::acquisition::{Message, RunOrder, Shared};
use crate::device::{Arrangement, Identity};
use crate::ending::Ending;
use crate::evaluation::Evaluator;
use crate::limits::Limits;
use crate::recorder::Recorder;
use crate::status::{Phase, RunLine, SharedStatus};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::Duration;

/// How often a run is measured whose level was lost.
const ATTEMPTS: usize = 3;
const TICK: Duration = Duration::from_millis(20);

/// What somebody wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Click {
    /// Walk on with the plan.
    Start,
    /// The device is mounted as asked.
    Mounted,
    /// End the program.
    Quit,
}

/// What is chosen for a session.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Least duration of a recording, s.
    pub duration: f64,
    /// Whether the operator confirms every mounting.
    pub confirm: bool,
    /// Whether the page must be there while a drive leaves.
    pub attended: bool,
    /// Limits of the bench.
    pub limits: Limits,
}

/// The controller: the second of the two threads.
pub struct Walk {
    /// Threads' common state.
    pub shared: Arc<Shared>,
    /// What the page shows.
    pub status: SharedStatus,
    /// The folder.
    pub recorder: Recorder,
    /// The device.
    pub identity: Identity,
    /// What was chosen.
    pub choice: Choice,
    /// To the acquisition.
    pub orders: Sender<RunOrder>,
    /// From the acquisition.
    pub messages: Receiver<Message>,
    /// From the page.
    pub clicks: Receiver<Click>,
    /// The desk.
    pub evaluator: Evaluator,
}

/// How a run went.
enum Went {
    Well,
    Again(Ending),
    Ended(Ending),
    Disk(String),
}

impl Walk {
    /// Walks until somebody quits.
    pub fn run(mut self) {
        self.evaluate();
        self.settle_phase();
        loop {
            self.shared.controller_beat();
            match self.clicks.recv_timeout(TICK) {
                Ok(Click::Start) => {
                    if !self.campaign() {
                        break;
                    }
                }
                Ok(Click::Mounted) | Err(RecvTimeoutError::Timeout) => {}
                Ok(Click::Quit) | Err(RecvTimeoutError::Disconnected) => break,
            }
        }
    }

    fn settle_phase(&self) {
        let all = self.recorder.done() == self.recorder.plan().runs.len();
        let mut status = self.status.lock();
        status.done = self.recorder.done();
        status.phase = if all { Phase::Finished } else { Phase::Ready };
    }

    fn evaluate(&self) {
        if self.recorder.done() > 0 {
            self.evaluator.ask(self.recorder.done());
        }
    }

    /// Measures what is left of the plan; false when the program is to end.
    fn campaign(&mut self) -> bool {
        self.shared.clear_stop();
        self.status.lock().reason = None;
        let order = self.recorder.plan().order();
        let left: Vec<usize> = order
            .into_iter()
            .filter(|&r| !self.recorder.is_done(r))
            .collect();
        let mut mounted = None;
        for (k, &run) in left.iter().enumerate() {
            let seat = self.recorder.plan().runs[run].mounting();
            if self.choice.confirm && mounted != Some(seat) {
                match self.wait_for_mounting(run) {
                    Some(true) => {}
                    Some(false) => return true,
                    None => return false,
                }
            }
            mounted = Some(seat);
            if !self.attempts(run) {
                return true;
            }
            let next = left
                .get(k + 1)
                .map(|&n| self.recorder.plan().runs[n].mounting());
            if next != Some(seat) {
                self.evaluate();
            }
        }
        self.settle_phase();
        true
    }

    /// Shows what is to be mounted; true when it is, false on a stop, none when the program ends.
    fn wait_for_mounting(&self, run: usize) -> Option<bool> {
        self.show(run, Phase::Mounting);
        loop {
            self.shared.controller_beat();
            if self.shared.stopping() {
                self.pause(Ending::Stopped.to_string());
                return Some(false);
            }
            match self.clicks.recv_timeout(TICK) {
                Ok(Click::Mounted | Click::Start) => return Some(true),
                Ok(Click::Quit) | Err(RecvTimeoutError::Disconnected) => return None,
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    }

    /// Measures a run, again where its level was lost; false when the walk pauses.
    fn attempts(&mut self, run: usize) -> bool {
        for attempt in 1..=ATTEMPTS {
            self.show(run, Phase::Measuring);
            match self.measure(run) {
                Went::Well => return true,
                Went::Again(_) if attempt < ATTEMPTS => {}
                Went::Again(ending) | Went::Ended(ending) => {
                    self.pause(ending.to_string());
                    return false;
                }
                Went::Disk(what) => {
                    self.shared.stop();
                    self.pause(what);
                    return false;
                }
            }
        }
        false
    }

    fn pause(&self, reason: String) {
        let mut status = self.status.lock();
        status.phase = Phase::Paused;
        status.reason = Some(reason);
    }

    fn show(&self, run: usize, phase: Phase) {
        let planned = &self.recorder.plan().runs[run];
        let mut status = self.status.lock();
        status.phase = phase;
        status.run = Some(RunLine {
            name: planned.name.clone(),
            frequency: planned.frequency,
            inclination: planned.inclination,
            rotation: planned.rotation,
            target: planned.target,
        });
    }

    fn order(&self, run: usize) -> Result<RunOrder, String> {
        let plan = self.recorder.plan();
        let planned = &plan.runs[run];
        let sensitivity = plan.sensitivity(planned)?;
        self.choice
            .limits
            .check(planned.frequency, planned.target)?;
        let volts = planned.target * sensitivity;
        if volts > 0.95 * self.identity.full_scale {
            return Err(format!(
                "run {}: {} m/s² give {volts:.3} V at the reference, beyond the full scale of {} V: lower the target or the gain",
                planned.name, planned.target, self.identity.full_scale
            ));
        }
        let reference = self.identity.channels.iter().position(|c| c == "reference");
        let periods = (self.choice.duration * planned.frequency).ceil().max(4.0);
        Ok(RunOrder {
            arrangement: Arrangement {
                run: planned.name.clone(),
                frequency: planned.frequency,
                inclination: planned.inclination,
                rotation: planned.rotation,
            },
            target: planned.target,
            sensitivity,
            reference: reference.ok_or("the device has no channel \"reference\"")?,
            samples: (periods * self.identity.rate / planned.frequency).round() as usize,
            limits: self.choice.limits,
            attended: self.choice.attended,
        })
    }

    fn measure(&mut self, run: usize) -> Went {
        let order = match self.order(run) {
            Ok(order) => order,
            Err(what) => return Went::Disk(what),
        };
        self.shared.controller_beat();
        if self.orders.send(order).is_err() {
            return Went::Disk("the acquisition has ended: start the program again".to_owned());
        }
        let mut trouble = None;
        let mut settling = 0.0;
        loop {
            self.shared.controller_beat();
            let written = match self.messages.recv_timeout(TICK) {
                Err(RecvTimeoutError::Timeout) => Ok(()),
                Err(RecvTimeoutError::Disconnected) => {
                    return Went::Disk(
                        "the acquisition has ended: start the program again".to_owned(),
                    );
                }
                Ok(Message::Settled(seconds)) => {
                    settling = seconds;
                    self.recorder.begin(run)
                }
                Ok(Message::Samples(channels)) => {
                    let written = self.recorder.samples(&channels);
                    self.shared.written();
                    written
                }
                Ok(Message::Done(level)) => {
                    let ended = trouble.map_or_else(|| self.recorder.finish(level), Err);
                    return match ended {
                        Ok(()) => {
                            let mut status = self.status.lock();
                            status.done = self.recorder.done();
                            status.add(&self.recorder.plan().runs[run], level, settling);
                            Went::Well
                        }
                        Err(e) => Went::Disk(e.to_string()),
                    };
                }
                Ok(Message::Ended(ending)) => {
                    let marked = self.recorder.mark(run, ending.word(), &ending.to_string());
                    return match trouble.map_or(marked, Err) {
                        Err(e) => Went::Disk(e.to_string()),
                        Ok(()) if matches!(ending, Ending::LevelLost { .. }) => Went::Again(ending),
                        Ok(()) => Went::Ended(ending),
                    };
                }
            };
            // A disk that refuses stops the run; its end is waited for.
            if let Err(e) = written {
                self.shared.stop();
                trouble = trouble.or(Some(e));
            }
        }
    }
}
