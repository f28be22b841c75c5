//! The first screen: result, verdict, plot.

use super::{Page, marked};
use crate::Error;
use crate::document::{Block, Report};
use proofmass_uncertainty::Severity;
use std::fmt::Write;

impl Page {
    pub(super) fn answer(&mut self, report: &Report) -> Result<(), Error> {
        let answer = &report.answer;
        if report.says_nothing() {
            return Ok(());
        }
        self.out.push_str("<section class=\"answer\">\n");
        if !answer.figures.is_empty() {
            self.block(&Block::KeyFigures(answer.figures.clone()))?;
        }
        let gravest = report.findings.iter().map(|f| f.severity()).max();
        let class = match gravest {
            Some(Severity::Decision) => "decision",
            Some(Severity::Warning) => "warning",
            Some(Severity::Note) | None => "sound",
        };
        let _ = writeln!(
            self.out,
            "<p class=\"verdict {class}\">{} <span>{}</span></p>",
            match answer.verdict.as_str() {
                "" => String::new(),
                verdict => format!("<b>{}</b>", marked(verdict)),
            },
            report.standing()
        );
        self.blocks(&answer.blocks)?;
        if let Some(figure) = &answer.figure {
            self.first_figure(figure);
        }
        self.out.push_str("</section>\n");
        Ok(())
    }
}
