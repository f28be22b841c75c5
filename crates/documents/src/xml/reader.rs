//! The tree of a document.

use proofmass_io::{Error, ErrorKind, Result};
use quick_xml::NsReader;
use quick_xml::events::{BytesStart, Event};
use quick_xml::name::ResolveResult;

/// Elements of a document at most: the largest certificates have some thousands.
const MOST_ELEMENTS: usize = 200_000;
/// Elements within each other at most.
const DEEPEST: usize = 100;
/// Attributes of an element at most.
const MOST_ATTRIBUTES: usize = 64;

/// The vocabularies that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Namespace {
    /// Digital calibration certificates.
    Dcc,
    /// Quantities with units (D-SI).
    Si,
    /// Any other, or none.
    Other,
}

impl Namespace {
    fn of(uri: &str) -> Self {
        match uri {
            "https://ptb.de/dcc" => Self::Dcc,
            "https://ptb.de/si" => Self::Si,
            _ => Self::Other,
        }
    }
}

#[derive(Debug)]
struct Node {
    namespace: Namespace,
    name: Box<str>,
    line: u64,
    parent: usize,
    /// One behind its last descendant.
    end: usize,
    text: String,
    attributes: Vec<(Box<str>, String)>,
}

/// A document.
#[derive(Debug)]
pub(crate) struct XmlTree {
    /// In the order of the text; the first is the root.
    nodes: Vec<Node>,
}

/// An element of a document.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Element<'a> {
    tree: &'a XmlTree,
    at: usize,
}

impl XmlTree {
    /// Reads the bytes of a document; errors have their line.
    pub(crate) fn read(bytes: &[u8]) -> Result<Self> {
        let text = std::str::from_utf8(bytes).map_err(|e| {
            let before = &bytes[..e.valid_up_to()];
            refusal(line_of(before), "the text is not UTF-8")
                .with_hint("save the certificate as XML in UTF-8")
        })?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        Building::new(text).read()
    }

    pub(crate) fn root(&self) -> Element<'_> {
        Element { tree: self, at: 0 }
    }
}

fn refusal(line: u64, what: impl Into<String>) -> Error {
    Error::new(ErrorKind::Format, what).line(line)
}

fn line_of(before: &[u8]) -> u64 {
    1 + before.iter().filter(|b| **b == b'\n').count() as u64
}

struct Building<'a> {
    text: &'a str,
    reader: NsReader<&'a [u8]>,
    nodes: Vec<Node>,
    /// The elements that are open.
    open: Vec<usize>,
    /// Up to where lines were counted, and how many.
    counted: usize,
    line: u64,
}

impl<'a> Building<'a> {
    fn new(text: &'a str) -> Self {
        let mut reader = NsReader::from_str(text);
        reader.config_mut().check_comments = true;
        Self {
            text,
            reader,
            nodes: Vec::new(),
            open: Vec::new(),
            counted: 0,
            line: 1,
        }
    }

    fn advance(&mut self, position: u64) {
        let to = usize::try_from(position).map_or(self.text.len(), |p| p.min(self.text.len()));
        let passed = &self.text.as_bytes()[self.counted..to.max(self.counted)];
        self.line += passed.iter().filter(|b| **b == b'\n').count() as u64;
        self.counted = to.max(self.counted);
    }

    fn refuse(&self, what: impl Into<String>) -> Error {
        refusal(self.line, what)
    }

