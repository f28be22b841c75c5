//! Stored values of every kind as numbers.

use crate::stream::ABSENT;
use ::parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use ::parquet::column::page::{Page, PageReader};
use ::parquet::column::reader::ColumnReaderImpl;
use ::parquet::data_type::{
    BoolType, DoubleType, FixedLenByteArrayType, FloatType, Int32Type, Int64Type, Int96Type,
};
use ::parquet::data_type::{DataType, FixedLenByteArray, Int96};
use ::parquet::errors::ParquetError;
use ::parquet::schema::types::{ColumnDescPtr, ColumnDescriptor};
use std::sync::{Arc, Mutex};

/// What a stored value stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Meaning {
    /// Itself.
    Number,
    /// A whole number without sign.
    Unsigned,
    /// So many parts of one.
    Parts(f64),
    /// A time since 1970, or since midnight; so many units in a second.
    Time { per_second: i64, is_stamp: bool },
    /// A float of 16 bits.
    Half,
}

/// Days from the beginning of the Julian count to 1970.
const JULIAN_1970: i64 = 2_440_588;
const NANOSECONDS: i64 = 1_000_000_000;

impl Meaning {
    /// What the values of a column stand for; `None` where they are no numbers.
    pub(super) fn of(column: &ColumnDescriptor) -> Option<Self> {
        let parts = |scale: i32| Self::Parts(10_f64.powi(scale));
        let time = |per_second, is_stamp| Self::Time {
            per_second,
            is_stamp,
        };
        let per = |unit: &TimeUnit| match unit {
            TimeUnit::MILLIS => 1000,
            TimeUnit::MICROS => 1_000_000,
            TimeUnit::NANOS => NANOSECONDS,
        };
        let whole = matches!(column.physical_type(), Type::INT32 | Type::INT64);
        let fixed = column.physical_type() == Type::FIXED_LEN_BYTE_ARRAY;
        match (column.physical_type(), column.logical_type_ref()) {
            (Type::BYTE_ARRAY, _) => return None,
            (Type::INT96, _) => return Some(time(NANOSECONDS, true)),
            (_, Some(LogicalType::Integer(int))) if whole && !int.is_signed => {
                return Some(Self::Unsigned);
            }
            (_, Some(LogicalType::Integer(_))) if whole => return Some(Self::Number),
            (_, Some(LogicalType::Decimal(decimal))) if whole => {
                return Some(parts(decimal.scale));
            }
            (_, Some(LogicalType::Decimal(decimal)))
                if fixed && (1..=16).contains(&column.type_length()) =>
            {
                return Some(parts(decimal.scale));
            }
            (_, Some(LogicalType::Timestamp(stamp))) if whole => {
                return Some(time(per(&stamp.unit), true));
            }
            (_, Some(LogicalType::Time(of_day))) if whole => {
                return Some(time(per(&of_day.unit), false));
            }
            (_, Some(LogicalType::Float16)) if fixed && column.type_length() == 2 => {
                return Some(Self::Half);
            }
            (_, Some(_)) => return None,
            (_, None) => {}
        }
        Some(match column.converted_type() {
            ConvertedType::UINT_8
            | ConvertedType::UINT_16
            | ConvertedType::UINT_32
            | ConvertedType::UINT_64
                if whole =>
            {
                Self::Unsigned
            }
            ConvertedType::DECIMAL
                if whole || (fixed && (1..=16).contains(&column.type_length())) =>
            {
                parts(column.type_scale())
            }
            ConvertedType::TIMESTAMP_MILLIS if whole => time(1000, true),
            ConvertedType::TIMESTAMP_MICROS if whole => time(1_000_000, true),
            ConvertedType::TIME_MILLIS if whole => time(1000, false),
            ConvertedType::TIME_MICROS if whole => time(1_000_000, false),
            ConvertedType::NONE
            | ConvertedType::INT_8
            | ConvertedType::INT_16
            | ConvertedType::INT_32
            | ConvertedType::INT_64
                if !fixed =>
            {
                Self::Number
            }
            _ => return None,
        })
    }
}

/// A time in s, of which the whole seconds are exact; so many s are added.
fn seconds(count: i64, per_second: i64, more: i64) -> f64 {
    let part = (count % per_second) as f64 / per_second as f64;
    (count / per_second + more) as f64 + part
}

