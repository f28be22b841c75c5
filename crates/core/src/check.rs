//! Guards that arguments pass before anything is computed from them.

use crate::{Error, Float};

/// All of these lengths are the expected one.
///
/// # Errors
/// [`Error::Length`] with the name of the first that is not.
///
/// ```
/// use proofmass_core::{Error, check};
///
/// assert!(check::lengths(3, [("y", 3), ("z", 3)]).is_ok());
/// let refused = check::lengths(3, [("y", 3), ("z", 2)]);
/// assert_eq!(refused, Err(Error::Length { name: "z", expected: 3, got: 2 }));
/// ```
pub fn lengths(
    expected: usize,
    named: impl IntoIterator<Item = (&'static str, usize)>,
) -> Result<(), Error> {
    match named.into_iter().find(|(_, got)| *got != expected) {
        Some((name, got)) => Err(Error::Length {
            name,
            expected,
            got,
        }),
        None => Ok(()),
    }
}

/// Outputs y and z and the accelerations of a triaxial sensor, beside outputs x of this length.
pub(crate) fn columns(expected: usize, yz: [usize; 2], a: [usize; 3]) -> Result<(), Error> {
    let named = [
        ("y", yz[0]),
        ("z", yz[1]),
        ("acceleration of x", a[0]),
        ("acceleration of y", a[1]),
        ("acceleration of z", a[2]),
    ];
    lengths(expected, named)
}

/// Every number is finite.
///
/// # Errors
/// [`Error::NotFinite`] with the index of the first that is not.
pub fn finite<F: Float>(name: &'static str, values: &[F]) -> Result<(), Error> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(Error::NotFinite { name, index }),
        None => Ok(()),
    }
}

/// A column of finite numbers as long as the others.
///
/// # Errors
/// [`Error::Length`], [`Error::NotFinite`].
pub fn column<F: Float>(name: &'static str, values: &[F], expected: usize) -> Result<(), Error> {
    lengths(expected, [(name, values.len())])?;
    finite(name, values)
}

/// A number that is finite and not negative.
///
/// # Errors
/// [`Error::OutOfRange`].
pub fn not_negative(name: &'static str, value: f64) -> Result<f64, Error> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(Error::OutOfRange {
            name,
            value,
            min: 0.0,
            max: f64::MAX,
        })
    }
}

/// A number that is finite and positive.
///
/// # Errors
/// [`Error::OutOfRange`].
pub fn positive(name: &'static str, value: f64) -> Result<f64, Error> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(Error::OutOfRange {
            name,
            value,
            min: f64::MIN_POSITIVE,
            max: f64::MAX,
        })
    }
}

/// A number between two limits, these included.
///
/// # Errors
/// [`Error::OutOfRange`].
pub fn within(name: &'static str, value: f64, min: f64, max: f64) -> Result<(), Error> {
    if (min..=max).contains(&value) {
        Ok(())
    } else {
        Err(Error::OutOfRange {
            name,
            value,
            min,
            max,
        })
    }
}

/// A probability between zero and one, these excluded.
///
/// # Errors
/// [`Error::OutOfRange`].
pub fn probability(value: f64) -> Result<(), Error> {
    if value > 0.0 && value < 1.0 {
        Ok(())
    } else {
        Err(Error::OutOfRange {
            name: "probability",
            value,
            min: 0.0,
            max: 1.0,
        })
    }
}
