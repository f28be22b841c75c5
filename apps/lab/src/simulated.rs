//! The shaker bench of the simulated laboratory, block by block, with faults to switch on.

use crate::device::{Arrangement, Block, Device, DeviceError, Identity};
use num_complex::Complex64;
use proofmass::rig::bench::laboratory::{Laboratory, PreparedRun, Setup};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};
use std::time::{Duration, Instant};

/// What goes wrong on the simulated bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Fault {
    /// Nothing.
    None,
    /// The cable of the reference is off.
    CableOff,
    /// The reference changes its sign.
    Reversed,
    /// The device delivers nothing and says so in time.
    Stall,
    /// The device delivers nothing and takes nothing, without a word.
    Hang,
    /// A sample is no number.
    NotANumber,
    /// A block is too short.
    Short,
    /// The counter jumps.
    CounterJump,
    /// The gain of the power amplifier grows tenfold.
    Runaway,
}

impl Fault {
    /// Every fault with the word for it.
    pub const ALL: [(Self, &'static str); 9] = [
        (Self::None, "none"),
        (Self::CableOff, "cable-off"),
        (Self::Reversed, "reversed-gain"),
        (Self::Stall, "stall"),
        (Self::Hang, "hang"),
        (Self::NotANumber, "nan"),
        (Self::Short, "short-block"),
        (Self::CounterJump, "counter-jump"),
        (Self::Runaway, "runaway"),
    ];

    /// The fault of a word.
    pub fn of(word: &str) -> Option<Self> {
        let found = Self::ALL.iter().find(|(_, w)| *w == word);
        found.map(|(fault, _)| *fault)
    }
}

/// Switches a fault on from another thread, and tells what only a simulation knows.
#[derive(Clone, Debug, Default)]
pub struct Switch {
    fault: Arc<AtomicU8>,
    /// Largest true acceleration since the last look, m/s², as bits.
    peak: Arc<AtomicU64>,
    /// Number of samples whose drive was not zero, and of all samples.
    driven: Arc<AtomicU64>,
    last: Arc<AtomicU64>,
}

impl Switch {
    /// Switches a fault on, or all off.
    pub fn set(&self, fault: Fault) {
        self.fault.store(fault as u8, Ordering::Relaxed);
    }

    /// The fault that is on.
    pub fn get(&self) -> Fault {
        let value = self.fault.load(Ordering::Relaxed);
        let found = Fault::ALL.iter().find(|(f, _)| *f as u8 == value);
        found.map_or(Fault::None, |(fault, _)| *fault)
    }

    /// Largest true acceleration of the table since the last look, m/s².
    pub fn take_peak(&self) -> f64 {
        f64::from_bits(self.peak.swap(0, Ordering::Relaxed))
    }

    /// Blocks whose drive was not zero throughout.
    pub fn driven_blocks(&self) -> u64 {
        self.driven.load(Ordering::Relaxed)
    }

    /// Amplitude of the last block of the drive, V.
    pub fn last_drive(&self) -> f64 {
        f64::from_bits(self.last.load(Ordering::Relaxed))
    }
}

/// What is simulated beside the laboratory of `rig`.
#[derive(Clone, Debug)]
pub struct SimulatedBench {
    /// The laboratory.
    pub laboratory: Laboratory,
    /// Seed of everything random.
    pub seed: u64,
    /// Configurations, inclination and rotation in degrees.
    pub plan: Vec<(f64, f64)>,
    /// Frequencies, Hz.
    pub frequencies: Vec<f64>,
    /// Samples of a block.
    pub block: usize,
    /// How much faster than the clock on the wall; none is as fast as the machine can.
    pub speed: Option<f64>,
    /// Quality factor of a resonance near each frequency: amplitudes follow the drive by it.
    pub quality: f64,
    /// Distance of that resonance from the frequency, relative.
    pub detuning: f64,
    /// Gain of the power amplifier against that of the laboratory.
    pub gain: f64,
    /// Relative drift of that gain up and down, and its period in s.
    pub drift: (f64, f64),
    /// Largest drive, V.
    pub largest_drive: f64,
}

impl SimulatedBench {
    /// The bench of the laboratory of `rig` in real time, for a plan.
    pub fn new(plan: Vec<(f64, f64)>, frequencies: Vec<f64>, seed: u64) -> Self {
        Self {
            laboratory: Laboratory::default(),
            seed,
            plan,
            frequencies,
            block: 2048,
            speed: Some(1.0),
            quality: 6.0,
            detuning: 0.0,
            gain: 1.0,
            drift: (0.0, 60.0),
            largest_drive: 10.0,
        }
    }
}

/// The shaker under the present mounting, as a linear system at its frequency.
struct Shaken {
    prepared: PreparedRun,
    /// Pole, gain of the resonance per sample.
    pole: Complex64,
    inward: Complex64,
    state: Complex64,
    before: f64,
    turn: (f64, f64),
    /// Loss of the shaker per volt, and acceleration per volt without it.
    loss: f64,
    response: f64,
}

impl Shaken {
    fn new(bench: &SimulatedBench, prepared: PreparedRun, rate: f64) -> Self {
        let f = prepared.frequency;
        let omega = TAU * f / rate;
        let pole = Complex64::from_polar(
            (-omega / (2.0 * bench.quality)).exp(),
            omega * (1.0 + bench.detuning),
        );
        let shaker = &bench.laboratory.shaker;
        let response = shaker.response(f).norm();
        let at_level = shaker.motion(prepared.drive, f)[0].norm();
        Self {
            loss: (response * prepared.drive / at_level - 1.0) / prepared.drive,
            response,
            inward: 1.0 - pole * Complex64::from_polar(1.0, -omega),
            pole,
            state: Complex64::new(0.0, 0.0),
            before: 0.0,
            turn: omega.sin_cos(),
            prepared,
        }
    }

