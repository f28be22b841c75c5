//! Do the 95 % intervals of a triaxial calibration on the shaker hold the truth, whatever the mounting does?
//!
//! Prints the table of docs/shaker.md: `cargo run --release -p proofmass-shaker --example shaker_coverage`. An
//! argument sets the number of campaigns per case (300), a second one names the cases by a part of their name.
//!
//! The mounting is made here from turns of the body about fixed axes, one after the other, and shares no formula with the
//! estimator; everything from the phasors on is the real fit.

use num_complex::Complex64;
use proofmass_rig::bench::{BenchDevice, BenchWedge, published_plan};
use proofmass_shaker::campaign::frequency_result;
use proofmass_shaker::recording::{Quality, RunInput};
use proofmass_shaker::spurious::{self, Average, RatioRepeats};
use proofmass_shaker::{
    Acts, Budget, Configuration, Correction, Fit, Key, PhasorRow, ShakerCampaign, ShakerInput,
    ShakerMethod, SpuriousTable, calibrate, diagnose, joint,
};
use proofmass_uncertainty::{DegreesOfFreedom, Estimate, Finding, Severity};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

/// One case: half widths in degrees, what is there and what the budget knows of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Case {
    /// Its name in the table.
    pub name: &'static str,
    /// Tilt of every gluing about two axes: true and declared.
    pub tilt: [f64; 2],
    /// Mean tilt of all gluings.
    pub mean_tilt: [f64; 2],
    /// Lateral lean of every wedge.
    pub lean: [f64; 2],
    /// Zero of the mask, common to all gluings.
    pub mask: [f64; 2],
    /// Zero of the marks of every wedge, common to the gluings on it.
    pub marks: [f64; 2],
    /// Gain of the reference, common to the runs on a wedge: half width, not in degrees but relative.
    pub wedge_gain: [f64; 2],
    /// Repeats of the spurious motion and their noise in each part of a ratio; none for an ideal table.
    pub repeats: Option<(usize, f64)>,
    /// Whether every ratio has the scatter of its own repeats as uncertainty, instead of the pooled one.
    pub own: bool,
    /// Motion of the bench that nobody measured, or not everywhere.
    pub unmeasured: Option<Unmeasured>,
    /// Whether the cross terms are exactly zero.
    pub diagonal: bool,
    /// True over declared uncertainty of the readings and of the angle of every gluing.
    pub beyond: [f64; 2],
    /// Gluings.
    pub gluings: Gluings,
}

/// Motion of a bench drawn for each wedge and frequency by itself, and what the laboratory knows of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unmeasured {
    /// Standard deviation of each part of the ratios across the excitation.
    pub across: f64,
    /// Likewise along it.
    pub along: f64,
    /// Whether it was measured, to 0.001, on every other wedge.
    pub half: bool,
    /// Whether the wedges bend as well along the excitation, towards a resonance of some 4 to 7 kHz.
    pub bends: bool,
}

/// Configurations of a campaign.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gluings {
    /// All 44 of the published plan.
    #[default]
    Published,
    /// 0° twice, 35° and 75° at four rotations each, 90° at two.
    Twelve,
    /// 55° and 90° at three rotations each.
    Six,
}

impl Gluings {
    fn plan(self) -> Vec<(f64, f64)> {
        let of = |list: &[(f64, &[f64])]| -> Vec<(f64, f64)> {
            list.iter()
                .flat_map(|&(i, r)| r.iter().map(move |&r| (i, r)))
                .collect()
        };
        match self {
            Self::Published => published_plan(),
            Self::Twelve => of(&[
                (0.0, &[0.0, 180.0]),
                (35.0, &[0.0, 90.0, 180.0, 270.0]),
                (75.0, &[45.0, 135.0, 225.0, 315.0]),
                (90.0, &[0.0, 90.0]),
            ]),
            Self::Six => of(&[(55.0, &[0.0, 120.0, 240.0]), (90.0, &[60.0, 180.0, 300.0])]),
        }
    }
}

