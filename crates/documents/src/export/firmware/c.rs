//! C99 headers without dependencies or allocation.

use super::FirmwareBlock;
use super::vectors::Vectors;
use crate::export::literal;
use proofmass_core::velocity::{Observer, SteadyKalman, TwoChannel};
use proofmass_core::{Butterworth, Error};
use std::fmt::Write;

/// How numbers of one precision are written.
struct Style<'a> {
    name: &'a str,
    real: &'static str,
    single: bool,
}

impl Style<'_> {
    fn n(&self, v: f64) -> String {
        literal(v, self.single) + if self.single { "f" } else { "" }
    }

    fn row(&self, values: &[f64]) -> String {
        let cells: Vec<String> = values.iter().map(|v| self.n(*v)).collect();
        format!("{{{}}}", cells.join(", "))
    }

    fn rows<const N: usize>(&self, values: &[[f64; N]]) -> String {
        let rows: Vec<String> = values
            .iter()
            .map(|r| format!("    {}", self.row(r)))
            .collect();
        format!("{{\n{}\n}}", rows.join(",\n"))
    }

    fn constant(&self, name: &str, dimensions: &str, value: &str) -> String {
        format!(
            "static const {} {}_{name}{dimensions} = {value};\n",
            self.real, self.name
        )
    }
}

pub(super) fn text(
    block: &FirmwareBlock,
    name: &str,
    single: bool,
    heading: &[String],
    vectors: &Vectors,
) -> Result<String, Error> {
    let style = Style {
        name,
        real: if single { "float" } else { "double" },
        single,
    };
    let guard = format!("{}_H", name.to_ascii_uppercase());
    let mut c = String::from("/*\n");
    for line in heading {
        let _ = writeln!(c, " * {line}");
    }
    let _ = writeln!(
        c,
        " * C99, no library, no allocation. {name}_self_check() returns 0 when this compiler computes what the desk computed.\n */\n#ifndef {guard}\n#define {guard}\n"
    );
    // The call that makes one step of the self-check.
    let step = match block {
        FirmwareBlock::LowPass { corner, rate } => {
            low_pass(&mut c, &style, &Butterworth::<f64>::new(*corner, *rate)?)
        }
        FirmwareBlock::LinearPhase { taps, .. } => linear_phase(&mut c, &style, taps),
        FirmwareBlock::MovingAverage { samples, .. } => moving_average(&mut c, &style, *samples),
        FirmwareBlock::Bias {
            coefficients,
            state,
            ..
        } => bias(&mut c, &style, coefficients, state),
        FirmwareBlock::Velocity { filter, .. } => kalman(&mut c, &style, filter, None),
        FirmwareBlock::VelocityOffset { filter, offset, .. } => {
            kalman(&mut c, &style, filter, Some(*offset))
        }
        FirmwareBlock::VelocityCorner { filter, .. } => kalman(&mut c, &style, filter, None),
        FirmwareBlock::VelocitySecondOrderCorner { filter, .. } => {
            kalman(&mut c, &style, filter, None)
        }
        FirmwareBlock::Observer {
            k_x,
            k_v,
            k_b,
            sample_time,
        } => {
            let filter = Observer::<f64>::with_offset(*k_x, *k_v, *k_b, *sample_time)?;
            observer(&mut c, &style, &filter.coefficients())
        }
        FirmwareBlock::TwoChannel {
            k1,
            k2,
            sample_time,
        } => {
            let filter = TwoChannel::<f64>::new(*k1, *k2, *sample_time)?;
            two_channel(&mut c, &style, &filter.coefficients())
        }
        FirmwareBlock::EncoderMap { turn, lines, .. } => {
            let lines: Vec<[f64; 3]> = lines.iter().map(|l| [l.order, l.cosine, l.sine]).collect();
            encoder_map(&mut c, &style, *turn, &lines)
        }
    };
    self_check(&mut c, &style, vectors, &step, block);
    let _ = writeln!(c, "#endif");
    Ok(c)
}

/// Declarations and the result of one step of the self-check, in the words of C.
struct Step {
    begin: String,
    result: String,
}

