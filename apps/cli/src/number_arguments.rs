//! Numbers as options, and pairs of columns and units.

use crate::Failure;
use clap::error::{ContextKind, ContextValue};
use proofmass::io::{ColumnRef, Unit};
use std::error::Error;

/// What is wrong with the text of an option that stands for a number, in the words of a person.
pub(crate) fn no_number(wrong: &clap::Error) -> Option<Failure> {
    let source = wrong.source()?;
    let whole = source.is::<std::num::ParseIntError>();
    if !(whole || source.is::<std::num::ParseFloatError>()) {
        return None;
    }
    let said = |kind| match wrong.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        _ => None,
    };
    let (text, option) = (
        said(ContextKind::InvalidValue)?,
        said(ContextKind::InvalidArg)?,
    );
    let kind = if whole { "whole number" } else { "number" };
    let failure = Failure::new(format!("{text:?} is no {kind}, which {option} needs"));
    Some(match with_a_point(text) {
        Some(number) if !whole => failure.hint(format!("the decimal mark is the point: {number}")),
        _ if whole => failure.hint("write digits only, such as 4096"),
        _ => failure.hint("write digits, with a point before the decimals; 1.5e-3 is read too"),
    })
}

/// A number with a comma before its decimals, with a point instead.
fn with_a_point(text: &str) -> Option<String> {
    let number = text.replacen(',', ".", 1);
    (number != text && number.parse::<f64>().is_ok()).then_some(number)
}

/// A text that is not such a number.
fn refused(text: &str, wanted: &str) -> String {
    match with_a_point(text) {
        Some(number) => format!("the decimal mark is the point: {number}"),
        None => format!("{text:?} is no {wanted}"),
    }
}

/// Two columns, by name or number.
pub(crate) fn two_columns(text: &str) -> Result<[ColumnRef; 2], String> {
    match text.split(',').map(str::trim).collect::<Vec<_>>()[..] {
        [first, second] if !first.is_empty() && !second.is_empty() => {
            Ok([first, second].map(ColumnRef::from_word))
        }
        _ => Err(format!("{text:?} is no pair of columns, such as 2,3")),
    }
}

/// One unit of two columns, or one of each.
pub(crate) fn two_units(text: &str) -> Result<[Unit; 2], String> {
    let units = text.split(',').map(|unit| unit.trim().parse::<Unit>());
    let units: Vec<Unit> = units.collect::<Result<_, _>>().map_err(|e| e.to_string())?;
    match units[..] {
        [both] => Ok([both; 2]),
        [first, second] => Ok([first, second]),
        _ => Err(format!("{text:?} is neither a unit nor a pair of units")),
    }
}

pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v > 0.0 && v.is_finite() => Ok(v),
        _ => Err(refused(text, "positive number")),
    }
}

/// A probability of false alarms: neither 0 nor 1.
pub(crate) fn false_alarm_rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(p) if p > 0.0 && p < 1.0 => Ok(p),
        _ => Err("a false-alarm rate lies between 0 and 1".to_owned()),
    }
}

pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v >= 0.0 && v.is_finite() => Ok(v),
        _ => Err(refused(text, "number from zero on")),
    }
}

/// Two numbers, the second larger: `10,2000`.
pub(crate) fn band(text: &str) -> Result<[f64; 2], String> {
    match band_or_frequency(text) {
        Ok([low, high]) if low < high => Ok([low, high]),
        _ => Err(no_band(text)),
    }
}

/// Two numbers, the second larger or the same: `10,2000` or `160,160`.
pub(crate) fn band_or_frequency(text: &str) -> Result<[f64; 2], String> {
    let refused = || no_band(text);
    let (low, high) = text.split_once(',').ok_or_else(refused)?;
    let number = |t: &str| positive(t.trim()).map_err(|_| refused());
    let (low, high) = (number(low)?, number(high)?);
    match low <= high {
        true => Ok([low, high]),
        false => Err(refused()),
    }
}

fn no_band(text: &str) -> String {
    format!("{text:?} is no band in hertz such as 10,2000")
}

/// A coverage factor: any positive number.
pub(crate) fn coverage_factor(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(k) if k > 0.0 && k.is_finite() => Ok(k),
        _ => Err("a number above 0 is needed, such as 2".to_owned()),
    }
}

/// A coverage probability: neither 0 nor 1.
pub(crate) fn probability(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(p) if p > 0.0 && p < 1.0 => Ok(p),
        _ => Err("a number between 0 and 1 is needed, such as 0.95".to_owned()),
    }
}
