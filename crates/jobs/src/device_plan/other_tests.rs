//! What the tests need whose length is a formula.

use super::needed::{Known, Needed, size_of};
use super::noise::{rounded_up, short, spoken};
use super::{PROBABILITY, Way};
use crate::data_sheet::{Measurement, ReadLimit, unit};
use crate::trouble::Result;
use proofmass_core::STANDARD_GRAVITY;
use proofmass_uncertainty::{DegreesOfFreedom, normal_quantile};

/// Shortest and longest time at a temperature after the soak, s.
const PLATEAU: [f64; 2] = [60.0, 14_400.0];

/// Temperatures of a cycle: a straight line needs two, what bends it more.
const PLATEAUS: f64 = 5.0;

/// Time at each acceleration, s.
const LEVEL: f64 = 10.0;

/// Fewest and most accelerations of a test of linearity.
const LEVELS: [f64; 2] = [11.0, 500.0];

/// Runs of which a standard deviation is taken.
const REPEATS: u32 = 3;

impl Known<'_> {
    pub(super) fn other(
        &self,
        limit: &ReadLimit,
        needed: &Needed,
        shown_by: Measurement,
    ) -> Result<Way> {
        Ok(match shown_by {
            Measurement::Temperature => self.temperature(limit, needed),
            Measurement::Levels => self.levels(limit, needed),
            Measurement::Shaker => self.shaker(limit, needed),
            Measurement::Transverse => {
                let place = limit.frequency.map_or_else(
                    || "at one frequency of the flat range".to_owned(),
                    |[low, high]| frequencies(low, high),
                );
                Way::of(
                    format!("twelve directions across the axis, 30° apart, {place}"),
                    None,
                )
            }
            Measurement::Calibrations => self.calibrations(limit, needed),
            _ => response(limit),
        })
    }

    /// Two ends of the range: u(slope) = √(2 N²/t + 2 (2 ln 2/π) B² + K² (t_s + ⅔ t))/ΔT.
    fn temperature(&self, limit: &ReadLimit, needed: &Needed) -> Way {
        let given = self.given.temperature_range.as_deref();
        let given = given.and_then(|r| <[f64; 2]>::try_from(r.to_vec()).ok());
        let [low, high] = limit.temperature.or(given).unwrap_or([0.0, 0.0]);
        let range = high - low;
        let soak = 60.0 * self.given.soak;
        let noise = self.noise.unwrap_or_default();
        let u = |t: f64| {
            let (white, slow) = noise.of_mean(t);
            // Means one behind the other share half of the walk within them; the soak parts them.
            let variance = 2.0 * (white + slow) + noise.walk.powi(2) * soak;
            variance.sqrt() / range
        };
        let normal = normal_quantile(0.5 + 0.5 * PROBABILITY);
        // A scale is half the difference of two attitudes over g.
        let si = match limit.characteristic.name() {
            "scale-temperature" => {
                unit::ratio(&limit.unit, "1/K").unwrap_or(1.0) * STANDARD_GRAVITY * 2f64.sqrt()
            }
            _ => self.si_of_bias(limit).unwrap_or(1.0),
        };
        let attitudes = match limit.characteristic.name() {
            "scale-temperature" => "in two attitudes, each axis up and down, ",
            _ => "",
        };
        let most = si * needed.expanded / normal;
        let between = format!(
            "{attitudes}from {} to {} °C and back in {PLATEAUS} steps, {} of soak at each",
            short(low),
            short(high),
            spoken(soak)
        );
        let mut t = PLATEAU[0];
        while !(u(t) <= most) {
            if t > PLATEAU[1] || !(range > 0.0) {
                return Way::out_of_reach(
                    format!("{between}, then {}", spoken(PLATEAU[1])),
                    format!(
                        "{}: slow noise over the soak leaves more; widen the range of temperatures",
                        limit.characteristic.name()
                    ),
                );
            }
            t *= 1.1;
        }
        let t = rounded_up(t);
        Way::of(
            format!("{between}, then record for {}", spoken(t)),
            Some((2.0 * PLATEAUS - 1.0) * (soak + t)),
        )
    }

    /// Levels spread evenly over ± A: u(k₂) = σ/(A² √(4n/45)), u(k₃) = σ/(A³ √(4n/175)), by the orthogonal polynomials.
    fn levels(&self, limit: &ReadLimit, needed: &Needed) -> Way {
        let a = self.given.acceleration.unwrap_or(1.0);
        let relative = 0.01 * self.given.reference_uncertainty.unwrap_or(0.0);
        let (white, slow) = self.noise.unwrap_or_default().of_mean(LEVEL);
        // Mean square of accelerations spread evenly: A²/3.
        let sigma = (white + slow + (relative * a).powi(2) / 3.0).sqrt();
        let (reach, si) = match limit.characteristic.name() {
            "third-order" => (
                a.powi(3) * (4.0 / 175.0f64).sqrt(),
                unit::ratio(&limit.unit, "1/(m/s²)²").unwrap_or(1.0),
            ),
            _ => (
                a.powi(2) * (4.0 / 45.0f64).sqrt(),
                unit::ratio(&limit.unit, "1/(m/s²)").unwrap_or(1.0),
            ),
        };
        let normal = normal_quantile(0.5 + 0.5 * PROBABILITY);
        let most = si * needed.expanded;
        let wanted = (normal * sigma / (reach * most))
            .powi(2)
            .ceil()
            .max(LEVELS[0]);
        let what = |n: f64| {
            format!(
                "{n} accelerations spread over ± {} m/s², {LEVEL} s at each",
                short(a)
            )
        };
        match wanted <= LEVELS[1] {
            true => Way::of(what(wanted), Some(wanted * LEVEL)),
            false => Way::out_of_reach(
                what(LEVELS[1]),
                format!(
                    "{}: the reference accelerations scatter too much, or their range is too small",
                    limit.characteristic.name()
                ),
            ),
        }
    }

    /// What the reference leaves of the uncertainty, for three runs at each frequency.
    fn shaker(&self, limit: &ReadLimit, needed: &Needed) -> Way {
        let [low, high] = limit.frequency.unwrap_or([160.0, 160.0]);
        let normal = normal_quantile(0.5 + 0.5 * PROBABILITY);
        let expanded = needed.expanded / size_of(limit);
        let reference = normal * 0.01 * self.given.reference_uncertainty.unwrap_or(0.0);
        let place = frequencies(low, high);
        let left = expanded.powi(2) - reference.powi(2);
        if !(left > 0.0) {
            return Way::out_of_reach(
                place,
                format!(
                    "scale: U = {} % of the reference alone is no less than the {} % that the limit needs; have the reference calibrated better",
                    short(100.0 * reference),
                    short(100.0 * expanded)
                ),
            );
        }
        let t = DegreesOfFreedom::new(f64::from(REPEATS - 1))
            .map_or(normal, |nu| nu.coverage_factor(PROBABILITY));
        let scatter = (left * f64::from(REPEATS)).sqrt() / t;
        Way::of(
            format!(
                "{place}, {REPEATS} runs at each that scatter by {} % at most",
                short(100.0 * scatter)
            ),
            None,
        )
    }

    /// Months between two calibrations of the planned uncertainty: u(drift) = √2 u(b)/t.
    fn calibrations(&self, limit: &ReadLimit, needed: &Needed) -> Way {
        let noise = self.noise.unwrap_or_default();
        let (white, slow) = noise.of_mean(LEVEL);
        // Twelve attitudes of ten seconds know a bias by a rest's noise over 2.
        let u = (0.25 * (white + slow) + self.given.wander.powi(2) / 4.0).sqrt();
        let normal = normal_quantile(0.5 + 0.5 * PROBABILITY);
        let most = self.si_of_bias(limit).unwrap_or(1.0) * needed.expanded;
        let months = (2f64.sqrt() * normal * u / most).ceil().max(1.0);
        match months <= 120.0 {
            true => Way::of(
                format!(
                    "three calibrations of 12 attitudes or more over {months} {}",
                    if months > 1.0 { "months" } else { "month" }
                ),
                None,
            ),
            false => Way::out_of_reach(
                "calibrations over ten years".to_owned(),
                "bias-drift: the noise of a calibration hides it for ten years",
            ),
        }
    }
}