/// The cases of the table.
pub const CASES: [Case; 54] = [
    Case {
        name: "no tilt",
        ..NONE
    },
    Case {
        name: "tilt ±0.1°",
        tilt: [0.1, 0.1],
        ..NONE
    },
    Case {
        name: "tilt ±0.1° undeclared",
        tilt: [0.1, 0.0],
        ..NONE
    },
    Case {
        name: "tilt ±0.3°",
        tilt: [0.3, 0.3],
        ..NONE
    },
    Case {
        name: "tilt ±0.3° declared ±0.1°",
        tilt: [0.3, 0.1],
        ..NONE
    },
    Case {
        name: "tilt ±0.3° undeclared",
        tilt: [0.3, 0.0],
        ..NONE
    },
    Case {
        name: "tilt and mean tilt ±0.1°",
        tilt: [0.1, 0.1],
        mean_tilt: [0.1, 0.1],
        ..NONE
    },
    Case {
        name: "lean ±0.3° of wedges",
        lean: [0.3, 0.3],
        ..NONE
    },
    Case {
        name: "lean ±0.3° undeclared",
        lean: [0.3, 0.0],
        ..NONE
    },
    Case {
        name: "mask ±1°",
        mask: [1.0, 1.0],
        ..NONE
    },
    Case {
        name: "marks ±0.5° of wedges",
        marks: [0.5, 0.5],
        ..NONE
    },
    Case {
        name: "marks ±0.5° undeclared",
        marks: [0.5, 0.0],
        ..NONE
    },
    Case {
        name: "marks ±1° of wedges",
        marks: [1.0, 1.0],
        ..NONE
    },
    Case {
        name: "marks ±1° undeclared",
        marks: [1.0, 0.0],
        ..NONE
    },
    Case {
        name: "gain ±0.5 % of wedges",
        wedge_gain: [0.005, 0.005],
        ..NONE
    },
    Case {
        name: "gain ±0.25 % undeclared",
        wedge_gain: [0.0025, 0.0],
        ..NONE
    },
    Case {
        name: "gain ±0.5 % undeclared",
        wedge_gain: [0.005, 0.0],
        ..NONE
    },
    Case {
        name: "spurious, 2 × 0.001",
        repeats: Some((2, 1e-3)),
        ..NONE
    },
    Case {
        name: "spurious, 3 × 0.001",
        repeats: Some((3, 1e-3)),
        ..NONE
    },
    Case {
        name: "spurious, 10 × 0.001",
        repeats: Some((10, 1e-3)),
        ..NONE
    },
    Case {
        name: "spurious, 2 × 0.004",
        repeats: Some((2, 4e-3)),
        ..NONE
    },
    Case {
        name: "spurious, 3 × 0.004",
        repeats: Some((3, 4e-3)),
        ..NONE
    },
    Case {
        name: "spurious, 2 × 0.001, u of each",
        repeats: Some((2, 1e-3)),
        own: true,
        ..NONE
    },
    Case {
        name: "spurious, 3 × 0.001, u of each",
        repeats: Some((3, 1e-3)),
        own: true,
        ..NONE
    },
    Case {
        name: "spurious, 10 × 0.001, u of each",
        repeats: Some((10, 1e-3)),
        own: true,
        ..NONE
    },
    Case {
        name: "spurious, 2 × 0.004, u of each",
        repeats: Some((2, 4e-3)),
        own: true,
        ..NONE
    },
    Case {
        name: "spurious, 3 × 0.004, u of each",
        repeats: Some((3, 4e-3)),
        own: true,
        ..NONE
    },
    Case {
        name: "spurious, 10 × 0.004, u of each",
        repeats: Some((10, 4e-3)),
        own: true,
        ..NONE
    },
    Case {
        name: "cross terms zero",
        diagonal: true,
        ..NONE
    },
    Case {
        name: "44 gluings, readings × 2, gluing × 1",
        beyond: [2.0, 1.0],
        gluings: Gluings::Published,
        ..NONE
    },
    Case {
        name: "44 gluings, readings × 1, gluing × 2",
        beyond: [1.0, 2.0],
        gluings: Gluings::Published,
        ..NONE
    },
    Case {
        name: "44 gluings, readings × 1, gluing × 4",
        beyond: [1.0, 4.0],
        gluings: Gluings::Published,
        ..NONE
    },
    Case {
        name: "12 gluings, readings × 1, gluing × 1",
        beyond: [1.0, 1.0],
        gluings: Gluings::Twelve,
        ..NONE
    },
    Case {
        name: "12 gluings, readings × 2, gluing × 1",
        beyond: [2.0, 1.0],
        gluings: Gluings::Twelve,
        ..NONE
    },
    Case {
        name: "12 gluings, readings × 1, gluing × 2",
        beyond: [1.0, 2.0],
        gluings: Gluings::Twelve,
        ..NONE
    },
    Case {
        name: "12 gluings, readings × 1, gluing × 4",
        beyond: [1.0, 4.0],
        gluings: Gluings::Twelve,
        ..NONE
    },
    Case {
        name: "6 gluings, readings × 1, gluing × 1",
        beyond: [1.0, 1.0],
        gluings: Gluings::Six,
        ..NONE
    },
    Case {
        name: "6 gluings, readings × 2, gluing × 1",
        beyond: [2.0, 1.0],
        gluings: Gluings::Six,
        ..NONE
    },
    Case {
        name: "6 gluings, readings × 1, gluing × 2",
        beyond: [1.0, 2.0],
        gluings: Gluings::Six,
        ..NONE
    },
    Case {
        name: "6 gluings, readings × 1, gluing × 4",
        beyond: [1.0, 4.0],
        gluings: Gluings::Six,
        ..NONE
    },
    moving("unmeasured motion 0", 0.0, 0.0, false, Gluings::Published),
    moving(
        "unmeasured motion 0.2 %",
        0.002,
        0.0006,
        false,
        Gluings::Published,
    ),
    moving(
        "unmeasured motion 0.5 %",
        0.005,
        0.0015,
        false,
        Gluings::Published,
    ),
    moving(
        "unmeasured motion 1 %",
        0.01,
        0.003,
        false,
        Gluings::Published,
    ),
    moving(
        "unmeasured motion 2 %",
        0.02,
        0.006,
        false,
        Gluings::Published,
    ),
    moving(
        "unmeasured motion 5 %",
        0.05,
        0.015,
        false,
        Gluings::Published,
    ),
    moving(
        "half measured, motion 0.2 %",
        0.002,
        0.0006,
        true,
        Gluings::Published,
    ),
    moving(
        "half measured, motion 1 %",
        0.01,
        0.003,
        true,
        Gluings::Published,
    ),
    moving(
        "half measured, motion 5 %",
        0.05,
        0.015,
        true,
        Gluings::Published,
    ),
    moving(
        "12 gluings, unmeasured motion 0.2 %",
        0.002,
        0.0006,
        false,
        Gluings::Twelve,
    ),
    moving(
        "12 gluings, unmeasured motion 1 %",
        0.01,
        0.003,
        false,
        Gluings::Twelve,
    ),
    moving(
        "12 gluings, unmeasured motion 5 %",
        0.05,
        0.015,
        false,
        Gluings::Twelve,
    ),
    bending(
        "wedges that bend, unmeasured motion 1 %",
        Gluings::Published,
    ),
    bending(
        "12 gluings, wedges that bend, unmeasured motion 1 %",
        Gluings::Twelve,
    ),
];

