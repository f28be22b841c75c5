//! Motions with exact derivatives.

use proofmass_core::Error;
use proofmass_core::check::within;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Exact position, velocity and acceleration at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MotionPoint {
    /// m
    pub position: f64,
    /// m/s
    pub velocity: f64,
    /// m/s²
    pub acceleration: f64,
}

/// What the axis does; it stands until t = 0 where that is possible.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum AxisMotion {
    /// x = A e^{−ζω_n t} cos(√(1−ζ²) ω_n t), let go at t = 0.
    DampedOscillation {
        /// A, m.
        amplitude: f64,
        /// ω_n/2π, Hz.
        frequency: f64,
        /// ζ, below 1.
        damping: f64,
    },
    /// DC motor under a proportional-derivative position loop that follows r = A sin(2πft), from rest:
    /// x'' + (1/τ + K K_d) x' + K K_p x = K K_p r, with motor x''/u = K and mechanical time constant τ.
    Servo {
        /// A of the reference, m.
        amplitude: f64,
        /// f, Hz.
        frequency: f64,
        /// √(K K_p)/2π: natural frequency of the closed loop, Hz.
        loop_frequency: f64,
        /// Damping of the closed loop, below 1.
        loop_damping: f64,
    },
    /// A body that moves at constant velocity is hit: its rigid velocity changes along half a cosine, and its
    /// structure rings.
    Impact {
        /// Velocity before, m/s.
        before: f64,
        /// Rigid velocity after, m/s.
        after: f64,
        /// Time of the impact, s.
        time: f64,
        /// Duration of the contact, s.
        contact: f64,
        /// Amplitude of the ringing velocity, m/s.
        ringing: f64,
        /// Frequency of the ringing, Hz.
        ringing_frequency: f64,
        /// Decay of the ringing, 1/s.
        ringing_decay: f64,
    },
    /// Constant acceleration from rest to a constant velocity.
    Ramp {
        /// Final velocity, m/s.
        velocity: f64,
        /// Acceleration before it, m/s².
        acceleration: f64,
    },
    /// Nothing moves.
    Standstill,
}

impl AxisMotion {
    /// A rod between springs: 60 mm, 4 Hz, ζ = 0.02.
    pub fn damped_oscillation() -> Self {
        Self::DampedOscillation {
            amplitude: 0.06,
            frequency: 4.0,
            damping: 0.02,
        }
    }

    /// A motor with a bar that follows 20 mm at this frequency (5, 10 and 15 Hz in the reference experiment).
    pub fn servo(frequency: f64) -> Self {
        Self::Servo {
            amplitude: 0.02,
            frequency,
            loop_frequency: 20.0,
            loop_damping: 0.5,
        }
    }

    /// From 0.5 m/s to −0.2 m/s in 4 ms, with 60 Hz ringing.
    pub fn impact() -> Self {
        Self::Impact {
            before: 0.5,
            after: -0.2,
            time: 1.0,
            contact: 0.004,
            ringing: 0.1,
            ringing_frequency: 60.0,
            ringing_decay: 15.0,
        }
    }

    /// 20 mm/s after half a second.
    pub fn ramp() -> Self {
        Self::Ramp {
            velocity: 0.02,
            acceleration: 0.04,
        }
    }

    /// Exact motion at time t.
    pub fn at(&self, t: f64) -> MotionPoint {
        match *self {
            Self::DampedOscillation {
                amplitude,
                frequency,
                damping,
            } => {
                if t < 0.0 {
                    return MotionPoint {
                        position: amplitude,
                        ..MotionPoint::default()
                    };
                }
                let wn = TAU * frequency;
                decaying(
                    t,
                    damping * wn,
                    wn * (1.0 - damping * damping).sqrt(),
                    amplitude,
                    0.0,
                )
            }
            Self::Servo {
                amplitude,
                frequency,
                loop_frequency,
                loop_damping,
            } => servo(
                t,
                amplitude,
                TAU * frequency,
                TAU * loop_frequency,
                loop_damping,
            ),
            Self::Impact {
                before,
                after,
                time,
                contact,
                ringing,
                ringing_frequency,
                ringing_decay,
            } => {
                let s = t - time;
                if s < 0.0 {
                    return MotionPoint {
                        position: before * t,
                        velocity: before,
                        acceleration: 0.0,
                    };
                }
                let change = after - before;
                let u = s.min(contact);
                let angle = PI * u / contact;
                let inside = s < contact;
                let blow = MotionPoint {
                    position: 0.5 * change * (u - contact / PI * libm::sin(angle))
                        + change * (s - u),
                    velocity: 0.5 * change * (1.0 - libm::cos(angle)),
                    acceleration: if inside {
                        0.5 * change * PI / contact * libm::sin(angle)
                    } else {
                        0.0
                    },
                };
                // The ringing velocity B e^{−σs} sin ωs is the derivative of a decaying oscillation x with
                // x = −B e^{−σs}(σ sin ωs + ω cos ωs)/(σ² + ω²), started at zero.
                let (w, d) = (TAU * ringing_frequency, ringing_decay);
                let scale = ringing / (d * d + w * w);
                let ring = decaying(s, d, w, -scale * w, -scale * d);
                MotionPoint {
                    position: before * t + blow.position + ring.position + scale * w,
                    velocity: before + blow.velocity + ring.velocity,
                    acceleration: blow.acceleration + ring.acceleration,
                }
            }
            Self::Ramp {
                velocity,
                acceleration,
            } => {
                let end = velocity / acceleration;
                let (u, rest) = (t.clamp(0.0, end), (t - end).max(0.0));
                MotionPoint {
                    position: 0.5 * acceleration * u * u + velocity * rest,
                    velocity: acceleration * u,
                    acceleration: if (0.0..end).contains(&t) {
                        acceleration
                    } else {
                        0.0
                    },
                }
            }
            Self::Standstill => MotionPoint::default(),
        }
    }

