//! A constant for `proofmass-core`.

use super::{ExportNumber, Plan, literal};
use std::fmt::Write;

pub(super) fn text(plan: &Plan<'_>, number: ExportNumber) -> String {
    let single = number != ExportNumber::Double;
    let real = if single { "f32" } else { "f64" };
    let n = |v: f64| literal(v, single);
    let list = |items: Vec<String>| format!("[{}]", items.join(", "));
    let row = |v: &[f64]| list(v.iter().map(|v| n(*v)).collect());
    let rows = |m: &[Vec<f64>]| list(m.iter().map(|r| row(r)).collect());
    let powers = |m: &[[f64; 3]]| list(m.iter().map(|r| row(r)).collect());
    // One axis takes and gives a number, three an array.
    let one = plan.model.axes() == 1;
    let vector = if one {
        real.to_owned()
    } else {
        format!("[{real}; 3]")
    };
    let value = |v: &[f64]| if one { n(v[0]) } else { row(v) };
    let name = plan.name.to_ascii_uppercase();
    let mut text = String::new();
    for line in plan.heading() {
        let _ = writeln!(text, "//! {line}");
    }
    let linear = !one && plan.file.temperature.is_none() && plan.file.curvature.is_none();
    let matrices = || {
        format!(
            "SensorModel::constant(\n    Matrix3({}),\n    Matrix3({}),\n    {},\n)",
            rows(&plan.model.k()),
            rows(&plan.model.k_inverse()),
            row(&plan.model.bias())
        )
    };
    let (kind, mut uses, constant) = match (one, linear) {
        (true, _) => (
            "AxisCompensation",
            vec!["AxisCompensation"],
            format!("{}, {}", n(plan.model.k()[0][0]), n(plan.model.bias()[0])),
        ),
        (_, true) => ("SensorModel", vec!["Matrix3", "SensorModel"], matrices()),
        (_, false) => (
            "Compensation",
            vec!["Compensation", "Matrix3", "SensorModel"],
            matrices(),
        ),
    };
    let constant = if linear {
        constant
    } else {
        let thermal = plan.file.temperature.as_ref().map_or("None".to_owned(), |t| {
            uses.push("ThermalTerms");
            format!(
                "Some(ThermalTerms {{\n    reference: {},\n    range: [{}, {}],\n    bias: {},\n    scale: {},\n}})",
                n(t.reference),
                n(t.range[0]),
                n(t.range[1]),
                powers(&t.bias),
                powers(&t.scale)
            )
        });
        let curvature = plan.file.curvature.as_ref().map_or("None".to_owned(), |c| {
            uses.insert(1, "Curvature");
            format!(
                "Some(Curvature {{ quadratic: {}, cubic: {} }})",
                row(&c.quadratic),
                row(&c.cubic)
            )
        });
        format!("{kind}::constant({constant}, {thermal}, {curvature})")
    };
    let held = if one {
        "k and b"
    } else {
        "K, its inverse and b"
    };
    let _ = writeln!(text, "\nuse proofmass_core::{{{}}};\n", uses.join(", "));
    let _ = writeln!(
        text,
        "/// Compensation of the sensor; {held}, nothing is computed at start-up.\npub const {name}: {kind}<{real}> = {constant};\n"
    );
    if plan.needs_temperature() {
        let _ = writeln!(
            text,
            "/// Acceleration in m/s²; nothing where the temperature lies beyond the calibration. [`{name}`]`.apply` takes such a temperature\n\
             /// as the nearer end of it.\npub fn apply(output: {vector}, temperature: {real}) -> Option<{vector}> {{\n    \
             let covered = {name}.thermal().is_none_or(|terms| terms.covers(temperature));\n    \
             covered.then(|| {name}.apply(output, temperature))\n}}\n"
        );
    }
    let check = &plan.check;
    let bound = if single {
        check.single_bound
    } else {
        check.double_bound
    };
    let list = |rows: &[Vec<f64>]| {
        let rows: Vec<String> = rows.iter().map(|r| value(r)).collect();
        rows.join(",\n        ")
    };
    let temperatures: Vec<String> = check.temperatures.iter().map(|t| n(*t)).collect();
    let call = if linear {
        "apply(output)"
    } else {
        "apply(output, temperature)"
    };
    let temperature = if linear { "_" } else { "temperature" };
    let bound = n(bound);
    let comparison = if one {
        format!(
            "let e = a - EXPECTED[vector];\n        if !(-{bound}..={bound}).contains(&e) {{\n            return Some(vector);\n        }}"
        )
    } else {
        format!(
            "for axis in 0..3 {{\n            let e = a[axis] - EXPECTED[vector][axis];\n            \
             if !(-{bound}..={bound}).contains(&e) {{\n                return Some(vector);\n            }}\n        }}"
        )
    };
    let _ = writeln!(
        text,
        "/// Number of the first vector that this compiler computes otherwise than the desk did.\npub fn self_check() -> Option<usize> {{\n    \
         const OUTPUTS: [{vector}; {count}] = [\n        {}\n    ];\n    \
         const TEMPERATURES: [{real}; {count}] = [{}];\n    \
         const EXPECTED: [{vector}; {count}] = [\n        {}\n    ];\n    \
         for vector in 0..{count} {{\n        \
         let (output, {temperature}) = (OUTPUTS[vector], TEMPERATURES[vector]);\n        \
         let a = {name}.{call};\n        \
         {comparison}\n    }}\n    None\n}}\n\n\
         #[cfg(test)]\nmod tests {{\n    #[test]\n    fn law_the_constant_computes_what_the_desk_computed() {{\n        \
         assert_eq!(super::self_check(), None);\n    }}\n}}",
        list(&check.outputs),
        temperatures.join(", "),
        list(&check.accelerations),
        count = check.outputs.len(),
    );
    text
}
