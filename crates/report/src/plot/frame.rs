//! The rectangle data are drawn in, with its grid, ticks and labels.

use super::axis::{Axis, Mapping, Scale};
use super::svg::{Anchor, Svg, escape, text_width};
use super::ticks::Ticks;

/// Size of tick labels in pixels.
pub(super) const SMALL: f64 = 11.0;

/// A rectangle with mapped axes.
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
    pub(super) x: Mapping,
    pub(super) y: Mapping,
}

/// Room that the tick labels and the title of a vertical axis take on its left.
pub(super) fn left_margin(ticks: &Ticks) -> f64 {
    let widest = ticks
        .major
        .iter()
        .map(|(_, label)| text_width(label, SMALL))
        .fold(0.0, f64::max);
    widest + 40.0
}

impl Frame {
    pub(super) fn size(&self) -> (f64, f64) {
        (self.right - self.left, self.bottom - self.top)
    }

    /// The light grid, under the data.
    pub(super) fn grid(&self, svg: &mut Svg, x: &Ticks, y: &Ticks, scales: (Scale, Scale)) {
        let fine = "stroke=\"#f1f1f1\"";
        let coarse = "stroke=\"#e0e0e0\"";
        let vertical = |svg: &mut Svg, v: f64, style| {
            let p = self.x.at(v);
            svg.line((p, self.top), (p, self.bottom), style);
        };
        let horizontal = |svg: &mut Svg, v: f64, style| {
            let p = self.y.at(v);
            svg.line((self.left, p), (self.right, p), style);
        };
        if scales.0 == Scale::Log {
            x.minor.iter().for_each(|&v| vertical(svg, v, fine));
        }
        if scales.1 == Scale::Log {
            y.minor.iter().for_each(|&v| horizontal(svg, v, fine));
        }
        x.major.iter().for_each(|(v, _)| vertical(svg, *v, coarse));
        y.major
            .iter()
            .for_each(|(v, _)| horizontal(svg, *v, coarse));
    }

    /// Ticks with their labels, over the data; the horizontal axis is labelled where `label_x` says so.
    pub(super) fn ticks(&self, svg: &mut Svg, x: &Ticks, y: &Ticks, label_x: bool) {
        let ink = "stroke=\"#333\"";
        for &v in &x.minor {
            let p = self.x.at(v);
            svg.line((p, self.bottom), (p, self.bottom - 3.0), ink);
        }
        for &v in &y.minor {
            let p = self.y.at(v);
            svg.line((self.left, p), (self.left + 3.0, p), ink);
        }
        let small = "font-size=\"11\" fill=\"#333\"";
        for (v, label) in &x.major {
            let p = self.x.at(*v);
            svg.line((p, self.bottom), (p, self.bottom - 6.0), ink);
            if label_x {
                svg.text((p, self.bottom + 15.0), Anchor::Middle, label, small);
            }
        }
        for (v, label) in &y.major {
            let p = self.y.at(*v);
            svg.line((self.left, p), (self.left + 6.0, p), ink);
            svg.text((self.left - 6.0, p + 4.0), Anchor::End, label, small);
        }
    }

    /// Frame and titles of the axes.
    pub(super) fn axes(
        &self,
        svg: &mut Svg,
        x: (&Axis, &Ticks),
        y: (&Axis, &Ticks),
        label_x: bool,
    ) {
        svg.rect(
            (self.left, self.top),
            self.size(),
            "fill=\"none\" stroke=\"#333\"",
        );
        let (width, height) = self.size();
        if label_x {
            let title = x.0.title(x.1);
            let size = (12.0 * width / text_width(&title, 12.0).max(1.0)).clamp(7.0, 12.0);
            svg.text(
                (self.left + 0.5 * width, self.bottom + 34.0),
                Anchor::Middle,
                &title,
                &format!(
                    "data-x=\"{}\" fill=\"#111\" font-size=\"{size:.1}\"",
                    escape(&title)
                ),
            );
        }
        let title = y.0.title(y.1);
        // A title longer than its axis is set smaller rather than cut.
        let size = (12.0 * (height + 30.0) / text_width(&title, 12.0).max(1.0)).clamp(7.0, 12.0);
        svg.text_upwards(
            (self.left - left_margin(y.1) + 18.0, self.top + 0.5 * height),
            Anchor::Middle,
            &title,
            &format!(
                "data-y=\"{}\" fill=\"#111\" font-size=\"{size:.1}\"",
                escape(&title)
            ),
        );
    }
}

/// How many tick labels of the given kind fit along an axis of this many pixels.
pub(super) fn room_across(width: f64) -> usize {
    ((width / 80.0) as usize).clamp(3, 10)
}

/// As [`room_across`], for a vertical axis.
pub(super) fn room_upwards(height: f64) -> usize {
    ((height / 34.0) as usize).clamp(2, 10)
}
