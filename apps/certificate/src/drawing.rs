//! Drawings: SVG of the sheet, looked into before it is laid out.

use roxmltree::{Document, NodeType};

use crate::error::Result;
use crate::fonts;
use crate::place::Place;

/// Refuses what is no SVG, what refers to other files, and text without glyphs.
pub fn check(place: &Place) -> Result<()> {
    let document = Document::parse(place.text()?).map_err(|e| {
        place.error(
            format!("the drawing is not readable: {e}"),
            "give whole SVG, without a document type of its own",
        )
    })?;
    if document.root_element().tag_name().name() != "svg" {
        return Err(place.error(
            format!(
                "the drawing is <{}>, not <svg>",
                document.root_element().tag_name().name()
            ),
            "give SVG",
        ));
    }
    for node in document.descendants() {
        let line = document.text_pos_at(node.range().start).row;
        for attribute in node.attributes().filter(|a| a.name() == "href") {
            if !attribute.value().starts_with('#') && !attribute.value().starts_with("data:image/")
            {
                return Err(place.error(
                    format!(
                        "the drawing refers to \"{}\" (line {line} of it)",
                        attribute.value()
                    ),
                    "put what it shows into the drawing itself",
                ));
            }
        }
        let drawn = node
            .parent()
            .is_some_and(|p| matches!(p.tag_name().name(), "text" | "tspan" | "textPath"));
        if node.node_type() == NodeType::Text && drawn {
            for character in node.text().unwrap_or_default().chars() {
                if !character.is_whitespace() && !fonts::have(character) {
                    return Err(place.error(
                        format!(
                            "\"{character}\" (U+{:04X}) in the drawing (line {line} of it) is in none of the fonts of this program",
                            u32::from(character)
                        ),
                        "write it in Latin, Greek, Cyrillic or Persian script",
                    ));
                }
            }
        }
    }
    Ok(())
}
