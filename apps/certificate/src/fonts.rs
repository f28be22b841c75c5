//! The fonts that are shipped with the program, and which characters they have. Fonts of the machine are not looked at, so
//! that a sheet looks the same everywhere.

use std::sync::LazyLock;

use typst::foundations::Bytes;
use typst::text::Font;

static FILES: [&[u8]; 5] = [
    include_bytes!("../fonts/LibertinusSerif-Regular.otf"),
    include_bytes!("../fonts/LibertinusSerif-Bold.otf"),
    include_bytes!("../fonts/Vazirmatn-NL-Regular.ttf"),
    include_bytes!("../fonts/Vazirmatn-NL-Bold.ttf"),
    include_bytes!("../fonts/ProofmassMath.otf"),
];

/// All fonts, in the order of the files.
pub static FONTS: LazyLock<Vec<Font>> = LazyLock::new(|| {
    FILES
        .iter()
        .map(|file| Font::new(Bytes::new(*file), 0).expect("a font of the program is readable"))
        .collect()
});

/// Characters that are no glyphs but steer how others are joined or broken.
const INVISIBLE: [char; 6] = [
    '\u{ad}', '\u{200b}', '\u{200c}', '\u{200d}', '\u{200e}', '\u{200f}',
];

/// Whether nothing of it is seen.
pub fn is_invisible(character: char) -> bool {
    INVISIBLE.contains(&character)
}

/// Whether a text can be set with this character in it. What the font of the text lacks comes from another of them.
pub fn have(character: char) -> bool {
    is_invisible(character)
        || FONTS
            .iter()
            .any(|font| font.info().coverage.contains(u32::from(character)))
}