fn half(bits: u16) -> f64 {
    let size = match (bits >> 10 & 0x1F, f64::from(bits & 0x3FF)) {
        (0, part) => part / f64::from(1 << 24),
        (0x1F, 0.0) => f64::INFINITY,
        (0x1F, _) => f64::NAN,
        (exponent, part) => (1.0 + part / 1024.0) * 2_f64.powi(i32::from(exponent) - 15),
    };
    if bits >> 15 == 0 { size } else { -size }
}

/// A stored value.
pub(super) trait Stored: Sized {
    fn put(values: &[Self], meaning: Meaning, to: &mut Vec<f64>);
}

impl Stored for bool {
    fn put(values: &[Self], _: Meaning, to: &mut Vec<f64>) {
        to.extend(values.iter().map(|v| f64::from(u8::from(*v))));
    }
}

macro_rules! whole {
    ($type:ty, $unsigned:ty) => {
        impl Stored for $type {
            fn put(values: &[Self], meaning: Meaning, to: &mut Vec<f64>) {
                let values = values.iter().copied();
                match meaning {
                    Meaning::Unsigned => to.extend(values.map(|v| v as $unsigned as f64)),
                    Meaning::Parts(of_one) => to.extend(values.map(|v| v as f64 / of_one)),
                    Meaning::Time { per_second, .. } => {
                        to.extend(values.map(|v| seconds(v.into(), per_second, 0)));
                    }
                    Meaning::Number | Meaning::Half => to.extend(values.map(|v| v as f64)),
                }
            }
        }
    };
}

whole!(i32, u32);
whole!(i64, u64);

impl Stored for f32 {
    fn put(values: &[Self], _: Meaning, to: &mut Vec<f64>) {
        to.extend(values.iter().map(|v| f64::from(*v)));
    }
}

impl Stored for f64 {
    fn put(values: &[Self], _: Meaning, to: &mut Vec<f64>) {
        to.extend_from_slice(values);
    }
}

impl Stored for Int96 {
    fn put(values: &[Self], _: Meaning, to: &mut Vec<f64>) {
        to.extend(values.iter().map(|v| {
            let [low, high, day] = *v.data() else {
                return ABSENT;
            };
            let of_day = (u64::from(high) << 32 | u64::from(low)) as i64;
            let days = i64::from(day) - JULIAN_1970;
            seconds(of_day, NANOSECONDS, days * 86_400)
        }));
    }
}

impl Stored for FixedLenByteArray {
    fn put(values: &[Self], meaning: Meaning, to: &mut Vec<f64>) {
        to.extend(values.iter().map(|v| match (meaning, v.data()) {
            (Meaning::Half, &[low, high]) => half(u16::from_le_bytes([low, high])),
            (Meaning::Parts(of_one), bytes) => {
                // Two's complement, the most significant byte first.
                let sign = bytes.first().map_or(0, |b| i128::from(*b as i8 >> 7));
                let number = bytes.iter().fold(sign, |n, b| n << 8 | i128::from(*b));
                number as f64 / of_one
            }
            _ => ABSENT,
        }));
    }
}

/// A page on its way into a decoder.
#[derive(Clone, Default)]
pub(super) struct Hatch(Arc<Mutex<Option<Page>>>);

impl Hatch {
    pub(super) fn put(&self, page: Page) {
        *self.0.lock().unwrap_or_else(|e| e.into_inner()) = Some(page);
    }
}

impl Iterator for Hatch {
    type Item = Result<Page, ParquetError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

impl PageReader for Hatch {
    fn get_next_page(&mut self) -> Result<Option<Page>, ParquetError> {
        Ok(self.0.lock().unwrap_or_else(|e| e.into_inner()).take())
    }

    fn peek_next_page(
        &mut self,
    ) -> Result<Option<::parquet::column::page::PageMetadata>, ParquetError> {
        Ok(None)
    }

