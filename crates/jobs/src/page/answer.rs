//! The answer of a page: quantities as a reader expects them, always with U and what it rests on.

use proofmass_core::STANDARD_GRAVITY;
use proofmass_documents::StatedQuantity;
use proofmass_report::number::{minus, rounded, scientific};
use proofmass_report::{KeyFigure, Report};
use proofmass_uncertainty::superscript;
use std::f64::consts::{PI, SQRT_2};

/// Quantities that open a page where its job names none.
const FIRST: usize = 6;

/// The page with its answer first: where the job named no numbers, the first of its quantities; where it has no verdict, the
/// first of them as a sentence.
pub(crate) fn answer_first(page: Report, quantities: &[StatedQuantity]) -> Report {
    let page = match page.answer.figures.is_empty() {
        true => page.answers(quantities.iter().take(FIRST).map(stated)),
        false => page,
    };
    let page = match quantities.first() {
        Some(q) if page.answer.verdict.is_empty() => {
            page.verdict(format!("{} is {}.", capital(&label(&q.name)), with_unit(q)))
        }
        _ => page,
    };
    page.answer_first()
}

/// A quantity with U, k and its size in the unit of the trade.
pub(crate) fn stated(q: &StatedQuantity) -> KeyFigure {
    stated_as(&label(&q.name), q)
}

/// The same by another name.
pub(crate) fn stated_as(name: &str, q: &StatedQuantity) -> KeyFigure {
    noted(name, q, None)
}

/// The same, with where it comes from.
pub(crate) fn stated_by(q: &StatedQuantity, by: &str) -> KeyFigure {
    noted(&label(&q.name), q, Some(format!("by {by}")))
}

fn noted(name: &str, q: &StatedQuantity, more: Option<String>) -> KeyFigure {
    let mut notes = vec![match (q.k, q.interval) {
        _ if q.expanded == 0.0 => "taken as known".to_owned(),
        (Some(k), _) => format!("k = {k:.2}, {}", percent(q.probability)),
        (None, Some([low, high])) => {
            let [low, high] = [low, high].map(|end| limit(end, 0.5 * (high - low)));
            format!("{} from {low} to {high}", percent(q.probability))
        }
        (None, None) => percent(q.probability),
    }];
    notes.extend(in_the_trade(q.value, q.expanded, &q.unit));
    notes.extend(more);
    KeyFigure::new(name, plus_minus(q.value, q.expanded), q.unit.clone()).note(notes.join("; "))
}

/// A label at the head of a sentence; a symbol stays as it is.
fn capital(label: &str) -> String {
    let word = label.split(' ').next().unwrap_or_default();
    match label.chars().next() {
        Some(first) if word.len() > 2 && word.chars().all(|c| c.is_ascii_lowercase()) => {
            first.to_uppercase().chain(label.chars().skip(1)).collect()
        }
        _ => label.to_owned(),
    }
}

/// `5.02 ± 0.04 m/s` with k or the probability, for a sentence.
pub(crate) fn with_unit(q: &StatedQuantity) -> String {
    let factor = q.k.map_or(String::new(), |k| format!("k = {k:.2}, "));
    let unit = match q.unit.as_str() {
        "" | "1" => String::new(),
        unit => format!(" {unit}"),
    };
    format!(
        "{}{unit} ({factor}{})",
        minus(&plus_minus(q.value, q.expanded)),
        percent(q.probability)
    )
}

/// Value ± U, both to two digits of U, under one power of ten where that is shorter.
pub(crate) fn plus_minus(value: f64, expanded: f64) -> String {
    if !(expanded > 0.0 && expanded.is_finite()) {
        return scientific(value, 4);
    }
    // Digits beyond the tenth are no measurement: what is exact but for rounding says so by its U.
    if expanded < 1e-10 * value.abs() {
        return format!("{} ± {}", scientific(value, 10), scientific(expanded, 2));
    }
    let (value, expanded, power) = digits(value, expanded);
    match power {
        0 => format!("{value} ± {expanded}"),
        power => format!("({} ± {expanded})×10{}", minus(&value), superscript(power)),
    }
}

/// An end of an interval, to two digits of half its width.
fn limit(end: f64, half: f64) -> String {
    if !(half >= 1e-10 * end.abs() && half > 0.0 && half.is_finite()) {
        return scientific(end, 10);
    }
    match digits(end, half) {
        (end, _, 0) => minus(&end),
        (end, _, power) => format!("{}×10{}", minus(&end), superscript(power)),
    }
}

