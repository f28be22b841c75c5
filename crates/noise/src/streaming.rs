//! Allan deviation at octave averaging times of a stream, with memory for the logarithm of its length.

use crate::edf::partly_overlapping;
use crate::record::check_sample_rate;
use crate::{
    DeviationCurve, DeviationPoint, NoiseBasis, NoiseType, Statistic, chi_square_interval,
};
use proofmass_core::Error;

/// Starts per averaging time beyond the first octaves.
const PER_TAU: usize = 8;

/// Block sums a level remembers: two averaging times.
const HISTORY: usize = 2 * PER_TAU;

/// Samples handled at a time: the running sums of a piece stay in the first-level cache.
const PIECE: usize = 2048;

/// Overlapping Allan deviation of a rate that arrives in pieces, at m = 1, 2, 4, 8, …
///
/// Level j holds the last sixteen sums of 2^j samples; its second differences at a lag of eight sums are those of
/// m = 8·2^j, started every τ/8. Level 0 also gives m = 1, 2, 4, 8 with every start. Memory is some 200 bytes per
/// octave, work about two passes over the data; no running total of the whole stream is kept, so the digits of the last
/// sample are worth as much as those of the first.
///
/// For m ≤ 8 the result is that of [`deviation`](crate::deviation) with [`Statistic::OverlappingAllan`]; for longer τ it averages every
/// (m/8)-th of its terms, which costs 1 % of the degrees of freedom for white noise and less for redder noise.
///
/// ```
/// use proofmass_noise::StreamingAllan;
/// let mut stream = StreamingAllan::new(100.0).unwrap();
/// for second in 0..100 {
///     let piece: Vec<f64> = (0..100).map(|k| f64::from((second * 100 + k) * 7919 % 1009)).collect();
///     stream.push(&piece).unwrap();
/// }
/// let curve = stream.curve(0.95).unwrap();
/// assert_eq!(curve.points.last().unwrap().factor, 4096);
/// ```
#[derive(Clone, Debug)]
pub struct StreamingAllan {
    sample_rate: f64,
    samples: u64,
    reference: Option<f64>,
    levels: Vec<Level>,
}

#[derive(Clone, Debug, Default)]
struct Level {
    /// Last block sums, oldest first.
    history: Vec<f64>,
    /// First of a pair that waits for its second.
    pending: Option<f64>,
    /// Sum of squares and number of terms; four averaging times at level 0, one above.
    sums: [(f64, u64); 4],
}

impl StreamingAllan {
    /// An empty stream.
    ///
    /// **Errors** [`Error::OutOfRange`] for a sample rate that is not positive.
    pub fn new(sample_rate: f64) -> Result<Self, Error> {
        check_sample_rate(sample_rate)?;
        Ok(Self {
            sample_rate,
            ..Self::of_samples()
        })
    }

    /// An empty stream whose rate is not known yet: times count samples.
    pub(crate) fn of_samples() -> Self {
        Self {
            sample_rate: 1.0,
            samples: 0,
            reference: None,
            levels: vec![Level::default()],
        }
    }

    /// Samples taken in so far.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Takes in a piece of any length.
    ///
    /// **Errors** [`Error::NotFinite`] with the index within `rate`; nothing of that piece is taken in. Call
    /// [`StreamingAllan::gap`] and go on behind it if that is what should happen.
    pub fn push(&mut self, rate: &[f64]) -> Result<(), Error> {
        crate::record::check_finite("rate", rate)?;
        let Some(first) = rate.first() else {
            return Ok(());
        };
        // A constant changes nothing; without it the block sums of a sensor in gravity keep more digits.
        let reference = *self.reference.get_or_insert(*first);
        self.samples += rate.len() as u64;
        let mut centred = Vec::with_capacity(PIECE);
        for piece in rate.chunks(PIECE) {
            centred.clear();
            centred.extend(piece.iter().map(|y| y - reference));
            self.cascade(&centred);
        }
        Ok(())
    }

    /// Samples are missing here: no difference reaches across.
    pub fn gap(&mut self) {
        for level in &mut self.levels {
            level.history.clear();
            level.pending = None;
        }
    }

    fn cascade(&mut self, values: &[f64]) {
        let mut current = values.to_vec();
        let mut j = 0;
        while !current.is_empty() {
            if j == self.levels.len() {
                self.levels.push(Level::default());
            }
            let level = &mut self.levels[j];
            level.differences(&current, j == 0);
            current = level.pair(&current);
            j += 1;
        }
    }

    /// The curve so far, with χ² intervals.
    ///
    /// Degrees of freedom are those of eight starts per τ; the noise type is read from the slope to the
    /// neighbouring averaging times.
    ///
    /// **Errors** [`Error::TooFew`] before the third sample, [`Error::OutOfRange`] for the probability.
    pub fn curve(&self, probability: f64) -> Result<DeviationCurve, Error> {
        self.curve_at(self.sample_rate, probability)
    }

