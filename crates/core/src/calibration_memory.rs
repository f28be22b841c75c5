//! A calibration as bytes in the memory of a sensor module: written at the desk, read on the chip.

use crate::{
    AxisCompensation, Compensation, Curvature, Matrix3, SensorModel, THERMAL_ORDER, ThermalTerms,
};
use core::fmt;

/// Bytes of the largest image: three axes with temperature and curvature.
pub const LARGEST_MEMORY: usize = 240;

/// Bytes of a serial number, UTF-8.
pub const MEMORY_SERIAL: usize = 20;

/// First bytes of every image.
pub const MEMORY_MAGIC: [u8; 4] = *b"PMCM";

const VERSION: u8 = 1;
const HEAD: usize = 40;
const THERMAL: u8 = 1;
const CURVATURE: u8 = 2;

/// Why bytes are no calibration memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MemoryError {
    /// The first four bytes are others, as those of a memory that was never written.
    NotAMemory,
    /// Written by a later version of the layout.
    Version(u8),
    /// Fewer bytes than the image has.
    Short {
        /// Bytes that are there.
        found: usize,
        /// Bytes that the image has.
        needed: usize,
    },
    /// What its bytes say of axes, parts or length contradicts itself.
    Layout,
    /// The checksum is another: a bit has changed.
    Checksum {
        /// Checksum of the bytes.
        computed: u32,
        /// Checksum that is stored.
        stored: u32,
    },
    /// A coefficient is no finite number, or the serial number no text.
    Content,
}

impl fmt::Display for MemoryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAMemory => {
                f.write_str("the bytes are no calibration memory: they do not begin with \"PMCM\"")
            }
            Self::Version(version) => write!(
                f,
                "the calibration memory has layout {version}; {VERSION} is understood"
            ),
            Self::Short { found, needed } => write!(
                f,
                "the calibration memory ends after {found} of {needed} bytes"
            ),
            Self::Layout => f.write_str(
                "axes, parts and length of the calibration memory contradict each other",
            ),
            Self::Checksum { computed, stored } => write!(
                f,
                "the calibration memory is damaged: its checksum is {computed:08x}, {stored:08x} is stored"
            ),
            Self::Content => f.write_str(
                "the calibration memory holds a coefficient that is no finite number, or a serial number that is no text",
            ),
        }
    }
}

impl core::error::Error for MemoryError {}

/// Unit of the outputs that a stored calibration takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MemoryUnit {
    /// Numbers out of a converter.
    Count,
    /// Volts.
    Volt,
    /// m/s².
    MetrePerSecondSquared,
    /// Standard gravity, 9.80665 m/s².
    StandardGravity,
}

impl MemoryUnit {
    const ALL: [Self; 4] = [
        Self::Count,
        Self::Volt,
        Self::MetrePerSecondSquared,
        Self::StandardGravity,
    ];
}

/// The coefficients of one axis or three, in single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StoredCompensation {
    /// A single axis.
    OneAxis(AxisCompensation<f32>),
    /// Three axes and what they see of each other.
    ThreeAxes(Compensation<f32>),
}

