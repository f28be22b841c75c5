//! A calibration with the low-pass and the decimation behind it, as one step of firmware.

use super::{ExportForm, ExportOptions, FirmwareBlock, export, export_block, name, unable};
use crate::CalibrationFile;
use proofmass_io::{Error, ErrorKind, Result};
use std::fmt::Write;

/// A low-pass behind a calibration, and how many of its samples make one result.
#[derive(Clone, Debug, PartialEq)]
pub struct LowPassBehind {
    /// [`FirmwareBlock::LowPass`] or [`FirmwareBlock::LinearPhase`].
    pub low_pass: FirmwareBlock,
    /// Samples for one result, 1 for all.
    pub factor: u32,
}

impl LowPassBehind {
    /// A Butterworth low-pass with a corner in Hz, at a rate of samples per second.
    pub fn butterworth(corner: f64, rate: f64, factor: u32) -> Self {
        Self {
            low_pass: FirmwareBlock::LowPass { corner, rate },
            factor,
        }
    }
}

/// Writes a calibration as [`export`] does, with a low-pass and a decimation behind it and one step for all of it.
///
/// The parts are those that are written each by itself, with their self-checks; in Rust the low-pass and the decimation are
/// `proofmass_core::Decimator`, of a low-pass of linear phase `FirDecimator`, which the desk runs too.
///
/// ```
/// use proofmass_documents::{CalibrationFile, ExportForm, ExportOptions, LowPassBehind, export_chain};
/// use proofmass_io::Unit;
/// use proofmass_uncertainty::Estimate;
///
/// let k = [[415.0, 1.25, 4.0], [0.0, 412.5, 8.75], [0.0, 0.0, 414.0]];
/// let file = CalibrationFile::new("triangular", Unit::Count, k, [33_120.0, 33_271.0, 32_366.0], Estimate::new(vec![], vec![])?);
/// let behind = LowPassBehind::butterworth(10.0, 1000.0, 4);
/// let header = export_chain(&file, &behind, ExportForm::C, &ExportOptions::default())?;
/// assert!(header.contains("static inline int accelerometer_chain_step(accelerometer_chain_state *state, const float output[3], float acceleration[3])"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`export`] and [`export_block`]; a factor of zero.
pub fn export_chain(
    file: &CalibrationFile,
    behind: &LowPassBehind,
    form: ExportForm,
    options: &ExportOptions,
) -> Result<String> {
    if behind.factor == 0 {
        return Err(unable(
            "the decimation factor is 0, and must be 2 or more",
            "give a whole number from 2 on, or no decimation",
        ));
    }
    let name = name(file, options)?;
    let mut own = options.clone();
    own.name = Some(format!("{name}_low_pass"));
    own.source = None;
    own.notes = Vec::new();
    let taps = match &behind.low_pass {
        FirmwareBlock::LowPass { .. } => None,
        FirmwareBlock::LinearPhase { taps, .. } => Some(taps.len()),
        _ => {
            return Err(unable(
                "only a low-pass can follow a calibration here",
                "give one of second order or of linear phase",
            ));
        }
    };
    let low_pass = export_block(&behind.low_pass, form, &own)?;
    let calibration = export(file, form, options)?;
    let chained = Chained {
        name: &name,
        axes: file.axes(),
        temperature: file.temperature.is_some(),
        curvature: file.curvature.is_some(),
        factor: behind.factor,
        taps,
        real: match (form, options.number) {
            (ExportForm::Rust, super::ExportNumber::Float) => "f32",
            (ExportForm::Rust, _) => "f64",
            (_, super::ExportNumber::Float) => "float",
            _ => "double",
        },
    };
    match form {
        ExportForm::C => Ok(format!("{calibration}\n{low_pass}\n{}", chained.c())),
        ExportForm::Rust => Ok(chained.rust(&calibration, &low_pass)),
        ExportForm::Json => json(&calibration, &low_pass, behind.factor),
        _ => Err(unable(
            "a filter is written as C, Rust or JSON",
            "choose --c, --rust or --json",
        )),
    }
}

struct Chained<'a> {
    name: &'a str,
    axes: usize,
    temperature: bool,
    curvature: bool,
    factor: u32,
    /// Length of a response of linear phase.
    taps: Option<usize>,
    real: &'static str,
}

