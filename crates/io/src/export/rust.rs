//! A constant for `proofmass-core`.

use super::{ExportNumber, Plan, literal};
use std::fmt::Write;

pub(super) fn text(plan: &Plan<'_>, number: ExportNumber) -> String {
    let single = number != ExportNumber::Double;
    let real = if single { "f32" } else { "f64" };
    let n = |v: f64| literal(v, single);
    let row = |v: &[f64; 3]| format!("[{}, {}, {}]", n(v[0]), n(v[1]), n(v[2]));
    let rows = |m: &[[f64; 3]; 3]| format!("[{}, {}, {}]", row(&m[0]), row(&m[1]), row(&m[2]));
    let sensor = plan.model.sensor();
    let name = plan.name.to_ascii_uppercase();
    let mut text = String::new();
    for line in plan.heading() {
        let _ = writeln!(text, "//! {line}");
    }
    let linear = plan.model.thermal().is_none() && plan.model.curvature().is_none();
    let constant = format!(
        "SensorModel::constant(\n    Matrix3({}),\n    Matrix3({}),\n    {},\n)",
        rows(&sensor.k().0),
        rows(&sensor.k_inverse().0),
        row(&sensor.bias())
    );
    let mut uses = vec!["Matrix3", "SensorModel"];
    let (kind, value) = if linear {
        ("SensorModel", constant)
    } else {
        uses.insert(0, "Compensation");
        let thermal = plan.model.thermal().map_or("None".to_owned(), |t| {
            uses.push("ThermalTerms");
            format!(
                "Some(ThermalTerms {{\n    reference: {},\n    range: [{}, {}],\n    bias: {},\n    scale: {},\n}})",
                n(t.reference),
                n(t.range[0]),
                n(t.range[1]),
                rows(&t.bias),
                rows(&t.scale)
            )
        });
        let curvature = plan.model.curvature().map_or("None".to_owned(), |c| {
            uses.insert(1, "Curvature");
            format!(
                "Some(Curvature {{ quadratic: {}, cubic: {} }})",
                row(&c.quadratic),
                row(&c.cubic)
            )
        });
        (
            "Compensation",
            format!("Compensation::constant({constant}, {thermal}, {curvature})"),
        )
    };
    let _ = writeln!(text, "\nuse proofmass_core::{{{}}};\n", uses.join(", "));
    let _ = writeln!(
        text,
        "/// Compensation of the sensor; K, its inverse and b, nothing is computed at start-up.\npub const {name}: {kind}<{real}> = {value};\n"
    );
    if plan.needs_temperature() {
        let _ = writeln!(
            text,
            "/// Acceleration in m/s²; nothing where the temperature lies beyond the calibration. [`{name}`]`.apply` takes such a temperature\n\
             /// as the nearer end of it.\npub fn apply(output: [{real}; 3], temperature: {real}) -> Option<[{real}; 3]> {{\n    \
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
    let list = |rows: &[[f64; 3]]| {
        let rows: Vec<String> = rows.iter().map(row).collect();
        rows.join(",\n        ")
    };
    let temperatures: Vec<String> = check.temperatures.iter().map(|t| n(*t)).collect();
    let call = if linear {
        "apply(output)"
    } else {
        "apply(output, temperature)"
    };
    let temperature = if linear { "_" } else { "temperature" };
    let _ = writeln!(
        text,
        "/// Number of the first vector that this compiler computes otherwise than the desk did.\npub fn self_check() -> Option<usize> {{\n    \
         const OUTPUTS: [[{real}; 3]; {count}] = [\n        {}\n    ];\n    \
         const TEMPERATURES: [{real}; {count}] = [{}];\n    \
         const EXPECTED: [[{real}; 3]; {count}] = [\n        {}\n    ];\n    \
         for vector in 0..{count} {{\n        \
         let (output, {temperature}) = (OUTPUTS[vector], TEMPERATURES[vector]);\n        \
         let a = {name}.{call};\n        \
         for axis in 0..3 {{\n            let e = a[axis] - EXPECTED[vector][axis];\n            \
         if !(-{bound}..={bound}).contains(&e) {{\n                return Some(vector);\n            }}\n        }}\n    }}\n    None\n}}\n\n\
         #[cfg(test)]\nmod tests {{\n    #[test]\n    fn law_the_constant_computes_what_the_desk_computed() {{\n        \
         assert_eq!(super::self_check(), None);\n    }}\n}}",
        list(&check.outputs),
        temperatures.join(", "),
        list(&check.accelerations),
        count = check.outputs.len(),
        bound = n(bound),
    );
    text
}
