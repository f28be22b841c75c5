//! The SVG writer: elements, escaped text, numbers without superfluous digits, and a watch over NaN.

use super::ticks::Ticks;
use crate::Error;
use proofmass_core::Visible;
use std::fmt::Write;

/// 10 to a power.
pub(super) fn power_of_ten(exponent: i32) -> String {
    format!("10{}", crate::number::superscript(exponent))
}

/// The character that a superscript character raises.
fn lowered(c: char) -> Option<char> {
    Some(match c {
        '¹' => '1',
        '²' => '2',
        '³' => '3',
        '⁺' => '+',
        '⁻' => '−',
        'ᐟ' => '/',
        '⁰' | '⁴'..='⁹' => char::from_digit(c as u32 - '⁰' as u32, 10)?,
        _ => return None,
    })
}

/// Where a run of a text stands.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Level {
    Line,
    Above,
    Below,
}

/// Runs of a text that stand on the line, above it or, as an index, below it.
///
/// Superscript characters beyond ¹, ² and ³ are missing in many fonts and come out uneven from a substitute; a
/// text with one of them is drawn with raised common characters instead.
fn runs(text: &str) -> Vec<(Level, String)> {
    let common = |c: char| matches!(c, '¹' | '²' | '³') || lowered(c).is_none();
    let plain = text.chars().all(common);
    let mut runs: Vec<(Level, String)> = Vec::new();
    for (index, piece) in crate::subscript::pieces(text) {
        for c in piece.chars() {
            let (level, c) = match lowered(c) {
                _ if index => (Level::Below, c),
                Some(raised) if !plain => (Level::Above, raised),
                _ => (Level::Line, c),
            };
            match runs.last_mut() {
                Some((last, run)) if *last == level => run.push(c),
                _ => runs.push((level, c.to_string())),
            }
        }
    }
    runs
}

/// Text made safe for XML: the five special characters escaped, control characters dropped.
pub fn escape(text: &str) -> String {
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
            // A mark of the writing direction would let a name read backwards.
            c if Visible::hides(c) => {
                let _ = write!(out, "{}", c.escape_unicode());
            }
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
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    size * text.chars().map(em_width).sum::<f64>()
}

/// By how much wider than estimated a text may be set: DejaVu Sans, the only font of many machines, takes a sixth more than
/// Helvetica. Names in a margin of their own get it, or their first letters are cut.
pub(super) const WIDEST: f64 = 1.17;

/// A text of at most this many pixels: one that is longer keeps its ends around an ellipsis, since names of a
/// family differ at either.
pub(super) fn shortened(text: &str, size: f64, width: f64) -> String {
    if text_width(text, size) <= width {
        return text.into();
    }
    let chars: Vec<char> = text.chars().collect();
    let mut kept = chars.len();
    loop {
        kept = kept.saturating_sub(1);
        let tail = kept / 2;
        let head: String = chars[..kept - tail].iter().collect();
        let tail: String = chars[chars.len() - tail..].iter().collect();
        let short = format!("{}…{}", head.trim_end(), tail.trim_start());
        if kept <= 2 || text_width(&short, size) <= width {
            return short;
        }
    }
}

fn em_width(c: char) -> f64 {
    match c {
        'i' | 'j' | 'l' | '\'' | '|' => 0.23,
        ' ' | '.' | ',' | ':' | ';' | 'f' | 't' | 'I' | '!' | '/' | '·' => 0.28,
        '(' | ')' | '[' | ']' | 'r' | '-' => 0.34,
        'm' | 'M' | 'W' | '%' => 0.87,
        'w' | 'A'..='L' | 'N'..='V' | 'X'..='Z' => 0.70,
        '−' | '+' | '=' | '±' | '×' | '<' | '>' | '≤' | '≥' => 0.58,
        'c' | 's' | 'k' | 'v' | 'x' | 'y' | 'z' => 0.50,
        c if (c as u32) >= 0x2e80 => 1.0,
        c => lowered(c).map_or(0.556, |plain| 0.75 * em_width(plain)),
    }
}

/// A drawing under construction.
pub(super) struct Svg {
    out: String,
    /// Rectangles with their axes, for the script of a page.
    panels: Vec<String>,
    finite: bool,
}

