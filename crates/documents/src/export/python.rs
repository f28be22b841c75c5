//! A Python module.

use super::Plan;
use std::fmt::Write;

pub(super) fn text(plan: &Plan<'_>) -> String {
    let n = |v: f64| format!("{v:e}");
    // A tuple of one has a comma too.
    let tuple = |items: Vec<String>| match items.as_slice() {
        [one] => format!("({one},)"),
        _ => format!("({})", items.join(", ")),
    };
    let row = |v: &[f64]| tuple(v.iter().map(|v| n(*v)).collect());
    let rows = |m: &[Vec<f64>]| tuple(m.iter().map(|r| row(r)).collect());
    let powers = |m: &[[f64; 3]]| tuple(m.iter().map(|r| row(r)).collect());
    let axes = plan.model.axes();
    let (arguments, axis_words, outputs, result, called) = match axes {
        1 => (
            "output",
            ["", ""],
            "(output,)",
            "K_INVERSE[0][0] * v[0]",
            ["(", ",)"],
        ),
        _ => (
            "x, y, z",
            ["x, y, z ", "s"],
            "(x, y, z)",
            "tuple(r[0] * v[0] + r[1] * v[1] + r[2] * v[2] for r in K_INVERSE)",
            ["", ""],
        ),
    };
    let [named, plural] = axis_words;
    let mut text = String::from("\"\"\"");
    for line in plan.heading() {
        let plain = line.replace('\\', "/").replace('"', "'");
        let _ = writeln!(text, "{plain}");
    }
    text.push_str("\nWithout dependencies; numbers and arrays alike. `python FILE` checks itself.\n\"\"\"\n\n");
    let _ = writeln!(text, "K_INVERSE = {}", rows(&plan.model.k_inverse()));
    let _ = writeln!(text, "BIAS = {}", row(&plan.model.bias()));
    if let Some(terms) = &plan.file.temperature {
        let _ = writeln!(
            text,
            "T0 = {}\nBIAS_T = {}\nSCALE_T = {}",
            n(terms.reference),
            powers(&terms.bias),
            powers(&terms.scale)
        );
    }
    if let Some(block) = &plan.file.temperature {
        let _ = writeln!(
            text,
            "TEMPERATURE_RANGE = ({}, {})",
            n(block.range[0]),
            n(block.range[1])
        );
    }
    if let Some(terms) = &plan.file.curvature {
        let k = plan.model.k();
        let diagonal: Vec<f64> = (0..axes).map(|i| k[i][i]).collect();
        let _ = writeln!(
            text,
            "K_DIAGONAL = {}\nK2 = {}\nK3 = {}",
            row(&diagonal),
            row(&terms.quadratic),
            row(&terms.cubic)
        );
    }
    let temperature = if plan.needs_temperature() {
        ", temperature, hold=False"
    } else {
        ""
    };
    let outside = if plan.needs_temperature() {
        "    low, high = TEMPERATURE_RANGE\n    \
         if hold:\n        \
         temperature = temperature.clip(low, high) if hasattr(temperature, \"clip\") else min(max(temperature, low), high)\n    \
         for t in getattr(temperature, \"flat\", (temperature,)):\n        if not low <= t <= high:\n            \
         raise ValueError(f\"{t} degC is beyond the calibration, {low} to {high} degC\")\n"
    } else {
        ""
    };
    let _ = writeln!(
        text,
        "\n\ndef apply({arguments}{temperature}):\n    \"\"\"Acceleration {named}in m/s^2 from the output{plural}{}\"\"\"\n{outside}    v = []\n    \
         for axis, output in enumerate({outputs}):\n        value = output - BIAS[axis]",
        if plan.needs_temperature() {
            " and the temperature in degC.\n\n    \
             A temperature beyond TEMPERATURE_RANGE is a ValueError, or taken as the nearer end of it with hold=True.\n    "
        } else {
            "."
        }
    );
    if plan.needs_temperature() {
        text.push_str(
            "        d = temperature - T0\n        b, s = BIAS_T[axis], SCALE_T[axis]\n        \
             value = (value - d * (b[0] + d * (b[1] + d * b[2]))) / (1.0 + d * (s[0] + d * (s[1] + d * s[2])))\n",
        );
    }
    if plan.file.curvature.is_some() {
        text.push_str(
            "        y_ = value / K_DIAGONAL[axis]\n        k2, k3 = K2[axis], K3[axis]\n        x_ = y_\n        \
             for _ in range(3):\n            \
             x_ = x_ - (x_ * (1.0 + x_ * (k2 + x_ * k3)) - y_) / (1.0 + x_ * (2.0 * k2 + 3.0 * k3 * x_))\n        \
             value = K_DIAGONAL[axis] * x_\n",
        );
    }
    let _ = writeln!(text, "        v.append(value)\n    return {result}");
    let check = &plan.check;
    let [before, behind] = called;
    let list = |rows: &[Vec<f64>]| {
        let rows: Vec<String> = rows.iter().map(|r| row(r)).collect();
        rows.join(",\n        ")
    };
    let temperatures: Vec<String> = check.temperatures.iter().map(|t| n(*t)).collect();
    let argument = if plan.needs_temperature() { ", t" } else { "" };
    let _ = writeln!(
        text,
        "\n\ndef self_check():\n    \"\"\"None, or the number of the first vector that comes out otherwise than on the desk.\"\"\"\n    \
         outputs = (\n        {},\n    )\n    temperatures = ({},)\n    expected = (\n        {},\n    )\n    \
         for number, (o, t, e) in enumerate(zip(outputs, temperatures, expected)):\n        \
         a = {before}apply(*o{argument}){behind}\n        \
         if not all(abs(p - q) <= {} for p, q in zip(a, e)):\n            return number\n    return None\n\n\n\
         if __name__ == \"__main__\":\n    number = self_check()\n    if number is not None:\n        \
         raise SystemExit(f\"vector {{number}} does not agree\")\n    print(\"all vectors agree\")",
        list(&check.outputs),
        temperatures.join(", "),
        list(&check.accelerations),
        n(check.double_bound),
    );
    text
}