    /// The curve at a rate that became known later.
    pub(crate) fn curve_at(
        &self,
        sample_rate: f64,
        probability: f64,
    ) -> Result<DeviationCurve, Error> {
        check_sample_rate(sample_rate)?;
        proofmass_core::check::probability(probability)?;
        let mut values: Vec<(usize, f64, u64)> = Vec::new();
        for (j, level) in self.levels.iter().enumerate() {
            for (k, &(sum, terms)) in level.sums.iter().enumerate() {
                let m = if j == 0 { 1 << k } else { PER_TAU << j };
                if terms > 0 && (j == 0 || k == 0) {
                    let scale = 2.0 * (m as f64).powi(2) * terms as f64;
                    values.push((m, (sum / scale).sqrt(), terms));
                }
            }
        }
        if values.is_empty() {
            return Err(Error::TooFew {
                name: "rate samples",
                needed: 2,
                got: self.samples as usize,
            });
        }
        let phase_points = self.samples as usize + 1;
        let points = (0..values.len())
            .map(|i| {
                let (m, deviation, terms) = values[i];
                let (noise, basis) = by_slope(&values, i);
                let edf = partly_overlapping(noise, m, phase_points, PER_TAU);
                DeviationPoint {
                    factor: m,
                    tau: m as f64 / sample_rate,
                    deviation,
                    terms: terms as usize,
                    noise,
                    basis,
                    edf,
                    interval: edf.and_then(|edf| chi_square_interval(deviation, edf, probability)),
                }
            })
            .collect();
        Ok(DeviationCurve {
            statistic: Statistic::OverlappingAllan,
            sample_rate,
            phase_points,
            probability,
            points,
        })
    }
}

impl Level {
    /// Adds the squares of all second differences that end in the new values.
    fn differences(&mut self, values: &[f64], first: bool) {
        let known = self.history.len();
        let mut running = Vec::with_capacity(known + values.len() + 1);
        let mut sum = 0.0;
        running.push(sum);
        for v in self.history.iter().chain(values) {
            sum += v;
            running.push(sum);
        }
        let lags: &[usize] = if first { &[1, 2, 4, 8] } else { &[PER_TAU] };
        for (slot, &m) in self.sums.iter_mut().zip(lags) {
            let start = (known + 1).max(2 * m);
            if start >= running.len() {
                continue;
            }
            let c = &running[start..];
            let b = &running[start - m..running.len() - m];
            let a = &running[start - 2 * m..running.len() - 2 * m];
            let mut lanes = [0.0; 4];
            let (c4, cr) = c.as_chunks::<4>();
            let (b4, br) = b.as_chunks::<4>();
            let (a4, ar) = a.as_chunks::<4>();
            for ((c, b), a) in c4.iter().zip(b4).zip(a4) {
                for k in 0..4 {
                    let d = c[k] - 2.0 * b[k] + a[k];
                    lanes[k] += d * d;
                }
            }
            let mut total: f64 = lanes.iter().sum();
            for ((c, b), a) in cr.iter().zip(br).zip(ar) {
                total += (c - 2.0 * b + a).powi(2);
            }
            slot.0 += total;
            slot.1 += c.len() as u64;
        }
        self.history.extend_from_slice(values);
        let surplus = self.history.len().saturating_sub(HISTORY);
        self.history.drain(..surplus);
    }

    /// Sums of neighbours, for the next level.
    fn pair(&mut self, values: &[f64]) -> Vec<f64> {
        let mut sums = Vec::with_capacity(values.len() / 2 + 1);
        for &v in values {
            match self.pending.take() {
                Some(first) => sums.push(first + v),
                None => self.pending = Some(v),
            }
        }
        sums
    }
}

/// Noise type from σ² ∝ τ^μ, α = −1 − μ, over the neighbours of a point.
fn by_slope(values: &[(usize, f64, u64)], i: usize) -> (NoiseType, NoiseBasis) {
    let low = i.saturating_sub(1);
    let high = (i + 1).min(values.len() - 1);
    let (m1, s1, _) = values[low];
    let (m2, s2, _) = values[high];
    if m1 == m2 || !(s1 > 0.0 && s2 > 0.0) {
        return (NoiseType::White, NoiseBasis::Assumed);
    }
    let mu = 2.0 * (s2 / s1).ln() / (m2 as f64 / m1 as f64).ln();
    let alpha = (-1.0 - mu).round().clamp(-2.0, 1.0) as i32;
    match NoiseType::from_alpha(alpha) {
        Some(noise) => (noise, NoiseBasis::Slope),
        None => (NoiseType::White, NoiseBasis::Assumed),
    }
}
