//! Formulas: what of Typst's mathematics a sheet may use. No code, nothing that could read, repeat or draw.

use std::sync::LazyLock;

use typst::syntax::{SyntaxKind, SyntaxNode, parse_math};
use typst::{Library, LibraryExt};

use crate::error::Result;
use crate::place::Place;

/// Names that formulas may use: those of Typst's mathematics.
static LIBRARY: LazyLock<Library> = LazyLock::new(Library::default);

/// Longer than any formula of a certificate.
const LONGEST: usize = 2000;

/// Refuses a formula that is more than mathematics, or none.
pub fn check(place: &Place) -> Result<()> {
    let source = place.text()?;
    if source.trim().is_empty() || source.len() > LONGEST {
        return Err(place.error(
            format!("the formula is empty or longer than {LONGEST} bytes"),
            "give a formula, or a run of text instead",
        ));
    }
    let root = parse_math(source);
    if let Some(error) = root.errors_and_warnings().0.first() {
        return Err(place.error(
            format!("the formula \"{source}\" cannot be read: {}", error.message),
            "write it in Typst's mathematics, as \"U = k u_c\"",
        ));
    }
    walk(&root, place, source)
}

/// `text` and `equation` set type, which is the work of the layout.
fn known(name: &str) -> bool {
    !matches!(name, "text" | "equation") && LIBRARY.math.scope().get(name).is_some()
}

fn walk(node: &SyntaxNode, place: &Place, source: &str) -> Result<()> {
    use SyntaxKind as K;
    let mathematics = matches!(
        node.kind(),
        K::Math
            | K::MathText
            | K::MathIdent
            | K::MathFieldAccess
            | K::MathShorthand
            | K::MathAlignPoint
            | K::MathCall
            | K::MathArgs
            | K::MathDelimited
            | K::MathAttach
            | K::MathPrimes
            | K::MathFrac
            | K::MathRoot
            | K::Ident
            | K::Named
            | K::Str
            | K::Space
            | K::Linebreak
            | K::Escape
            | K::Text
            | K::LeftParen
            | K::RightParen
            | K::LeftBrace
            | K::RightBrace
            | K::LeftBracket
            | K::RightBracket
            | K::Comma
            | K::Semicolon
            | K::Colon
            | K::Underscore
            | K::Hat
            | K::Slash
            | K::Root
            | K::Bang
            | K::Dot
            | K::End
            | K::Plus
            | K::Minus
            | K::Star
            | K::Eq
    );
    if !mathematics {
        return Err(place.error(
            format!(
                "the formula \"{source}\" holds {}, which is no mathematics",
                node.kind().name()
            ),
            "write formulas without code, comments and labels",
        ));
    }
    if node.kind() == K::MathIdent && !known(node.leaf_text()) {
        return Err(place.error(
            format!("the formula \"{source}\" uses \"{}\", which mathematics does not know", node.leaf_text()),
            "put words in quotation marks, as U_\"rel\", and letters that are multiplied apart, as k u",
        ));
    }
    // Of `arrow.r` the first name alone stands in the mathematics.
    let names = if node.kind() == K::MathFieldAccess {
        1
    } else {
        usize::MAX
    };
    node.children()
        .take(names)
        .try_for_each(|child| walk(child, place, source))
}
