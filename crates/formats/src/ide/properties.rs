//! What an IDE file says of its channels and of their calibration.

use super::elements::{children, float, text, unsigned};
use crate::bytes::Order;
use crate::raw::Kind;
use std::collections::BTreeMap;

/// Elements that are read, by their identifiers in the schema `mide`.
mod id {
    pub(super) const CHANNEL_LIST: u32 = 0x5270;
    pub(super) const CHANNEL: u32 = 0x5271;
    pub(super) const CHANNEL_ID: u32 = 0x5272;
    pub(super) const CHANNEL_NAME: u32 = 0x5273;
    pub(super) const CHANNEL_CALIBRATION: u32 = 0x5274;
    pub(super) const CHANNEL_FORMAT: u32 = 0x5275;
    pub(super) const CHANNEL_PARSER: u32 = 0x5276;
    pub(super) const TIME_SCALE: u32 = 0x5277;
    pub(super) const TIME_MODULUS: u32 = 0x5278;
    pub(super) const SUBCHANNEL: u32 = 0x52A0;
    pub(super) const SUBCHANNEL_ID: u32 = 0x52A1;
    pub(super) const SUBCHANNEL_NAME: u32 = 0x52A2;
    pub(super) const SUBCHANNEL_CALIBRATION: u32 = 0x52A3;
    pub(super) const SUBCHANNEL_LABEL: u32 = 0x52A5;
    pub(super) const SUBCHANNEL_UNITS: u32 = 0x52A6;
    pub(super) const CALIBRATIONS: u32 = 0x4B00;
    pub(super) const UNIVARIATE: u32 = 0x4B01;
    pub(super) const BIVARIATE: u32 = 0x4B02;
    pub(super) const CALIBRATION_ID: u32 = 0x4B03;
    pub(super) const REFERENCE: u32 = 0x4B04;
    pub(super) const OTHER_REFERENCE: u32 = 0x4B05;
    pub(super) const OTHER_CHANNEL: u32 = 0x4B06;
    pub(super) const OTHER_SUBCHANNEL: u32 = 0x4B07;
    pub(super) const COEFFICIENT: u32 = 0x4B08;
}

/// Channels by their number and calibrations by theirs.
#[derive(Debug, Default)]
pub(super) struct Properties {
    pub(super) channels: BTreeMap<u64, Described>,
    pub(super) calibrations: BTreeMap<u64, Polynomial>,
}

/// A channel of the recorder: numbers that are taken together.
#[derive(Debug)]
pub(super) struct Described {
    pub(super) name: String,
    /// What a sample looks like, or why it is not read.
    pub(super) format: Result<Sample, String>,
    pub(super) calibration: Option<u64>,
    /// Length of a step of its time codes, s.
    pub(super) tick: f64,
    /// Time codes begin again from here on.
    pub(super) modulus: Option<u64>,
    /// By the number of the field.
    pub(super) subchannels: BTreeMap<u64, Subchannel>,
}

#[derive(Debug, Default)]
pub(super) struct Subchannel {
    pub(super) name: Option<String>,
    pub(super) unit: Option<String>,
    pub(super) calibration: Option<u64>,
}

/// Coefficients, the highest power first, of the numbers less a reference.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Polynomial {
    pub(super) coefficients: Vec<f64>,
    pub(super) reference: f64,
    pub(super) other: Option<Other>,
}

/// The subchannel whose numbers are the second variable of a polynomial, and what is taken from them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Other {
    pub(super) channel: u64,
    pub(super) subchannel: u64,
    pub(super) reference: f64,
}

/// Fields of a sample.
#[derive(Debug, PartialEq)]
pub(super) struct Sample {
    pub(super) order: Order,
    /// Kind and place in the sample.
    pub(super) fields: Vec<(Kind, u64)>,
    pub(super) size: u64,
}

/// Lists of a description in each other: those of a recorder are two.
const DEEPEST: usize = 8;
/// More fields than any recorder has.
const FIELDS: usize = 64;

