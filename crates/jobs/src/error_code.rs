//! The codes of errors: what each means, and what usually helps.

use serde::Serialize;
use std::fmt::{self, Write as _};

/// What an error with a code means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct ErrorCode {
    /// As it stands behind `error`.
    pub code: &'static str,
    /// What is wrong.
    pub meaning: &'static str,
    /// What usually helps; the hint of an error says what helps in its case.
    pub remedy: &'static str,
}

const fn code(code: &'static str, meaning: &'static str, remedy: &'static str) -> ErrorCode {
    ErrorCode {
        code,
        meaning,
        remedy,
    }
}

static CODES: [ErrorCode; 26] = [
    code(
        "request",
        "The call, the campaign or the request contradicts itself, lacks something, or asks for something that does not exist.",
        "Add or change what the message names; `--help` of the command has its options, `proofmass schema KIND` the keys of a file.",
    ),
    code(
        "configuration",
        "A key of a file of settings (campaign.toml, a data sheet, a budget) is unknown, missing, or has a value outside its range.",
        "Go to the file, line and key of the message. `proofmass schema KIND` has every key with its values; an editor that knows this schema marks what is wrong.",
    ),
    code(
        "not-found",
        "A file or a folder is not there.",
        "Check the path. It counts from the folder in which you type, and in a campaign from the folder of campaign.toml.",
    ),
    code(
        "access",
        "The operating system did not let the program read or write: no permission, a full disk, a file that another program holds.",
        "Check permissions and free space, or write to another folder. What stood there before is still there.",
    ),
    code(
        "format",
        "The file is not of the form that was expected: empty, cut off, binary, of another program, or of another version.",
        "`proofmass inspect FILE` says what it is; `proofmass formats` lists what is read. A file that was cut off has to be copied again.",
    ),
    code(
        "row",
        "A line of a table has another number of fields than the lines before it.",
        "Go to the line. A decimal comma in a file that is separated by commas, or a last line that was cut off, is the usual cause.",
    ),
    code(
        "field",
        "A field is not a number, or not a finite one.",
        "Go to the line and column. Words such as `NaN`, `-` or `overflow` stand for missing samples: cut the recording there (`--between`), or leave the line out.",
    ),
    code(
        "column",
        "A column is missing, is named twice, or has a unit of another quantity.",
        "`proofmass inspect FILE` lists the columns with their units; name the column by its heading or its number, and its unit by `--unit`.",
    ),
    code(
        "element",
        "A part of a document (a certificate, a result) has content that is not valid there.",
        "Go to the part that the message names. If the file was edited by hand, write it again with the program that made it.",
    ),
    code(
        "time",
        "There is no time base, or the time column does not run forward.",
        "Name the column (`--time`) and its unit (`--time-unit`), or state the rate (`--rate`). Stamps that jump back are those of a logger that was started again: cut there.",
    ),
    code(
        "output",
        "The outcome cannot be put into a file: the place is taken by something else, or a value is not finite.",
        "Name another folder or file with `-o`, or add `--force` where the message says that it helps.",
    ),
    code(
        "data",
        "The data were read and do not carry the result that is asked for, or a file is not what the command needs.",
        "The message says what the data lack. Another command may be the one for this file: `proofmass --help` lists them.",
    ),
    code(
        "length",
        "Two things that belong together have different lengths.",
        "Give both over the same samples, rows or frequencies.",
    ),
    code(
        "too-few",
        "There are fewer readings, rests, frequencies or windows than the result needs.",
        "Record more or longer, take a model with fewer parameters, or let the search find more of them where the recording has them.",
    ),
    code(
        "too-many",
        "There is more than can be worked on: points, parameters, trials.",
        "Ask for fewer, or cut the recording.",
    ),
    code(
        "not-finite",
        "A number in the data or in a result is infinite or not a number (NaN).",
        "Look at the sample that is named: an overflow of a logger, a division by a column of zeros. Nothing is written.",
    ),
    code(
        "not-increasing",
        "Times, frequencies or levels are not in ascending order, or are repeated.",
        "Sort the table, and keep one line of each.",
    ),
    code(
        "out-of-range",
        "A number lies outside of what is possible: a negative length, a corner above half of the sampling rate, a probability beyond one.",
        "The message has the range. A unit that is off by a power of ten is the usual cause.",
    ),
    code(
        "not-positive-definite",
        "A covariance matrix that was given is not valid: a variance is negative, or a correlation is beyond one.",
        "Check the table that it comes from; digits that were cut off can be the cause.",
    ),
    code(
        "singular",
        "The equations have no unique solution: some rows or columns repeat others.",
        "Leave out what is repeated, or measure in another attitude, level or frequency.",
    ),
    code(
        "constant",
        "Something that has to change does not: an output that is constant, levels that are all alike.",
        "Check the column, and whether the sensor was connected; else change what is measured.",
    ),
    code(
        "unobservable",
        "The data do not determine the parameter that is named: many values of it give the same readings.",
        "Measure where it has an effect, for a cross-axis term in oblique attitudes, for an offset in both senses, or take it out of the model.",
    ),
    code(
        "too-uncertain",
        "The data determine the parameter so poorly that its linear uncertainty means nothing.",
        "Measure where it has an effect, or take it out of the model.",
    ),
    code(
        "not-converged",
        "An iteration did not come to an end: the data do not fit the model, or hardly determine its parameters.",
        "Look at the data first (`proofmass inspect`), at units and order of the columns, then take a simpler model.",
    ),
    code(
        "cancelled",
        "Somebody stopped it. Nothing was written.",
        "Start it again.",
    ),
    code(
        "closed",
        "Nobody reads any more what is written (`… -o - | head`).",
        "Nothing has to be done.",
    ),
];

