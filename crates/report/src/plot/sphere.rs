//! Directions on the unit sphere: two hemispheres side by side in Lambert's equal-area projection.

use super::placing::{Area, DATA, Ink, TEXT};
use super::svg::{Anchor, Svg, text_width};
use super::ticks::{self, Ticks};
use super::{check_finite, colour};
use crate::Error;
use serde::{Deserialize, Serialize};

/// Directions, each coloured by a value.
///
/// The left disc shows the hemisphere around +z seen from outside, the right one that around −z; they open like
/// a book about their common +x point. Radius ρ = √(1 − |cos θ|), so equal areas on the sphere are equal on
/// paper and clusters or holes of attitudes show as what they are. Positive values are discs, negative ones
/// squares, so that the sign survives a black and white print.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SpherePlot {
    /// The points.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) points: Vec<SpherePoint>,
    /// What the value is, beside the colour bar.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) value_label: String,
    /// Its unit; empty or `1` for a pure number.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) unit: String,
    /// Names of the three axes.
    pub axes: [String; 3],
}

/// A direction with a value.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SpherePoint {
    /// Direction; its length is ignored.
    pub(crate) direction: [f64; 3],
    /// Value, shown by colour.
    pub(crate) value: f64,
    /// Label beside the point; empty for none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) label: String,
}

/// Size of point labels in pixels.
const LABEL: f64 = 9.5;
/// Size of axis names in pixels.
const NAME: f64 = 11.0;
/// Half the side of a point.
const POINT: f64 = 5.6;

/// Where everything stands; each length follows from the words that need it.
struct Layout {
    radius: f64,
    centres: [(f64, f64); 2],
    bar: f64,
    bar_title: f64,
    width: f64,
    height: f64,
}

impl Layout {
    fn new(axes: &[String; 3], marks: &Ticks) -> Self {
        let name = text_width(&format!("−{}", axes[0]), NAME);
        // An axis name with air on both sides; two of them lie between the discs.
        let side = name + 19.0;
        let ticks = marks.major.iter().map(|(_, label)| text_width(label, 10.0));
        let ticks = ticks.fold(16.0, f64::max);
        let column = 14.0 + BAR + 8.0 + ticks + 24.0;
        let radius = ((760.0 - 4.0 * side - column) / 4.0).clamp(100.0, 146.0);
        let top = 49.0;
        let bar = 4.0 * (side + radius) + 14.0;
        Self {
            radius,
            centres: [side + radius, 3.0 * (side + radius)].map(|x| (x, top + radius)),
            bar,
            bar_title: bar + BAR + 8.0 + ticks + 16.0,
            width: (4.0 * (side + radius) + column).max(760.0),
            height: top + 2.0 * radius + 28.0,
        }
    }
}

/// Width of the colour bar.
const BAR: f64 = 12.0;

