//! The SVG writer: elements, escaped text, numbers without superfluous digits, and a watch over NaN.

use crate::Error;
use std::fmt::Write;

/// Opens a superscript inside a text; a control character that no input text can carry past [`escape`].
const SUPER: char = '\u{1}';
/// Closes it.
const NORMAL: char = '\u{2}';

/// 10 to a power, with a real superscript.
pub(super) fn power_of_ten(exponent: i32) -> String {
    format!(
        "10{SUPER}{}{NORMAL}",
        crate::number::minus(&exponent.to_string())
    )
}

/// Text made safe for XML: the five special characters escaped, control characters dropped.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' => out.push(c),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => {}
            c => out.push(c),
        }
    }
    out
}

/// Where a text is held.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// Estimated width of a text in pixels: the widths of Helvetica, which the usual substitutes share.
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    let mut raised = false;
    let mut width = 0.0;
    for c in text.chars() {
        let em = match c {
            SUPER => {
                raised = true;
                0.0
            }
            NORMAL => {
                raised = false;
                0.0
            }
            'i' | 'j' | 'l' | '\'' | '|' => 0.23,
            ' ' | '.' | ',' | ':' | ';' | 'f' | 't' | 'I' | '!' | '/' | '·' => 0.28,
            '(' | ')' | '[' | ']' | 'r' | '-' | '²' | '³' | '¹' => 0.34,
            'm' | 'M' | 'W' | '%' => 0.87,
            'w' | 'A'..='L' | 'N'..='V' | 'X'..='Z' => 0.70,
            '−' | '+' | '=' | '±' | '<' | '>' | '≤' | '≥' => 0.58,
            'c' | 's' | 'k' | 'v' | 'x' | 'y' | 'z' => 0.50,
            c if (c as u32) >= 0x2e80 => 1.0,
            _ => 0.556,
        };
        width += if raised { 0.72 * em } else { em };
    }
    width * size
}

/// A drawing under construction.
pub(super) struct Svg {
    out: String,
    finite: bool,
}

impl Svg {
    /// An empty drawing of this size with its accessible title.
    pub(super) fn new(width: f64, height: f64, title: &str, id: &str) -> Self {
        let mut svg = Self {
            out: String::new(),
            finite: true,
        };
        let (w, h) = (svg.number(width), svg.number(height));
        let _ = write!(
            svg.out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
             role=\"img\" aria-labelledby=\"{id}-title\" font-family=\"Helvetica, Arial, 'Liberation Sans', \
             'DejaVu Sans', sans-serif\" font-size=\"12\">\n<title id=\"{id}-title\">{}</title>\n",
            escape(title)
        );
        svg
    }

    /// At most two decimals, no trailing zeros, no negative zero.
    fn number(&mut self, value: f64) -> String {
        if !value.is_finite() {
            self.finite = false;
            return "0".into();
        }
        let rounded = (value * 100.0).round() / 100.0;
        // Adding zero turns −0 into 0.
        (rounded + 0.0).to_string()
    }

    pub(super) fn line(&mut self, from: (f64, f64), to: (f64, f64), attributes: &str) {
        let n = [from.0, from.1, to.0, to.1].map(|v| self.number(v));
        let _ = writeln!(
            self.out,
            "<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" {attributes}/>",
            n[0], n[1], n[2], n[3]
        );
    }

    pub(super) fn rect(&mut self, at: (f64, f64), size: (f64, f64), attributes: &str) {
        let n = [at.0, at.1, size.0.max(0.0), size.1.max(0.0)].map(|v| self.number(v));
        let _ = writeln!(
            self.out,
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" {attributes}/>",
            n[0], n[1], n[2], n[3]
        );
    }

    pub(super) fn circle(&mut self, at: (f64, f64), radius: f64, attributes: &str) {
        let n = [at.0, at.1, radius].map(|v| self.number(v));
        let _ = writeln!(
            self.out,
            "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" {attributes}/>",
            n[0], n[1], n[2]
        );
    }

    /// A line through points, closed or not; fewer than two points draw nothing.
    pub(super) fn path(&mut self, points: &[(f64, f64)], closed: bool, attributes: &str) {
        if points.len() < 2 {
            return;
        }
        let mut d = String::with_capacity(points.len() * 12);
        for (i, &(x, y)) in points.iter().enumerate() {
            let (x, y) = (self.number(x), self.number(y));
            let _ = write!(d, "{}{x} {y}", if i == 0 { "M" } else { "L" });
        }
        if closed {
            d.push('Z');
        }
        let _ = writeln!(self.out, "<path d=\"{d}\" {attributes}/>");
    }

    /// A text; superscripts marked by [`power_of_ten`] are raised.
    pub(super) fn text(&mut self, at: (f64, f64), anchor: Anchor, text: &str, attributes: &str) {
        let (x, y) = (self.number(at.0), self.number(at.1));
        let held = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let mut body = String::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once(SUPER) {
            let (raised, tail) = after.split_once(NORMAL).unwrap_or((after, ""));
            let _ = write!(
                body,
                "{}<tspan dy=\"-4.5\" font-size=\"75%\">{}</tspan>",
                escape(before),
                escape(raised)
            );
            if !tail.is_empty() {
                // The shift lasts until it is taken back.
                let (next, more) = match tail.find(SUPER) {
                    Some(i) => tail.split_at(i),
                    None => (tail, ""),
                };
                let _ = write!(body, "<tspan dy=\"4.5\">{}</tspan>", escape(next));
                rest = more;
            } else {
                rest = "";
            }
        }
        body.push_str(&escape(rest));
        let _ = writeln!(
            self.out,
            "<text x=\"{x}\" y=\"{y}\" text-anchor=\"{held}\" {attributes}>{body}</text>"
        );
    }

    /// A text turned a quarter to the left about its anchor.
    pub(super) fn text_upwards(
        &mut self,
        at: (f64, f64),
        anchor: Anchor,
        text: &str,
        attributes: &str,
    ) {
        let (x, y) = (self.number(at.0), self.number(at.1));
        let turned = format!("transform=\"rotate(-90 {x} {y})\" {attributes}");
        self.text(at, anchor, text, &turned);
    }

    /// Opens a group that shows nothing outside a rectangle.
    pub(super) fn open_clip(&mut self, id: &str, at: (f64, f64), size: (f64, f64)) {
        let _ = write!(self.out, "<clipPath id=\"{id}\">");
        self.rect(at, size, "");
        let _ = writeln!(self.out, "</clipPath><g clip-path=\"url(#{id})\">");
    }

    /// Closes the last group.
    pub(super) fn close(&mut self) {
        self.out.push_str("</g>\n");
    }

    /// The finished element; a coordinate that was not finite is refused here at the latest.
    pub(super) fn finish(mut self, name: &str) -> Result<String, Error> {
        if !self.finite {
            return Err(Error::NotFinite {
                series: format!("drawing of {name}"),
                index: 0,
                value: f64::NAN,
            });
        }
        self.out.push_str("</svg>");
        Ok(self.out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_escape_leaves_no_markup_and_no_control_character() {
        assert_eq!(
            escape("<a href=\"x\">&'\u{1}\u{2}"),
            "&lt;a href=&quot;x&quot;&gt;&amp;&#39;"
        );
    }

    #[test]
    fn refuses_a_coordinate_that_is_not_finite() {
        let mut svg = Svg::new(10.0, 10.0, "t", "i");
        svg.line((0.0, f64::NAN), (1.0, 1.0), "");
        assert!(svg.finish("t").is_err());
    }
}