const fn bending(name: &'static str, gluings: Gluings) -> Case {
    Case {
        unmeasured: Some(Unmeasured {
            across: 0.01,
            along: 0.003,
            half: false,
            bends: true,
        }),
        ..moving(name, 0.0, 0.0, false, gluings)
    }
}

const fn moving(name: &'static str, across: f64, along: f64, half: bool, gluings: Gluings) -> Case {
    Case {
        name,
        unmeasured: Some(Unmeasured {
            across,
            along,
            half,
            bends: false,
        }),
        gluings,
        ..NONE
    }
}

const NONE: Case = Case {
    name: "",
    tilt: [0.0; 2],
    mean_tilt: [0.0; 2],
    lean: [0.0; 2],
    mask: [0.0; 2],
    marks: [0.0; 2],
    wedge_gain: [0.0; 2],
    repeats: None,
    own: false,
    unmeasured: None,
    diagonal: false,
    beyond: [1.0; 2],
    gluings: Gluings::Published,
};

/// Turn of a body about a fixed axis by the right hand: the matrix whose columns are the turned axes.
fn turn(axis: [f64; 3], angle: f64) -> [[f64; 3]; 3] {
    let (s, c) = angle.sin_cos();
    let [x, y, z] = axis;
    let cross = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            f64::from(i == j) * c + (1.0 - c) * axis[i] * axis[j] + s * cross[i][j]
        })
    })
}

