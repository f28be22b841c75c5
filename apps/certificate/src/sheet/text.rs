//! Texts of a sheet: what can be printed as it stands.

use typst::foundations::Datetime;

use crate::error::Result;
use crate::fonts;
use crate::place::Place;

/// A text whose characters all have a glyph.
pub(super) fn text(place: &Place) -> Result<()> {
    place.text()?;
    glyphs(place)
}

/// A text in which something can be seen.
pub(super) fn filled(place: &Place) -> Result<()> {
    text(place)?;
    if place
        .text()?
        .chars()
        .all(|c| c.is_whitespace() || fonts::is_invisible(c))
    {
        return Err(place.error("the text is empty", "write what is to be printed there"));
    }
    Ok(())
}

pub(super) fn glyphs(place: &Place) -> Result<()> {
    for (i, character) in place.text()?.chars().enumerate() {
        let code = format!("U+{:04X}", u32::from(character));
        let position = i + 1;
        if character.is_control() {
            return Err(place.error(
                format!("character {position} is the control character {code}"),
                "make a paragraph or an entry of its own of what stands on a new line",
            ));
        }
        if matches!(character, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}') {
            return Err(place.error(
                format!("character {position}, {code}, is invisible and turns the direction of what follows"),
                "leave it out: runs are kept apart, and a run \"number\" stays left to right",
            ));
        }
        if !fonts::have(character) {
            return Err(place.error(
                format!("character {position}, \"{character}\" ({code}), is in none of the fonts of this program"),
                "write it in Latin, Greek, Cyrillic or Persian script",
            ));
        }
    }
    Ok(())
}

/// Two or three letters, and a region of two if need be.
pub(super) fn language(place: &Place) -> Result<()> {
    let (language, region) = place
        .text()?
        .split_once('-')
        .unwrap_or((place.text()?, "AA"));
    let good = (2..=3).contains(&language.len())
        && language.bytes().all(|b| b.is_ascii_lowercase())
        && region.len() == 2
        && region.bytes().all(|b| b.is_ascii_uppercase());
    if good {
        Ok(())
    } else {
        Err(place.error(
            format!("\"{}\" is no language", place.text()?),
            "write it as en, it, fa or en-GB",
        ))
    }
}

pub(super) fn date(place: &Place) -> Result<Datetime> {
    let parts: Vec<&str> = place.text()?.split('-').collect();
    let digits = |part: &str, n: usize| part.len() == n && part.bytes().all(|b| b.is_ascii_digit());
    match parts[..] {
        [y, m, d] if digits(y, 4) && digits(m, 2) && digits(d, 2) => y
            .parse()
            .ok()
            .zip(m.parse().ok().zip(d.parse().ok()))
            .and_then(|(y, (m, d))| Datetime::from_ymd_hms(y, m, d, 0, 0, 0)),
        _ => None,
    }
    .ok_or_else(|| {
        place.error(
            format!("\"{}\" is no date", place.text().unwrap_or_default()),
            "write it as 2026-11-27",
        )
    })
}