fn low_pass(c: &mut String, s: &Style<'_>, design: &Butterworth<f64>) -> Step {
    let (name, real) = (s.name, s.real);
    *c += &s.constant("b", "[3]", &s.row(&design.numerator));
    *c += &s.constant("a", "[2]", &s.row(&design.denominator));
    let _ = writeln!(
        c,
        "\ntypedef struct {{\n    {real} input[2], output[2];\n}} {name}_state;\n\n\
         /* As after a long time at one value. */\n\
         static inline void {name}_init({name}_state *state, {real} value)\n{{\n    \
         state->input[0] = state->input[1] = state->output[0] = state->output[1] = value;\n}}\n\n\
         static inline {real} {name}_step({name}_state *state, {real} input)\n{{\n    \
         const {real} at = state->output[0];\n    \
         const {real} y = {name}_b[0] * (input - at) + {name}_b[1] * (state->input[0] - at)\n        \
         + {name}_b[2] * (state->input[1] - at) - {name}_a[1] * (state->output[1] - at) + at;\n    \
         state->input[1] = state->input[0];\n    state->input[0] = input;\n    \
         state->output[1] = state->output[0];\n    state->output[0] = y;\n    return y;\n}}\n"
    );
    Step {
        begin: format!(
            "{name}_state state;\n    {name}_init(&state, {});",
            s.n(0.0)
        ),
        result: format!("{name}_step(&state, first[step])"),
    }
}

fn linear_phase(c: &mut String, s: &Style<'_>, taps: &[f64]) -> Step {
    let (name, real, k) = (s.name, s.real, taps.len());
    let rows: Vec<String> = taps
        .chunks(8)
        .map(|row| row.iter().map(|h| s.n(*h)).collect::<Vec<_>>().join(", "))
        .collect();
    let rows = format!("{{\n    {}\n}}", rows.join(",\n    "));
    *c += "/* Of the oldest sample first. */\n";
    *c += &s.constant("taps", &format!("[{k}]"), &rows);
    let _ = writeln!(
        c,
        "\ntypedef struct {{\n    {real} samples[{k}];\n    int next;\n}} {name}_state;\n\n\
         /* As after a long time at one value. */\n\
         static inline void {name}_init({name}_state *state, {real} value)\n{{\n    \
         int i;\n    for (i = 0; i < {k}; i++)\n        state->samples[i] = value;\n    state->next = 0;\n}}\n\n\
         static inline void {name}_push({name}_state *state, {real} input)\n{{\n    \
         state->samples[state->next] = input;\n    \
         state->next = state->next + 1 == {k} ? 0 : state->next + 1;\n}}\n\n\
         /* Of the last {k} samples, summed from the oldest on. */\n\
         static inline {real} {name}_result(const {name}_state *state)\n{{\n    \
         {real} sum = {zero};\n    int i, k = 0;\n    \
         for (i = state->next; i < {k}; i++)\n        sum += {name}_taps[k++] * state->samples[i];\n    \
         for (i = 0; i < state->next; i++)\n        sum += {name}_taps[k++] * state->samples[i];\n    \
         return sum;\n}}\n\n\
         static inline {real} {name}_step({name}_state *state, {real} input)\n{{\n    \
         {name}_push(state, input);\n    return {name}_result(state);\n}}\n",
        zero = s.n(0.0)
    );
    Step {
        begin: format!(
            "{name}_state state;\n    {name}_init(&state, {});",
            s.n(0.0)
        ),
        result: format!("{name}_step(&state, first[step])"),
    }
}

fn moving_average(c: &mut String, s: &Style<'_>, samples: usize) -> Step {
    let (name, real) = (s.name, s.real);
    let _ = writeln!(
        c,
        "typedef struct {{\n    {real} samples[{samples}];\n    int next, filled;\n}} {name}_state;\n\n\
         static inline void {name}_init({name}_state *state)\n{{\n    \
         int i;\n    for (i = 0; i < {samples}; i++)\n        state->samples[i] = {zero};\n    \
         state->next = state->filled = 0;\n}}\n\n\
         /* Mean of the samples so far, of the last {samples} from then on. */\n\
         static inline {real} {name}_step({name}_state *state, {real} input)\n{{\n    \
         {real} sum = {zero};\n    int i;\n    \
         state->samples[state->next] = input;\n    \
         state->next = (state->next + 1) % {samples};\n    \
         if (state->filled < {samples})\n        state->filled++;\n    \
         for (i = 0; i < state->filled; i++)\n        sum += state->samples[i];\n    \
         return sum / ({real})state->filled;\n}}\n",
        zero = s.n(0.0)
    );
    Step {
        begin: format!("{name}_state state;\n    {name}_init(&state);"),
        result: format!("{name}_step(&state, first[step])"),
    }
}

