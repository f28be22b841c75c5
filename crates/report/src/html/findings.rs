//! Findings on a page: one line each, evidence and advice folded behind it.

use super::{Page, marked};
use crate::grouping::groups;
use crate::number::minus_signs;
use crate::plot::escape;
use proofmass_uncertainty::{Finding, Severity};
use std::fmt::Write;

/// Of more lines than these, or of twice as many findings, paper has no details.
const MANY: usize = 6;

impl Page {
    pub(super) fn findings(&mut self, findings: &[Finding]) {
        let groups = groups(findings);
        if groups.is_empty() {
            return;
        }
        let many = match groups.len() > MANY || findings.len() > 2 * MANY {
            true => " many",
            false => "",
        };
        let _ = writeln!(self.out, "<ul class=\"findings{many}\">");
        for group in &groups {
            let class = match group.severity() {
                Severity::Decision => "decision",
                Severity::Warning => "warning",
                Severity::Note => "note",
            };
            let line = format!(
                "<b>{}</b> {} <code>{}</code>",
                capital(&group.severity().to_string()),
                marked(&sentence(&group.line)),
                escape(group.code())
            );
            let several = group.members.len() > 1;
            let says = |f: &&Finding| !f.evidence_text().is_empty() || !f.advice_text().is_empty();
            if !several && !group.members.iter().any(says) {
                let _ = writeln!(self.out, "<li class=\"{class}\"><p>{line}</p></li>");
                continue;
            }
            let _ = writeln!(
                self.out,
                "<li class=\"{class}\"><details><summary>{line}</summary>"
            );
            let mut advised = "";
            for finding in &group.members {
                let what = match several {
                    true => finding.what(),
                    false => "",
                };
                // Alike findings have the same advice; it stands once.
                let advice = match finding.advice_text() {
                    same if same == advised => "",
                    other => other,
                };
                advised = finding.advice_text();
                for (word, text) in [
                    ("what", minus_signs(what)),
                    ("evidence", minus_signs(finding.evidence_text())),
                    ("advice", advice.to_owned()),
                ] {
                    if !text.is_empty() {
                        let text = marked(&sentence(&text));
                        let _ = writeln!(self.out, "<p class=\"{word}\">{text}</p>");
                    }
                }
            }
            self.out.push_str("</details></li>\n");
        }
        self.out.push_str("</ul>\n");
        if !many.is_empty() {
            self.out.push_str(
                "<p class=\"paper\">Evidence and advice stand on the page on a screen, and in result.json.</p>\n",
            );
        }
    }
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars
        .next()
        .map(|c| c.to_uppercase().chain(chars).collect())
        .unwrap_or_default()
}

/// Capital and full stop around a clause; a symbol or the name of a part at its head stays as it is.
fn sentence(text: &str) -> String {
    let head = text.split(' ').next().unwrap_or_default();
    let word = head.len() > 1 && head.chars().all(|c| c.is_ascii_lowercase() || c == ',');
    let mut text = match word {
        true => capital(text),
        false => text.to_owned(),
    };
    if !text.ends_with(['.', '!', '?', ':']) {
        text.push('.');
    }
    text
}