    fn read(mut self) -> Result<XmlTree> {
        loop {
            self.advance(self.reader.buffer_position());
            let event = match self.reader.read_resolved_event() {
                Ok((space, event)) => {
                    let space = match space {
                        ResolveResult::Bound(space) => Some(Namespace::of(space.0)),
                        ResolveResult::Unbound => Some(Namespace::Other),
                        ResolveResult::Unknown(_) => None,
                    };
                    (space, event)
                }
                Err(e) => {
                    self.advance(self.reader.error_position());
                    return Err(self
                        .refuse(format!("is no XML: {e}"))
                        .with_hint("fetch the certificate again: a file that was cut short or changed by hand ends like this"));
                }
            };
            match event {
                (space, Event::Start(start)) => {
                    self.begin(space, &start)?;
                    self.open.push(self.nodes.len() - 1);
                }
                (space, Event::Empty(start)) => self.begin(space, &start)?,
                (_, Event::End(_)) => {
                    if let Some(closed) = self.open.pop() {
                        self.nodes[closed].end = self.nodes.len();
                    }
                }
                (_, Event::Text(text)) => self.add(&text.xml10_content())?,
                (_, Event::CData(text)) => self.add(&text.xml10_content())?,
                (_, Event::GeneralRef(reference)) => {
                    let name = reference.clone().into_inner();
                    let text = quick_xml::escape::unescape(&format!("&{name};"))
                        .map(String::from)
                        .map_err(|_| self.entity(&name))?;
                    self.add(&text)?;
                }
                (_, Event::DocType(_)) => {
                    return Err(self
                        .refuse("has a document type declaration (DOCTYPE), which is not read: entities are not expanded, and nothing outside of the file is opened")
                        .with_hint("no certificate needs one: remove it, or ask the laboratory for the certificate without it"));
                }
                (_, Event::Decl(declaration)) => {
                    if let Some(Ok(encoding)) = declaration.encoding()
                        && !encoding.eq_ignore_ascii_case("utf-8")
                        && !encoding.eq_ignore_ascii_case("us-ascii")
                    {
                        return Err(self
                            .refuse(format!(
                                "says that it is written in {encoding}; UTF-8 is read"
                            ))
                            .with_hint("save the certificate as XML in UTF-8"));
                    }
                }
                (_, Event::Comment(_) | Event::PI(_)) => {}
                (_, Event::Eof) => break,
            }
        }
        if let Some(open) = self.open.last() {
            let name = &self.nodes[*open].name;
            let line = self.nodes[*open].line;
            return Err(self
                .refuse(format!(
                    "ends within the element {name} that begins in line {line}"
                ))
                .with_hint("fetch the certificate again: it was cut short"));
        }
        if self.nodes.is_empty() {
            return Err(self
                .refuse("holds no element")
                .with_hint("name a digital calibration certificate (XML)"));
        }
        Ok(XmlTree { nodes: self.nodes })
    }

    fn entity(&self, name: &str) -> Error {
        let name: String = name.chars().take(40).collect();
        self.refuse(format!("uses the entity &{name};, which is not expanded"))
            .with_hint("write the character itself; only &lt; &gt; &amp; &apos; &quot; and numbers of characters are known")
    }

    fn begin(&mut self, space: Option<Namespace>, start: &BytesStart) -> Result<()> {
        if self.nodes.len() >= MOST_ELEMENTS {
            return Err(self.refuse(format!(
                "has more than {MOST_ELEMENTS} elements, which no certificate has"
            )));
        }
        if self.open.len() >= DEEPEST {
            return Err(self.refuse(format!(
                "has more than {DEEPEST} elements within each other, which no certificate has"
            )));
        }
        if self.open.is_empty() && !self.nodes.is_empty() {
            return Err(
                self.refuse("has a second element beside the first; a document has one root")
            );
        }
        let Some(namespace) = space else {
            let name = start.name().0;
            return Err(self.refuse(format!("uses a prefix that nothing declares: {name}")));
        };
        let mut attributes = Vec::new();
        for attribute in start.attributes() {
            let attribute =
                attribute.map_err(|e| self.refuse(format!("has a damaged attribute: {e}")))?;
            if attributes.len() >= MOST_ATTRIBUTES {
                return Err(self.refuse(format!(
                    "has an element with more than {MOST_ATTRIBUTES} attributes"
                )));
            }
            let value = quick_xml::escape::unescape(&attribute.value)
                .map_err(|_| self.entity(&attribute.value))?;
            attributes.push((attribute.key.0.into(), value.into_owned()));
        }
        self.nodes.push(Node {
            namespace,
            name: start.local_name().as_ref().into(),
            line: self.line,
            parent: self.open.last().copied().unwrap_or(0),
            end: self.nodes.len() + 1,
            text: String::new(),
            attributes,
        });
        Ok(())
    }

    fn add(&mut self, text: &str) -> Result<()> {
        let bad = |c: char| c.is_control() && !matches!(c, '\t' | '\n' | '\r' | '\u{85}');
        if let Some(c) = text.chars().find(|c| bad(*c)) {
            return Err(self.refuse(format!(
                "holds the control character {}",
                c.escape_unicode()
            )));
        }
        match self.open.last() {
            Some(open) => self.nodes[*open].text.push_str(text),
            None if text.trim().is_empty() => {}
            None => {
                return Err(self
                    .refuse("has text outside of its elements")
                    .with_hint("name a digital calibration certificate (XML)"));
            }
        }
        Ok(())
    }
}