/// Thirds of an octave from end to end, those preferred by ISO 266 being ten to a decade.
fn frequencies(low: f64, high: f64) -> String {
    if !(high > low) {
        return format!("at {} Hz", short(low));
    }
    let between = (10.0 * (high / low).log10()).ceil();
    format!(
        "at {} frequencies from {} to {} Hz, thirds of an octave apart",
        between + 1.0,
        short(low),
        short(high)
    )
}

/// The band of a frequency response about what is limited.
fn response(limit: &ReadLimit) -> Way {
    let name = limit.characteristic.name();
    let hertz = |v: f64| v * unit::ratio(&limit.unit, "Hz").unwrap_or(1.0);
    let ends = [limit.limits.lower, limit.limits.upper, limit.typical];
    let ends = ends.into_iter().flatten().map(hertz).filter(|v| *v > 0.0);
    let (least, largest) = ends.fold((f64::INFINITY, 0.0f64), |(a, b), v| (a.min(v), b.max(v)));
    match name {
        "resonance" | "bandwidth" if largest > 0.0 => Way::of(
            format!(
                "excite from {} to {} Hz: a tenth of the frequency to three times it",
                short(0.1 * least),
                short(3.0 * largest)
            ),
            None,
        ),
        // Twenty periods of the lowest frequency.
        "low-corner" if largest > 0.0 => {
            let lowest = 0.2 * least;
            let duration = rounded_up(20.0 / lowest);
            Way::of(
                format!(
                    "excite from {} to {} Hz for {}: a fifth of the corner to ten times it",
                    short(lowest),
                    short(10.0 * largest),
                    spoken(duration)
                ),
                Some(duration),
            )
        }
        "delay" => Way::of(
            "excite up to a fifth of the sampling rate, both channels in one clock".to_owned(),
            None,
        ),
        _ => Way::of(
            "excite from a tenth of the resonance to three times it".to_owned(),
            None,
        ),
    }
}