impl Sample {
    /// Of a word for it as the module `struct` of Python understands it: `<hhh`.
    fn of(word: &str) -> Option<Self> {
        let (order, letters) = match word.split_at_checked(1)? {
            ("<", rest) => (Order::Little, rest),
            (">" | "!", rest) => (Order::Big, rest),
            _ => return None,
        };
        let mut sample = Self {
            order,
            fields: Vec::new(),
            size: 0,
        };
        let mut times: Option<u64> = None;
        for letter in letters.chars().filter(|c| !c.is_whitespace()) {
            if let Some(digit) = letter.to_digit(10) {
                let so_far = times.unwrap_or(0);
                times = Some(so_far.checked_mul(10)?.checked_add(u64::from(digit))?);
                continue;
            }
            let times = times.take().unwrap_or(1);
            if times > FIELDS as u64 {
                return None;
            }
            let kind = match letter {
                'x' => {
                    sample.size += times;
                    continue;
                }
                'b' | 'c' => Kind::I8,
                'B' | '?' => Kind::U8,
                'h' => Kind::I16,
                'H' => Kind::U16,
                'i' | 'l' => Kind::I32,
                'I' | 'L' => Kind::U32,
                'q' => Kind::I64,
                'Q' => Kind::U64,
                'f' => Kind::F32,
                'd' => Kind::F64,
                _ => return None,
            };
            for _ in 0..times {
                sample.fields.push((kind, sample.size));
                sample.size += kind.size();
            }
        }
        let fits = (1..=FIELDS).contains(&sample.fields.len()) && times.is_none();
        fits.then_some(sample)
    }
}

impl Properties {
    /// Takes in the content of `RecordingProperties` or of what stands in it.
    pub(super) fn take(&mut self, element: u32, content: &[u8]) {
        self.take_at(0, element, content);
    }

    fn take_at(&mut self, depth: usize, element: u32, content: &[u8]) {
        match element {
            id::CHANNEL => self.channel(content),
            id::UNIVARIATE | id::BIVARIATE => self.polynomial(element, content),
            super::PROPERTIES | id::CHANNEL_LIST | id::CALIBRATIONS if depth < DEEPEST => {
                children(content).for_each(|(id, content)| self.take_at(depth + 1, id, content));
            }
            _ => {}
        }
    }

    fn channel(&mut self, content: &[u8]) {
        let mut number = None;
        let mut name = None;
        let (mut format, mut parser) = (None, None);
        let mut scale = None;
        let mut channel = Described {
            name: String::new(),
            format: Err(String::new()),
            calibration: None,
            tick: 1.0 / 32_768.0,
            modulus: None,
            subchannels: BTreeMap::new(),
        };
        for (element, content) in children(content) {
            match element {
                id::CHANNEL_ID => number = unsigned(content),
                id::CHANNEL_NAME => name = Some(text(content)),
                id::CHANNEL_CALIBRATION => channel.calibration = unsigned(content),
                id::CHANNEL_FORMAT => format = Some(text(content)),
                id::CHANNEL_PARSER => parser = Some(text(content)),
                id::TIME_SCALE => scale = Some(text(content)),
                id::TIME_MODULUS => {
                    channel.modulus = unsigned(content).filter(|m| (2..1 << 56).contains(m));
                }
                id::SUBCHANNEL => {
                    let (number, subchannel) = subchannel(content);
                    channel.subchannels.insert(number, subchannel);
                }
                _ => {}
            }
        }
        let Some(number) = number else { return };
        let name = name.filter(|n| !n.is_empty());
        channel.name = name.unwrap_or_else(|| format!("channel {number}"));
        // What only the maker's program takes apart has a word for it, which comes before a format.
        let known = ["NMEA", "MPL3115", "LegacyAccelerometer"];
        let own = parser.filter(|p| known.contains(&p.as_str()) || format.is_none());
        channel.format = match (own, format) {
            (Some(own), _) => Err(format!("its samples are of the kind {own:?}")),
            (None, Some(word)) => {
                Sample::of(&word).ok_or_else(|| format!("its samples are of the form {word:?}"))
            }
            (None, None) => Err("the file does not say what its samples look like".to_owned()),
        };
        if let Some(scale) = scale {
            match quotient(&scale) {
                Some(tick) => channel.tick = tick,
                None => {
                    channel.format = Err(format!("the step of its time codes is {scale:?}"));
                }
            }
        }
        self.channels.insert(number, channel);
    }