fn bias(
    c: &mut String,
    s: &Style<'_>,
    coefficients: &[[f64; 3]; 3],
    state: &[[f64; 2]; 3],
) -> Step {
    let (name, real) = (s.name, s.real);
    *c += "/* phi, Q, R of x, y, z. */\n";
    *c += &s.constant("coefficients", "[3][3]", &s.rows(coefficients));
    *c += "/* Bias and variance to begin with: those at the end of the recording. */\n";
    *c += &s.constant("begin", "[3][2]", &s.rows(state));
    let _ = writeln!(
        c,
        "\ntypedef struct {{\n    {real} bias[3], variance[3];\n}} {name}_state;\n\n\
         static inline void {name}_init({name}_state *state)\n{{\n    int i;\n    \
         for (i = 0; i < 3; i++) {{\n        state->bias[i] = {name}_begin[i][0];\n        \
         state->variance[i] = {name}_begin[i][1];\n    }}\n}}\n\n\
         /* One sampling period passes. */\n\
         static inline void {name}_predict({name}_state *state, int axis)\n{{\n    \
         const {real} *k = {name}_coefficients[axis];\n    \
         state->bias[axis] = k[0] * state->bias[axis];\n    \
         state->variance[axis] = k[1] + k[0] * state->variance[axis] * k[0];\n}}\n\n\
         /* A sample at which the true acceleration is known: gravity at rest, or zero. */\n\
         static inline void {name}_update({name}_state *state, int axis, {real} measured, {real} known)\n{{\n    \
         const {real} r = {name}_coefficients[axis][2], p = state->variance[axis];\n    \
         const {real} gain = p * ({one} / (p + r));\n    \
         state->bias[axis] += gain * (measured - known - state->bias[axis]);\n    \
         state->variance[axis] = gain * r;\n}}\n",
        one = s.n(1.0)
    );
    Step {
        begin: format!("{name}_state state;\n    {name}_init(&state);"),
        result: format!(
            "({name}_predict(&state, 0), {name}_update(&state, 0, first[step], second[step]), state.bias[0])"
        ),
    }
}

/// With an offset, it is the third state and begins as that.
fn kalman<const N: usize>(
    c: &mut String,
    s: &Style<'_>,
    filter: &SteadyKalman<f64, N>,
    offset: Option<f64>,
) -> Step {
    let (name, real) = (s.name, s.real);
    let read = filter.component;
    *c += &s.constant("f", &format!("[{N}][{N}]"), &s.rows(&filter.f));
    *c += "/* Of the last acceleration, this one, and the one before the last. */\n";
    *c += &s.constant("g", &format!("[3][{N}]"), &s.rows(&filter.g));
    *c += &s.constant("gain", &format!("[{N}]"), &s.row(&filter.k));
    if let Some(offset) = offset {
        *c += "/* Offset of the accelerometer in the recording: init begins with it, nothing is subtracted before. */\n";
        *c += &s.constant("offset", "", &s.n(offset));
    }
    let what = if read == 0 { "position" } else { "speed" };
    let _ = writeln!(
        c,
        "\n/* x: position, velocity{offset}. */\ntypedef struct {{\n    {real} x[{N}], acceleration[2];\n}} {name}_state;\n\n\
         static inline void {name}_init({name}_state *state, {real} position, {real} velocity, {real} acceleration)\n{{\n    \
         int i;\n    for (i = 0; i < {N}; i++)\n        state->x[i] = {zero};\n    \
         state->x[0] = position;\n    state->x[1] = velocity;\n{begin}    \
         state->acceleration[0] = state->acceleration[1] = acceleration;\n}}\n\n\
         /* One sample, with a {what} where one was read; returns the velocity. */\n\
         static inline {real} {name}_step({name}_state *state, int has_reading, {real} reading, {real} acceleration)\n{{\n    \
         {real} x[{N}];\n    int i, k;\n    \
         for (i = 0; i < {N}; i++) {{\n        \
         x[i] = {name}_g[0][i] * state->acceleration[0] + {name}_g[1][i] * acceleration + {name}_g[2][i] * state->acceleration[1];\n        \
         for (k = 0; k < {N}; k++)\n            x[i] += {name}_f[i][k] * state->x[k];\n    }}\n    \
         if (has_reading) {{\n        const {real} innovation = reading - x[{read}];\n        \
         for (i = 0; i < {N}; i++)\n            x[i] += {name}_gain[i] * innovation;\n    }}\n    \
         for (i = 0; i < {N}; i++)\n        state->x[i] = x[i];\n    \
         state->acceleration[1] = state->acceleration[0];\n    state->acceleration[0] = acceleration;\n    \
         return x[1];\n}}\n",
        offset = offset.map_or("", |_| ", offset of the accelerometer"),
        begin = offset.map_or(String::new(), |_| format!(
            "    state->x[2] = {name}_offset;\n"
        )),
        zero = s.n(0.0)
    );
    Step {
        begin: format!(
            "{name}_state state;\n    {name}_init(&state, {z}, {z}, {z});",
            z = s.n(0.0)
        ),
        result: format!("{name}_step(&state, 1, first[step], second[step])"),
    }
}

