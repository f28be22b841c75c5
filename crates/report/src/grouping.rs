//! Findings by line: alike ones are one line, the gravest first.

use crate::number::minus_signs;
use proofmass_uncertainty::{Finding, Severity};

/// Findings of one code and severity.
pub(crate) struct Group<'a> {
    /// What is doubtful, for all of them.
    pub(crate) line: String,
    /// The findings.
    pub(crate) members: Vec<&'a Finding>,
}

impl Group<'_> {
    /// How much they weigh.
    pub(crate) fn severity(&self) -> Severity {
        self.members[0].severity()
    }

    /// Their kind.
    pub(crate) fn code(&self) -> &str {
        self.members[0].code()
    }
}

/// The gravest first, else in their order.
pub(crate) fn groups(findings: &[Finding]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for finding in findings {
        let alike =
            |g: &&mut Group<'_>| g.code() == finding.code() && g.severity() == finding.severity();
        match groups.iter_mut().find(alike) {
            Some(group) => group.members.push(finding),
            None => groups.push(Group {
                line: String::new(),
                members: vec![finding],
            }),
        }
    }
    for group in &mut groups {
        group.line = minus_signs(line(&group.members));
    }
    groups.sort_by_key(|g| std::cmp::Reverse(g.severity()));
    groups
}

/// One sentence for all: of several parts of an answer their names and what is said of each.
fn line(members: &[&Finding]) -> String {
    let first = members[0].what();
    let parts: Option<Vec<(&str, &str)>> =
        members.iter().map(|f| f.what().split_once(": ")).collect();
    match (members.len(), parts) {
        (1, _) => first.to_owned(),
        (n, _) if members.iter().all(|f| f.what() == first) => format!("{first}, {n} times"),
        (_, Some(parts)) if parts.iter().all(|p| p.1 == parts[0].1) => {
            let names: Vec<&str> = parts.iter().map(|p| p.0).collect();
            format!("{}: {}", names.join(", "), parts[0].1)
        }
        (n, _) => format!("{first}, and {} more of this kind", n - 1),
    }
}

/// What the findings say of the result as a whole; alike ones count once, as they are one line.
pub(crate) fn standing(findings: &[Finding]) -> String {
    let groups = groups(findings);
    let of = |severity| groups.iter().filter(|g| g.severity() == severity).count();
    let counted = |severity, word: &str| match of(severity) {
        0 => None,
        1 => Some(format!("one {word}")),
        n => Some(format!("{n} {word}s")),
    };
    let decisions = of(Severity::Decision);
    let others = [
        counted(Severity::Warning, "warning"),
        counted(Severity::Note, "note"),
    ];
    let others: Vec<String> = others.into_iter().flatten().collect();
    let others = others.join(" and ");
    match (decisions, others.as_str()) {
        (0, "") => "Nothing was found that speaks against the result.".to_owned(),
        (0, others) if of(Severity::Warning) == 0 => format!("The result stands; {others}."),
        (0, others) => format!("The result stands with {others}."),
        (n, others) => {
            let what = match n {
                1 => "A decision is needed before the result is used".to_owned(),
                n => format!("{n} decisions are needed before the result is used"),
            };
            match others {
                "" => format!("{what}."),
                others => format!("{what}; {others} besides."),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    proofmass_uncertainty::findings! {
        CATALOGUE;

        /// The wheel slipped.
        slip(at: f64) = "slip", [Warning, Decision], what "the wheel slips at {at} s";

        /// Too short.
        short() = "short", [Note], what "the record is short";
    }

    #[test]
    fn law_alike_findings_are_one_line_and_the_gravest_comes_first() {
        assert_eq!(CATALOGUE.len(), 2);
        let three = [
            short().of_part("x"),
            slip(1.0),
            short().of_part("y"),
            slip(2.0),
            slip(3.0).at(Severity::Decision),
        ];
        let lines: Vec<String> = groups(&three).into_iter().map(|g| g.line).collect();
        assert_eq!(
            lines,
            [
                "the wheel slips at 3 s",
                "the wheel slips at 1 s, and 1 more of this kind",
                "x, y: the record is short",
            ]
        );
        let same = [short(), short(), short(), short()];
        assert_eq!(groups(&same)[0].line, "the record is short, 4 times");
        assert_eq!(
            standing(&three),
            "A decision is needed before the result is used; one warning and one note besides."
        );
        assert_eq!(
            standing(&three[..3]),
            "The result stands with one warning and one note."
        );
        assert_eq!(
            standing(&[]),
            "Nothing was found that speaks against the result."
        );
    }
}