/// A calibration that is stored in the device it belongs to.
///
/// **Layout**, little-endian, 128 bytes for three axes without temperature and curvature, at most [`LARGEST_MEMORY`]:
///
/// | bytes | content |
/// |---|---|
/// | 0 … 3 | `PMCM` |
/// | 4 | version of the layout, 1 |
/// | 5 | axes, 1 or 3 |
/// | 6 | parts: bit 0 temperature, bit 1 curvature |
/// | 7 | unit of the outputs: 0 count, 1 V, 2 m/s², 3 g |
/// | 8, 9 | length of the image with its checksum |
/// | 10, 11 | zero |
/// | 12 … 31 | serial number, UTF-8, filled up with zeros |
/// | 32 … 39 | first eight bytes of the SHA-256 of the file that the calibration stands in |
/// | then | single precision: K by rows, K⁻¹ by rows (three axes only), b |
/// | with temperature | T₀, lowest, highest temperature, β by axes, γ by axes (powers 1 to 3) |
/// | with curvature | k₂, k₃ by axes, the largest acceleration of both |
/// | last four | CRC-32 of all before (polynomial 0x04C11DB7 reflected, as in IEEE 802.3 and zip) |
///
/// ```
/// use proofmass_core::*;
///
/// let sensor = SensorModel::<f32>::new(Matrix3::diagonal([414.0; 3]), [33_120.0; 3])?;
/// let stored = StoredCompensation::ThreeAxes(Compensation::new(sensor, None, None, 20.0)?);
/// let memory = CalibrationMemory::new("0042", [0; 8], MemoryUnit::Count, stored).unwrap();
/// let mut bytes = [0xff; 256];
/// let length = memory.write(&mut bytes).unwrap();
/// assert_eq!(length, 128);
/// // On the chip, where all of the memory is given.
/// assert_eq!(CalibrationMemory::read(&bytes), Ok(memory));
/// bytes[50] ^= 1;
/// assert!(matches!(CalibrationMemory::read(&bytes), Err(MemoryError::Checksum { .. })));
/// # Ok::<(), Error>(())
/// ```
#[doc(alias("EEPROM", "calibration memory", "TEDS"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalibrationMemory {
    serial: [u8; MEMORY_SERIAL],
    source: [u8; 8],
    unit: MemoryUnit,
    reach: f32,
    stored: StoredCompensation,
}

impl CalibrationMemory {
    /// From the serial number, the beginning of the digest of the calibration's file, and the coefficients.
    ///
    /// # Errors
    /// [`MemoryError::Content`] for a serial number of more than [`MEMORY_SERIAL`] bytes or with a zero in it.
    pub fn new(
        serial: &str,
        source: [u8; 8],
        unit: MemoryUnit,
        stored: StoredCompensation,
    ) -> Result<Self, MemoryError> {
        let mut bytes = [0; MEMORY_SERIAL];
        if serial.len() > MEMORY_SERIAL || serial.bytes().any(|b| b == 0) {
            return Err(MemoryError::Content);
        }
        bytes[..serial.len()].copy_from_slice(serial.as_bytes());
        Ok(Self {
            serial: bytes,
            source,
            unit,
            reach: 0.0,
            stored,
        })
    }

    /// With the largest acceleration at which curvature was measured, m/s².
    #[must_use]
    pub fn reach(mut self, reach: f32) -> Self {
        self.reach = reach;
        self
    }

    /// Serial number of the device; empty where none was known.
    pub fn serial(&self) -> &str {
        let end = self.serial.iter().position(|b| *b == 0);
        // Checked where the value was made.
        core::str::from_utf8(&self.serial[..end.unwrap_or(MEMORY_SERIAL)]).unwrap_or_default()
    }

    /// First eight bytes of the SHA-256 of the file that the calibration stands in.
    pub fn source(&self) -> [u8; 8] {
        self.source
    }

    /// Unit of the outputs.
    pub fn unit(&self) -> MemoryUnit {
        self.unit
    }

    /// The coefficients.
    pub fn compensation(&self) -> &StoredCompensation {
        &self.stored
    }

    /// Writes the image to the beginning of the bytes; its length. None where they are too few, which leaves them as they were.
    pub fn write(&self, bytes: &mut [u8]) -> Option<usize> {
        let (axes, parts) = self.shape();
        let length = length(axes, parts);
        let image = bytes.get_mut(..length)?;
        image[..4].copy_from_slice(&MEMORY_MAGIC);
        image[4..8].copy_from_slice(&[VERSION, axes as u8, parts, self.unit as u8]);
        image[8..12].copy_from_slice(&(length as u32).to_le_bytes());
        image[12..32].copy_from_slice(&self.serial);
        image[32..HEAD].copy_from_slice(&self.source);
        let mut place = HEAD;
        let mut put = |value: f32| {
            image[place..place + 4].copy_from_slice(&value.to_le_bytes());
            place += 4;
        };
        match &self.stored {
            StoredCompensation::OneAxis(model) => {
                put(model.scale());
                put(model.bias());
                put_terms(model.thermal(), model.curvature(), self.reach, &mut put);
            }
            StoredCompensation::ThreeAxes(model) => {
                let sensor = model.sensor();
                for matrix in [sensor.k(), sensor.k_inverse()] {
                    matrix.0.iter().flatten().for_each(|v| put(*v));
                }
                sensor.bias().iter().for_each(|v| put(*v));
                put_terms(model.thermal(), model.curvature(), self.reach, &mut put);
            }
        }
        let sum = crc32(&image[..length - 4]);
        image[length - 4..].copy_from_slice(&sum.to_le_bytes());
        Some(length)
    }

