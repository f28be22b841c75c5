//! Properties of objects, as far as they tell clock, unit and scaling.

use super::index::string;
use crate::bytes::{Bytes, Order};
use crate::stream::Clock;
use std::collections::HashMap;

/// A value.
#[derive(Clone, Debug, PartialEq)]
enum Value {
    Number(f64),
    Text(String),
}

/// Properties by name.
#[derive(Clone, Debug, Default)]
pub(super) struct Properties {
    values: HashMap<String, Value>,
}

impl Properties {
    /// Takes in one; a later value counts.
    pub(super) fn read(&mut self, b: &mut Bytes<'_>) -> Option<()> {
        let name = string(b)?;
        let value = match b.u32()? {
            0 => None,
            1 => Some(f64::from(b.i8()?)),
            2 => Some(f64::from(b.i16()?)),
            3 => Some(f64::from(b.i32()?)),
            4 => Some(b.i64()? as f64),
            5 | 0x21 => Some(f64::from(b.u8()?)),
            6 => Some(f64::from(b.u16()?)),
            7 => Some(f64::from(b.u32()?)),
            8 => Some(b.u64()? as f64),
            9 | 0x19 => Some(f64::from(b.f32()?)),
            10 | 0x1A => Some(b.f64()?),
            0x20 => {
                let text = string(b)?;
                self.values.insert(name, Value::Text(text));
                return Some(());
            }
            0x44 => {
                let (first, second) = (b.u64()?, b.u64()?);
                let (fraction, seconds) = match b.order {
                    Order::Little => (first, second),
                    Order::Big => (second, first),
                };
                Some(seconds as i64 as f64 + fraction as f64 / 2_f64.powi(64))
            }
            0x0B | 0x1B => {
                b.take(16)?;
                None
            }
            0x0008_000C => {
                b.take(8)?;
                None
            }
            0x0010_000D => {
                b.take(16)?;
                None
            }
            _ => return None,
        };
        if let Some(value) = value {
            self.values.insert(name, Value::Number(value));
        }
        Some(())
    }

    pub(super) fn text(&self, name: &str) -> Option<String> {
        match self.values.get(name)? {
            Value::Text(text) => Some(text.clone()),
            Value::Number(_) => None,
        }
    }

    pub(super) fn number(&self, name: &str) -> Option<f64> {
        match self.values.get(name)? {
            Value::Number(number) => Some(*number),
            Value::Text(_) => None,
        }
    }

    /// A number that counts something.
    pub(super) fn count(&self, name: &str) -> Option<u32> {
        let number = self.number(name)?;
        (number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number))
            .then_some(number as u32)
    }

    /// The highest number in brackets after a word, such as that of `NI_Scale[2]_Scale_Type`.
    pub(super) fn highest(&self, before: &str, after: &str) -> Option<u32> {
        let numbers = self.values.keys().filter_map(|name| {
            let rest = name.strip_prefix(before)?.strip_suffix(after)?;
            rest.parse().ok()
        });
        numbers.max()
    }

    /// The clock of a waveform.
    pub(super) fn clock(&self) -> Clock {
        match self.number("wf_increment") {
            Some(step) if step.is_finite() && step > 0.0 && (1.0 / step).is_finite() => {
                Clock::Rate {
                    hz: 1.0 / step,
                    start_s: self
                        .number("wf_start_offset")
                        .filter(|v| v.is_finite())
                        .unwrap_or(0.0),
                }
            }
            _ => Clock::Unsaid,
        }
    }
}