impl<'a> Element<'a> {
    fn node(self) -> &'a Node {
        &self.tree.nodes[self.at]
    }

    /// Its name without a prefix.
    pub(crate) fn name(self) -> &'a str {
        &self.node().name
    }

    pub(crate) fn namespace(self) -> Namespace {
        self.node().namespace
    }

    pub(crate) fn line(self) -> u64 {
        self.node().line
    }

    /// Whether it is this one.
    pub(crate) fn is(self, namespace: Namespace, name: &str) -> bool {
        self.namespace() == namespace && self.name() == name
    }

    /// Its own text, without that of its children, without blanks at the ends.
    pub(crate) fn text(self) -> &'a str {
        self.node().text.trim()
    }

    pub(crate) fn attribute(self, name: &str) -> Option<&'a str> {
        let mut all = self.node().attributes.iter();
        all.find(|(key, _)| &**key == name)
            .map(|(_, value)| value.as_str())
    }

    pub(crate) fn parent(self) -> Option<Self> {
        (self.at > 0).then(|| Self {
            at: self.node().parent,
            ..self
        })
    }

    /// Its children in the order of the text.
    pub(crate) fn children(self) -> impl Iterator<Item = Self> {
        let (tree, end) = (self.tree, self.node().end);
        let first = (self.at + 1 < end).then_some(self.at + 1);
        std::iter::successors(first, move |at| {
            let next = tree.nodes[*at].end;
            (next < end).then_some(next)
        })
        .map(move |at| Self { tree, at })
    }

    /// It and all within it, in the order of the text.
    pub(crate) fn descendants(self) -> impl Iterator<Item = Self> {
        let tree = self.tree;
        (self.at..self.node().end).map(move |at| Self { tree, at })
    }

    /// The first child of a name.
    pub(crate) fn child(self, namespace: Namespace, name: &str) -> Option<Self> {
        self.children().find(|c| c.is(namespace, name))
    }

    /// The element behind these names, from child to child.
    pub(crate) fn at(self, namespace: Namespace, names: &[&str]) -> Option<Self> {
        names
            .iter()
            .try_fold(self, |e, name| e.child(namespace, name))
    }

    /// An error about this element.
    pub(crate) fn refuse(self, what: impl Into<String>) -> Error {
        Error::new(ErrorKind::Element, what)
            .line(self.line())
            .column(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(text: &str) -> String {
        XmlTree::read(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn law_a_tree_has_its_text_lines_and_namespaces() {
        let text = "<?xml version=\"1.0\"?>\n<a:x xmlns:a='https://ptb.de/dcc' n='1&lt;2'>\n one &amp; \
                    <b xmlns='https://ptb.de/si'/>\n two<!-- no --><![CDATA[ <3>]]>\n<a:c>&#x33;</a:c></a:x>\n";
        let tree = XmlTree::read(text.as_bytes()).unwrap();
        let root = tree.root();
        assert!(root.is(Namespace::Dcc, "x") && root.line() == 2);
        assert_eq!(root.attribute("n"), Some("1<2"));
        assert_eq!(root.text(), "one & \n two <3>");
        let children: Vec<_> = root.children().map(|c| (c.name(), c.line())).collect();
        assert_eq!(children, [("b", 3), ("c", 5)]);
        assert_eq!(root.child(Namespace::Si, "b").unwrap().text(), "");
        assert_eq!(root.at(Namespace::Dcc, &["c"]).unwrap().text(), "3");
        assert_eq!(root.descendants().count(), 3);
    }

    #[test]
    fn refuses_what_expands_reaches_out_or_is_no_tree() {
        for (text, word) in [
            ("", "no element"),
            ("a,b\n1,2\n", "text outside"),
            ("<a>\n<b></a>", "no XML"),
            (
                "<a>\n<b>",
                "ends within the element b that begins in line 2",
            ),
            ("<a/><b/>", "second element"),
            ("<a>&x;</a>", "&x;"),
            ("<a b='&x;'/>", "&x;"),
            ("<a>&#0;</a>", "&#0;"),
            ("<p:a/>", "prefix"),
            ("<a b='1' b='2'/>", "attribute"),
            ("<a>\u{1}</a>", "control"),
            (
                "<?xml version='1.0' encoding='ISO-8859-1'?><a/>",
                "ISO-8859-1",
            ),
            (
                "<!DOCTYPE a [<!ENTITY x \"y\"><!ENTITY z \"&x;&x;\">]><a>&z;</a>",
                "document type",
            ),
            (
                "<!DOCTYPE a SYSTEM \"file:///etc/passwd\"><a/>",
                "document type",
            ),
        ] {
            let said = said(text);
            assert!(said.contains(word), "{text}: {said}");
        }
        let deep = "<a>".repeat(100_000);
        assert!(said(&deep).contains("within each other"));
        let wide = format!("<a>{}</a>", "<b/>".repeat(1_000_000));
        assert!(said(&wide).contains("200000 elements"));
        assert!(
            XmlTree::read(b"<a>\xff</a>")
                .unwrap_err()
                .to_string()
                .contains("UTF-8")
        );
    }

    /// Cut anywhere it is an error, never a shorter certificate.
    #[test]
    fn refuses_a_document_cut_anywhere() {
        let text = "<a x='1'><b>t&amp;é</b><!--c--><c/></a>";
        for end in 0..text.len() {
            assert!(XmlTree::read(&text.as_bytes()[..end]).is_err(), "{end}");
        }
    }
}