    /// Reads an image from the beginning of the bytes; what follows it is not looked at.
    ///
    /// # Errors
    /// See [`MemoryError`]. A calibration is read whole or not at all.
    pub fn read(bytes: &[u8]) -> Result<Self, MemoryError> {
        if !bytes.starts_with(&MEMORY_MAGIC) {
            return Err(MemoryError::NotAMemory);
        }
        let found = bytes.len();
        let head = bytes.get(..HEAD).ok_or(MemoryError::Short {
            found,
            needed: HEAD,
        })?;
        if head[4] != VERSION {
            return Err(MemoryError::Version(head[4]));
        }
        let (axes, parts) = (usize::from(head[5]), head[6]);
        let needed = length(axes, parts);
        let stated = u32::from_le_bytes([head[8], head[9], head[10], head[11]]);
        if !matches!(axes, 1 | 3) || parts > (THERMAL | CURVATURE) || stated != needed as u32 {
            return Err(MemoryError::Layout);
        }
        let image = bytes
            .get(..needed)
            .ok_or(MemoryError::Short { found, needed })?;
        let (body, sum) = image.split_at(needed - 4);
        let stored = u32::from_le_bytes([sum[0], sum[1], sum[2], sum[3]]);
        let computed = crc32(body);
        if computed != stored {
            return Err(MemoryError::Checksum { computed, stored });
        }
        let unit = MemoryUnit::ALL.get(usize::from(head[7]));
        let unit = *unit.ok_or(MemoryError::Layout)?;
        let mut numbers = Numbers(&body[HEAD..]);
        if !numbers.all_finite() {
            return Err(MemoryError::Content);
        }
        let mut reach = 0.0;
        let stored = if axes == 1 {
            let (scale, bias) = (numbers.next(), numbers.next());
            let (thermal, curvature) = numbers.terms::<1>(parts, &mut reach);
            if scale == 0.0 {
                return Err(MemoryError::Content);
            }
            StoredCompensation::OneAxis(AxisCompensation::constant(scale, bias, thermal, curvature))
        } else {
            let k = Matrix3([numbers.take(), numbers.take(), numbers.take()]);
            let inverse = Matrix3([numbers.take(), numbers.take(), numbers.take()]);
            let sensor = SensorModel::constant(k, inverse, numbers.take());
            let (thermal, curvature) = numbers.terms::<3>(parts, &mut reach);
            StoredCompensation::ThreeAxes(Compensation::constant(sensor, thermal, curvature))
        };
        let mut serial = [0; MEMORY_SERIAL];
        serial.copy_from_slice(&head[12..32]);
        let end = serial.iter().position(|b| *b == 0).unwrap_or(MEMORY_SERIAL);
        if core::str::from_utf8(&serial[..end]).is_err() {
            return Err(MemoryError::Content);
        }
        let mut source = [0; 8];
        source.copy_from_slice(&head[32..HEAD]);
        Ok(Self {
            serial,
            source,
            unit,
            reach,
            stored,
        })
    }

    fn shape(&self) -> (usize, u8) {
        let (axes, thermal, curvature) = match &self.stored {
            StoredCompensation::OneAxis(m) => (1, m.thermal().is_some(), m.curvature().is_some()),
            StoredCompensation::ThreeAxes(m) => (3, m.thermal().is_some(), m.curvature().is_some()),
        };
        (
            axes,
            u8::from(thermal) * THERMAL + u8::from(curvature) * CURVATURE,
        )
    }
}