impl SpherePlot {
    /// No points yet; axes named x, y, z.
    pub fn new(value_label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            points: Vec::new(),
            value_label: value_label.into(),
            unit: unit.into(),
            axes: ["x", "y", "z"].map(String::from),
        }
    }

    /// Adds a direction.
    #[must_use]
    pub fn point(mut self, direction: [f64; 3], value: f64, label: impl Into<String>) -> Self {
        self.points.push(SpherePoint {
            direction,
            value,
            label: label.into(),
        });
        self
    }

    pub(super) fn draw(&self, title: &str, id: &str) -> Result<String, Error> {
        let values: Vec<f64> = self.points.iter().map(|p| p.value).collect();
        check_finite(&self.value_label, &values)?;
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let signed = low < 0.0;
        let size = low.abs().max(high.abs());
        let (from, to) = match (self.points.is_empty(), signed) {
            (true, _) => (0.0, 1.0),
            (_, true) => (-size, size),
            _ => (0.0, if size > 0.0 { size } else { 1.0 }),
        };
        let shade = |value: f64| {
            let t = (value - from) / (to - from);
            if signed {
                colour::diverging(2.0 * t - 1.0)
            } else {
                colour::sequential(t)
            }
        };
        let marks = ticks::linear(from, to, 6);
        let layout = Layout::new(&self.axes, &marks);
        let mut svg = Svg::new(layout.width, layout.height, title, id);
        let mut ink = Ink::new(layout.width, layout.height);
        for (centre, sign) in layout.centres.iter().zip(["+", "−"]) {
            self.graticule(&mut svg, &mut ink, (*centre, layout.radius), sign);
        }
        let mut labels: Vec<((f64, f64), &str)> = Vec::new();
        for (index, point) in self.points.iter().enumerate() {
            let (at, lower) = project(&point.direction, &self.value_label, index)?;
            let (centre, r) = (layout.centres[usize::from(lower)], layout.radius);
            let at = (centre.0 + r * at.0, centre.1 - r * at.1);
            let style = format!(
                "fill=\"{}\" stroke=\"#222\" stroke-width=\"0.9\"",
                shade(point.value)
            );
            if point.value < 0.0 {
                svg.rect((at.0 - 5.0, at.1 - 5.0), (10.0, 10.0), &style);
            } else {
                svg.circle(at, POINT, &style);
            }
            let area = [at.0 - POINT, at.1 - POINT, at.0 + POINT, at.1 + POINT];
            ink.cover(&area, DATA);
            if !point.label.is_empty() {
                labels.push((at, &point.label));
            }
        }
        for (at, label) in labels {
            write_label(&mut svg, &mut ink, &layout, at, label);
        }
        self.colour_bar(&mut svg, &layout, &marks, ((from, to), signed), &shade);
        svg.finish(title)
    }

    fn graticule(
        &self,
        svg: &mut Svg,
        ink: &mut Ink,
        (centre, radius): ((f64, f64), f64),
        sign: &str,
    ) {
        svg.circle(centre, radius, "fill=\"#fbfbfb\" stroke=\"#333\"");
        let rim = (0..=180).map(|k| {
            let (s, c) = (f64::from(2 * k)).to_radians().sin_cos();
            (centre.0 + radius * c, centre.1 + radius * s)
        });
        ink.line(&rim.collect::<Vec<_>>(), 1.0);
        for theta in [30.0_f64, 60.0] {
            let r = radius * (1.0 - theta.to_radians().cos()).sqrt();
            svg.circle(centre, r, "fill=\"none\" stroke=\"#ddd\"");
            let (text, at) = (format!("{theta}°"), (centre.0 + 3.0, centre.1 - r - 2.0));
            svg.text(at, Anchor::Start, &text, "font-size=\"9\" fill=\"#999\"");
            ink.cover(&[at.0, at.1 - 7.0, at.0 + 14.0, at.1], 2.0);
        }
        for k in 0..4 {
            let (s, c) = (f64::from(k) * 45.0_f64.to_radians()).sin_cos();
            let style = if k % 2 == 0 {
                "stroke=\"#ccc\""
            } else {
                "stroke=\"#e6e6e6\""
            };
            svg.line(
                (centre.0 - radius * c, centre.1 - radius * s),
                (centre.0 + radius * c, centre.1 + radius * s),
                style,
            );
        }
        let [x, y, z] = &self.axes;
        // Seen from outside, the far hemisphere has its x axis pointing left.
        let (right, left) = if sign == "+" {
            ("+", "−")
        } else {
            ("−", "+")
        };
        for (dx, dy, anchor, name) in [
            (radius + 9.0, 4.0, Anchor::Start, format!("{right}{x}")),
            (-radius - 9.0, 4.0, Anchor::End, format!("{left}{x}")),
            (0.0, -radius - 9.0, Anchor::Middle, format!("+{y}")),
            (0.0, radius + 19.0, Anchor::Middle, format!("−{y}")),
        ] {
            let at = (centre.0 + dx, centre.1 + dy);
            let style = "font-size=\"11\" fill=\"#333\"";
            svg.text(at, anchor, &name, style);
            let width = text_width(&name, NAME);
            let start = match anchor {
                Anchor::Start => at.0,
                Anchor::Middle => at.0 - 0.5 * width,
                Anchor::End => at.0 - width,
            };
            ink.cover(&[start, at.1 - 9.0, start + width, at.1 + 2.0], TEXT);
        }
        svg.text(
            (centre.0, centre.1 - radius - 30.0),
            Anchor::Middle,
            &format!("hemisphere around {sign}{z}"),
            "font-weight=\"bold\" fill=\"#111\"",
        );
    }

    fn colour_bar(
        &self,
        svg: &mut Svg,
        layout: &Layout,
        marks: &Ticks,
        ((from, to), signed): ((f64, f64), bool),
        shade: &dyn Fn(f64) -> String,
    ) {
        let x = layout.bar;
        let top = layout.centres[0].1 - layout.radius;
        let key = if signed { 44.0 } else { 0.0 };
        let bottom = layout.centres[0].1 + layout.radius - key;
        let steps = 60;
        for i in 0..steps {
            let t = (f64::from(i) + 0.5) / f64::from(steps);
            let y = bottom - (bottom - top) * f64::from(i + 1) / f64::from(steps);
            let style = format!("fill=\"{}\"", shade(from + t * (to - from)));
            // A little overlap, or hair lines show between the steps.
            let tall = (bottom - top) / f64::from(steps) + 0.4;
            svg.rect((x, y), (BAR, tall), &style);
        }
        let frame = "fill=\"none\" stroke=\"#333\"";
        svg.rect((x, top), (BAR, bottom - top), frame);
        let ink = "font-size=\"10\" fill=\"#333\"";
        for (v, label) in &marks.major {
            let y = bottom - (bottom - top) * (v - from) / (to - from);
            svg.line((x + BAR, y), (x + BAR + 4.0, y), "stroke=\"#333\"");
            svg.text((x + BAR + 7.0, y + 3.5), Anchor::Start, label, ink);
        }
        let axis = super::Axis::linear(self.value_label.as_str(), self.unit.as_str());
        let title = axis.title(marks);
        let size = (11.0 * layout.height / text_width(&title, 11.0).max(1.0)).clamp(7.0, 11.0);
        svg.text_upwards(
            (layout.bar_title, layout.centres[0].1),
            Anchor::Middle,
            &title,
            &format!("font-size=\"{size:.1}\" fill=\"#111\""),
        );
        if signed {
            let grey = "fill=\"#ddd\" stroke=\"#222\" stroke-width=\"0.9\"";
            svg.circle((x + 6.0, bottom + 21.0), 5.0, grey);
            svg.text((x + BAR + 7.0, bottom + 24.5), Anchor::Start, "≥ 0", ink);
            svg.rect((x + 1.5, bottom + 34.5), (9.0, 9.0), grey);
            svg.text((x + BAR + 7.0, bottom + 42.5), Anchor::Start, "< 0", ink);
        }
    }
}