    /// The drive after the resonance, as a turning phasor in V.
    fn follow(&mut self, drive: f64) -> Complex64 {
        let (sin, cos) = self.turn;
        // The quarter turn behind a sine, from two samples of it.
        let analytic = Complex64::new((self.before - drive * cos) / -sin, 0.0)
            + Complex64::new(0.0, 1.0) * drive;
        self.before = drive;
        self.state = self.pole * self.state + self.inward * analytic;
        self.state
    }

    /// Outputs in V of the four channels, and the acceleration in m/s².
    fn outputs(&self, z: Complex64) -> ([f64; 4], f64) {
        let d = z.norm();
        if d < 1e-12 {
            return ([0.0; 4], 0.0);
        }
        let of_level = |d: f64| d / (1.0 + self.loss * d);
        let scale = of_level(d) / of_level(self.prepared.drive);
        let e = z / d;
        let volts = self.prepared.volts.map(|phasors| {
            let horner = phasors
                .iter()
                .rev()
                .fold(Complex64::new(0.0, 0.0), |sum, p| (sum + p) * e);
            scale * horner.re
        });
        (volts, self.response * of_level(d))
    }
}

/// The simulated bench as a device.
pub struct Simulated {
    bench: SimulatedBench,
    identity: Identity,
    setup: Setup,
    shaken: Option<Shaken>,
    switch: Switch,
    random: Xoshiro256PlusPlus,
    counter: u64,
    began: Instant,
    blocks: u64,
    /// Dropped when the device is let go: a hang ends with it.
    released: Arc<RwLock<bool>>,
}

impl Simulated {
    /// Draws the errors of the bench.
    pub fn new(bench: SimulatedBench) -> Self {
        let daq = &bench.laboratory.acquisition;
        Self {
            identity: Identity {
                maker: "proofmass".into(),
                model: "simulated shaker bench".into(),
                serial: bench.seed.to_string(),
                channels: ["reference", "x", "y", "z"].map(String::from).to_vec(),
                rate: daq.sampling_frequency,
                block: bench.block,
                full_scale: daq.full_scale,
                drive: Some(bench.largest_drive),
                paced: bench.speed.is_some(),
            },
            setup: bench
                .laboratory
                .set_up(&bench.plan, &bench.frequencies, bench.seed),
            random: Xoshiro256PlusPlus::seed_from_u64(bench.seed ^ 0xB10C),
            bench,
            shaken: None,
            switch: Switch::default(),
            counter: 0,
            began: Instant::now(),
            blocks: 0,
            released: Arc::new(RwLock::new(false)),
        }
    }

    /// The switch of the faults.
    pub fn switch(&self) -> Switch {
        self.switch.clone()
    }

    /// Ends a hang, for tests that want their thread back.
    pub fn release(&self) -> impl Fn() + Send + 'static {
        let released = self.released.clone();
        move || *released.write().unwrap_or_else(PoisonError::into_inner) = true
    }

