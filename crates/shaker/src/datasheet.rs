//! A sensitivity against the value on its datasheet.

mod triaxial;

pub use triaxial::{Datasheet, Promise, SheetBand, SheetDeviation, SheetSensitivity, kept};

use crate::findings;
use proofmass_core::STANDARD_GRAVITY;
use proofmass_uncertainty::{Finding, Severity};

/// How far one sensitivity is from its datasheet value.
#[derive(Clone, Debug, PartialEq)]
pub struct OffDatasheet {
    /// What stands before the number where there are several: an axis.
    pub name: Option<String>,
    /// Value over that of the datasheet, less one.
    pub relative: f64,
    /// Tolerance of the datasheet and U together, as a share of its value.
    pub allowed: f64,
}

/// Departure beyond which, and multiple of what tolerance and U allow beyond which, the tolerance is not the reason.
const FAR: (f64, f64) = (0.15, 1.5);
/// Multiple of tolerance and U together, and least departure, that no device has either.
const MANY: (f64, f64) = (3.0, 0.02);

impl OffDatasheet {
    /// By more than tolerance and U together.
    pub fn is_beyond(&self) -> bool {
        self.relative.abs() > self.allowed
    }

    /// By so much that something else than the device must be the reason.
    pub fn is_far(&self) -> bool {
        let off = self.relative.abs();
        let far = off > FAR.0.max(FAR.1 * self.allowed.min(0.4));
        let many = off > MANY.1.max(MANY.0 * self.allowed);
        self.is_beyond() && (far || many)
    }

    /// A slip of units or gain that explains the ratio, to within 2 % or what tolerance and U allow, a tenth at most.
    pub fn probable_cause(&self) -> Option<&'static str> {
        const G: f64 = STANDARD_GRAVITY;
        let ratio = 1.0 + self.relative;
        let within = self.allowed.clamp(0.02, 0.1);
        [
            (G, "the datasheet value is per m/s² and was stated per g, or acceleration was read in g that is in m/s²: the ratio is that of g, 9.80665"),
            (1.0 / G, "the datasheet value is per g and was stated per m/s², or acceleration was read in m/s² that is in g: the ratio is that of g, 1/9.80665"),
            (1e3, "a prefix milli is missing or too many: the ratio is 1000"),
            (1e-3, "a prefix milli is missing or too many: the ratio is 1/1000"),
            (100.0, "a percentage stands where a fraction is expected, or a gain of 100 was left out: the ratio is 100"),
            (0.01, "a percentage stands where a fraction is expected, or a gain of 100 was counted twice: the ratio is 1/100"),
            (10.0 , "a gain of 10 was left out: the ratio is 10"),
            (0.1, "a gain of 10 was counted twice: the ratio is 1/10"),
        ]
        .into_iter()
        .map(|(factor, words)| ((ratio / factor - 1.0).abs(), words))
        .filter(|(off, _)| *off <= within)
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, words)| words)
    }

    fn in_words(&self) -> String {
        let name = self.name.iter().map(|n| format!("{n} "));
        let percent = 100.0 * self.relative;
        let number = match percent.abs() {
            p if p < 1000.0 => format!("{percent:+.1} %"),
            _ => format!("{:.4} times", 1.0 + self.relative),
        };
        name.chain([number]).collect()
    }
}

/// Sensitivities at one frequency that are not those of the datasheet: a decision where one is far off, else a warning. `None` where all
/// are within tolerance and U.
pub fn off_datasheet(frequency: f64, all: &[OffDatasheet]) -> Option<Finding> {
    let off: Vec<&OffDatasheet> = all.iter().filter(|o| o.is_beyond()).collect();
    let words: Vec<String> = off.iter().map(|o| o.in_words()).collect();
    let worst = off
        .iter()
        .max_by(|a, b| a.relative.abs().total_cmp(&b.relative.abs()))?;
    let what = format!(
        "the sensitivity at {frequency} Hz is off its datasheet value: {}",
        words.join(", ")
    );
    Some(finding(&what, worst))
}

fn finding(what: &str, worst: &OffDatasheet) -> Finding {
    let far = worst.is_far();
    let cause = worst.probable_cause().filter(|_| far);
    let remedy = match cause {
        Some(cause) => format!("the probable cause: {cause}"),
        None => {
            "check gains, cables and the unit of the datasheet; near a resonance it does not hold"
                .to_owned()
        }
    };
    findings::off_datasheet(what, 100.0 * worst.allowed, &remedy).at(match far {
        true => Severity::Decision,
        false => Severity::Warning,
    })
}

