//! A C99 header in integers.

use super::Plan;
use proofmass_core::{FixedPoint, FixedRange, TEMPERATURE_BITS};
use proofmass_io::{Error, ErrorKind, Result};
use proofmass_signal::AnyCompensation;
use std::fmt::Write;

pub(super) fn text(plan: &Plan<'_>, range: FixedRange) -> Result<String> {
    let AnyCompensation::ThreeAxes(model) = &plan.model else {
        return Err(super::unable(
            "integers are written for three axes, the calibration has one",
            "choose single precision: one axis takes three multiplications",
        ));
    };
    let fixed = FixedPoint::new(model, range).map_err(|e| {
        Error::new(
            ErrorKind::Configuration,
            format!("the model does not fit into integers: {e}"),
        )
        .with_hint("choose single precision, or a smaller range of outputs")
        .because(e)
    })?;
    let name = &plan.name;
    let guard = format!("{}_H", name.to_ascii_uppercase());
    let row = |v: &[i32]| {
        let cells: Vec<String> = v.iter().map(i32::to_string).collect();
        format!("{{{}}}", cells.join(", "))
    };
    let rows = |m: &[[i32; 3]; 3]| {
        let rows: Vec<String> = m.iter().map(|r| format!("    {}", row(r))).collect();
        format!("{{\n{}\n}}", rows.join(",\n"))
    };
    let mut c = String::from("/*\n");
    for line in plan.heading() {
        let _ = writeln!(c, " * {line}");
    }
    let [x, y, z] = fixed.bound;
    let _ = writeln!(
        c,
        " * C99 integers, no allocation. Acceleration = result / 2^{bits} m/s^2, within\n * {x:.2e}, {y:.2e}, {z:.2e} m/s^2 \
         (x, y, z) of exact arithmetic for every output from {low} to {high}.\n \
         * {name}_self_check() returns 0 when this compiler computes what the desk computed.\n */",
        bits = fixed.result_bits,
        low = fixed.outputs[0][0],
        high = fixed.outputs[0][1],
    );
    let _ = writeln!(
        c,
        "#ifndef {guard}\n#define {guard}\n\n#include <stdint.h>\n\n#define {upper}_RESULT_BITS {}",
        fixed.result_bits,
        upper = name.to_ascii_uppercase()
    );
    let _ = writeln!(
        c,
        "\n/* value / 2^shift to the nearest, halves away from zero */\nstatic inline int64_t {name}_rounded(int64_t value, int shift)\n{{\n    \
         const int64_t half = (INT64_C(1) << shift) >> 1;\n    \
         return value >= 0 ? (value + half) >> shift : -((half - value) >> shift);\n}}\n"
    );
    let bias: Vec<String> = fixed.bias.iter().map(|b| format!("INT64_C({b})")).collect();
    let _ = writeln!(
        c,
        "static const int32_t {name}_k_inverse[3][3] = {}; /* / 2^{} */",
        rows(&fixed.matrix),
        fixed.matrix_bits
    );
    let _ = writeln!(
        c,
        "static const int64_t {name}_bias[3] = {{{}}}; /* / 2^{} */",
        bias.join(", "),
        fixed.signal_bits
    );
    if let Some(thermal) = &fixed.thermal {
        let _ = writeln!(
            c,
            "/* Powers 1 to 3 of z = (T - T0) * 2^{} / 2^30, per axis. */",
            thermal.shift
        );
        let _ = writeln!(
            c,
            "static const int32_t {name}_bias_t[3][3] = {}; /* / 2^{} */",
            rows(&thermal.bias),
            fixed.signal_bits
        );
        let _ = writeln!(
            c,
            "static const int32_t {name}_scale_t[3][3] = {}; /* / 2^30 */",
            rows(&thermal.scale)
        );
        let _ = writeln!(
            c,
            "\nstatic inline int64_t {name}_power_sum(const int32_t c[3], int64_t z)\n{{\n    \
             const int64_t inner = c[1] + {name}_rounded(c[2] * z, 30);\n    \
             return {name}_rounded((c[0] + {name}_rounded(inner * z, 30)) * z, 30);\n}}"
        );
    }
    if let Some(curvature) = &fixed.curvature {
        let _ = writeln!(
            c,
            "/* x (1 + k2 x + k3 x^2) = y, x / 2^29. */\nstatic const int32_t {name}_k2[3] = {}; /* / 2^30 */\n\
             static const int32_t {name}_k3[3] = {}; /* / 2^30 */\n\n\
             static inline int64_t {name}_straightened(int64_t y, int64_t a, int64_t b)\n{{\n    \
             int64_t x = y;\n    int step;\n    for (step = 0; step < 3; step++) {{\n        \
             const int64_t bend = {name}_rounded((a + {name}_rounded(b * x, 29)) * x, 29);\n        \
             const int64_t slope = (INT64_C(1) << 30) + {name}_rounded((2 * a + {name}_rounded(3 * b * x, 29)) * x, 29);\n        \
             x -= (x + {name}_rounded(x * bend, 30) - y) * (INT64_C(1) << 30) / slope;\n    }}\n    return x;\n}}",
            row(&curvature.quadratic),
            row(&curvature.cubic)
        );
    }
    let temperature = if fixed.thermal.is_some() {
        "int32_t temperature, "
    } else {
        ""
    };
    let _ = writeln!(
        c,
        "\n/* Returns 1, or 0 where an output{} lies outside its range: acceleration is then left as it was. */\n\
         static inline int {name}_apply(const int32_t output[3], {temperature}int32_t acceleration[3])\n{{\n    \
         int64_t v[3];\n    int i;\n    for (i = 0; i < 3; i++) {{\n        \
         if (output[i] < INT32_C({low}) || output[i] > INT32_C({high}))\n            return 0;\n        \
         v[i] = output[i] * (INT64_C(1) << {bits}) - {name}_bias[i];\n    }}",
        if fixed.thermal.is_some() {
            format!(
                " or, unless {} is defined, the temperature (in 1/{} degC)",
                super::c::hold_switch(name),
                1 << TEMPERATURE_BITS
            )
        } else {
            String::new()
        },
        low = fixed.outputs[0][0],
        high = fixed.outputs[0][1],
        bits = fixed.signal_bits,
    );
    if let Some(thermal) = &fixed.thermal {
        let _ = writeln!(
            c,
            "{}    const int64_t z = ((int64_t)temperature - {}) * (INT64_C(1) << {});\n    \
             for (i = 0; i < 3; i++) {{\n        v[i] -= {name}_power_sum({name}_bias_t[i], z);\n        \
             v[i] = v[i] * (INT64_C(1) << 30) / ((INT64_C(1) << 30) + {name}_power_sum({name}_scale_t[i], z));\n    }}",
            super::c::outside(
                name,
                &thermal.range[0].to_string(),
                &thermal.range[1].to_string()
            ),
            thermal.reference,
            thermal.shift
        );
    }
    if fixed.curvature.is_some() {
        let _ = writeln!(
            c,
            "    for (i = 0; i < 3; i++)\n        v[i] = {name}_straightened(v[i], {name}_k2[i], {name}_k3[i]);"
        );
    }
    let shift = fixed.signal_bits + fixed.matrix_bits - fixed.result_bits;
    let _ = writeln!(
        c,
        "    for (i = 0; i < 3; i++) {{\n        const int32_t *r = {name}_k_inverse[i];\n        \
         acceleration[i] = (int32_t){name}_rounded(r[0] * v[0] + r[1] * v[1] + r[2] * v[2], {shift});\n    }}\n    return 1;\n}}\n"
    );
    self_check(&mut c, plan, &fixed, &row);
    let _ = writeln!(c, "#endif");
    Ok(c)
}

