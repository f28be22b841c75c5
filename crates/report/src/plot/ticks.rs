//! Where an axis carries numbers: steps of 1, 2 and 5 on linear axes, decades on logarithmic ones.

use super::svg::power_of_ten;
use crate::number::minus;

/// Ticks of one axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ticks {
    /// Position in data units and label.
    pub(super) major: Vec<(f64, String)>,
    /// Positions without label.
    pub(super) minor: Vec<f64>,
    /// Power of ten that the labels leave to the axis label; 0 for none.
    pub(super) exponent: i32,
    /// Number that the labels leave to the axis label, as printed there.
    pub(super) offset: Option<String>,
    /// The same number, 0 for none.
    pub(super) base: f64,
}

impl Ticks {
    /// Ticks at these positions.
    pub(super) fn at(major: Vec<(f64, String)>) -> Self {
        Self {
            major,
            minor: Vec::new(),
            exponent: 0,
            offset: None,
            base: 0.0,
        }
    }
}

/// The smallest of 1, 2, 5 × 10ⁿ that is at least `raw`, as (mantissa, exponent).
fn round_step(raw: f64) -> (f64, i32) {
    let exponent = raw.log10().floor() as i32;
    let mantissa = raw / 10f64.powi(exponent);
    // A little slack: 2.0000000001 is a 2.
    for m in [1.0, 2.0, 5.0] {
        if mantissa <= m * (1.0 + 1e-9) {
            return (m, exponent);
        }
    }
    (1.0, exponent + 1)
}

/// `low` and `high` widened to a range that can be divided: equal or nearly equal ends are set apart.
pub(super) fn widened(low: f64, high: f64) -> (f64, f64) {
    let size = low.abs().max(high.abs());
    if high - low > 1e-12 * size && high - low > 1e-290 {
        return (low, high);
    }
    let half = if size < 1e-285 { 1.0 } else { 0.05 * size };
    (low - half, high + half)
}

/// Multiples of a step of 1, 2 or 5 × 10ⁿ inside the range, between 3 and `most` + 1 of them.
pub(super) fn linear(low: f64, high: f64, most: usize) -> Ticks {
    let (low, high) = widened(low, high);
    let slack = 1e-6;
    let ends = |(mantissa, exponent): (f64, i32)| {
        let step = mantissa * 10f64.powi(exponent);
        (
            (low / step - slack).ceil(),
            (high / step + slack).floor(),
            step,
        )
    };
    let mut round = round_step((high - low) / most.max(2) as f64);
    // The next finer step, where its multiples happen to be few enough as well.
    let finer = match round {
        (5.0, exponent) => (2.0, exponent),
        (2.0, exponent) => (1.0, exponent),
        (_, exponent) => (5.0, exponent - 1),
    };
    let (first, last, _) = ends(finer);
    if last - first <= most as f64 {
        round = finer;
    }
    let (mantissa, step_exponent) = round;
    let (first, last, step) = ends(round);
    let count = (last - first).clamp(0.0, 1000.0) as usize;
    let values: Vec<f64> = (0..=count).map(|i| (first + i as f64) * step).collect();
    let largest = low.abs().max(high.abs());
    let leading = largest.log10().floor() as i32;
    // Labels of more than seven digits are unreadable: what they share moves to the axis label.
    if leading - step_exponent >= 7 {
        let coarse = 10f64.powi(step_exponent + 2);
        let offset = (0.5 * (low + high) / coarse).round() * coarse;
        let mut inner = linear(low - offset, high - offset, most);
        for (value, _) in &mut inner.major {
            *value += offset;
        }
        for value in &mut inner.minor {
            *value += offset;
        }
        let decimals = (-(step_exponent + 2)).max(0) as usize;
        let printed = if (-6..15).contains(&leading) {
            minus(&format!("{offset:.decimals$}"))
        } else {
            crate::number::scientific(offset, (leading - step_exponent - 1).max(1) as usize)
        };
        inner.offset = Some(printed);
        inner.base = offset;
        return inner;
    }
    let exponent = if (-3..5).contains(&leading) {
        0
    } else {
        leading.div_euclid(3) * 3
    };
    let decimals = (exponent - step_exponent).max(0) as usize;
    let half = exponent / 2;
    let major = values
        .iter()
        .map(|&v| {
            let shown = v / 10f64.powi(half) / 10f64.powi(exponent - half);
            (v, minus(&format!("{shown:.decimals$}")))
        })
        .collect();
    let parts = if mantissa == 2.0 { 4.0 } else { 5.0 };
    let fine = step / parts;
    let minor_first = (low / fine - slack).ceil();
    let minor_count = ((high / fine + slack).floor() - minor_first).clamp(0.0, 1000.0) as usize;
    let minor = (0..=minor_count)
        .map(|i| minor_first + i as f64)
        .filter(|k| k % parts != 0.0)
        .map(|k| k * fine)
        .collect();
    Ticks {
        major,
        minor,
        exponent,
        offset: None,
        base: 0.0,
    }
}

