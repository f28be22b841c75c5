//! Constants for `proofmass-core`.

use super::FirmwareBlock;
use super::vectors::Vectors;
use crate::export::literal;
use proofmass_core::velocity::{Observer, SteadyKalman, TwoChannel};
use proofmass_core::{Butterworth, Error};
use std::fmt::Write;

pub(super) fn text(
    block: &FirmwareBlock,
    name: &str,
    single: bool,
    heading: &[String],
    vectors: &Vectors,
) -> Result<String, Error> {
    let real = if single { "f32" } else { "f64" };
    let n = |v: f64| literal(v, single);
    let row = |v: &[f64]| {
        format!(
            "[{}]",
            v.iter().map(|v| n(*v)).collect::<Vec<_>>().join(", ")
        )
    };
    let name = name.to_ascii_uppercase();
    let mut text = String::new();
    for line in heading {
        let _ = writeln!(text, "//! {line}");
    }
    // Imports, constants, the state a check begins with, and one step of it.
    let (uses, constant, state, step) = match block {
        FirmwareBlock::LowPass { corner, rate } => {
            let design = Butterworth::<f64>::new(*corner, *rate)?;
            (
                "Butterworth, LowPassState".to_owned(),
                format!(
                    "pub const {name}: Butterworth<{real}> = Butterworth::constant({}, {});",
                    row(&design.numerator),
                    row(&design.denominator)
                ),
                "LowPassState::at(0.0)".to_owned(),
                format!("{name}.step(&mut state, first)"),
            )
        }
        FirmwareBlock::LinearPhase { taps, .. } => (
            "FirDecimator, FirDecimatorState".to_owned(),
            format!(
                "pub const {name}_TAPS: [{real}; {k}] = {};\n\n\
                 pub const {name}: FirDecimator<{real}, 1, {k}> = FirDecimator::constant({name}_TAPS, 1);",
                row(taps),
                k = taps.len()
            ),
            "FirDecimatorState::at([0.0])".to_owned(),
            format!("{name}.step(&mut state, [first]).map_or(0.0, |[v]| v)"),
        ),
        FirmwareBlock::MovingAverage { samples, .. } => (
            "MovingAverage".to_owned(),
            format!(
                "pub type {}<T> = MovingAverage<T, {samples}>;",
                pascal(&name)
            ),
            format!("{}::<{real}>::new()", pascal(&name)),
            "state.step(first)".to_owned(),
        ),
        FirmwareBlock::Bias {
            coefficients,
            state,
            ..
        } => {
            let filters: Vec<String> = coefficients
                .iter()
                .map(|c| {
                    format!(
                        "    BiasFilter::constant({}, {}, {}),",
                        n(c[0]),
                        n(c[1]),
                        n(c[2])
                    )
                })
                .collect();
            let states: Vec<String> = state
                .iter()
                .map(|s| format!("    BiasState::known({}, {}),", n(s[0]), n(s[1])))
                .collect();
            (
                "BiasFilter, BiasState".to_owned(),
                format!(
                    "pub const {name}: [BiasFilter<{real}>; 3] = [\n{}\n];\n\n\
                     /// Bias and variance at the end of the recording.\n\
                     pub const {name}_STATE: [BiasState<{real}>; 3] = [\n{}\n];",
                    filters.join("\n"),
                    states.join("\n")
                ),
                format!("{name}_STATE[0]"),
                format!(
                    "{{\n            {name}[0].predict(&mut state);\n            {name}[0].update(&mut state, first, second);\n            state.bias()\n        }}"
                ),
            )
        }
        FirmwareBlock::Velocity { filter, .. } => kalman(filter, &name, real, &row, &n),
        FirmwareBlock::VelocityOffset { filter, offset, .. } => {
            let (uses, constant, _, step) = kalman(filter, &name, real, &row, &n);
            let begin = row(&[0.0, 0.0, *offset]);
            (
                uses,
                format!(
                    "{constant}\n\n\
                     /// States to begin with: position and velocity are those of the start, the offset is that of the recording.\n\
                     pub const {name}_BEGIN: [{real}; 3] = {begin};"
                ),
                format!("KalmanState::new({name}_BEGIN, [0.0; 3], 0.0)"),
                step,
            )
        }
        FirmwareBlock::VelocityCorner { filter, .. } => kalman(filter, &name, real, &row, &n),
        FirmwareBlock::VelocitySecondOrderCorner { filter, .. } => {
            kalman(filter, &name, real, &row, &n)
        }
        FirmwareBlock::Observer {
            k_x,
            k_v,
            k_b,
            sample_time,
        } => {
            let c = Observer::<f64>::with_offset(*k_x, *k_v, *k_b, *sample_time)?.coefficients();
            (
                "velocity::{Observer, ObserverState}".to_owned(),
                format!(
                    "pub const {name}: Observer<{real}> = Observer::constant({});",
                    row(&c)
                ),
                "ObserverState::new(0.0, 0.0, 0.0)".to_owned(),
                format!("{name}.step(&mut state, first, second)"),
            )
        }
        FirmwareBlock::TwoChannel {
            k1,
            k2,
            sample_time,
        } => {
            let c = TwoChannel::<f64>::new(*k1, *k2, *sample_time)?.coefficients();
            (
                "velocity::{TwoChannel, TwoChannelState}".to_owned(),
                format!(
                    "pub const {name}: TwoChannel<{real}> = TwoChannel::constant({});",
                    row(&c)
                ),
                "TwoChannelState::new(0.0, 0.0, 0.0)".to_owned(),
                format!("{name}.step(&mut state, first, second)"),
            )
        }
        FirmwareBlock::EncoderMap { turn, lines, unit } => {
            let lines: Vec<String> = lines
                .iter()
                .map(|l| {
                    format!(
                        "    ErrorLine {{ order: {}, cosine: {}, sine: {} }},",
                        n(l.order),
                        n(l.cosine),
                        n(l.sine)
                    )
                })
                .collect();
            (
                "encoder::ErrorLine".to_owned(),
                format!(
                    "pub const {name}: [ErrorLine<{real}>; {}] = [\n{}\n];\n\n\
                     /// Way or angle of one turn, {unit}.\npub const {name}_TURN: {real} = {};\n\n\
                     /// What the encoder shows too much at a reading.\n\
                     pub fn error(reading: {real}) -> {real} {{\n    \
                     let turns = reading / {name}_TURN;\n    \
                     {name}.iter().map(|line| line.at(turns)).sum()\n}}",
                    lines.len(),
                    lines.join("\n"),
                    n(*turn)
                ),
                "()".to_owned(),
                "error(first)".to_owned(),
            )
        }
    };
    let uses = if uses.contains(',') && !uses.contains("::") {
        format!("{{{uses}}}")
    } else {
        uses
    };
    let _ = writeln!(text, "\nuse proofmass_core::{uses};\n");
    let _ = writeln!(
        text,
        "/// Designed off line; nothing is computed at start-up.\n{constant}\n"
    );
    let second = if block.takes_two() { "second" } else { "_" };
    let memory = match block {
        FirmwareBlock::EncoderMap { .. } => String::new(),
        _ => format!("    let mut state = {state};\n"),
    };
    let count = vectors.first.len();
    let _ = writeln!(
        text,
        "/// Number of the first step that this compiler computes otherwise than the desk did.\n\
         pub fn self_check() -> Option<usize> {{\n    \
         const FIRST: [{real}; {count}] = {};\n    \
         const SECOND: [{real}; {count}] = {};\n    \
         const EXPECTED: [{real}; {count}] = {};\n\
         {memory}    \
         for step in 0..{count} {{\n        \
         let (first, {second}) = (FIRST[step], SECOND[step]);\n        \
         let result = {step};\n        \
         let e = result - EXPECTED[step];\n        \
         if !(-{bound}..={bound}).contains(&e) {{\n            return Some(step);\n        }}\n    }}\n    None\n}}\n\n\
         #[cfg(test)]\nmod tests {{\n    #[test]\n    fn law_the_constant_computes_what_the_desk_computed() {{\n        \
         assert_eq!(super::self_check(), None);\n    }}\n}}",
        row(&vectors.first),
        row(&vectors.second),
        row(&vectors.expected),
        bound = n(vectors.bound),
    );
    Ok(text)
}

