//! What a stability analysis is made from: evenly spaced rate or phase data.

use proofmass_core::Error;

/// Evenly spaced data of one channel.
///
/// In the language of clocks a *rate* is a frequency deviation y and a *phase* its integral x. For an
/// accelerometer the rate is the acceleration and the phase the velocity; for a gyroscope angular rate and angle.
///
/// **Units** rate in U, phase in U·s; every deviation comes out in U (the time deviations in U·s).
#[derive(Clone, Copy, Debug)]
pub enum Record<'a> {
    /// Rate samples y_k, each the mean over one sample interval.
    Rate(&'a [f64]),
    /// Phase samples x_k, the running integral of the rate.
    Phase(&'a [f64]),
}

impl Record<'_> {
    /// Number of samples given.
    pub fn len(&self) -> usize {
        match self {
            Self::Rate(v) | Self::Phase(v) => v.len(),
        }
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Phase in units of U·τ0, one point more than there are rate samples.
    ///
    /// The mean rate is removed before summing: no statistic of this crate sees it, and the phase stays small, so
    /// that the second differences of 10⁷ samples keep some ten digits.
    ///
    /// # Errors
    /// [`Error::NotFinite`] with the index of the first sample that is NaN or infinite, [`Error::TooFew`] for
    /// fewer than two rate samples (three phase samples), [`Error::OutOfRange`] for a rate that is not positive.
    pub(crate) fn phase(&self, sample_rate: f64) -> Result<Vec<f64>, Error> {
        check_sample_rate(sample_rate)?;
        match self {
            Self::Rate(y) => {
                check_finite("rate", y)?;
                check_count("rate samples", y.len(), 2)?;
                Ok(accumulate(y))
            }
            Self::Phase(x) => {
                check_finite("phase", x)?;
                check_count("phase samples", x.len(), 3)?;
                let origin = x[0];
                Ok(x.iter().map(|x| (x - origin) * sample_rate).collect())
            }
        }
    }
}

/// Phase x_0 = 0, x_{k+1} = x_k + (y_k − ȳ).
fn accumulate(y: &[f64]) -> Vec<f64> {
    let mean = mean(y);
    let mut phase = Vec::with_capacity(y.len() + 1);
    let mut x = 0.0;
    phase.push(x);
    phase.extend(y.iter().map(|y| {
        x += y - mean;
        x
    }));
    phase
}

/// Mean in eight interleaved sums: one running sum would wait for every addition.
fn mean(y: &[f64]) -> f64 {
    let (chunks, rest) = y.as_chunks::<8>();
    let mut lanes = [0.0; 8];
    for chunk in chunks {
        for (lane, v) in lanes.iter_mut().zip(chunk) {
            *lane += v;
        }
    }
    (lanes.iter().sum::<f64>() + rest.iter().sum::<f64>()) / y.len() as f64
}

pub(crate) fn check_sample_rate(sample_rate: f64) -> Result<(), Error> {
    if sample_rate > 0.0 && sample_rate.is_finite() {
        Ok(())
    } else {
        Err(Error::OutOfRange {
            name: "sample rate",
            value: sample_rate,
            min: f64::MIN_POSITIVE,
            max: f64::MAX,
        })
    }
}

pub(crate) fn check_finite(name: &'static str, values: &[f64]) -> Result<(), Error> {
    // 0 x is zero for a finite x and NaN otherwise; without a branch the sum runs in vectors.
    let (chunks, rest) = values.as_chunks::<8>();
    let mut lanes = [0.0; 8];
    for chunk in chunks {
        for (lane, v) in lanes.iter_mut().zip(chunk) {
            *lane += 0.0 * v;
        }
    }
    if lanes.iter().all(|lane| *lane == 0.0) && rest.iter().all(|v| v.is_finite()) {
        return Ok(());
    }
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(Error::NotFinite { name, index }),
        None => Ok(()),
    }
}

pub(crate) fn check_count(name: &'static str, got: usize, needed: usize) -> Result<(), Error> {
    if got < needed {
        Err(Error::TooFew { name, needed, got })
    } else {
        Ok(())
    }
}