fn product(a: [[f64; 3]; 3], b: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// The axes of the device in the frame of the bench.
pub fn body(inclination: f64, rotation: f64, lean: f64, tilt: [f64; 2]) -> [[f64; 3]; 3] {
    let size = tilt[0].hypot(tilt[1]);
    let about = if size > 0.0 {
        [tilt[0] / size, tilt[1] / size, 0.0]
    } else {
        [1.0, 0.0, 0.0]
    };
    let seat = product(
        turn([1.0, 0.0, 0.0], lean),
        turn([0.0, 1.0, 0.0], -inclination),
    );
    product(
        seat,
        product(turn([0.0, 0.0, 1.0], -rotation), turn(about, size)),
    )
}

/// A campaign of one seed with its truth.
pub struct Simulated {
    /// Phasors of the runs.
    pub rows: Vec<PhasorRow>,
    /// Measured spurious motion.
    pub spurious: SpuriousTable,
    /// S of every frequency.
    pub truth: Vec<[[Complex64; 3]; 3]>,
}

impl Case {
    /// Runs over the published plan.
    pub fn campaign(&self, frequencies: &[f64], seed: u64) -> Simulated {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut flat = {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0xA5A5);
            move |half_width: f64| half_width * (2.0 * rng.random::<f64>() - 1.0)
        };
        let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
        let plan = self.gluings.plan();
        let mut wedges: Vec<(f64, f64, f64)> = vec![];
        for &(inclination, _) in &plan {
            if !wedges.iter().any(|w| w.0 == inclination) {
                wedges.push((inclination, flat(0.1), flat(self.lean[0])));
            }
        }
        // Drawn by themselves, so that the other cases keep their campaigns.
        let mut of_wedges = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x5A5A);
        let mut shared: Vec<[f64; 2]> = vec![];
        for _ in &wedges {
            let sizes = [self.marks[0], self.wedge_gain[0]];
            shared.push(sizes.map(|half| half * (2.0 * of_wedges.random::<f64>() - 1.0)));
        }
        let of_wedge = |inclination: f64| {
            let place = wedges.iter().position(|w| w.0 == inclination);
            shared[place.expect("drawn")]
        };
        let mask = flat(self.mask[0]);
        let mean = [flat(self.mean_tilt[0]), flat(self.mean_tilt[0])];
        let seats: Vec<[[f64; 3]; 3]> = plan
            .iter()
            .map(|&(inclination, rotation)| {
                let wedge = wedges.iter().find(|w| w.0 == inclination).expect("drawn");
                let glued = rotation + mask + of_wedge(inclination)[0] + flat(self.beyond[1]);
                let tilt = [0, 1].map(|k| (mean[k] + flat(self.tilt[0])).to_radians());
                body(
                    (inclination + wedge.1).to_radians(),
                    glued.to_radians(),
                    wedge.2.to_radians(),
                    tilt,
                )
            })
            .collect();
        let mut of_motion = {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x3C3C);
            move || -> f64 { StandardNormal.sample(&mut rng) }
        };
        let gains: [f64; 3] = std::array::from_fn(|_| 1.0 + flat(0.0015));
        let device = BenchDevice {
            cross: if self.diagonal {
                [[0.0; 3]; 3]
            } else {
                BenchDevice::default().cross
            },
            ..BenchDevice::default()
        };
        let (mut rows, mut truth, mut readings) = (vec![], vec![], vec![]);
        for &frequency in frequencies {
            let s = device.sensitivity(frequency);
            let certificate = Complex64::from_polar(1.0 + 0.002 * normal(), 0.003 * normal());
            let moved: Vec<[Complex64; 3]> = wedges
                .iter()
                .map(|w| match self.unmeasured {
                    Some(u) => {
                        let mut motion = [u.across, u.across, u.along]
                            .map(|size| Complex64::new(of_motion(), of_motion()) * size);
                        if u.bends {
                            motion[2] += BenchWedge::default().ratio(w.0, frequency)[2];
                        }
                        motion
                    }
                    None => [Complex64::new(0.0, 0.0); 3],
                })
                .collect();
            let motion = |inclination: f64| match self.repeats {
                _ if self.unmeasured.is_some() => {
                    moved[wedges
                        .iter()
                        .position(|w| w.0 == inclination)
                        .expect("drawn")]
                }
                Some(_) => BenchWedge::default().ratio(inclination, frequency),
                None => [Complex64::new(0.0, 0.0); 3],
            };
            let measured = match self.unmeasured {
                Some(u) if u.half => Some((10, 1e-3)),
                Some(_) => None,
                None => self.repeats,
            };
            if let Some((repeats, noise)) = measured {
                let every = if self.unmeasured.is_some() { 2 } else { 1 };
                for (inclination, ..) in wedges.iter().step_by(every) {
                    for axis in 0..3 {
                        let whole = motion(*inclination)[axis] + f64::from(axis == 2);
                        let read = |_| whole + Complex64::new(normal(), normal()) * noise;
                        readings.push(RatioRepeats {
                            inclination: inclination.to_radians(),
                            frequency,
                            axis,
                            ratios: (0..repeats).map(read).collect(),
                        });
                    }
                }
            }
            for (&(inclination, rotation), seat) in plan.iter().zip(&seats) {
                let mut e = motion(inclination);
                e[2] += 1.0;
                let table = Complex64::from_polar(10.0, normal());
                let gain = 1.0 + of_wedge(inclination)[1];
                let seen: [Complex64; 3] = std::array::from_fn(|i| {
                    (0..3).map(|k| e[k] * seat[k][i]).sum::<Complex64>() * table
                });
                let outputs = std::array::from_fn(|j| {
                    let o: Complex64 = (0..3).map(|i| seen[i] * s[i][j]).sum();
                    let size = 0.003 * self.beyond[0];
                    let reading = Complex64::from_polar(1.0 + size * normal(), size * normal());
                    let noise = 5e-5 * self.beyond[0];
                    o * gains[j] * reading + Complex64::new(normal(), normal()) * noise
                });
                rows.push(PhasorRow::new(
                    format!("{frequency} Hz, {inclination}°, {rotation}°"),
                    frequency,
                    Configuration::degrees(inclination, rotation),
                    table * certificate * gain,
                    outputs,
                ));
            }
            truth.push(s);
        }
        let spurious = if self.own {
            own_scatter(&readings)
        } else {
            spurious::table(&readings).expect("two repeats at least").0
        };
        Simulated {
            rows,
            spurious,
            truth,
        }
    }

    /// What the laboratory declares.
    pub fn budget(&self) -> Budget {
        let gluing = [Key::Inclination, Key::Rotation];
        let reading = [Key::Run, Key::Channel];
        let mut inputs = vec![
            ShakerInput::new(
                "reference.calibration",
                Acts::ReferenceModulus,
                0.002,
                &[Key::Frequency],
            ),
            ShakerInput::new(
                "reference.phase",
                Acts::ReferencePhase,
                0.003,
                &[Key::Frequency],
            ),
            ShakerInput::rectangular(
                "wedge.angle",
                Acts::Inclination,
                0.1f64.to_radians(),
                &[Key::Inclination],
            ),
            ShakerInput::rectangular("gluing.angle", Acts::Rotation, 1f64.to_radians(), &gluing),
            ShakerInput::rectangular(
                "conditioner.gain",
                Acts::OutputModulus,
                0.0015,
                &[Key::Channel],
            ),
            ShakerInput::new("reading", Acts::OutputModulus, 0.003, &reading),
            ShakerInput::new("reading.phase", Acts::OutputPhase, 0.003, &reading),
            ShakerInput::new("noise", Acts::OutputAdditive, 5e-5, &reading),
        ];
        for (key, acts, half_width, keys) in [
            ("gluing.tilt", Acts::Tilt, self.tilt[1], &gluing[..]),
            ("device.tilt.mean", Acts::Tilt, self.mean_tilt[1], &[]),
            ("wedge.lean", Acts::Lean, self.lean[1], &[Key::Inclination]),
            ("mask.zero", Acts::Rotation, self.mask[1], &[]),
            (
                "wedge.marks",
                Acts::Rotation,
                self.marks[1],
                &[Key::Inclination],
            ),
        ] {
            if half_width > 0.0 {
                inputs.push(ShakerInput::rectangular(
                    key,
                    acts,
                    half_width.to_radians(),
                    keys,
                ));
            }
        }
        if self.wedge_gain[1] > 0.0 {
            inputs.push(ShakerInput::rectangular(
                "wedge.gain",
                Acts::ReferenceModulus,
                self.wedge_gain[1],
                &[Key::Inclination],
            ));
        }
        Budget::new(inputs).expect("a budget")
    }

    /// How often the intervals hold the truth.
    pub fn cell(&self, frequencies: &[f64], campaigns: usize) -> Cell {
        let budget = self.budget();
        let all: Vec<Judged> = (0..campaigns as u64)
            .into_par_iter()
            .map(|seed| {
                let mut simulated = self.campaign(frequencies, 50_000 + seed);
                if self.unmeasured.is_some() {
                    return through_a_calibration(&simulated, &budget);
                }
                // As in a calibration.
                simulated.spurious = simulated.spurious.pooled("measured").0;
                let (suspects, _) = diagnose(&simulated.rows, &simulated.spurious, &budget, None)
                    .expect("sound runs");
                let fit = joint(&simulated.rows, &simulated.spurious, &budget).expect("sound runs");
                let missing = |code: &str| {
                    let of = |f: &Finding| f.code() == code && f.severity() != Severity::Note;
                    fit.findings.iter().any(of)
                };
                let widths = WIDTHS.map(|p| {
                    let f = &fit.frequencies[0].estimate.quantities();
                    f[p].expanded(0.95) / f[0].value
                });
                let said = [
                    missing("missing-input"),
                    missing("angle-prior-too-small"),
                    !suspects.is_empty(),
                ];
                let sizes = if self.diagonal { sizes(&fit) } else { vec![] };
                let estimates: Vec<&Estimate> =
                    fit.frequencies.iter().map(|f| &f.estimate).collect();
                (hits(&estimates, &simulated), said, widths, sizes)
            })
            .collect();
        let n = campaigns as f64;
        let share = |p: usize| all.iter().filter(|a| a.0[p]).count() as f64 / n;
        let frequencies = frequencies.len() as f64;
        let components: Vec<f64> = (0..18)
            .map(|p| {
                (0..frequencies as usize)
                    .map(|f| share(18 * f + p))
                    .sum::<f64>()
                    / frequencies
            })
            .collect();
        let count = all[0].3.len();
        Cell {
            components,
            said: [0, 1, 2].map(|k| all.iter().filter(|a| a.1[k]).count() as f64 / n),
            width: [0, 1, 2, 3].map(|k| all.iter().map(|a| a.2[k]).sum::<f64>() / n),
            sizes: (0..count)
                .map(|k| all.iter().filter(|a| a.3[k]).count() as f64 / n)
                .collect(),
        }
    }
}

