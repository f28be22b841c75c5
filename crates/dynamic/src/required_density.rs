//! A required density of an acceleration and whether a measured one keeps it.

use proofmass_core::{Error, STANDARD_GRAVITY};
use proofmass_signal::Density;
use serde::{Deserialize, Serialize};

/// A point of a required density.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RequiredPoint {
    /// Frequency, Hz.
    pub frequency: f64,
    /// Density, (m/s²)²/Hz.
    pub density: f64,
    /// Lower and upper tolerance from here to the next point, dB.
    pub tolerance: [f64; 2],
}

/// A density that is required of an acceleration: straight lines in the logarithms between its points.
///
/// ```
/// use proofmass_dynamic::required_density::RequiredDensity;
/// let navmat = RequiredDensity::named("navmat-p-9492").unwrap();
/// let g = 9.80665;
/// assert!((navmat.rms(20.0, 2000.0) / g - 6.06).abs() < 0.01);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RequiredDensity {
    /// What it is called.
    pub name: String,
    /// Its points in ascending order of the frequency.
    pub points: Vec<RequiredPoint>,
}

/// A published profile: its word, its title, its points in Hz and g²/Hz.
type Profile = (&'static str, &'static str, &'static [(f64, f64)]);

/// Published profiles; their overall values are 6.06, 14.1, 10.0 and 7.7 g.
const PROFILES: [Profile; 4] = [
    (
        "navmat-p-9492",
        "NAVMAT P-9492",
        &[(20.0, 0.01), (80.0, 0.04), (350.0, 0.04), (2000.0, 0.007)],
    ),
    (
        "gevs-qualification",
        "GSFC-STD-7000 (GEVS), qualification",
        &[(20.0, 0.026), (50.0, 0.16), (800.0, 0.16), (2000.0, 0.026)],
    ),
    (
        "gevs-acceptance",
        "GSFC-STD-7000 (GEVS), acceptance",
        &[(20.0, 0.013), (50.0, 0.08), (800.0, 0.08), (2000.0, 0.013)],
    ),
    (
        "mil-std-810-minimum-integrity",
        "MIL-STD-810, method 514, category 24, minimum integrity",
        &[(20.0, 0.04), (1000.0, 0.04), (2000.0, 0.01)],
    ),
];

impl RequiredDensity {
    /// Tolerance where none is stated, dB.
    pub const TOLERANCE: [f64; 2] = [-3.0, 3.0];

    /// Words of the published profiles.
    ///
    /// **Source** `[NAVMATP9492]`, `[GSFC-STD-7000]`, `[MIL-STD-810H]` method 514.8, annex E.
    pub fn names() -> impl Iterator<Item = &'static str> {
        PROFILES.iter().map(|p| p.0)
    }

    /// A published profile by its word, with ±3 dB.
    pub fn named(word: &str) -> Option<Self> {
        let (_, title, points) = PROFILES.iter().find(|p| p.0 == word)?;
        let square = STANDARD_GRAVITY * STANDARD_GRAVITY;
        let points = points.iter().map(|(frequency, density)| RequiredPoint {
            frequency: *frequency,
            density: density * square,
            tolerance: Self::TOLERANCE,
        });
        Some(Self {
            name: (*title).to_owned(),
            points: points.collect(),
        })
    }

    /// Refuses what is no profile.
    ///
    /// # Errors
    /// [`Error::TooFew`] points; [`Error::OutOfRange`] for frequencies that do not ascend, densities that are not positive, a
    /// tolerance that leaves no room.
    pub fn check(&self) -> Result<(), Error> {
        if self.points.len() < 2 {
            return Err(Error::TooFew {
                name: "points of the required spectrum",
                needed: 2,
                got: self.points.len(),
            });
        }
        let mut before = 0.0;
        for p in &self.points {
            let refused = |name, value, min: f64| Error::OutOfRange {
                name,
                value,
                min,
                max: f64::MAX,
            };
            if !(p.frequency > before && p.frequency.is_finite()) {
                return Err(refused(
                    "frequency of the required spectrum",
                    p.frequency,
                    before,
                ));
            }
            if !(p.density > 0.0 && p.density.is_finite()) {
                return Err(refused("density of the required spectrum", p.density, 0.0));
            }
            let [low, high] = p.tolerance;
            if !(low < high && low.is_finite() && high.is_finite()) {
                return Err(refused(
                    "upper tolerance of the required spectrum",
                    high,
                    low,
                ));
            }
            before = p.frequency;
        }
        Ok(())
    }

    /// Lowest and highest frequency, Hz.
    pub fn band(&self) -> [f64; 2] {
        let at = |p: Option<&RequiredPoint>| p.map_or(0.0, |p| p.frequency);
        [at(self.points.first()), at(self.points.last())]
    }

    /// Density and tolerance at a frequency; `None` beyond its points.
    pub fn at(&self, frequency: f64) -> Option<(f64, [f64; 2])> {
        let k = self.points.partition_point(|p| p.frequency <= frequency);
        let a = self.points.get(k.checked_sub(1)?)?;
        match self.points.get(k) {
            Some(b) => {
                let t = (frequency / a.frequency).ln() / (b.frequency / a.frequency).ln();
                Some((a.density * (b.density / a.density).powf(t), a.tolerance))
            }
            // The last point has the tolerance of the line that ends there.
            None if a.frequency == frequency => {
                let line = self.points.get(k.wrapping_sub(2)).unwrap_or(a);
                Some((a.density, line.tolerance))
            }
            None => None,
        }
    }

    /// Root mean square between two frequencies, m/s²: each line in closed form.
    pub fn rms(&self, low: f64, high: f64) -> f64 {
        let lines = self.points.windows(2).map(|pair| {
            let (a, b) = (pair[0], pair[1]);
            let (from, to) = (low.max(a.frequency), high.min(b.frequency));
            if !(to > from) {
                return 0.0;
            }
            let slope = (b.density / a.density).ln() / (b.frequency / a.frequency).ln();
            let at = |f: f64| a.density * (f / a.frequency).powf(slope);
            match (slope + 1.0).abs() < 1e-9 {
                true => at(from) * from * (to / from).ln(),
                false => (at(to) * to - at(from) * from) / (slope + 1.0),
            }
        });
        lines.sum::<f64>().sqrt()
    }
}