impl Chained<'_> {
    fn c(&self) -> String {
        let Self {
            name, axes, real, ..
        } = self;
        let wait = self.factor - 1;
        // A Butterworth begins as if its first sample had lasted; a finite response has no result before it is full.
        let zero = match *real {
            "float" => "0.0f",
            _ => "0.0",
        };
        let (before, begin, run) = match self.taps {
            None => (
                "state->wait = 0;\n    state->begun = 0;".to_owned(),
                format!(
                    "if (!state->begun)\n        for (i = 0; i < {axes}; i++)\n            {name}_low_pass_init(&state->axis[i], a[i]);\n    state->begun = 1;\n    for (i = 0; i < {axes}; i++)\n        a[i] = {name}_low_pass_step(&state->axis[i], a[i]);\n    "
                ),
                "a[i]".to_owned(),
            ),
            Some(taps) => (
                format!(
                    "int i;\n    for (i = 0; i < {axes}; i++)\n        {name}_low_pass_init(&state->axis[i], {zero});\n    state->wait = {}ul;\n    state->begun = 1;",
                    taps - 1
                ),
                format!(
                    "for (i = 0; i < {axes}; i++)\n        {name}_low_pass_push(&state->axis[i], a[i]);\n    "
                ),
                format!("{name}_low_pass_result(&state->axis[i])"),
            ),
        };
        let guard = format!("{}_CHAIN_H", name.to_ascii_uppercase());
        let (argument, apply) = match self.temperature {
            true => (
                format!("{real} temperature, "),
                format!("if (!{name}_apply(output, temperature, a))\n        return 0;"),
            ),
            false => (String::new(), format!("{name}_apply(output, a);")),
        };
        let beyond = match self.temperature {
            true => ", and where the temperature lies beyond the calibration: that sample is lost",
            false => "",
        };
        format!(
            "#ifndef {guard}\n#define {guard}\n\n\
             /* Calibration, low-pass, one result for {factor} samples. */\n\
             typedef struct {{\n    {name}_low_pass_state axis[{axes}];\n    unsigned long wait;\n    int begun;\n}} {name}_chain_state;\n\n\
             /* Before the first sample, and after a gap. */\n\
             static inline void {name}_chain_init({name}_chain_state *state)\n{{\n    {before}\n}}\n\n\
             /* One sample. Returns 1 with an acceleration in m/s^2, 0 where none is due{beyond}. */\n\
             static inline int {name}_chain_step({name}_chain_state *state, const {real} output[{axes}], {argument}{real} acceleration[{axes}])\n{{\n    \
             {real} a[{axes}];\n    int i;\n    {apply}\n    \
             {begin}\
             if (state->wait > 0) {{\n        state->wait--;\n        return 0;\n    }}\n    \
             state->wait = {wait}ul;\n    \
             for (i = 0; i < {axes}; i++)\n        acceleration[i] = {run};\n    return 1;\n}}\n\n#endif\n",
            factor = self.factor,
        )
    }

    fn rust(&self, calibration: &str, low_pass: &str) -> String {
        let Self {
            name, axes, real, ..
        } = self;
        let upper = name.to_ascii_uppercase();
        let one = *axes == 1;
        let vector = match one {
            true => (*real).to_owned(),
            false => format!("[{real}; 3]"),
        };
        let linear = !one && !self.temperature && !self.curvature;
        let (argument, a) = match (self.temperature, linear) {
            (true, _) => (
                format!(", temperature: {real}"),
                "calibration::apply(output, temperature)?".to_owned(),
            ),
            (false, true) => (String::new(), format!("calibration::{upper}.apply(output)")),
            (false, false) => (
                String::new(),
                format!("calibration::{upper}.apply(output, 0.0)"),
            ),
        };
        let (a, given) = match one {
            true => (format!("[{a}]"), ".map(|[a]| a)"),
            false => (a, ""),
        };
        let mut text = String::new();
        for (module, of) in [("calibration", calibration), ("low_pass", low_pass)] {
            let _ = writeln!(text, "pub mod {module} {{\n{of}}}\n");
        }
        let factor = self.factor;
        let (uses, constant, of, state, begin) = match self.taps {
            None => (
                "Decimator, DecimatorState",
                format!(
                    "Decimator<{real}, {axes}> = Decimator::constant(low_pass::{upper}_LOW_PASS, {factor})"
                ),
                "Low-pass",
                format!("DecimatorState<{real}, {axes}>"),
                "DecimatorState::at(a, 0)",
            ),
            Some(k) => (
                "FirDecimator, FirDecimatorState",
                format!(
                    "FirDecimator<{real}, {axes}, {k}> = FirDecimator::constant(low_pass::{upper}_LOW_PASS_TAPS, {factor})"
                ),
                "Low-pass of linear phase",
                format!("FirDecimatorState<{real}, {axes}, {k}>"),
                "FirDecimatorState::new()",
            ),
        };
        let _ = write!(
            text,
            "use proofmass_core::{{{uses}}};\n\n\
             /// {of}, and one result for {factor} samples.\n\
             pub const DECIMATOR: {constant};\n\n\
             /// One sample: an acceleration in m/s² where one is due. The state is `None` before the first sample and after a gap.\n\
             pub fn step(state: &mut Option<{state}>, output: {vector}{argument}) -> Option<{vector}> {{\n    \
             let a = {a};\n    \
             let state = state.get_or_insert({begin});\n    \
             DECIMATOR.step(state, a){given}\n}}\n",
        );
        text
    }
}

/// The coefficients with the low-pass as a part of them.
fn json(calibration: &str, low_pass: &str, factor: u32) -> Result<String> {
    let read = |text: &str| {
        serde_json::from_str::<serde_json::Value>(text)
            .map_err(|e| Error::new(ErrorKind::Output, format!("the text is no JSON: {e}")))
    };
    let (mut all, low_pass) = (read(calibration)?, read(low_pass)?);
    if let Some(parts) = all.as_object_mut() {
        parts.insert("low_pass".to_owned(), low_pass);
        parts.insert("decimation".to_owned(), factor.into());
    }
    let bytes = proofmass_io::finite::to_json(&all)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