type Parts = (String, String, String, String);

fn kalman<const N: usize>(
    filter: &SteadyKalman<f64, N>,
    name: &str,
    real: &str,
    row: &dyn Fn(&[f64]) -> String,
    n: &dyn Fn(f64) -> String,
) -> Parts {
    let rows = |m: &[[f64; N]]| {
        let rows: Vec<String> = m.iter().map(|r| row(r)).collect();
        format!("[{}]", rows.join(", "))
    };
    (
        "velocity::{KalmanState, SteadyKalman}".to_owned(),
        format!(
            "pub const {name}: SteadyKalman<{real}, {N}> = SteadyKalman {{\n    f: {},\n    g: {},\n    k: {},\n    component: {},\n    velocity_variance: {},\n}};",
            rows(&filter.f),
            rows(&filter.g),
            row(&filter.k),
            filter.component,
            n(filter.velocity_variance)
        ),
        format!("KalmanState::new([0.0; {N}], [0.0; {N}], 0.0)"),
        format!("{name}.step(&mut state, Some(first), second)"),
    )
}

/// A name of a type from one of a constant.
fn pascal(name: &str) -> String {
    name.split('_')
        .map(|word| {
            let (head, tail) = word.split_at(word.len().min(1));
            head.to_owned() + &tail.to_ascii_lowercase()
        })
        .collect()
}
