//! Text of others as it may be shown: nothing in it steers the terminal or turns the direction of writing.

use core::fmt::{self, Write};

/// Shows a text with control characters and marks of the writing direction as escapes, `\u{1b}`.
///
/// Line ends and tabulators pass. Names of files, headings and labels come from anywhere; in a message they must
/// neither colour, move nor hide anything, nor read backwards.
///
/// ```
/// use proofmass_core::Visible;
/// let name = "report\u{202e}gpj.\u{1b}[31m";
/// assert_eq!(Visible(name).to_string(), r"report\u{202e}gpj.\u{1b}[31m");
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Visible<'a>(pub &'a str);

impl Visible<'_> {
    /// Whether a character is shown as an escape.
    pub fn hides(c: char) -> bool {
        let marks = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        marks || c.is_control() && c != '\n' && c != '\t'
    }
}

impl fmt::Display for Visible<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for c in self.0.chars() {
            if Self::hides(c) {
                write!(f, "{}", c.escape_unicode())?;
            } else {
                f.write_char(c)?;
            }
        }
        Ok(())
    }
}
