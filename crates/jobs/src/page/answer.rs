//! The answer of a page: quantities as a reader expects them, always with U and what it rests on.

use proofmass_core::STANDARD_GRAVITY;
use proofmass_io::StatedQuantity;
use proofmass_report::number::{minus, rounded, scientific};
use proofmass_report::{KeyFigure, Report};
use proofmass_uncertainty::superscript;
use std::f64::consts::PI;

/// Quantities that open a page where its job names none.
const FIRST: usize = 6;

/// The page with its answer first: where the job named no numbers, the first of its quantities.
pub(crate) fn answer_first(page: Report, quantities: &[StatedQuantity]) -> Report {
    let page = match page.answer.figures.is_empty() {
        true => page.answers(quantities.iter().take(FIRST).map(stated)),
        false => page,
    };
    page.answer_first()
}

/// A quantity with U, k and its size in the unit of the trade.
pub(crate) fn stated(q: &StatedQuantity) -> KeyFigure {
    let mut notes = vec![match (q.k, q.interval) {
        _ if q.expanded == 0.0 => "exact".to_owned(),
        (Some(k), _) => format!("k = {k:.2}, {}", percent(q.probability)),
        (None, Some([low, high])) => format!(
            "{} from {} to {}",
            percent(q.probability),
            scientific(low, 4),
            scientific(high, 4)
        ),
        (None, None) => percent(q.probability),
    }];
    notes.extend(in_the_trade(q.value, &q.unit));
    KeyFigure::new(
        label(&q.name),
        plus_minus(q.value, q.expanded),
        q.unit.clone(),
    )
    .note(notes.join("; "))
}

/// `5.02 ± 0.04 m/s` with k or the probability, for a sentence.
pub(crate) fn with_unit(q: &StatedQuantity) -> String {
    let factor = q.k.map_or(String::new(), |k| format!("k = {k:.2}, "));
    format!(
        "{} {} ({factor}{})",
        minus(&plus_minus(q.value, q.expanded)),
        q.unit,
        percent(q.probability)
    )
}

/// Value ± U, both to two digits of U, under one power of ten where that is shorter.
pub(crate) fn plus_minus(value: f64, expanded: f64) -> String {
    if !(expanded > 0.0 && expanded.is_finite()) {
        return scientific(value, 6);
    }
    let largest = value.abs().max(expanded);
    let exponent = largest.log10().floor();
    let plain = (-3.0..6.0).contains(&exponent) && expanded.log10() < 3.0;
    let power = if plain { 0.0 } else { exponent };
    let scale = 10f64.powf(-power);
    let (value, expanded) = rounded(value * scale, expanded * scale);
    match power == 0.0 {
        true => format!("{value} ± {expanded}"),
        false => format!(
            "({} ± {expanded})×10{}",
            minus(&value),
            superscript(power as i32)
        ),
    }
}

/// `95 %`, without zeros that say nothing.
fn percent(probability: f64) -> String {
    let text = format!("{:.2}", 100.0 * probability);
    format!("{} %", text.trim_end_matches('0').trim_end_matches('.'))
}

/// A dotted name as it is read: `S.xx.modulus[frequency=160]` is S xx modulus at 160 Hz.
fn label(name: &str) -> String {
    let (name, place) = name.split_once('[').unwrap_or((name, ""));
    let place = place.trim_end_matches(']');
    let place = match place.split_once('=') {
        Some(("frequency", f)) => format!(" at {f} Hz"),
        Some((what, value)) => format!(", {what} {value}"),
        None => String::new(),
    };
    format!("{}{place}", name.replace(['.', '_'], " "))
}

/// Units in which data sheets and navigators state what SI has in m/s² and rad/s.
const TRADE: [(&str, &[(&str, f64)]); 6] = [
    ("m/s²", &[("mg", 1e3 / STANDARD_GRAVITY)]),
    (
        "(m/s²)/√Hz",
        &[("µg/√Hz", 1e6 / STANDARD_GRAVITY), ("m/s/√h", 60.0)],
    ),
    ("(m/s²)/K", &[("mg/K", 1e3 / STANDARD_GRAVITY)]),
    ("rad", &[("°", 180.0 / PI)]),
    ("rad/s", &[("°/h", 3600.0 * 180.0 / PI)]),
    ("(rad/s)/√Hz", &[("°/√h", 60.0 * 180.0 / PI)]),
];

/// The size in other units, with three digits.
pub(crate) fn in_the_trade(value: f64, unit: &str) -> Vec<String> {
    let known = TRADE.iter().find(|(si, _)| *si == unit);
    let others = known.map_or(&[][..], |(_, others)| *others);
    let size = |(name, factor): &(&str, f64)| match (*name, value * factor) {
        ("mg", mg) if mg.abs() >= 1e3 => format!("{} g", scientific(1e-3 * mg, 3)),
        (name, size) => format!("{} {name}", scientific(size, 3)),
    };
    others.iter().map(size).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_uncertainty::{DegreesOfFreedom, Quantity};

    #[test]
    fn known_quantities_with_u_k_and_the_unit_of_the_trade() {
        let of = |name: &str, unit: &str, value: f64, u: f64| {
            let quantity = Quantity {
                name: name.to_owned(),
                unit: unit.to_owned(),
                value,
                standard_uncertainty: u,
                dof: DegreesOfFreedom::INFINITE,
            };
            stated(&StatedQuantity::new(&quantity, 0.95))
        };
        let figure = |label: &str, value: &str, unit: &str, note: &str| {
            KeyFigure::new(label, value, unit).note(note)
        };
        assert_eq!(
            of("bias.x", "m/s²", -0.0312, 0.0014),
            figure(
                "bias x",
                "-0.0312 ± 0.0027",
                "m/s²",
                "k = 1.96, 95 %; −3.18 mg"
            )
        );
        // 1 mg/√Hz is 9.80665e-3 (m/s²)/√Hz and 0.588 m/s/√h.
        assert_eq!(
            of("x.N", "(m/s²)/√Hz", 9.80665e-3, 1e-5),
            figure(
                "x N",
                "0.009807 ± 0.000020",
                "(m/s²)/√Hz",
                "k = 1.96, 95 %; 1000 µg/√Hz; 0.588 m/s/√h"
            )
        );
        assert_eq!(
            of("S.xx.modulus[frequency=160]", "V/(m/s²)", 2.5e-5, 1e-7),
            figure(
                "S xx modulus at 160 Hz",
                "(2.500 ± 0.020)×10⁻⁵",
                "V/(m/s²)",
                "k = 1.96, 95 %"
            )
        );
        assert_eq!(in_the_trade(2.0 * STANDARD_GRAVITY, "m/s²"), ["2.00 g"]);
        assert_eq!(plus_minus(0.0, 0.0), "0");
    }
}