fn observer(c: &mut String, s: &Style<'_>, coefficients: &[f64; 5]) -> Step {
    let (name, real) = (s.name, s.real);
    *c += "/* k_x, k_v, k_b, half the sample time, and 1/(1 + h (k_x + h (k_v + h k_b))). */\n";
    *c += &s.constant("coefficients", "[5]", &s.row(coefficients));
    let _ = writeln!(
        c,
        "\ntypedef struct {{\n    {real} position, velocity, offset, error, acceleration;\n}} {name}_state;\n\n\
         static inline void {name}_init({name}_state *state, {real} position, {real} velocity, {real} acceleration)\n{{\n    \
         state->position = position;\n    state->velocity = velocity;\n    \
         state->offset = state->error = {zero};\n    state->acceleration = acceleration;\n}}\n\n\
         /* Velocity at the time of these readings. */\n\
         static inline {real} {name}_step({name}_state *state, {real} position, {real} acceleration)\n{{\n    \
         const {real} k_x = {name}_coefficients[0], k_v = {name}_coefficients[1], k_b = {name}_coefficients[2];\n    \
         const {real} h = {name}_coefficients[3], inverse = {name}_coefficients[4];\n    \
         const {real} e = state->error, input = acceleration + state->acceleration;\n    \
         const {real} b = state->offset - h * k_b * e;\n    \
         const {real} v = state->velocity + h * (input - b - state->offset + k_v * e);\n    \
         const {real} x = state->position + h * (v + state->velocity + k_x * e);\n    \
         const {real} difference = position - x, error = inverse * difference;\n    \
         state->offset = b - h * k_b * error;\n    \
         state->velocity = v + h * (k_v * error + h * k_b * error);\n    \
         state->position = x + (difference - error);\n    state->error = error;\n    state->acceleration = acceleration;\n    \
         return state->velocity;\n}}\n",
        zero = s.n(0.0)
    );
    fused(s)
}

fn two_channel(c: &mut String, s: &Style<'_>, coefficients: &[f64; 4]) -> Step {
    let (name, real) = (s.name, s.real);
    *c += "/* k1 + k2, k1 k2, half the sample time, and 1/(1 + h (k1 + k2) + h h k1 k2). */\n";
    *c += &s.constant("coefficients", "[4]", &s.row(coefficients));
    let _ = writeln!(
        c,
        "\ntypedef struct {{\n    {real} position, acceleration, velocity, z;\n}} {name}_state;\n\n\
         static inline void {name}_init({name}_state *state, {real} position, {real} velocity, {real} acceleration)\n{{\n    \
         state->position = position;\n    state->velocity = velocity;\n    \
         state->acceleration = acceleration;\n    state->z = {zero};\n}}\n\n\
         /* Velocity at the time of these readings. */\n\
         static inline {real} {name}_step({name}_state *state, {real} position, {real} acceleration)\n{{\n    \
         const {real} alpha = {name}_coefficients[0], beta = {name}_coefficients[1];\n    \
         const {real} h = {name}_coefficients[2], inverse = {name}_coefficients[3];\n    \
         const {real} step = position - state->position, v = state->velocity;\n    \
         const {real} z = state->z + beta * (step - h * v);\n    \
         const {real} drive = acceleration + state->acceleration - alpha * v + z + state->z;\n    \
         const {real} velocity = inverse * (v + alpha * step + h * drive);\n    \
         state->position = position;\n    state->acceleration = acceleration;\n    \
         state->velocity = velocity;\n    state->z = z - beta * h * velocity;\n    \
         return velocity;\n}}\n",
        zero = s.n(0.0)
    );
    fused(s)
}

fn fused(s: &Style<'_>) -> Step {
    let name = s.name;
    Step {
        begin: format!(
            "{name}_state state;\n    {name}_init(&state, {z}, {z}, {z});",
            z = s.n(0.0)
        ),
        result: format!("{name}_step(&state, first[step], second[step])"),
    }
}