/// What the job itself says of a campaign.
fn through_a_calibration(simulated: &Simulated, budget: &Budget) -> Judged {
    let run = |r: &PhasorRow| RunInput {
        run: r.run.clone(),
        session: r.session.clone(),
        frequency: r.frequency,
        configuration: r.configuration,
        reference: r.reference,
        outputs: r.outputs,
        covariance: r.covariance,
        quality: Quality::default(),
    };
    let mut campaign =
        ShakerCampaign::new(simulated.rows.iter().map(run).collect(), budget.clone());
    campaign.methods = vec![ShakerMethod::Joint];
    if !simulated.spurious.entries.is_empty() {
        campaign.corrections = vec![Correction {
            label: "measured".to_owned(),
            table: simulated.spurious.clone(),
        }];
    }
    let calibration = calibrate(&campaign).expect("sound runs");
    let result = &calibration.results[0];
    let missing = |code: &str| {
        let of = |f: &Finding| f.code() == code && f.severity() != Severity::Note;
        result.findings.iter().any(of)
    };
    let said = [
        missing("missing-input"),
        missing("angle-prior-too-small"),
        !calibration.suspects.is_empty(),
    ];
    let estimates: Vec<&Estimate> = result.frequencies.iter().map(|f| &f.estimate).collect();
    let first = estimates[0].quantities();
    let widths = WIDTHS.map(|p| first[p].expanded(0.95) / first[0].value);
    (hits(&estimates, simulated), said, widths, vec![])
}