/// One sensitivity over frequency that is not that of the datasheet, by the frequencies (Hz) that it is off by one factor at. At the
/// frequency nearest to 160 Hz, where datasheets are made, it may be a decision; elsewhere, where a resonance may be near, it is a warning.
pub fn off_datasheet_over_frequency(mut all: Vec<(f64, OffDatasheet)>) -> Vec<Finding> {
    let away = |f: f64| (f / 160.0).ln().abs();
    all.sort_by(|a, b| away(a.0).total_cmp(&away(b.0)));
    let first = all.first().map(|f| f.0);
    let mut groups: Vec<Vec<(f64, OffDatasheet)>> = Vec::new();
    for (frequency, off) in all.into_iter().filter(|(_, o)| o.is_beyond()) {
        let same = |g: &&mut Vec<(f64, OffDatasheet)>| {
            ((1.0 + off.relative) / (1.0 + g[0].1.relative) - 1.0).abs() < 0.05
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push((frequency, off)),
            None => groups.push(vec![(frequency, off)]),
        }
    }
    groups
        .into_iter()
        .filter_map(|mut group| {
            let usual = Some(group[0].0) == first;
            group.sort_by(|a, b| a.0.total_cmp(&b.0));
            let worst = group
                .iter()
                .map(|g| &g.1)
                .max_by(|a, b| a.relative.abs().total_cmp(&b.relative.abs()))?;
            let found = finding(&sentence(&group), worst);
            Some(match usual {
                true => found,
                // Near a resonance the datasheet does not hold.
                false => found.at(Severity::Warning),
            })
        })
        .collect()
}

/// `the sensitivity is 19.0 % above its datasheet value at 80, 160 and 1000 Hz`.
fn sentence(group: &[(f64, OffDatasheet)]) -> String {
    let all = || group.iter().map(|g| g.1.relative);
    let (least, most) = (
        all().fold(f64::INFINITY, f64::min),
        all().fold(f64::NEG_INFINITY, f64::max),
    );
    let names: Vec<String> = group.iter().map(|g| g.0.to_string()).collect();
    let at = match names.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => names.join(""),
    };
    let number = |r: f64| match r {
        r if r >= 9.0 => format!("{:.4} times", 1.0 + r),
        r => format!("{:.1} %", 100.0 * r.abs()),
    };
    let side = match most {
        r if r >= 9.0 => "",
        r if r > 0.0 => " above",
        _ => " below",
    };
    let (near, far) = match most > 0.0 {
        true => (number(least), number(most)),
        false => (number(most), number(least)),
    };
    let size = match near == far {
        true => far,
        false => format!("{near} to {far}"),
    };
    format!("the sensitivity is {size}{side} its datasheet value at {at} Hz")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn off(ratio: f64, allowed: f64) -> OffDatasheet {
        OffDatasheet {
            name: None,
            relative: ratio - 1.0,
            allowed,
        }
    }

    #[test]
    fn known_slips_are_named_and_others_are_not() {
        for (ratio, word) in [
            (9.80665, "9.80665"),
            (0.104, "1/9.80665"),
            (1010.0, "1000"),
            (0.000_99, "1/1000"),
            (101.0, "percentage"),
            (10.03, "gain of 10"),
        ] {
            let cause = off(ratio, 0.01).probable_cause();
            assert!(cause.is_some_and(|c| c.contains(word)), "{ratio} {cause:?}");
        }
        for ratio in [1.0, 0.8, 1.3, 2.0, 5.0, 9.5, 12.0, 0.2] {
            assert_eq!(off(ratio, 0.01).probable_cause(), None, "{ratio}");
        }
    }

    #[test]
    fn known_sentence_over_frequency() {
        let all = [80.0, 160.0, 1000.0].map(|f| (f, off(1.19, 0.05)));
        let found = off_datasheet_over_frequency(all.to_vec());
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].severity(), Severity::Decision);
        assert_eq!(
            found[0].what(),
            "the sensitivity is 19.0 % above its datasheet value at 80, 160 and 1000 Hz"
        );
        // A resonance above the usual frequency is a warning.
        let all = vec![(160.0, off(1.0, 0.05)), (3000.0, off(1.4, 0.05))];
        let found = off_datasheet_over_frequency(all);
        assert_eq!(found[0].severity(), Severity::Warning);
    }

    #[test]
    fn known_sizes_of_the_finding() {
        assert!(off_datasheet(160.0, &[off(1.04, 0.05)]).is_none());
        let near = off_datasheet(160.0, &[off(1.08, 0.05)]).unwrap();
        assert_eq!(
            (near.code(), near.severity()),
            ("off-datasheet", Severity::Warning)
        );
        let far = off_datasheet(160.0, &[off(1.01, 0.05), off(0.104, 0.05)]).unwrap();
        assert_eq!(
            (far.code(), far.severity()),
            ("off-datasheet", Severity::Decision)
        );
        assert!(far.what().contains("-89.6 %"), "{}", far.what());
        assert!(
            far.advice_text().contains("1/9.80665"),
            "{}",
            far.advice_text()
        );
    }
}
