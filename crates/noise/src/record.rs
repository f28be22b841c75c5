//! What a stability analysis is made from: evenly spaced rate or phase data.

use proofmass_core::Error;

/// Evenly spaced data of one channel.
///
/// In the language of clocks a *rate* is a frequency deviation y and a *phase* its integral x. For an
/// accelerometer the rate is the acceleration and the phase the velocity; for a gyroscope angular rate and angle.
///
/// **Units** rate in U, phase in U·s; every deviation comes out in U (the time deviations in U·s).
#[derive(Clone, Copy, Debug)]
pub enum NoiseRecord<'a> {
    /// Rate samples y_k, each the mean over one sample interval.
    Rate(&'a [f64]),
    /// Phase samples x_k, the running integral of the rate.
    Phase(&'a [f64]),
}

impl NoiseRecord<'_> {
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
