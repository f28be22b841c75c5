//! A C99 header in single or double precision.

use super::{ExportNumber, Plan, literal};
use std::fmt::Write;

pub(super) fn text(plan: &Plan<'_>, number: ExportNumber) -> String {
    let single = number == ExportNumber::Float;
    let real = if single { "float" } else { "double" };
    let n = |v: f64| literal(v, single) + if single { "f" } else { "" };
    let row = |v: &[f64]| {
        let cells: Vec<String> = v.iter().map(|v| n(*v)).collect();
        format!("{{{}}}", cells.join(", "))
    };
    let join = |rows: Vec<String>| format!("{{\n{}\n}}", rows.join(",\n"));
    let rows = |m: &[Vec<f64>]| join(m.iter().map(|r| format!("    {}", row(r))).collect());
    let powers = |m: &[[f64; 3]]| join(m.iter().map(|r| format!("    {}", row(r))).collect());
    let axes = plan.model.axes();
    let name = &plan.name;
    let guard = format!("{}_H", name.to_ascii_uppercase());
    let mut c = String::new();
    let _ = writeln!(c, "/*");
    for line in plan.heading() {
        let _ = writeln!(c, " * {line}");
    }
    let _ = writeln!(
        c,
        " * C99, no library, no allocation. {name}_self_check() returns 0 when this compiler computes what the desk computed."
    );
    let _ = writeln!(c, " */\n#ifndef {guard}\n#define {guard}\n");
    let _ = writeln!(
        c,
        "static const {real} {name}_k_inverse[{axes}][{axes}] = {};",
        rows(&plan.model.k_inverse())
    );
    let _ = writeln!(
        c,
        "static const {real} {name}_bias[{axes}] = {};",
        row(&plan.model.bias())
    );
    if let Some(terms) = &plan.file.temperature {
        let _ = writeln!(
            c,
            "/* Powers 1 to 3 of T - T0, per axis. */\nstatic const {real} {name}_t0 = {};",
            n(terms.reference)
        );
        let _ = writeln!(
            c,
            "static const {real} {name}_bias_t[{axes}][3] = {};",
            powers(&terms.bias)
        );
        let _ = writeln!(
            c,
            "static const {real} {name}_scale_t[{axes}][3] = {};",
            powers(&terms.scale)
        );
    }
    if let Some(terms) = &plan.file.curvature {
        let k = plan.model.k();
        let diagonal: Vec<f64> = (0..axes).map(|i| k[i][i]).collect();
        let _ = writeln!(
            c,
            "static const {real} {name}_k_diagonal[{axes}] = {};",
            row(&diagonal)
        );
        let _ = writeln!(
            c,
            "static const {real} {name}_k2[{axes}] = {};\nstatic const {real} {name}_k3[{axes}] = {};",
            row(&terms.quadratic),
            row(&terms.cubic)
        );
    }
    function(&mut c, plan, real, &n);
    self_check(&mut c, plan, real, single, &row, &n);
    let _ = writeln!(c, "#endif");
    c
}

/// The macro with which a temperature beyond the calibration is taken as the nearer end of it.
pub(super) fn hold_switch(name: &str) -> String {
    format!("{}_HOLD_TEMPERATURE", name.to_ascii_uppercase())
}

/// What is done with a temperature outside two literals; one that is no number is outside.
pub(super) fn outside(name: &str, low: &str, high: &str) -> String {
    format!(
        "#ifdef {}\n    if (temperature < {low})\n        temperature = {low};\n    else if (temperature > {high})\n        temperature = {high};\n#endif\n    \
         if (!(temperature >= {low} && temperature <= {high}))\n        return 0;\n",
        hold_switch(name)
    )
}

/// The beginning of the function that applies what was read from a memory, up to the temperature.
pub(super) fn outside_of_a_memory(name: &str) -> String {
    let within = outside(name, "c->low", "c->high");
    let within = within.lines().map(|line| match line.starts_with('#') {
        true => format!("{line}\n"),
        false => format!("    {line}\n"),
    });
    let within: String = within.collect();
    format!(
        "\n/* Acceleration in m/s^2. Returns 1, or 0 where the temperature, in degC, lies beyond the calibration: acceleration is then left as it was.\n   \
         A calibration without temperature does not look at it. With {} defined before the header is included, such a temperature\n   \
         is taken as the nearer end of the calibration. */\n\
         static inline int {name}_apply(const {name}_t *c, const float *output, float temperature, float *acceleration)\n{{\n    \
         float v[3] = {{0.0f, 0.0f, 0.0f}}, d = 0.0f;\n    int i;\n    if (c->has_temperature) {{\n{}    ",
        hold_switch(name),
        within
    )
}