    fn polynomial(&mut self, kind: u32, content: &[u8]) {
        let mut number = None;
        let mut polynomial = Polynomial::default();
        let mut other = Other::default();
        let mut said = [false; 2];
        for (element, content) in children(content) {
            match element {
                id::CALIBRATION_ID => number = unsigned(content),
                id::REFERENCE => polynomial.reference = float(content).unwrap_or(f64::NAN),
                id::COEFFICIENT => {
                    let coefficient = float(content).unwrap_or(f64::NAN);
                    polynomial.coefficients.push(coefficient);
                }
                id::OTHER_REFERENCE => other.reference = float(content).unwrap_or(f64::NAN),
                id::OTHER_CHANNEL => {
                    said[0] = true;
                    other.channel = unsigned(content).unwrap_or(u64::MAX);
                }
                id::OTHER_SUBCHANNEL => {
                    said[1] = true;
                    other.subchannel = unsigned(content).unwrap_or(u64::MAX);
                }
                _ => {}
            }
        }
        let two = kind == id::BIVARIATE;
        let count = polynomial.coefficients.len();
        let numbers = [polynomial.reference, other.reference];
        let mut numbers = numbers.iter().chain(&polynomial.coefficients);
        let whole = numbers.all(|v| v.is_finite())
            && match two {
                true => count == 4 && said == [true; 2],
                false => (1..=16).contains(&count),
            };
        // One that is damaged is as one that is not there: whoever names it says so.
        if let Some(number) = number.filter(|_| whole) {
            polynomial.other = two.then_some(other);
            self.calibrations.insert(number, polynomial);
        }
    }
}

fn subchannel(content: &[u8]) -> (u64, Subchannel) {
    let (mut number, mut label) = (0, None);
    let mut subchannel = Subchannel::default();
    for (element, content) in children(content) {
        match element {
            id::SUBCHANNEL_ID => number = unsigned(content).unwrap_or(u64::MAX),
            id::SUBCHANNEL_NAME => subchannel.name = Some(text(content)),
            id::SUBCHANNEL_LABEL => label = Some(text(content)),
            id::SUBCHANNEL_CALIBRATION => subchannel.calibration = unsigned(content),
            // Some recorders write the sign of the degree as on a web page.
            id::SUBCHANNEL_UNITS => {
                subchannel.unit = Some(text(content).replace("&#176;", "°"));
            }
            _ => {}
        }
    }
    let said = |word: Option<String>| word.filter(|w| !w.is_empty());
    subchannel.name = said(subchannel.name).or(said(label));
    subchannel.unit = said(subchannel.unit);
    (number, subchannel)
}

/// The value of `1.0/32768`.
fn quotient(text: &str) -> Option<f64> {
    let mut parts = text.split('/').map(|p| p.trim().parse::<f64>());
    let first = parts.next()?.ok()?;
    let value = parts.try_fold(first, |v, part| part.ok().map(|part| v / part))?;
    (value.is_finite() && value > 0.0).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_words_for_samples() {
        let sample = Sample::of(">lh").unwrap();
        assert_eq!(sample.fields, [(Kind::I32, 0), (Kind::I16, 4)]);
        assert_eq!((sample.order, sample.size), (Order::Big, 6));
        let sample = Sample::of("<2hx f").unwrap();
        assert_eq!(sample.fields[2], (Kind::F32, 5));
        for bad in ["", "<", "hh", "<s", "<3", "<65h", "<99999999999999999999h"] {
            assert_eq!(Sample::of(bad), None, "{bad}");
        }
        assert_eq!(quotient("1.0/32768"), Some(1.0 / 32_768.0));
        assert_eq!(quotient("1/0"), None);
    }
}
