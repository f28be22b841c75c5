//! XML as text: what is written is escaped, so that no text becomes markup.

use std::fmt::Write as _;

/// A document in the making, two blanks for each level.
#[derive(Debug, Default)]
pub(crate) struct XmlWriter {
    text: String,
    open: Vec<String>,
}

impl XmlWriter {
    pub(crate) fn new() -> Self {
        Self {
            text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned(),
            open: Vec::new(),
        }
    }

    fn tag(&mut self, name: &str, attributes: &[(&str, &str)]) {
        let indent = 2 * self.open.len();
        let _ = write!(self.text, "{:indent$}<{name}", "");
        for (key, value) in attributes {
            let _ = write!(self.text, " {key}=\"{}\"", escaped(value));
        }
    }

    /// Begins an element.
    pub(crate) fn begin(&mut self, name: &str, attributes: &[(&str, &str)]) {
        self.tag(name, attributes);
        self.text.push_str(">\n");
        self.open.push(name.to_owned());
    }

    /// Ends the element that was begun last.
    pub(crate) fn end(&mut self) {
        if let Some(name) = self.open.pop() {
            let indent = 2 * self.open.len();
            let _ = writeln!(self.text, "{:indent$}</{name}>", "");
        }
    }

    /// An element with text.
    pub(crate) fn leaf(&mut self, name: &str, text: &str) {
        self.leaf_with(name, &[], text);
    }

    /// An element with attributes and text.
    pub(crate) fn leaf_with(&mut self, name: &str, attributes: &[(&str, &str)], text: &str) {
        self.tag(name, attributes);
        let _ = writeln!(self.text, ">{}</{name}>", escaped(text));
    }

    /// The document.
    pub(crate) fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.end();
        }
        self.text
    }
}

/// Text with the characters of markup as references, and without those that XML cannot hold.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&apos;"),
            '\t' | '\n' => out.push(c),
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::xml::XmlTree;

    #[test]
    fn law_text_is_read_as_it_was_written_and_never_markup() {
        let odd = "a<b>&amp;\"'</x:y> é \u{202e} ]]>";
        let mut writer = XmlWriter::new();
        writer.begin("a", &[("k", odd)]);
        writer.begin("b", &[]);
        writer.leaf("c", odd);
        let text = writer.finish();
        let tree = XmlTree::read(text.as_bytes()).unwrap();
        assert_eq!(tree.root().attribute("k"), Some(odd));
        assert_eq!(tree.root().descendants().count(), 3);
        let last = tree.root().descendants().last().unwrap();
        assert_eq!((last.name(), last.text()), ("c", odd));
        let control = escaped("\u{0}\u{1b}x");
        assert_eq!(control, "\u{fffd}\u{fffd}x");
    }
}