/// A table as a laboratory writes it that has no program for it: each mean with the scatter of its own repeats.
fn own_scatter(readings: &[RatioRepeats]) -> SpuriousTable {
    let (mut table, _) = spurious::table(readings).expect("two repeats at least");
    for entry in &mut table.entries {
        let here = |r: &&RatioRepeats| {
            r.inclination == entry.inclination && r.frequency == entry.frequency
        };
        for r in readings.iter().filter(here) {
            if let Ok(Average::Coherent(e)) = spurious::average(&r.ratios) {
                entry.covariance[r.axis] = e.covariance;
                entry.dof = DegreesOfFreedom::new(e.dof).expect("two repeats at least");
            }
        }
    }
    table
}

/// For every frequency and real number of S, whether its interval holds the truth.
fn hits(estimates: &[&Estimate], simulated: &Simulated) -> Vec<bool> {
    let mut hits = vec![];
    for (estimate, truth) in estimates.iter().zip(&simulated.truth) {
        for (p, q) in estimate.quantities().iter().enumerate() {
            let s = truth[p / 6][p / 2 % 3];
            let truth = if p % 2 == 0 { s.re } else { s.im };
            hits.push((q.value - truth).abs() <= q.expanded(0.95));
        }
    }
    hits
}

/// Moduli of the six cross terms and the three transverse sensitivities, all truly zero.
fn sizes(fit: &Fit) -> Vec<bool> {
    let result = frequency_result(&fit.frequencies[0]).expect("a matrix");
    let cross = (0..9).filter(|k| k % 4 != 0);
    let mut hits: Vec<bool> = cross
        .map(|k| &result.sensitivity[k].modulus)
        .map(|m| m.value <= m.expanded)
        .collect();
    let transverse = result
        .transverse
        .iter()
        .filter(|q| !q.name.ends_with("angle"));
    hits.extend(transverse.map(|t| t.value <= t.expanded));
    hits
}

