//! Units a reader of shaker results expects, and how many digits they deserve.

use proofmass_report::number::freedom;
use proofmass_shaker::derived::{Expanded, SensitivityTerm};
use proofmass_shaker::{FrequencyResult, MethodResult, OutputUnit, ShakerCalibration};

/// Unit in which sensitivities are printed: the prefix of the largest main term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unit {
    pub(super) name: &'static str,
    pub(super) factor: f64,
    pub(super) output: OutputUnit,
}

impl Unit {
    pub(super) fn of(calibration: &ShakerCalibration) -> Self {
        let rigorous = calibration
            .results
            .iter()
            .flat_map(|r| r.frequencies.iter().flat_map(|f| &f.sensitivity))
            .map(|t| t.modulus.value);
        let published = calibration
            .results
            .iter()
            .flat_map(|r| {
                r.published
                    .iter()
                    .flat_map(|p| p.fit.sensitivity.as_flattened())
            })
            .copied();
        let largest = rigorous.chain(published).fold(0.0, f64::max);
        let own = calibration
            .results
            .iter()
            .flat_map(|r| &r.frequencies)
            .flat_map(|f| &f.sensitivity)
            .map(|t| t.modulus.unit.as_str())
            .next();
        // Only volts take a prefix.
        for output in [OutputUnit::Acceleration, OutputUnit::Count] {
            if own == Some(output.sensitivity()) {
                return Self {
                    name: output.sensitivity(),
                    factor: 1.0,
                    output,
                };
            }
        }
        let (name, factor) = match largest {
            v if v >= 0.5 => ("V/(m/s²)", 1.0),
            v if v >= 0.5e-3 => ("mV/(m/s²)", 1e3),
            _ => ("µV/(m/s²)", 1e6),
        };
        Self {
            name,
            factor,
            output: OutputUnit::Volt,
        }
    }
}

pub(super) use crate::page::answer::plus_minus;

/// The same of a quantity times a factor.
pub(super) fn scaled(q: &Expanded, factor: f64) -> String {
    plus_minus(q.value * factor, q.expanded * factor)
}

/// A phase as printed, in degrees, between −90° and 270°, so that a term near 0° and one near 180° (a negative
/// cross term) do not jump.
pub(super) fn degrees(term: &SensitivityTerm) -> Option<(f64, f64)> {
    let phase = term.phase.as_ref()?;
    let value = phase.value.to_degrees();
    let value = if value < -90.0 { value + 360.0 } else { value };
    Some((value, phase.expanded.to_degrees()))
}

/// Degrees of freedom; from ten thousand on Student's t is a normal distribution to every digit printed.
pub(super) fn degrees_of_freedom(dof: Option<f64>) -> String {
    freedom(dof.unwrap_or(f64::INFINITY))
}

/// The frequency that stands for the device: the one nearest to 160 Hz, where datasheets are written.
pub(super) fn representative(result: &MethodResult) -> Option<&FrequencyResult> {
    result.frequencies.iter().min_by(|a, b| {
        let far = |f: &FrequencyResult| (f.frequency / 160.0).ln().abs();
        far(a).total_cmp(&far(b))
    })
}

/// `xx` as an index of nine.
pub(super) const TERMS: [&str; 9] = ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"];
/// Indices of the main terms.
pub(super) const MAIN: [usize; 3] = [0, 4, 8];
/// Indices of the cross terms.
pub(super) const CROSS: [usize; 6] = [1, 2, 3, 5, 6, 7];