    fn skip_next_page(&mut self) -> Result<(), ParquetError> {
        Ok(())
    }
}

/// Makes numbers of the pages of one chunk of a column.
pub(super) trait Decoder: Send {
    /// Appends so many numbers of the page at hand; the absent ones are [`ABSENT`]. Gives how many are not.
    fn numbers(&mut self, n: usize, to: &mut Vec<f64>) -> Result<u64, ParquetError>;
    /// Takes the dictionary in.
    fn dictionary(&mut self) -> Result<u64, ParquetError>;
}

struct Typed<T: DataType> {
    reader: ColumnReaderImpl<T>,
    meaning: Meaning,
    /// Level of a number that is there.
    full: i16,
    levels: Vec<i16>,
    values: Vec<T::T>,
}

impl<T: DataType> Decoder for Typed<T>
where
    T::T: Stored,
{
    fn numbers(&mut self, n: usize, to: &mut Vec<f64>) -> Result<u64, ParquetError> {
        self.levels.clear();
        self.values.clear();
        let levels = (self.full > 0).then_some(&mut self.levels);
        let (rows, _, _) = self
            .reader
            .read_records(n, levels, None, &mut self.values)?;
        if rows != n {
            return Err(ParquetError::General(format!(
                "holds {rows} numbers of {n}"
            )));
        }
        let start = to.len();
        T::T::put(&self.values, self.meaning, to);
        let mut there = to.len();
        let count = (there - start) as u64;
        if there == start + n {
            return Ok(count);
        }
        if self.levels.len() != n {
            return Err(ParquetError::General("holds too few numbers".to_owned()));
        }
        // From the end, so that each number moves to its row over those that moved.
        to.resize(start + n, ABSENT);
        for (row, level) in self.levels.iter().enumerate().rev() {
            to[start + row] = match *level == self.full && there > start {
                true => {
                    there -= 1;
                    to[there]
                }
                false => ABSENT,
            };
        }
        Ok(count)
    }

    fn dictionary(&mut self) -> Result<u64, ParquetError> {
        // With no page behind it there is nothing to read but the dictionary.
        let levels = Some(&mut self.levels);
        let (rows, _, _) = self
            .reader
            .read_records(1, levels, None, &mut self.values)?;
        Ok(rows as u64)
    }
}

/// Bytes that a stored value takes; 0 where they are bits.
pub(super) fn width(column: &ColumnDescriptor) -> u64 {
    match column.physical_type() {
        Type::BOOLEAN | Type::BYTE_ARRAY => 0,
        Type::INT32 | Type::FLOAT => 4,
        Type::INT64 | Type::DOUBLE => 8,
        Type::INT96 => 12,
        Type::FIXED_LEN_BYTE_ARRAY => column.type_length().max(1) as u64,
    }
}

/// A decoder for a column, fed through a hatch; `None` where it holds no numbers.
pub(super) fn decoder(
    column: &ColumnDescPtr,
    meaning: Meaning,
    hatch: Hatch,
) -> Option<Box<dyn Decoder>> {
    fn of<T: DataType>(column: &ColumnDescPtr, meaning: Meaning, hatch: Hatch) -> Box<dyn Decoder>
    where
        T::T: Stored,
    {
        Box::new(Typed::<T> {
            reader: ColumnReaderImpl::new(Arc::clone(column), Box::new(hatch)),
            meaning,
            full: column.max_def_level(),
            levels: Vec::new(),
            values: Vec::new(),
        })
    }
    Some(match column.physical_type() {
        Type::BOOLEAN => of::<BoolType>(column, meaning, hatch),
        Type::INT32 => of::<Int32Type>(column, meaning, hatch),
        Type::INT64 => of::<Int64Type>(column, meaning, hatch),
        Type::INT96 => of::<Int96Type>(column, meaning, hatch),
        Type::FLOAT => of::<FloatType>(column, meaning, hatch),
        Type::DOUBLE => of::<DoubleType>(column, meaning, hatch),
        Type::FIXED_LEN_BYTE_ARRAY => of::<FixedLenByteArrayType>(column, meaning, hatch),
        Type::BYTE_ARRAY => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Figures of IEEE 754 binary16.
    #[test]
    fn known_halves() {
        for (bits, value) in [
            (0x3C00, 1.0),
            (0xC000, -2.0),
            (0x7BFF, 65_504.0),
            (0x0001, 2_f64.powi(-24)),
            (0x0400, 2_f64.powi(-14)),
            (0x3555, 0.333_251_953_125),
            (0xFC00, f64::NEG_INFINITY),
        ] {
            assert_eq!(half(bits), value);
        }
        assert!(half(0x7E00).is_nan());
    }

    #[test]
    fn known_times_before_and_after_1970() {
        assert_eq!(seconds(-1, 1000, 0), -0.001);
        assert_eq!(
            seconds(1_700_000_000_123_456_789, NANOSECONDS, 0),
            1_700_000_000.123_456_8
        );
        let mut to = Vec::new();
        let mut day = Int96::new();
        day.set_data(500_000_000, 0, 2_440_589);
        Int96::put(&[day], Meaning::Number, &mut to);
        assert_eq!(to, [86_400.5]);
    }
}
