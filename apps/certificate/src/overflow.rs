//! Text that runs over the edge of its page, which a layout does not report by itself.

use typst::layout::{Abs, Frame, FrameItem, Point, Size, Transform};
use typst_layout::PagedDocument;

use crate::error::{Error, Result};

/// As far as text may come to the edge of the paper; printers leave out what is nearer.
const EDGE: f64 = 5.0;

/// Refuses pages with text beyond their edge.
pub fn check(document: &PagedDocument) -> Result<()> {
    for (i, page) in document.pages().iter().enumerate() {
        if let Some(words) = beyond(&page.frame, Transform::identity(), page.frame.size()) {
            return Err(Error::new(
                format!("\"{}\" does not fit on page {}", abridged(&words), i + 1),
                "shorten it, or part it: numbers and formulas are never broken",
            ));
        }
    }
    Ok(())
}

fn beyond(frame: &Frame, placed: Transform, paper: Size) -> Option<String> {
    frame.items().find_map(|(at, item)| match item {
        FrameItem::Group(group) => {
            let within = placed
                .pre_concat(Transform::translate(at.x, at.y))
                .pre_concat(group.transform);
            beyond(&group.frame, within, paper)
        }
        FrameItem::Text(text) => {
            let ends = [*at, *at + Point::with_x(text.width())].map(|end| end.transform(placed));
            let edge = Abs::mm(EDGE);
            let out = |p: &Point| {
                p.x < edge || p.x > paper.x - edge || p.y < edge || p.y > paper.y - edge
            };
            ends.iter().any(out).then(|| text.text.to_string())
        }
        _ => None,
    })
}

fn abridged(words: &str) -> String {
    match words.char_indices().nth(60) {
        None => words.to_owned(),
        Some((end, _)) => format!("{}…", &words[..end]),
    }
}
