//! A sensitivity against the value on its datasheet.

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

/// Beyond this no tolerance of a sensitivity is the reason.
const FAR: f64 = 0.2;

impl OffDatasheet {
    /// By more than tolerance and U together.
    pub fn is_beyond(&self) -> bool {
        self.relative.abs() > self.allowed
    }

    /// By so much that something else than the device must be the reason.
    pub fn is_far(&self) -> bool {
        self.is_beyond() && self.relative.abs() > FAR.max(2.0 * self.allowed.min(0.4))
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
    let far = worst.is_far();
    let cause = worst.probable_cause().filter(|_| far);
    let remedy = match cause {
        Some(cause) => format!("the probable cause: {cause}"),
        None => {
            "check gains, cables and the unit of the datasheet; near a resonance it does not hold"
                .to_owned()
        }
    };
    let finding =
        findings::off_datasheet(frequency, &words.join(", "), 100.0 * worst.allowed, &remedy);
    Some(finding.at(if far {
        Severity::Decision
    } else {
        Severity::Warning
    }))
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