fn function(c: &mut String, plan: &Plan<'_>, real: &str, n: &dyn Fn(f64) -> String) {
    let (name, axes) = (&plan.name, plan.model.axes());
    let (result, temperature) = if plan.needs_temperature() {
        ("int", format!("{real} temperature, "))
    } else {
        ("void", String::new())
    };
    let comment = if plan.needs_temperature() {
        format!(
            "/* Acceleration in m/s^2. Returns 1, or 0 where the temperature lies beyond the calibration: acceleration is then left as it was.\n   \
             With {} defined before the header is included, such a temperature is taken as the nearer end of the calibration. */",
            hold_switch(name)
        )
    } else {
        "/* Acceleration in m/s^2. */".to_owned()
    };
    let _ = writeln!(
        c,
        "\n{comment}\nstatic inline {result} {name}_apply(const {real} output[{axes}], {temperature}{real} acceleration[{axes}])\n{{"
    );
    let _ = writeln!(c, "    {real} v[{axes}];\n    int i;");
    if let Some(block) = &plan.file.temperature {
        let (low, high) = (n(block.range[0]), n(block.range[1]));
        let _ = writeln!(c, "    {real} d;");
        c.push_str(&outside(name, &low, &high));
        let _ = writeln!(c, "    d = temperature - {name}_t0;");
    }
    let _ = writeln!(c, "    for (i = 0; i < {axes}; i++) {{");
    let _ = writeln!(c, "        v[i] = output[i] - {name}_bias[i];");
    let one = n(1.0);
    if plan.needs_temperature() {
        let _ = writeln!(
            c,
            "        const {real} *b = {name}_bias_t[i], *s = {name}_scale_t[i];\n        \
             v[i] = (v[i] - d * (b[0] + d * (b[1] + d * b[2]))) / ({one} + d * (s[0] + d * (s[1] + d * s[2])));"
        );
    }
    if plan.file.curvature.is_some() {
        let _ = writeln!(
            c,
            "        const {real} y = v[i] / {name}_k_diagonal[i], k2 = {name}_k2[i], k3 = {name}_k3[i];\n        \
             {real} x = y;\n        int step;\n        \
             for (step = 0; step < 3; step++)\n            \
             x = x - (x * ({one} + x * (k2 + x * k3)) - y) / ({one} + x * ({} * k2 + {} * k3 * x));\n        \
             v[i] = {name}_k_diagonal[i] * x;",
            n(2.0),
            n(3.0)
        );
    }
    let products: Vec<String> = (0..axes).map(|j| format!("r[{j}] * v[{j}]")).collect();
    let _ = writeln!(
        c,
        "    }}\n    for (i = 0; i < {axes}; i++) {{\n        const {real} *r = {name}_k_inverse[i];\n        \
         acceleration[i] = {};\n    }}",
        products.join(" + ")
    );
    if plan.needs_temperature() {
        let _ = writeln!(c, "    return 1;");
    }
    let _ = writeln!(c, "}}\n");
}

fn self_check(
    c: &mut String,
    plan: &Plan<'_>,
    real: &str,
    single: bool,
    row: &dyn Fn(&[f64]) -> String,
    n: &dyn Fn(f64) -> String,
) {
    let (name, check, axes) = (&plan.name, &plan.check, plan.model.axes());
    let bound = if single {
        check.single_bound
    } else {
        check.double_bound
    };
    let _ = writeln!(
        c,
        "/* 0 when all vectors agree within {} m/s^2, else the number of the first that does not. */",
        literal(bound, true)
    );
    let _ = writeln!(c, "static inline int {name}_self_check(void)\n{{");
    let count = check.outputs.len();
    let list = |rows: Vec<String>| format!("{{\n        {}\n    }}", rows.join(",\n        "));
    let _ = writeln!(
        c,
        "    static const {real} output[{count}][{axes}] = {};",
        list(check.outputs.iter().map(|o| row(o)).collect())
    );
    if plan.needs_temperature() {
        let _ = writeln!(
            c,
            "    static const {real} temperature[{count}] = {};",
            row(&check.temperatures)
        );
    }
    let _ = writeln!(
        c,
        "    static const {real} expected[{count}][{axes}] = {};",
        list(check.accelerations.iter().map(|a| row(a)).collect())
    );
    let argument = if plan.needs_temperature() {
        "temperature[v], "
    } else {
        ""
    };
    let _ = writeln!(
        c,
        "    int v, i;\n    for (v = 0; v < {count}; v++) {{\n        {real} a[{axes}];\n        \
         {name}_apply(output[v], {argument}a);\n        for (i = 0; i < {axes}; i++) {{\n            \
         const {real} e = a[i] - expected[v][i];\n            \
         if (!(e <= {bound} && e >= -{bound}))\n                return v + 1;\n        }}\n    }}\n    return 0;\n}}\n",
        bound = n(bound)
    );
}