/// Every code of an error, those of calls and files first.
pub fn error_codes() -> &'static [ErrorCode] {
    &CODES
}

impl fmt::Display for ErrorCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "error[{}]", self.code)?;
        writeln!(f, "  {}", self.meaning)?;
        writeln!(f, "  what helps: {}", self.remedy)
    }
}

/// The page of all errors, in Markdown.
#[doc(hidden)]
pub fn page() -> String {
    let mut page = String::from(
        "# Errors\n\n\
         An error is a refusal: no result, exit code 1. It says what is wrong, where, and in its hint what to do: `error[column]: data.csv: …`.\n\
         The word in brackets is its code. `proofmass explain CODE` shows an entry of this page. A result with a doubt is a\n\
         [finding](findings.md) instead. Words are explained in the [glossary](glossary.md).\n\n\
         This page is made from the list of codes: `cargo run -p proofmass-jobs --example pages`.\n",
    );
    for one in error_codes() {
        let _ = write!(
            page,
            "\n## `{}`\n\n{}\n\nWhat helps: {}\n",
            one.code, one.meaning, one.remedy
        );
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Trouble, TroubleKind};
    use proofmass_io::ErrorKind;
    use std::collections::BTreeSet;

    #[test]
    fn law_every_code_has_one_entry() {
        let listed: Vec<&str> = CODES.iter().map(|c| c.code).collect();
        let distinct: BTreeSet<&str> = listed.iter().copied().collect();
        assert_eq!(listed.len(), distinct.len());
        let all: BTreeSet<&str> = proofmass_core::Error::CODES
            .into_iter()
            .chain(ErrorKind::ALL.map(ErrorKind::code))
            .chain(TroubleKind::ALL.map(TroubleKind::code))
            .collect();
        assert_eq!(distinct, all);
    }

    #[test]
    fn known_the_code_is_that_of_the_error_behind() {
        assert_eq!(Trouble::request("no").code(), "request");
        let constant = proofmass_core::Error::Constant {
            name: "output",
            value: 1.0,
        };
        assert_eq!(Trouble::from(constant).about("run 7").code(), "constant");
        let column = proofmass_io::Error::new(ErrorKind::Column, "no column az");
        assert_eq!(Trouble::from(column).code(), "column");
    }
}
