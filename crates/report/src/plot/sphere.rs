//! Directions on the unit sphere: two hemispheres side by side in Lambert's equal-area projection.

use super::svg::{Anchor, Svg, text_width};
use super::ticks;
use super::{check_finite, colour};
use crate::Error;

/// Directions, each coloured by a value.
///
/// The left disc shows the hemisphere around +z seen from outside, the right one that around −z; they open like
/// a book about their common +x point. Radius ρ = √(1 − |cos θ|), so equal areas on the sphere are equal on
/// paper and clusters or holes of attitudes show as what they are. Positive values are discs, negative ones
/// squares, so that the sign survives a black and white print.
#[derive(Clone, Debug, PartialEq)]
pub struct SpherePlot {
    /// The points.
    pub points: Vec<SpherePoint>,
    /// What the value is, beside the colour bar.
    pub value_label: String,
    /// Its unit; empty or `1` for a pure number.
    pub unit: String,
    /// Names of the three axes.
    pub axes: [String; 3],
}

/// A direction with a value.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpherePoint {
    /// Direction; its length is ignored.
    pub direction: [f64; 3],
    /// Value, shown by colour.
    pub value: f64,
    /// Label beside the point; empty for none.
    pub label: String,
}

const R: f64 = 150.0;
const TOP: f64 = 36.0;

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
        let (width, height) = (760.0, 2.0 * R + TOP + 36.0);
        let mut svg = Svg::new(width, height, title, id);
        let centres = [(24.0 + R, TOP + R), (24.0 + 3.0 * R + 36.0, TOP + R)];
        for (centre, sign) in centres.iter().zip(["+", "−"]) {
            self.graticule(&mut svg, *centre, sign);
        }
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
        let mut labels: Vec<(f64, f64, &str)> = Vec::new();
        for (index, point) in self.points.iter().enumerate() {
            let (at, lower) = project(&point.direction, &self.value_label, index)?;
            let centre = centres[usize::from(lower)];
            let at = (centre.0 + R * at.0, centre.1 - R * at.1);
            let style = format!(
                "fill=\"{}\" stroke=\"#222\" stroke-width=\"0.9\"",
                shade(point.value)
            );
            if point.value < 0.0 {
                svg.rect((at.0 - 5.0, at.1 - 5.0), (10.0, 10.0), &style);
            } else {
                svg.circle(at, 5.6, &style);
            }
            if !point.label.is_empty() {
                labels.push((at.0, at.1, &point.label));
            }
        }
        place_labels(&mut svg, &labels);
        self.colour_bar(&mut svg, (from, to), signed, &shade);
        svg.finish(title)
    }

    fn graticule(&self, svg: &mut Svg, centre: (f64, f64), sign: &str) {
        svg.circle(centre, R, "fill=\"#fbfbfb\" stroke=\"#333\"");
        for theta in [30.0_f64, 60.0] {
            let r = R * (1.0 - theta.to_radians().cos()).sqrt();
            svg.circle(centre, r, "fill=\"none\" stroke=\"#ddd\"");
            let text = format!("{theta}°");
            svg.text(
                (centre.0 + 3.0, centre.1 - r - 2.0),
                Anchor::Start,
                &text,
                "font-size=\"9\" fill=\"#999\"",
            );
        }
        for k in 0..4 {
            let (s, c) = (f64::from(k) * 45.0_f64.to_radians()).sin_cos();
            let style = if k % 2 == 0 {
                "stroke=\"#ccc\""
            } else {
                "stroke=\"#e6e6e6\""
            };
            svg.line(
                (centre.0 - R * c, centre.1 - R * s),
                (centre.0 + R * c, centre.1 + R * s),
                style,
            );
        }
        let [x, y, z] = &self.axes;
        let ink = "font-size=\"11\" fill=\"#333\"";
        // Seen from outside, the far hemisphere has its x axis pointing left.
        let (right, left) = if sign == "+" {
            ("+", "−")
        } else {
            ("−", "+")
        };
        svg.text(
            (centre.0 + R + 4.0, centre.1 + 4.0),
            Anchor::Start,
            &format!("{right}{x}"),
            ink,
        );
        svg.text(
            (centre.0 - R - 4.0, centre.1 + 4.0),
            Anchor::End,
            &format!("{left}{x}"),
            ink,
        );
        svg.text(
            (centre.0, centre.1 - R - 5.0),
            Anchor::Middle,
            &format!("+{y}"),
            ink,
        );
        svg.text(
            (centre.0, centre.1 + R + 14.0),
            Anchor::Middle,
            &format!("−{y}"),
            ink,
        );
        svg.text(
            (centre.0 - R, centre.1 - R - 12.0),
            Anchor::Start,
            &format!("hemisphere around {sign}{z}"),
            "font-weight=\"bold\" fill=\"#111\"",
        );
    }

    fn colour_bar(
        &self,
        svg: &mut Svg,
        (from, to): (f64, f64),
        signed: bool,
        shade: &dyn Fn(f64) -> String,
    ) {
        let (x, top, bottom) = (24.0 + 4.0 * R + 36.0 + 34.0, TOP, TOP + 2.0 * R - 24.0);
        let steps = 60;
        for i in 0..steps {
            let t = (f64::from(i) + 0.5) / f64::from(steps);
            let y = bottom - (bottom - top) * f64::from(i + 1) / f64::from(steps);
            let style = format!("fill=\"{}\"", shade(from + t * (to - from)));
            // A little overlap, or hair lines show between the steps.
            svg.rect(
                (x, y),
                (12.0, (bottom - top) / f64::from(steps) + 0.4),
                &style,
            );
        }
        svg.rect(
            (x, top),
            (12.0, bottom - top),
            "fill=\"none\" stroke=\"#333\"",
        );
        let marks = ticks::linear(from, to, 6);
        for (v, label) in &marks.major {
            let y = bottom - (bottom - top) * (v - from) / (to - from);
            svg.line((x + 12.0, y), (x + 16.0, y), "stroke=\"#333\"");
            svg.text(
                (x + 18.0, y + 4.0),
                Anchor::Start,
                label,
                "font-size=\"10\" fill=\"#333\"",
            );
        }
        let axis = super::Axis::linear(self.value_label.as_str(), self.unit.as_str());
        let title = axis.title(&marks);
        let size = (11.0 * 330.0 / text_width(&title, 11.0).max(1.0)).clamp(7.0, 11.0);
        svg.text_upwards(
            (x - 6.0, 0.5 * (top + bottom)),
            Anchor::Middle,
            &title,
            &format!("font-size=\"{size:.1}\" fill=\"#111\""),
        );
        if signed {
            let grey = "fill=\"#ddd\" stroke=\"#222\" stroke-width=\"0.9\"";
            let ink = "font-size=\"10\" fill=\"#333\"";
            svg.circle((x - 8.0, bottom + 18.0), 5.0, grey);
            svg.text((x, bottom + 22.0), Anchor::Start, "≥ 0", ink);
            svg.rect((x + 27.0, bottom + 13.5), (9.0, 9.0), grey);
            svg.text((x + 40.0, bottom + 22.0), Anchor::Start, "< 0", ink);
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

/// Labels right of, left of, above or below their points: the first place that crosses no other label or point.
fn place_labels(svg: &mut Svg, labels: &[(f64, f64, &str)]) {
    let mut taken: Vec<[f64; 4]> = labels
        .iter()
        .map(|l| [l.0 - 5.0, l.1 - 5.0, l.0 + 5.0, l.1 + 5.0])
        .collect();
    for &(x, y, label) in labels {
        let w = text_width(label, 9.5);
        let places = [
            (x + 8.0, y + 3.5),
            (x - 8.0 - w, y + 3.5),
            (x - 0.5 * w, y - 8.0),
            (x - 0.5 * w, y + 15.0),
            (x + 5.0, y - 7.0),
            (x + 5.0, y + 13.0),
        ];
        let area = |p: &(f64, f64)| [p.0, p.1 - 8.0, p.0 + w, p.1];
        let overlap = |a: &[f64; 4]| {
            taken
                .iter()
                .map(|b| {
                    (a[2].min(b[2]) - a[0].max(b[0])).max(0.0)
                        * (a[3].min(b[3]) - a[1].max(b[1])).max(0.0)
                })
                .sum::<f64>()
        };
        let best = places
            .iter()
            .min_by(|a, b| overlap(&area(a)).total_cmp(&overlap(&area(b))))
            .unwrap_or(&places[0]);
        taken.push(area(best));
        svg.text(
            *best,
            Anchor::Start,
            label,
            "font-size=\"9.5\" fill=\"#222\" paint-order=\"stroke\" stroke=\"#fff\" stroke-width=\"2.5\" stroke-linejoin=\"round\"",
        );
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