/// Integers agree to the last bit, or not at all.
fn self_check(c: &mut String, plan: &Plan<'_>, fixed: &FixedPoint, row: &dyn Fn(&[i32]) -> String) {
    let name = &plan.name;
    let scale = f64::from(1u32 << TEMPERATURE_BITS);
    let mut lines = Vec::new();
    for (output, t) in plan.check.outputs.iter().zip(&plan.check.temperatures) {
        let output: [i32; 3] = std::array::from_fn(|i| output[i] as i32);
        // The ends of the range lie between two steps of the temperature.
        let mut t = (t * scale).round() as i32;
        if let Some(thermal) = &fixed.thermal {
            t = t.clamp(thermal.range[0], thermal.range[1]);
        }
        if let Some(a) = fixed.apply(output, t) {
            lines.push(row(&[output[0], output[1], output[2], t, a[0], a[1], a[2]]));
        }
    }
    let argument = if fixed.thermal.is_some() {
        "r[3], "
    } else {
        ""
    };
    let _ = writeln!(
        c,
        "/* 0 when all vectors agree to the last bit, else the number of the first that does not. */\n\
         static inline int {name}_self_check(void)\n{{\n    \
         /* output x, y, z, temperature, acceleration x, y, z */\n    \
         static const int32_t vectors[{count}][7] = {{\n        {list}\n    }};\n    \
         int v, i;\n    for (v = 0; v < {count}; v++) {{\n        const int32_t *r = vectors[v];\n        int32_t a[3];\n        \
         if (!{name}_apply(r, {argument}a))\n            return v + 1;\n        \
         for (i = 0; i < 3; i++)\n            if (a[i] != r[4 + i])\n                return v + 1;\n    }}\n    return 0;\n}}\n",
        count = lines.len(),
        list = lines.join(",\n        "),
    );
}