/// Powers of ten inside the range, with 2 to 9 as minor ticks; 1, 2, 5 where few decades are spanned, and the
/// linear ticks where not even those are enough.
pub(super) fn logarithmic(low: f64, high: f64, most: usize) -> Ticks {
    let from = (low.log10() - 1e-9).ceil() as i32;
    let to = (high.log10() + 1e-9).floor() as i32;
    let inside = |v: f64| v >= low * (1.0 - 1e-9) && v <= high * (1.0 + 1e-9);
    let plain = from >= -3 && to <= 4;
    let label = |m: i32, e: i32| -> String {
        if plain {
            let decimals = (-e).max(0) as usize;
            format!("{:.decimals$}", f64::from(m) * 10f64.powi(e))
        } else if m == 1 {
            power_of_ten(e)
        } else {
            format!("{m}×{}", power_of_ten(e))
        }
    };
    let decades = (to - from + 1).max(0) as usize;
    let of = |mantissas: &[i32]| -> Vec<(f64, String)> {
        (from - 1..=to)
            .flat_map(|e| mantissas.iter().map(move |&m| (m, e)))
            .map(|(m, e)| (f64::from(m) * 10f64.powi(e), label(m, e)))
            .filter(|(v, _)| inside(*v))
            .collect()
    };
    let minors = || -> Vec<f64> {
        (from - 1..=to)
            .flat_map(|e| (2..10).map(move |m| f64::from(m) * 10f64.powi(e)))
            .filter(|&v| inside(v))
            .collect()
    };
    let mut ticks = Ticks {
        major: Vec::new(),
        minor: Vec::new(),
        exponent: 0,
        offset: None,
        base: 0.0,
    };
    if decades > most {
        let stride = decades.div_ceil(most) as i32;
        ticks.major = (from..=to)
            .filter(|e| e.rem_euclid(stride) == 0)
            .map(|e| (10f64.powi(e), label(1, e)))
            .collect();
        ticks.minor = (from..=to)
            .filter(|e| e.rem_euclid(stride) != 0)
            .map(|e| 10f64.powi(e))
            .collect();
    } else if decades >= 3 {
        ticks.major = of(&[1]);
        ticks.minor = minors();
    } else {
        ticks.major = of(&[1, 2, 5]);
        ticks.minor = minors();
        if ticks.major.len() < 3 {
            return linear(low, high, most);
        }
    }
    ticks
        .minor
        .retain(|v| !ticks.major.iter().any(|(m, _)| (m / v - 1.0).abs() < 1e-9));
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn law_linear_ticks_are_round_inside_and_few(
            centre in -1e6..1e6f64, exponent in -12..9i32, m in 1.0..10.0f64, most in 3usize..10,
        ) {
            let half = m * 10f64.powi(exponent);
            let (low, high) = widened(centre - half, centre + half);
            let ticks = linear(low, high, most);
            let n = ticks.major.len();
            // Steps grow by at most 2.5, so at least most/2.5 − 1 and at most `most` + 1 multiples fit.
            prop_assert!(n >= 1.max((most as f64 / 2.5).floor() as usize).saturating_sub(1));
            prop_assert!(n <= most + 1, "{n} ticks");
            let span = high - low;
            for w in ticks.major.windows(2) {
                let step = w[1].0 - w[0].0;
                prop_assert!(w[0].1 != w[1].1, "labels repeat: {:?}", w);
                // Differences near a large centre carry its rounding.
                let e = step.log10().floor();
                let mantissa = step / 10f64.powf(e);
                let rounding = 4.0 * f64::EPSILON * centre.abs() / step + 1e-9;
                prop_assert!([1.0, 2.0, 5.0, 10.0].iter().any(|r| (mantissa / r - 1.0).abs() < rounding.max(1e-6) * 10.0));
            }
            for (v, _) in &ticks.major {
                prop_assert!(*v >= low - 1e-5 * span && *v <= high + 1e-5 * span);
            }
        }

        #[test]
        fn law_logarithmic_ticks_lie_inside_and_are_few(from in -20.0..20.0f64, decades in 0.01..30.0f64, most in 4usize..12) {
            let (low, high) = (10f64.powf(from), 10f64.powf(from + decades));
            let ticks = logarithmic(low, high, most);
            prop_assert!(!ticks.major.is_empty());
            prop_assert!(ticks.major.len() <= (most + 1).max(9));
            for (v, _) in &ticks.major {
                prop_assert!(*v >= low * (1.0 - 1e-6) && *v <= high * (1.0 + 1e-6));
            }
        }
    }

    #[test]
    fn law_known_axes() {
        let labels = |t: Ticks| t.major.into_iter().map(|(_, l)| l).collect::<Vec<_>>();
        assert_eq!(
            labels(linear(0.0, 10.0, 5)),
            ["0", "2", "4", "6", "8", "10"]
        );
        assert_eq!(
            labels(linear(-1e-4, 1e-4, 4)),
            ["−100", "−50", "0", "50", "100"]
        );
        assert_eq!(linear(-1e-4, 1e-4, 4).exponent, -6);
        assert_eq!(
            labels(logarithmic(0.1, 100.0, 8)),
            ["0.1", "1", "10", "100"]
        );
        assert_eq!(
            linear(9.806_650_000_1, 9.806_650_000_9, 5)
                .offset
                .as_deref(),
            Some("9.80665000")
        );
    }
}
