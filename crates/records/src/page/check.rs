//! What a check found.

use crate::check::{Check, Difference, Recomputed};
use proofmass_report::{Field, Report, Rounding, Section, Table};

/// What is damaged is listed up to this number.
const SHOWN: usize = 12;

/// What a check found.
pub fn check(check: &Check) -> Report {
    let mut section = Section::new("Damage");
    for line in check.damage.iter().take(SHOWN) {
        section = section.paragraph(line.clone());
    }
    if check.damage.len() > SHOWN {
        section = section.paragraph(format!(
            "And {} more, which JSON has.",
            check.damage.len() - SHOWN
        ));
    }
    let page = Report::new("Check of the records")
        .question(match check.damage.len() {
            0 => format!(
                "The records are whole: {} entries, {} files, {} signatures.",
                check.entries, check.files, check.signatures
            ),
            1 => "One thing is not as it was filed.".to_owned(),
            n => format!("{n} things are not as they were filed."),
        })
        .meta("digest of the last entry", check.head.clone());
    match check.is_whole() {
        true => page,
        false => page.section(section.summarised()),
    }
}

/// What came of computing a result again.
pub fn recomputed(result: i64, found: &Recomputed) -> Report {
    let page = Report::new(format!("Result {result} computed again"));
    let table = |quantities: &[Difference]| {
        let fields = [
            Field::shown("quantity", "", |d: &Difference| d.name.as_str().into()),
            Field::shown("stored", "", |d: &Difference| d.values[0].into())
                .rounded(Rounding::Significant(8)),
            Field::shown("now", "", |d: &Difference| d.values[1].into())
                .rounded(Rounding::Significant(8)),
            Field::shown("unit", "", |d: &Difference| d.unit.as_str().into()),
            Field::shown("difference / U", "", |d: &Difference| d.share.into())
                .rounded(Rounding::TwoDigits),
            Field::shown("judgement", "", |d: &Difference| {
                if d.is_within() {
                    "within U"
                } else {
                    "BEYOND U"
                }
                .into()
            }),
        ];
        Section::new("Quantities")
            .table(Table::of("", fields, quantities))
            .summarised()
    };
    match found {
        Recomputed::Same => page.question("The same version gives the same bytes."),
        Recomputed::Differs { quantities } => page
            .question("The same version gives OTHER bytes.")
            .section(table(quantities)),
        Recomputed::OtherVersion {
            version,
            quantities,
        } => {
            let beyond = quantities.iter().filter(|d| !d.is_within()).count();
            page.question(format!(
                "Computed by {version}; {beyond} of {} quantities now differ by more than their U.",
                quantities.len()
            ))
            .section(table(quantities))
        }
        Recomputed::NotPossible { why } => {
            page.question(format!("It cannot be computed again: {why}."))
        }
    }
}