fn encoder_map(c: &mut String, s: &Style<'_>, turn: f64, lines: &[[f64; 3]]) -> Step {
    let (name, real) = (s.name, s.real);
    let count = lines.len();
    *c += &s.constant("turn", "", &s.n(turn));
    if count > 0 {
        *c += "/* Cycles per turn, cosine, sine. */\n";
        *c += &s.constant("lines", &format!("[{count}][3]"), &s.rows(lines));
    }
    // Powers of an eighth of a turn: the next one is below 10^-17.
    let sine = [
        -6.0,
        120.0,
        -5040.0,
        362_880.0,
        -39_916_800.0,
        6_227_020_800.0,
        -1_307_674_368_000.0,
    ];
    let cosine = [
        -2.0,
        24.0,
        -720.0,
        40_320.0,
        -3_628_800.0,
        479_001_600.0,
        -87_178_291_200.0,
        20_922_789_888_000.0,
    ];
    let series = |terms: &[f64]| -> String {
        let mut text = s.n(1.0 / terms[terms.len() - 1]);
        for term in terms.iter().rev().skip(1) {
            text = format!("({} + square * {text})", s.n(1.0 / term));
        }
        format!("({} + square * {text})", s.n(1.0))
    };
    let body = if count == 0 {
        format!("    (void)reading;\n    return {};\n", s.n(0.0))
    } else {
        format!(
            "    const {real} turns = reading / {name}_turn;\n    {real} sum = {zero};\n    int i;\n    \
             for (i = 0; i < {count}; i++)\n        sum += {name}_line({name}_lines[i][0] * turns, {name}_lines[i][1], {name}_lines[i][2]);\n    \
             return sum;\n",
            zero = s.n(0.0)
        )
    };
    if count > 0 {
        let _ = writeln!(
            c,
            "\n/* cosine and sine of an angle in turns, without a library. */\n\
             static inline {real} {name}_line({real} turns, {real} cosine, {real} sine)\n{{\n    \
             const {real} half = turns < {zero} ? {minus} : {plus};\n    \
             const {real} part = turns - ({real})(long long)(turns + half);\n    \
             const int quarter = (int)({four} * part + (part < {zero} ? {minus} : {plus}));\n    \
             const {real} angle = {tau} * (part - {quarter_turn} * ({real})quarter), square = angle * angle;\n    \
             const {real} si = angle * {si};\n    \
             const {real} co = {co};\n    \
             switch (quarter & 3) {{\n    case 0:\n        return cosine * co + sine * si;\n    \
             case 1:\n        return sine * co - cosine * si;\n    \
             case 2:\n        return -cosine * co - sine * si;\n    \
             default:\n        return cosine * si - sine * co;\n    }}\n}}",
            zero = s.n(0.0),
            minus = s.n(-0.5),
            plus = s.n(0.5),
            four = s.n(4.0),
            tau = s.n(std::f64::consts::TAU),
            quarter_turn = s.n(0.25),
            si = series(&sine),
            co = series(&cosine)
        );
    }
    let _ = writeln!(
        c,
        "\n/* What the encoder shows too much at a reading. */\n\
         static inline {real} {name}_error({real} reading)\n{{\n{body}}}\n\n\
         static inline {real} {name}_correct({real} reading)\n{{\n    return reading - {name}_error(reading);\n}}\n"
    );
    Step {
        begin: String::new(),
        result: format!("{name}_error(first[step])"),
    }
}

fn self_check(
    c: &mut String,
    s: &Style<'_>,
    vectors: &Vectors,
    step: &Step,
    block: &FirmwareBlock,
) {
    let (name, real) = (s.name, s.real);
    let count = vectors.first.len();
    let _ = writeln!(
        c,
        "/* 0 when all steps agree within {}, else the number of the first that does not. */\nstatic inline int {name}_self_check(void)\n{{",
        literal(vectors.bound, true)
    );
    let mut vector = |label: &str, values: &[f64]| {
        let _ = writeln!(
            c,
            "    static const {real} {label}[{count}] = {};",
            s.row(values)
        );
    };
    vector("first", &vectors.first);
    if block.takes_two() {
        vector("second", &vectors.second);
    }
    vector("expected", &vectors.expected);
    let begin = if step.begin.is_empty() {
        String::new()
    } else {
        format!("    {}\n", step.begin)
    };
    let _ = writeln!(
        c,
        "    int step;\n{begin}    for (step = 0; step < {count}; step++) {{\n        \
         const {real} e = {} - expected[step];\n        \
         if (!(e <= {bound} && e >= -{bound}))\n            return step + 1;\n    }}\n    return 0;\n}}\n",
        step.result,
        bound = s.n(vectors.bound)
    );
}
