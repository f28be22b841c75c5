//! The units that are understood, as a page.

use proofmass_io::Unit;
use proofmass_uncertainty::unit_symbols;
use std::fmt::Write as _;

/// The page of all units, `docs/units.md`.
pub fn page() -> String {
    let mut page = String::from(
        "# Units\n\n\
         What is understood as a unit, and what it is in SI units. Words are explained in the [glossary](glossary.md).\n\n\
         ## Of recordings, tables and options\n\n\
         In headings (`acc_x_g`, `acc_x (mg)`), in `units` of a campaign and in options such as `--unit`. Blanks and `^` do not count, `²` is `2`, `µ` is `u`;\n\
         capitals count. In a heading some letters are more often the name of a channel (`A`, `C`, `F`, `G`, `K`, `m`, `N`, `1`, `-`, `raw`, `adc`): there they are no unit unless\n\
         they stand in brackets. Here `g` is standard gravity, 9.80665 m/s².\n\n\
         | unit | is | in names of columns | also read |\n|---|---|---|---|\n",
    );
    for unit in Unit::all() {
        let (si, factor) = unit.si();
        let is = match unit {
            Unit::Count => {
                "a number out of a converter, whose size only a calibration knows".to_owned()
            }
            Unit::One => "a pure number".to_owned(),
            Unit::DegreeFahrenheit => "read as °C".to_owned(),
            Unit::Kelvin => "read as °C where a temperature is meant".to_owned(),
            _ if si == unit => String::new(),
            _ => format!("{factor} {si}"),
        };
        let aliases: Vec<String> = unit.aliases().iter().map(|a| format!("`{a}`")).collect();
        let _ = writeln!(
            page,
            "| {unit} | {is} | `{}` | {} |",
            unit.ascii(),
            aliases.join(", ")
        );
    }
    page += "\n## Of models and budgets\n\n\
         In `unit` of an input or output of [a model](uncertainty.md), where units are multiplied, divided and raised: `mV/(m/s²)`, `kg·m^-3`, `1/°C`. A blank, `·` or `*` multiplies. Here `g` is the gram; standard\n\
         gravity is `gn`. Prefixes are those of the SI from a (10⁻¹⁸) to Y (10²⁴), with `u` for `µ`. Any other text is a label: it is printed, and takes no part in the check of units.\n\n\
         | symbol | is | with prefixes |\n|---|---|---|\n";
    for unit in unit_symbols() {
        let prefixes = if unit.prefixes { "yes" } else { "" };
        let _ = writeln!(
            page,
            "| `{}` | {} {} | {prefixes} |",
            unit.symbol, unit.factor, unit.coherent
        );
    }
    page
}