/// Bytes of an image of so many axes with these parts.
fn length(axes: usize, parts: u8) -> usize {
    let linear = match axes {
        1 => 2,
        _ => 2 * axes * axes + axes,
    };
    let thermal = match parts & THERMAL {
        0 => 0,
        _ => 3 + 2 * THERMAL_ORDER * axes,
    };
    let curvature = match parts & CURVATURE {
        0 => 0,
        _ => 2 * axes + 1,
    };
    HEAD + 4 * (linear + thermal + curvature) + 4
}

fn put_terms<const N: usize>(
    thermal: Option<&ThermalTerms<f32, N>>,
    curvature: Option<&Curvature<f32, N>>,
    reach: f32,
    put: &mut dyn FnMut(f32),
) {
    if let Some(terms) = thermal {
        put(terms.reference);
        terms.range.iter().for_each(|v| put(*v));
        for powers in [&terms.bias, &terms.scale] {
            powers.iter().flatten().for_each(|v| put(*v));
        }
    }
    if let Some(terms) = curvature {
        for powers in [&terms.quadratic, &terms.cubic] {
            powers.iter().for_each(|v| put(*v));
        }
        put(reach);
    }
}

/// Numbers in single precision, one after the other; there are as many as the length says.
struct Numbers<'a>(&'a [u8]);

impl Numbers<'_> {
    fn all_finite(&self) -> bool {
        let mut numbers = Numbers(self.0);
        (0..self.0.len() / 4).all(|_| numbers.next().is_finite())
    }

    fn next(&mut self) -> f32 {
        match self.0.split_first_chunk::<4>() {
            Some((number, rest)) => {
                self.0 = rest;
                f32::from_le_bytes(*number)
            }
            None => f32::NAN,
        }
    }

    fn take<const N: usize>(&mut self) -> [f32; N] {
        core::array::from_fn(|_| self.next())
    }

    fn powers<const N: usize>(&mut self) -> [[f32; THERMAL_ORDER]; N] {
        core::array::from_fn(|_| self.take())
    }

    #[allow(clippy::type_complexity)]
    fn terms<const N: usize>(
        &mut self,
        parts: u8,
        reach: &mut f32,
    ) -> (Option<ThermalTerms<f32, N>>, Option<Curvature<f32, N>>) {
        let thermal = (parts & THERMAL != 0).then(|| ThermalTerms {
            reference: self.next(),
            range: self.take(),
            bias: self.powers(),
            scale: self.powers(),
        });
        let curvature = (parts & CURVATURE != 0).then(|| Curvature {
            quadratic: self.take(),
            cubic: self.take(),
        });
        if curvature.is_some() {
            *reach = self.next();
        }
        (thermal, curvature)
    }
}