/// A measured density beside the required one, at each frequency of both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DensityLine {
    /// Hz.
    pub frequency: f64,
    /// Measured, (m/s²)²/Hz.
    pub measured: f64,
    /// Simultaneous 95 % interval.
    pub interval: [f64; 2],
    /// Required.
    pub required: f64,
    /// Lower and upper limit.
    pub limits: [f64; 2],
}

/// What a measured density says of a required one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "verdict")]
#[non_exhaustive]
pub enum DensityVerdict {
    /// Every simultaneous interval lies within the limits.
    Inside {
        /// Frequency at which the estimate comes nearest to a limit, Hz.
        frequency: f64,
        /// How far it is from there, dB.
        margin: f64,
    },
    /// An interval lies wholly beyond a limit.
    Beyond {
        /// Frequency of the estimate that is beyond by most, Hz.
        frequency: f64,
        /// By how much, dB; below zero beneath the lower limit.
        by: f64,
        /// Its interval, dB beyond the limit.
        interval: [f64; 2],
        /// Lines beyond.
        lines: usize,
    },
    /// Neither: the record is too short, or does not reach all frequencies.
    NotShown {
        /// Lines whose interval reaches over a limit.
        lines: usize,
        /// Frequency of the estimate that is nearest to a limit or furthest beyond, Hz.
        frequency: f64,
        /// How far it is within it, dB; below zero beyond.
        margin: f64,
        /// Part of the required band that was measured, Hz.
        reached: [f64; 2],
        /// How many times as long a record at the required level would have to be; at most one where its length is enough.
        longer: f64,
    },
}

/// A measured density held against a required one.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DensityComparison {
    /// What it says.
    pub verdict: DensityVerdict,
    /// Root mean square in the common band, its standard uncertainty, and the required one, m/s².
    pub rms: [f64; 3],
    /// Degrees of freedom of a line.
    pub dof: f64,
    /// Distance of the lines, Hz.
    pub resolution: f64,
    /// Line by line.
    #[serde(skip)]
    pub lines: Vec<DensityLine>,
}

/// Share of Gaussian records that keep a profile and are called beyond, at most; and of those outside that are called inside.
const LEVEL: f64 = 0.05;
/// Σ ρ² of neighbouring lines of a Hann window: 1 + 2 (4/9 + 1/36).
const SHARED: f64 = 1.0 + 2.0 * (4.0 / 9.0 + 1.0 / 36.0);