/// Place in the unit disc of its hemisphere, and whether that is the lower one.
fn project(direction: &[f64; 3], name: &str, index: usize) -> Result<((f64, f64), bool), Error> {
    check_finite(&format!("direction {index} of {name}"), direction)?;
    let largest = direction.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    if largest == 0.0 {
        return Err(Error::NoDirection {
            series: name.into(),
            index,
        });
    }
    // Scaled first: the square of a very long vector would overflow.
    let [x, y, z] = direction.map(|v| v / largest);
    let length = (x * x + y * y + z * z).sqrt();
    let [x, y, z] = [x / length, y / length, z / length];
    let lower = z < 0.0;
    // √(1 − |z|) over √(1 − z²): finite at the pole.
    let scale = 1.0 / (1.0 + z.abs()).sqrt();
    let x = if lower { -x } else { x };
    Ok(((scale * x, scale * y), lower))
}

/// A label beside its point, inside the discs where there is room, over nothing else.
fn write_label(svg: &mut Svg, ink: &mut Ink, layout: &Layout, (x, y): (f64, f64), label: &str) {
    let w = text_width(label, LABEL);
    let outside = |area: &Area| {
        let beyond = |a: f64, b: f64| {
            let from = |c: &(f64, f64)| (a - c.0).hypot(b - c.1);
            layout
                .centres
                .iter()
                .map(from)
                .fold(f64::INFINITY, f64::min)
                > layout.radius - 2.0
        };
        let [a, b, c, d] = *area;
        [(a, b), (c, b), (a, d), (c, d)]
            .iter()
            .filter(|corner| beyond(corner.0, corner.1))
            .count()
    };
    let mut places = Vec::new();
    for (n, d) in [8.0, 12.0].into_iter().enumerate() {
        for (left, base) in [
            (x + d, y + 3.5),
            (x - d - w, y + 3.5),
            (x - 0.5 * w, y - d),
            (x - 0.5 * w, y + d + 7.0),
            (x + 0.6 * d, y - 0.7 * d),
            (x + 0.6 * d, y + 0.7 * d + 7.0),
            (x - 0.6 * d - w, y - 0.7 * d),
            (x - 0.6 * d - w, y + 0.7 * d + 7.0),
        ] {
            let area = [left, base - 7.5, left + w, base + 0.5];
            let handicap = 10.0 * n as f64 + 6.0 * outside(&area) as f64;
            let area = [
                area[0].max(2.0),
                area[1],
                area[2].min(layout.bar - 4.0),
                area[3],
            ];
            places.push((area, handicap));
        }
    }
    if let Some(best) = ink.place(&places) {
        let area = places[best].0;
        let style = "font-size=\"9.5\" fill=\"#222\"";
        svg.text_over((area[0], area[3] - 0.5), Anchor::Start, label, style);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_projection_keeps_areas() {
        // The cap of polar angle θ has the share 1 − cos θ of the hemisphere, and ρ² of the disc.
        for theta in [0.0_f64, 0.3, 1.0, 1.5] {
            let ((x, y), lower) =
                project(&[3.0 * theta.sin(), 0.0, 3.0 * theta.cos()], "t", 0).unwrap();
            assert!(!lower && y == 0.0);
            assert!((x * x - (1.0 - theta.cos())).abs() < 1e-14);
        }
        assert!(project(&[0.0; 3], "t", 4).is_err());
        assert!(project(&[1e200, 1e200, 0.0], "t", 4).is_ok());
    }
}
