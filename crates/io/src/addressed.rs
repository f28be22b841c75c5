//! What a hint says to somebody who typed options, and to somebody who wrote a campaign.
//!
//! A hint names the option, and behind it in brackets what says the same in a campaign: ``say --unit g (`unit = "g"` in a campaign)``.
//! This is the one place where the other half is left out.

/// What the person who reads a message has at hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Addressee {
    /// The options of a command.
    Options,
    /// A campaign, in which keys stand for options.
    Campaign,
}

/// End of what is said of a campaign.
const END: &str = " in a campaign)";

impl Addressee {
    /// The hint as this person can follow it.
    ///
    /// ```
    /// use proofmass_io::Addressee;
    ///
    /// let hint = "likely it is g: say --unit g (`unit = \"g\"` in a campaign), or what it is";
    /// assert_eq!(Addressee::Options.read(hint), "likely it is g: say --unit g, or what it is");
    /// assert_eq!(Addressee::Campaign.read(hint), "likely it is g: say `unit = \"g\"`, or what it is");
    /// ```
    pub fn read(self, hint: &str) -> String {
        let (mut said, mut rest) = (String::new(), hint);
        while let Some(end) = rest.find(END) {
            let (before, after) = (&rest[..end], &rest[end + END.len()..]);
            let Some(start) = opening(before) else {
                said += &rest[..end + END.len()];
                rest = after;
                continue;
            };
            let (text, keys) = (before[..start].trim_end(), &before[start + 1..]);
            match (self, text.rfind("--")) {
                (Self::Options, _) => said += text,
                // The option with its value ends where the bracket begins.
                (Self::Campaign, Some(option)) if !text[option..].contains([',', ';', ':']) => {
                    said += &text[..option];
                    said += keys;
                }
                (Self::Campaign, _) => said += &rest[..end + END.len()],
            }
            rest = after;
        }
        said + rest
    }
}

/// The bracket that is open at the end of a text.
fn opening(text: &str) -> Option<usize> {
    let mut depth = 0;
    for (at, c) in text.char_indices().rev() {
        match c {
            ')' => depth += 1,
            '(' if depth == 0 => return Some(at),
            '(' => depth -= 1,
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_hints_for_both() {
        for (hint, options, campaign) in [
            (
                "add --time COLUMN (`time` in a campaign) or --rate HZ (`sampling_rate_Hz` in a campaign)",
                "add --time COLUMN or --rate HZ",
                "add `time` or `sampling_rate_Hz`",
            ),
            (
                "cut the part out (or give `separator` in a campaign), please",
                "cut the part out, please",
                "cut the part out (or give `separator` in a campaign), please",
            ),
            (
                "give --rate HZ (`sampling_rate_Hz` in a campaign) (in hertz)",
                "give --rate HZ (in hertz)",
                "give `sampling_rate_Hz` (in hertz)",
            ),
            (
                "write it in a campaign",
                "write it in a campaign",
                "write it in a campaign",
            ),
        ] {
            assert_eq!(Addressee::Options.read(hint), options);
            assert_eq!(Addressee::Campaign.read(hint), campaign);
        }
    }
}