/// A value and its U to two digits of U, and the power of ten that both are to be multiplied by, zero where that is no shorter.
fn digits(value: f64, expanded: f64) -> (String, String, i32) {
    let largest = value.abs().max(expanded);
    let exponent = largest.log10().floor();
    let plain = (-3.0..6.0).contains(&exponent) && expanded.log10() < 3.0;
    let power = if plain { 0.0 } else { exponent };
    let scale = 10f64.powf(-power);
    let (value, expanded) = rounded(value * scale, expanded * scale);
    (value, expanded, power as i32)
}

/// `95 %`, without zeros that say nothing.
fn percent(probability: f64) -> String {
    let text = format!("{:.2}", 100.0 * probability);
    format!("{} %", text.trim_end_matches('0').trim_end_matches('.'))
}

/// A dotted name as it is read: `S.xx.modulus[frequency=160]` is S xx modulus at 160 Hz.
pub(crate) fn label(name: &str) -> String {
    let (name, place) = name.split_once('[').unwrap_or((name, ""));
    let place = place.trim_end_matches(']');
    let place = match place.split_once('=') {
        Some(("frequency", f)) => format!(" at {f} Hz"),
        Some((what, value)) => format!(", {what} {value}"),
        None => String::new(),
    };
    let words = name.split(['.', '_']).map(|word| match word {
        "arias" => "Arias",
        "rms" => "RMS",
        word => word,
    });
    format!("{}{place}", words.collect::<Vec<_>>().join(" "))
}

/// Units in which data sheets and navigators state what SI has in m/s² and rad/s.
const TRADE: [(&str, &[(&str, f64)]); 8] = [
    ("m/s²", &[("mg", 1e3 / STANDARD_GRAVITY)]),
    (
        "(m/s²)/√Hz",
        // Data sheets state the one-sided density; N itself is two-sided.
        &[
            ("µg/√Hz one-sided", SQRT_2 * 1e6 / STANDARD_GRAVITY),
            ("m/s/√h", 60.0),
        ],
    ),
    ("(m/s²)·√Hz", &[("mg/√h", 60.0 * 1e3 / STANDARD_GRAVITY)]),
    ("m/s²/K", &[("mg/K", 1e3 / STANDARD_GRAVITY)]),
    ("rad", &[("°", 180.0 / PI)]),
    ("rad/s", &[("°/h", 3600.0 * 180.0 / PI)]),
    ("(rad/s)/√Hz", &[("°/√h", 60.0 * 180.0 / PI)]),
    ("(rad/s)·√Hz", &[("°/h/√h", 60.0 * 3600.0 * 180.0 / PI)]),
];

/// The size in other units with its expanded uncertainty, where there is none with three digits.
pub(crate) fn in_the_trade(value: f64, expanded: f64, unit: &str) -> Vec<String> {
    let known = TRADE.iter().find(|(si, _)| *si == unit);
    let others = known.map_or(&[][..], |(_, others)| *others);
    let size = |(name, factor): &(&str, f64)| {
        let (name, factor) = match *name {
            "mg" if (value * factor).abs() >= 1e3 => ("g", 1e-3 * factor),
            name => (name, *factor),
        };
        let text = match expanded > 0.0 {
            true => plus_minus(value * factor, expanded * factor),
            false => scientific(value * factor, 3),
        };
        format!("{} {name}", minus(&text))
    };
    others.iter().map(size).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_uncertainty::{DegreesOfFreedom, Quantity};

    #[test]
    fn known_ends_of_an_interval_differ_as_it_is_wide() {
        assert_eq!(limit(49_986_000.0, 14_000.0), "4.9986×10⁷");
        assert_eq!(limit(50_014_000.0, 14_000.0), "5.0014×10⁷");
        assert_eq!(limit(-0.0312, 0.0014), "−0.0312");
        assert_eq!(limit(2.0, 0.0), scientific(2.0, 10));
    }

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
                "k = 1.96, 95 %; −3.18 ± 0.28 mg"
            )
        );
        // 1 mg/√Hz two-sided is 9.80665e-3 (m/s²)/√Hz, √2 mg/√Hz one-sided and 0.588 m/s/√h.
        assert_eq!(
            of("x.N", "(m/s²)/√Hz", 9.80665e-3, 1e-5),
            figure(
                "x N",
                "0.009807 ± 0.000020",
                "(m/s²)/√Hz",
                "k = 1.96, 95 %; 1414.2 ± 2.8 µg/√Hz one-sided; 0.5884 ± 0.0012 m/s/√h"
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
        assert_eq!(
            in_the_trade(2.0 * STANDARD_GRAVITY, 0.0, "m/s²"),
            ["2.00 g"]
        );
        assert_eq!(plus_minus(0.0, 0.0), "0");
        assert_eq!(plus_minus(2842.451, 0.0), "2842", "no U, few digits");
        // A clock that is exact but for rounding.
        assert_eq!(plus_minus(100.0, 9.4e-17), "100.0000000 ± 9.4×10⁻¹⁷");
    }
}