impl RequiredDensity {
    /// Holds a measured density against this one; `relative` is the relative standard uncertainty of the acceleration.
    ///
    /// Each line has the interval ν S/χ² at 1 − 0.05/m of m lines, so that all of them hold together in 95 of 100 records,
    /// widened by what the calibration leaves open, (1 ± 1.96 u)².
    ///
    /// **Assumes** a Gaussian acceleration whose density is even over the distance of two lines.
    ///
    /// # Errors
    /// [`Error::TooFew`] where no line lies in the band; those of [`RequiredDensity::check`].
    pub fn judge(&self, density: &Density, relative: f64) -> Result<DensityComparison, Error> {
        self.check()?;
        let [low, high] = self.band();
        let rows: Vec<(usize, f64, [f64; 2])> = density
            .frequency
            .iter()
            .enumerate()
            // The lines at zero and at the end have half the freedom, and belong to no band.
            .take(density.frequency.len().saturating_sub(1))
            .skip(1)
            .filter_map(|(k, f)| {
                self.at(*f)
                    .map(|(required, tolerance)| (k, required, tolerance))
            })
            .collect();
        let probability = 1.0 - LEVEL / rows.len().max(1) as f64;
        let (Some(intervals), false) = (density.confidence(probability), rows.is_empty()) else {
            return Err(Error::TooFew {
                name: "lines of the spectrum in the required band",
                needed: 1,
                got: rows.len(),
            });
        };
        let (less, more) = (
            (1.0 - 1.96 * relative).max(0.0).powi(2),
            (1.0 + 1.96 * relative).powi(2),
        );
        let lines: Vec<DensityLine> = rows
            .iter()
            .map(|&(k, required, tolerance)| {
                let (from, to) = intervals[k];
                DensityLine {
                    frequency: density.frequency[k],
                    measured: density.density[k],
                    interval: [less * from, more * to],
                    required,
                    limits: tolerance.map(|d| required * 10f64.powf(d / 10.0)),
                }
            })
            .collect();
        let bin = density.bin_width;
        let reached = [
            low.max(lines[0].frequency - bin),
            high.min(lines[lines.len() - 1].frequency + bin),
        ];
        let whole = reached[0] <= low * (1.0 + 1e-9) && reached[1] >= high * (1.0 - 1e-9);
        let nu = density.dof[rows[0].0];
        // Of a line at an end of the band the half within it.
        let square = |l: &DensityLine| {
            let (from, to) = (l.frequency - 0.5 * bin, l.frequency + 0.5 * bin);
            l.measured * (to.min(reached[1]) - from.max(reached[0])).max(0.0)
        };
        let mean_square: f64 = lines.iter().map(square).sum();
        let scatter: f64 = lines.iter().map(|l| square(l).powi(2)).sum();
        let scatter = (scatter * SHARED * 2.0 / nu).sqrt();
        let rms = mean_square.sqrt();
        // d√x = dx/(2√x)
        let u = match rms > 0.0 {
            true => (0.5 * scatter / rms).hypot(relative * rms),
            false => 0.0,
        };
        let verdict = verdict(&lines, whole, reached, nu, probability);
        Ok(DensityComparison {
            verdict,
            rms: [rms, u, self.rms(reached[0], reached[1])],
            dof: nu,
            resolution: bin,
            lines,
        })
    }
}

fn decibels(ratio: f64) -> f64 {
    10.0 * ratio.max(1e-30).log10()
}

fn verdict(
    lines: &[DensityLine],
    whole: bool,
    reached: [f64; 2],
    nu: f64,
    probability: f64,
) -> DensityVerdict {
    let margin = |l: &DensityLine| {
        decibels(l.measured / l.limits[0]).min(decibels(l.limits[1] / l.measured.max(1e-300)))
    };
    let worst = lines
        .iter()
        .min_by(|a, b| margin(a).total_cmp(&margin(b)))
        .unwrap_or(&lines[0]);
    let beyond = |l: &DensityLine| l.interval[0] > l.limits[1] || l.interval[1] < l.limits[0];
    let within = |l: &DensityLine| l.interval[0] >= l.limits[0] && l.interval[1] <= l.limits[1];
    let count = lines.iter().filter(|l| beyond(l)).count();
    let furthest = lines.iter().filter(|l| beyond(l));
    if let Some(l) = furthest.min_by(|a, b| margin(a).total_cmp(&margin(b))) {
        let limit = match l.interval[0] > l.limits[1] {
            true => l.limits[1],
            false => l.limits[0],
        };
        let of = |s: f64| decibels(s / limit);
        return DensityVerdict::Beyond {
            frequency: l.frequency,
            by: of(l.measured),
            interval: l.interval.map(of),
            lines: count,
        };
    }
    let open = lines.iter().filter(|l| !within(l)).count();
    if open == 0 && whole {
        return DensityVerdict::Inside {
            frequency: worst.frequency,
            margin: margin(worst),
        };
    }
    // Half an interval in dB falls as 1/√ν: 10/ln 10 · z √(2/ν).
    let z = proofmass_uncertainty::normal_quantile(0.5 + 0.5 * probability);
    let half = 10.0 / std::f64::consts::LN_10 * z * (2.0 / nu).sqrt();
    // The scatter of the estimate itself takes as much again.
    let room =
        decibels(worst.limits[1] / worst.required).min(decibels(worst.required / worst.limits[0]));
    let longer = match room > 0.0 {
        true => (2.0 * half / room).powi(2),
        false => f64::MAX,
    };
    DensityVerdict::NotShown {
        lines: open,
        frequency: worst.frequency,
        margin: margin(worst),
        reached,
        longer,
    }
}