/// Of one campaign: hits of the components, what was said, widths, hits of the sizes.
type Judged = (Vec<bool>, [bool; 3], [f64; WIDTHS.len()], Vec<bool>);

/// Real parts whose widths are told, among the 18 of S: xz, zx, xx, zz.
const WIDTHS: [usize; 4] = [4, 12, 0, 16];

/// What came of the campaigns of one case.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Share of intervals that hold the truth, for each of the 18 reals, over the frequencies.
    pub components: Vec<f64>,
    /// Share of campaigns in which an input is told to be missing, a declared one is too small, and a run is accused.
    pub said: [f64; 3],
    /// Mean U of Re S_xz and of Re S_zx over S_xx.
    pub width: [f64; WIDTHS.len()],
    /// Share of moduli and transverse sensitivities that reach zero, where they are zero.
    pub sizes: Vec<f64>,
}

impl Cell {
    /// Mean over some of the components.
    pub fn mean(&self, of: &[usize]) -> f64 {
        of.iter().map(|&p| self.components[p]).sum::<f64>() / of.len() as f64
    }
}

#[allow(dead_code, reason = "a test has no use for the printed table")]
fn main() {
    let campaigns = std::env::args()
        .nth(1)
        .and_then(|a| a.parse().ok())
        .unwrap_or(300);
    println!(
        "| case | main | xy, yx | xz, yz | zx, zy | imaginary | all 18 | least, most | missing | too small | accused | U xz, zx, xx, zz in % |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    let only = std::env::args().nth(2).unwrap_or_default();
    for case in CASES.iter().filter(|c| c.name.contains(&only)) {
        let cell = case.cell(&[10.0, 160.0, 1000.0], campaigns);
        let percent = |v: f64| format!("{:.1}", 100.0 * v);
        let imaginary: Vec<usize> = (0..9).map(|k| 2 * k + 1).collect();
        let all: Vec<usize> = (0..18).collect();
        let least = cell.components.iter().copied().fold(1.0, f64::min);
        let most = cell.components.iter().copied().fold(0.0, f64::max);
        println!(
            "| {} | {} | {} | {} | {} | {} | {} | {}, {} | {} | {} | {} | {:.3}, {:.3}, {:.3}, {:.3} |",
            case.name,
            percent(cell.mean(&[0, 8, 16])),
            percent(cell.mean(&[2, 6])),
            percent(cell.mean(&[4, 10])),
            percent(cell.mean(&[12, 14])),
            percent(cell.mean(&imaginary)),
            percent(cell.mean(&all)),
            percent(least),
            percent(most),
            percent(cell.said[0]),
            percent(cell.said[1]),
            percent(cell.said[2]),
            100.0 * cell.width[0],
            100.0 * cell.width[1],
            100.0 * cell.width[2],
            100.0 * cell.width[3],
        );
        if !cell.sizes.is_empty() {
            let sizes: Vec<String> = cell.sizes.iter().map(|&s| percent(s)).collect();
            println!(
                "| … its six moduli and three transverse sensitivities | {} |",
                sizes.join(", ")
            );
        }
    }
}