    fn block(&mut self, drive: &[f64]) -> Vec<Vec<f64>> {
        let daq = self.bench.laboratory.acquisition.clone();
        let step = 2.0 * daq.full_scale / 2f64.powi(daq.bits as i32);
        let fault = self.switch.get();
        let mut channels: [Vec<f64>; 4] = Default::default();
        let mut peak = f64::from_bits(self.switch.peak.load(Ordering::Relaxed));
        let (size, period) = self.bench.drift;
        let time = self.counter as f64 / daq.sampling_frequency;
        let runaway = if fault == Fault::Runaway { 10.0 } else { 1.0 };
        let gain = runaway * self.bench.gain * (1.0 + size * (TAU * time / period).sin());
        for &v in drive {
            let (mut volts, acceleration) = match &mut self.shaken {
                Some(shaken) => {
                    let z = shaken.follow(gain * v);
                    shaken.outputs(z)
                }
                None => ([0.0; 4], 0.0),
            };
            peak = peak.max(acceleration);
            match fault {
                Fault::CableOff => volts[0] = 0.0,
                Fault::Reversed => volts[0] = -volts[0],
                _ => {}
            }
            for (channel, v) in channels.iter_mut().zip(volts) {
                let noise: f64 = StandardNormal.sample(&mut self.random);
                let v = (v + daq.offset + daq.noise * noise).clamp(-daq.full_scale, daq.full_scale);
                channel.push((v / step).round() * step);
            }
        }
        self.switch.peak.store(peak.to_bits(), Ordering::Relaxed);
        channels.into()
    }

    /// Waits until the block is due by the clock on the wall.
    fn keep_time(&mut self) {
        self.blocks += 1;
        if let Some(speed) = self.bench.speed {
            let due = self.blocks as f64 * self.identity.block_seconds() / speed;
            let due = self.began + Duration::from_secs_f64(due);
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
    }
}

impl Device for Simulated {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        self.counter = 0;
        self.blocks = 0;
        self.began = Instant::now();
        if let Some(shaken) = &mut self.shaken {
            shaken.state = Complex64::new(0.0, 0.0);
            shaken.before = 0.0;
        }
        Ok(())
    }

    fn arrange(&mut self, arrangement: &Arrangement) -> Result<(), DeviceError> {
        // A fault is there for one run: somebody put the cable back.
        self.switch.set(Fault::None);
        let same = |a: f64, b: f64| (a - b).abs() < 1e-6;
        let lacks = |what: &str| {
            DeviceError::Nonsense(format!(
                "the simulated bench has no {what} of run {}",
                arrangement.run
            ))
        };
        let frequencies = &self.bench.frequencies;
        let f = frequencies
            .iter()
            .position(|f| same(*f, arrangement.frequency));
        let seat = (
            arrangement.inclination.unwrap_or(0.0),
            arrangement.rotation.unwrap_or(0.0),
        );
        let place = |p: &(f64, f64)| same(p.0, seat.0) && same(p.1, seat.1);
        let place = self.bench.plan.iter().position(place);
        let f = f.ok_or_else(|| lacks("frequency"))?;
        let place = place.ok_or_else(|| lacks("mounting"))?;
        let prepared = self.setup.prepare(f * self.bench.plan.len() + place, None);
        let prepared = prepared.map_err(|_| lacks("drive"))?;
        self.shaken = Some(Shaken::new(&self.bench, prepared, self.identity.rate));
        Ok(())
    }

    fn exchange(&mut self, drive: &[f64], wait: Duration) -> Result<Block, DeviceError> {
        match self.switch.get() {
            Fault::Stall => {
                std::thread::sleep(wait);
                return Err(DeviceError::Stalled);
            }
            Fault::Hang => {
                let over = |r: &RwLock<bool>| *r.read().unwrap_or_else(PoisonError::into_inner);
                while !over(&self.released) && self.switch.get() == Fault::Hang {
                    std::thread::sleep(Duration::from_millis(5));
                }
                return Err(DeviceError::Stalled);
            }
            _ => {}
        }
        self.note(drive);
        let mut channels = self.block(drive);
        let first = self.counter;
        self.counter += drive.len() as u64;
        match self.switch.get() {
            Fault::NotANumber => channels[1][drive.len() / 2] = f64::NAN,
            Fault::Short => channels
                .iter_mut()
                .for_each(|c| c.truncate(drive.len() / 2)),
            Fault::CounterJump => self.counter += 17,
            _ => {}
        }
        self.keep_time();
        Ok(Block {
            first,
            channels,
            overloaded: Vec::new(),
        })
    }

    fn silence(&mut self, _wait: Duration) -> Result<(), DeviceError> {
        if self.switch.get() == Fault::Hang {
            return Err(DeviceError::Stalled);
        }
        self.note(&[]);
        Ok(())
    }
}

impl Simulated {
    fn note(&self, drive: &[f64]) {
        let peak = drive.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        if peak > 0.0 {
            self.switch.driven.fetch_add(1, Ordering::Relaxed);
        }
        let last = drive.last().map_or(0.0, |_| peak);
        self.switch.last.store(last.to_bits(), Ordering::Relaxed);
    }
}
