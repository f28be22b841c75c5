//! What stands in the calibration memory of a device, for people and for programs.

use crate::export::unit_from;
use proofmass_core::{
    CalibrationMemory, Curvature, LARGEST_MEMORY, MEMORY_MAGIC, StoredCompensation, ThermalTerms,
};
use proofmass_io::{Error, ErrorKind, Result, Unit};
use serde::Serialize;
use std::fmt::Write;

/// Whether the bytes begin as a calibration memory does.
pub fn is_calibration_memory(head: &[u8]) -> bool {
    head.starts_with(&MEMORY_MAGIC)
}

/// The content of a calibration memory, in single precision as it is stored.
///
/// **Units** K in the unit of the outputs per m/s², b in that unit, temperatures in °C.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct MemoryContent {
    /// Always `calibration-memory`.
    pub kind: &'static str,
    /// Serial number of the device; empty where none was known.
    pub serial: String,
    /// First sixteen digits of the SHA-256 of the file that the calibration stands in.
    pub source_sha256_begins: String,
    /// Bytes of the image, checksum included.
    pub bytes: usize,
    /// Bytes behind it that were not looked at.
    pub bytes_behind: usize,
    /// Unit of the outputs.
    pub input_unit: Unit,
    /// Sensitivity matrix.
    #[serde(rename = "K")]
    pub k: Vec<Vec<f32>>,
    /// Its inverse.
    #[serde(rename = "K_inverse")]
    pub k_inverse: Vec<Vec<f32>>,
    /// Bias.
    pub b: Vec<f32>,
    /// T₀, lowest and highest temperature, β and γ by axes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature: Option<MemoryTemperature>,
    /// k₂ and k₃ by axes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub curvature: Option<MemoryCurvature>,
}

/// How a stored calibration follows the temperature.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct MemoryTemperature {
    /// T₀, °C.
    pub reference: f32,
    /// Lowest and highest temperature, °C.
    pub range: [f32; 2],
    /// β by axes, powers 1 to 3.
    pub bias: Vec<[f32; 3]>,
    /// γ by axes, powers 1 to 3.
    pub scale: Vec<[f32; 3]>,
}

/// Curvature of a stored calibration.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct MemoryCurvature {
    /// k₂ by axes, 1/(m/s²).
    pub quadratic: Vec<f32>,
    /// k₃ by axes, 1/(m/s²)².
    pub cubic: Vec<f32>,
}

impl MemoryContent {
    /// Reads an image from the beginning of the bytes.
    ///
    /// # Errors
    /// Bytes that are no calibration memory, are cut off, or have changed since they were written.
    pub fn read(bytes: &[u8]) -> Result<Self> {
        let memory = CalibrationMemory::read(bytes).map_err(|e| {
            Error::new(ErrorKind::Format, e.to_string())
                .with_hint("read the memory of the device again, or write the calibration anew: `proofmass export calibration.json --memory`")
        })?;
        // The layout says the length; writing it again counts it.
        let length = memory.write(&mut [0; LARGEST_MEMORY]).unwrap_or_default();
        let (k, k_inverse, b, temperature, curvature) = match memory.compensation() {
            StoredCompensation::OneAxis(m) => (
                vec![vec![m.scale()]],
                vec![vec![1.0 / m.scale()]],
                vec![m.bias()],
                m.thermal().map(temperature),
                m.curvature().map(curvature),
            ),
            StoredCompensation::ThreeAxes(m) => {
                let sensor = m.sensor();
                let rows = |m: &[[f32; 3]; 3]| m.iter().map(|r| r.to_vec()).collect();
                (
                    rows(&sensor.k().0),
                    rows(&sensor.k_inverse().0),
                    sensor.bias().to_vec(),
                    m.thermal().map(temperature),
                    m.curvature().map(curvature),
                )
            }
        };
        Ok(Self {
            kind: "calibration-memory",
            serial: memory.serial().to_owned(),
            source_sha256_begins: memory.source().iter().fold(String::new(), |mut t, b| {
                let _ = write!(t, "{b:02x}");
                t
            }),
            bytes: length,
            bytes_behind: bytes.len() - length,
            input_unit: unit_from(memory.unit()),
            k,
            k_inverse,
            b,
            temperature,
            curvature,
        })
    }

    /// As lines for people.
    pub fn text(&self) -> String {
        let unit = self.input_unit;
        let mut text = format!(
            "Calibration memory{}\n{} bytes, checksum right; outputs in {unit}, {} in single precision\n",
            match self.serial.as_str() {
                "" => ", of a device without a serial number".to_owned(),
                serial => format!(" of {serial}"),
            },
            self.bytes,
            match self.b.len() {
                1 => "one axis".to_owned(),
                n => format!("{n} axes"),
            }
        );
        let _ = writeln!(
            text,
            "made from a file whose SHA-256 begins with {}",
            self.source_sha256_begins
        );
        for (name, rows) in [("K", &self.k), ("K⁻¹", &self.k_inverse)] {
            let rows: Vec<String> = rows.iter().map(|r| format!("{r:?}")).collect();
            let _ = writeln!(text, "{name}   {}", rows.join(", "));
        }
        let _ = writeln!(text, "b   {:?}", self.b);
        if let Some(t) = &self.temperature {
            let [low, high] = t.range;
            let _ = writeln!(
                text,
                "T₀  {} °C, from {low} to {high} °C\nβ   {:?}\nγ   {:?}",
                t.reference, t.bias, t.scale
            );
        }
        if let Some(c) = &self.curvature {
            let _ = writeln!(text, "k₂  {:?}\nk₃  {:?}", c.quadratic, c.cubic);
        }
        if self.bytes_behind > 0 {
            let _ = writeln!(
                text,
                "{} bytes behind it were not looked at",
                self.bytes_behind
            );
        }
        text
    }
}

fn temperature<const N: usize>(terms: &ThermalTerms<f32, N>) -> MemoryTemperature {
    MemoryTemperature {
        reference: terms.reference,
        range: terms.range,
        bias: terms.bias.to_vec(),
        scale: terms.scale.to_vec(),
    }
}

fn curvature<const N: usize>(terms: &Curvature<f32, N>) -> MemoryCurvature {
    MemoryCurvature {
        quadratic: terms.quadratic.to_vec(),
        cubic: terms.cubic.to_vec(),
    }
}