/// CRC-32 without a table: a memory is read once, at the start.
fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for byte in bytes {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
        }
    }
    !crc
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The check value of the catalogue of parametrised CRC algorithms.
    #[test]
    fn published_check_value_of_the_checksum() {
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    }

    fn three(thermal: bool, curvature: bool) -> CalibrationMemory {
        let k = Matrix3([[415.0, 1.25, 4.0], [0.0, 412.5, 8.75], [-1.0, 0.5, 414.0]]);
        let sensor = SensorModel::<f32>::new(k, [33_120.0, 33_271.0, 32_366.0]).unwrap();
        let thermal = thermal.then(|| ThermalTerms {
            reference: 25.0,
            range: [-40.0, 85.0],
            bias: [[0.2, -1e-3, 1e-5], [0.1, 0.0, 0.0], [-0.3, 2e-3, 0.0]],
            scale: [[1e-4, 0.0, 0.0], [2e-4, 1e-7, 0.0], [-1e-4, 0.0, 1e-9]],
        });
        let curvature = curvature.then_some(Curvature {
            quadratic: [1e-4, -2e-4, 3e-5],
            cubic: [1e-6, 0.0, -1e-6],
        });
        let model = Compensation::new(sensor, thermal, curvature, 20.0).unwrap();
        let stored = StoredCompensation::ThreeAxes(model);
        let memory = CalibrationMemory::new("SN-0042", [7; 8], MemoryUnit::Count, stored).unwrap();
        memory.reach(if curvature.is_some() { 20.0 } else { 0.0 })
    }

    fn one(thermal: bool, curvature: bool) -> CalibrationMemory {
        let thermal = thermal.then_some(ThermalTerms {
            reference: 23.0,
            range: [0.0, 50.0],
            bias: [[1e-4, 0.0, 1e-9]],
            scale: [[1e-4, -1e-6, 0.0]],
        });
        let curvature = curvature.then_some(Curvature {
            quadratic: [1e-5],
            cubic: [-1e-7],
        });
        let model = AxisCompensation::new(0.13, 2e-3, thermal, curvature, 50.0).unwrap();
        let stored = StoredCompensation::OneAxis(model);
        let memory = CalibrationMemory::new("", [0; 8], MemoryUnit::Volt, stored).unwrap();
        memory.reach(if curvature.is_some() { 50.0 } else { 0.0 })
    }

    /// Lengths counted by hand: 40 + 4 (21 | 2 + 21 | 9 + 7 | 3) + 4.
    #[test]
    fn known_lengths_and_what_is_written_is_read() {
        let cases = [
            (three(false, false), 128),
            (three(true, false), 212),
            (three(false, true), 156),
            (three(true, true), LARGEST_MEMORY),
            (one(false, false), 52),
            (one(true, false), 88),
            (one(false, true), 64),
            (one(true, true), 100),
        ];
        for (memory, length) in cases {
            let mut bytes = [0xff; 256];
            assert_eq!(memory.write(&mut bytes), Some(length));
            assert_eq!(CalibrationMemory::read(&bytes), Ok(memory));
            assert_eq!(CalibrationMemory::read(&bytes[..length]), Ok(memory));
            assert_eq!(bytes[length], 0xff);
            assert_eq!(memory.write(&mut bytes[..length - 1]), None);
        }
    }

    /// Every changed bit, and every image that ends too early, is refused: the checksum finds all errors of one bit.
    #[test]
    fn law_no_damaged_image_is_read() {
        for memory in [three(true, true), one(false, false)] {
            let mut bytes = [0; LARGEST_MEMORY];
            let length = memory.write(&mut bytes).unwrap();
            for bit in 0..8 * length {
                bytes[bit / 8] ^= 1 << (bit % 8);
                assert!(CalibrationMemory::read(&bytes[..length]).is_err(), "{bit}");
                bytes[bit / 8] ^= 1 << (bit % 8);
            }
            for end in 0..length {
                assert!(CalibrationMemory::read(&bytes[..end]).is_err(), "{end}");
            }
        }
        for blank in [[0u8; 256], [0xff; 256]] {
            assert_eq!(
                CalibrationMemory::read(&blank),
                Err(MemoryError::NotAMemory)
            );
        }
    }

    /// A right checksum over what cannot be is refused as well.
    #[test]
    fn refuses_what_is_no_number_no_text_and_no_unit() {
        let forged = |place: usize, with: &[u8]| {
            let mut bytes = [0; LARGEST_MEMORY];
            let length = three(false, false).write(&mut bytes).unwrap();
            bytes[place..place + with.len()].copy_from_slice(with);
            let sum = crc32(&bytes[..length - 4]);
            bytes[length - 4..length].copy_from_slice(&sum.to_le_bytes());
            CalibrationMemory::read(&bytes)
        };
        assert_eq!(
            forged(44, &f32::NAN.to_le_bytes()),
            Err(MemoryError::Content)
        );
        assert_eq!(forged(12, &[0xc3, 0x28]), Err(MemoryError::Content));
        assert_eq!(forged(7, &[9]), Err(MemoryError::Layout));
        assert_eq!(forged(4, &[2]), Err(MemoryError::Version(2)));
        assert_eq!(forged(5, &[2]), Err(MemoryError::Layout));
        assert_eq!(forged(6, &[4]), Err(MemoryError::Layout));
        let long = CalibrationMemory::new(
            "123456789012345678901",
            [0; 8],
            MemoryUnit::Count,
            *three(false, false).compensation(),
        );
        assert_eq!(long, Err(MemoryError::Content));
    }
}