    /// Refuses parameters for which the formulas do not hold.
    pub(super) fn check(&self) -> Result<(), Error> {
        const SMALL: f64 = 1e-9;
        const LARGE: f64 = 1e9;
        match *self {
            Self::DampedOscillation {
                amplitude,
                frequency,
                damping,
            } => {
                within("amplitude", amplitude, -LARGE, LARGE)?;
                within("frequency", frequency, SMALL, LARGE)?;
                within("damping", damping, 0.0, 1.0 - SMALL)
            }
            Self::Servo {
                amplitude,
                frequency,
                loop_frequency,
                loop_damping,
            } => {
                within("amplitude", amplitude, -LARGE, LARGE)?;
                within("frequency", frequency, SMALL, LARGE)?;
                within("loop_frequency", loop_frequency, SMALL, LARGE)?;
                within("loop_damping", loop_damping, SMALL, 1.0 - SMALL)
            }
            Self::Impact {
                before,
                after,
                time,
                contact,
                ringing,
                ringing_frequency,
                ringing_decay,
            } => {
                within("before", before, -LARGE, LARGE)?;
                within("after", after, -LARGE, LARGE)?;
                within("time", time, -LARGE, LARGE)?;
                within("contact", contact, SMALL, LARGE)?;
                within("ringing", ringing, -LARGE, LARGE)?;
                within("ringing_frequency", ringing_frequency, SMALL, LARGE)?;
                within("ringing_decay", ringing_decay, 0.0, LARGE)
            }
            Self::Ramp {
                velocity,
                acceleration,
            } => {
                within("velocity", velocity, -LARGE, LARGE)?;
                within("acceleration", acceleration, -LARGE, LARGE)?;
                within("duration of the ramp", velocity / acceleration, 0.0, LARGE)
            }
            Self::Standstill => Ok(()),
        }
    }
}

/// e^{−σt}(C cos ωt + S sin ωt) with its derivatives.
fn decaying(t: f64, sigma: f64, w: f64, c: f64, s: f64) -> MotionPoint {
    // Not the system's own, so that a seed gives the same bits on every machine.
    let e = libm::exp(-sigma * t);
    let (sin, cos) = libm::sincos(w * t);
    let (c1, s1) = (w * s - sigma * c, -w * c - sigma * s);
    let (c2, s2) = (w * s1 - sigma * c1, -w * c1 - sigma * s1);
    MotionPoint {
        position: e * (c * cos + s * sin),
        velocity: e * (c1 * cos + s1 * sin),
        acceleration: e * (c2 * cos + s2 * sin),
    }
}

/// x'' + 2ζω₀x' + ω₀²x = ω₀² A sin ωt from rest: forced part plus the decaying part that makes it start at rest.
fn servo(t: f64, amplitude: f64, w: f64, w0: f64, zeta: f64) -> MotionPoint {
    if t < 0.0 {
        return MotionPoint::default();
    }
    // Forced part P sin ωt + Q cos ωt.
    let (d, e) = (w0 * w0 - w * w, 2.0 * zeta * w0 * w);
    let scale = w0 * w0 * amplitude / (d * d + e * e);
    let (p, q) = (scale * d, -scale * e);
    let forced = decaying(t, 0.0, w, q, p);
    let (sigma, wd) = (zeta * w0, w0 * (1.0 - zeta * zeta).sqrt());
    let c = -q;
    let s = (sigma * c - w * p) / wd;
    let free = decaying(t, sigma, wd, c, s);
    MotionPoint {
        position: forced.position + free.position,
        velocity: forced.velocity + free.velocity,
        acceleration: forced.acceleration + free.acceleration,
    }
}