impl Svg {
    /// An empty drawing of this size with its accessible title.
    pub(super) fn new(width: f64, height: f64, title: &str, id: &str) -> Self {
        let mut svg = Self {
            out: String::new(),
            panels: Vec::new(),
            finite: true,
        };
        let (w, h) = (svg.number(width), svg.number(height));
        let _ = write!(
            svg.out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" preserveAspectRatio=\"xMinYMin meet\" \
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

    /// A text; superscripts are raised, indices lowered.
    pub(super) fn text(&mut self, at: (f64, f64), anchor: Anchor, text: &str, attributes: &str) {
        let (x, y) = (self.number(at.0), self.number(at.1));
        let held = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let mut body = String::new();
        // A shift lasts until it is taken back; it is counted in the size of its own run.
        let mut shifted: f64 = 0.0;
        for (level, run) in runs(text) {
            let run = escape(&run);
            let (level, size): (f64, f64) = match level {
                Level::Line => (0.0, 1.0),
                Level::Above => (-0.31, 0.78),
                Level::Below => (0.2, 0.78),
            };
            let _ = if level == shifted && size == 1.0 {
                write!(body, "{run}")
            } else {
                // Two decimals, and no sign or zeros that say nothing.
                let shift = (100.0 * (level - shifted) / size).round() / 100.0;
                let small = if size < 1.0 { " font-size=\"78%\"" } else { "" };
                write!(body, "<tspan dy=\"{shift}em\"{small}>{run}</tspan>")
            };
            shifted = level;
        }
        let _ = writeln!(
            self.out,
            "<text x=\"{x}\" y=\"{y}\" text-anchor=\"{held}\" {attributes}>{body}</text>"
        );
    }

    /// A text on a white border of its own, for places where it may cross a line.
    ///
    /// The border is a text of its own below: one painted with each run would eat into the run before it.
    pub(super) fn text_over(
        &mut self,
        at: (f64, f64),
        anchor: Anchor,
        text: &str,
        attributes: &str,
    ) {
        let border =
            "aria-hidden=\"true\" stroke=\"#fff\" stroke-width=\"3\" stroke-linejoin=\"round\"";
        self.text(at, anchor, text, &format!("{attributes} {border}"));
        self.text(at, anchor, text, attributes);
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

    /// Says where a rectangle lies and what its axes run over, each logarithmic or not.
    ///
    /// What the label of an axis takes from its numbers (a power of ten, a number that is subtracted) comes last, where there is any.
    pub(super) fn panel(
        &mut self,
        corners: [f64; 4],
        axes: [(bool, (f64, f64)); 2],
        ticks: [&Ticks; 2],
    ) {
        let corners = corners.map(|v| self.number(v)).join(",");
        let axes = axes.map(|(log, (low, high))| format!("{},{low:e},{high:e}", u8::from(log)));
        let taken = match ticks.iter().any(|t| t.exponent != 0 || t.base != 0.0) {
            true => ticks
                .map(|t| format!(",{},{:e}", t.exponent, t.base))
                .concat(),
            false => String::new(),
        };
        self.panels
            .push(format!("[{corners},{}{taken}]", axes.join(",")));
    }

    /// Opens a group that belongs to a panel and not to its data: the script of a page redraws it.
    pub(super) fn open_ticks(&mut self, panel: usize) {
        let _ = writeln!(self.out, "<g data-ticks=\"{panel}\">");
    }

    /// Opens a group that shows nothing outside a rectangle.
    pub(super) fn open_clip(&mut self, id: &str, at: (f64, f64), size: (f64, f64)) {
        let _ = write!(self.out, "<clipPath id=\"{id}\">");
        self.rect(at, size, "");
        let _ = writeln!(
            self.out,
            "</clipPath><g clip-path=\"url(#{id})\" data-panel=\"\">"
        );
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
        if !self.panels.is_empty() {
            let panels = format!("data-panels=\"[{}]\" role=", self.panels.join(","));
            self.out = self.out.replacen("role=", &panels, 1);
        }
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
    fn law_rare_superscripts_become_raised_common_characters() {
        assert_eq!(runs("m/s²"), [(Level::Line, "m/s²".into())]);
        assert_eq!(
            runs("kg·m²·s⁻²"),
            [
                (Level::Line, "kg·m".into()),
                (Level::Above, "2".into()),
                (Level::Line, "·s".into()),
                (Level::Above, "−2".into())
            ]
        );
        assert_eq!(runs("τ⁻¹ᐟ²")[1], (Level::Above, "−1/2".into()));
        assert_eq!(runs(&power_of_ten(-305))[1], (Level::Above, "−305".into()));
        let index = runs("K_xx / 2");
        assert_eq!(index[1].0, Level::Below, "{index:?}");
        assert!(runs("").iter().all(|run| run.1.is_empty()));
    }

    #[test]
    fn law_a_long_name_is_shortened_in_its_middle() {
        assert_eq!(shortened("bias.x", 11.0, 100.0), "bias.x");
        let name = "temperature coefficient of the misalignment.xy";
        let short = shortened(name, 11.0, 120.0);
        assert!(text_width(&short, 11.0) <= 120.0 && short.len() > 15);
        assert!(short.starts_with("temp") && short.ends_with(".xy") && short.contains('…'));
        assert_eq!(shortened("äöü", 11.0, 0.0), "ä…ü");
    }

    #[test]
    fn refuses_a_coordinate_that_is_not_finite() {
        let mut svg = Svg::new(10.0, 10.0, "t", "i");
        svg.line((0.0, f64::NAN), (1.0, 1.0), "");
        assert!(svg.finish("t").is_err());
    }
}
