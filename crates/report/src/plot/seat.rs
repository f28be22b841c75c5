//! The frame of a bench with wedges: axes of table and device, and the senses of inclination and rotation.

use super::svg::{Anchor, Svg};
use crate::Error;
use serde::{Deserialize, Serialize};

/// Table, wedge and device from the side, and the device from above on its face, with the axes x′, y′, z′ and x, y, z and
/// the senses in which α and ω are positive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SeatPlot;

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 300.0;
/// Angles that are drawn, degrees.
const ALPHA: f64 = 30.0;
const OMEGA: f64 = 25.0;

const INK: &str = "#222";
const TABLE: &str = "#0072b2";
const DEVICE: &str = "#d55e00";

/// A point and a direction of the picture, y upwards.
type Vector = (f64, f64);

fn along(from: Vector, direction: Vector, length: f64) -> Vector {
    (from.0 + length * direction.0, from.1 - length * direction.1)
}

/// Unit vector at an angle from the right, counter-clockwise, degrees.
fn heading(degrees: f64) -> Vector {
    let (sin, cos) = degrees.to_radians().sin_cos();
    (cos, sin)
}

fn arrow(
    svg: &mut Svg,
    from: Vector,
    degrees: f64,
    length: f64,
    colour: &str,
    dashed: bool,
) -> Vector {
    let tip = along(from, heading(degrees), length);
    let dash = if dashed {
        " stroke-dasharray=\"5 4\""
    } else {
        ""
    };
    svg.line(
        from,
        tip,
        &format!("stroke=\"{colour}\" stroke-width=\"1.8\"{dash}"),
    );
    head(svg, tip, degrees, colour);
    tip
}

fn head(svg: &mut Svg, tip: Vector, degrees: f64, colour: &str) {
    let back = [160.0, -160.0].map(|turn| along(tip, heading(degrees + turn), 10.0));
    svg.path(
        &[tip, back[0], back[1]],
        true,
        &format!("fill=\"{colour}\""),
    );
}

/// An arc about a centre from one angle to another with a head at its end.
fn arc(svg: &mut Svg, centre: Vector, radius: f64, [from, to]: [f64; 2]) {
    let steps = 24;
    let at = |k: i32| from + (to - from) * f64::from(k) / f64::from(steps);
    let points: Vec<Vector> = (0..=steps)
        .map(|k| along(centre, heading(at(k)), radius))
        .collect();
    svg.path(
        &points,
        false,
        &format!("fill=\"none\" stroke=\"{INK}\" stroke-width=\"1.2\""),
    );
    let turn = if to > from { 90.0 } else { -90.0 };
    head(svg, points[points.len() - 1], to + turn, INK);
}

fn word(svg: &mut Svg, at: Vector, anchor: Anchor, text: &str, colour: &str) {
    svg.text(
        at,
        anchor,
        text,
        &format!("font-size=\"13\" fill=\"{colour}\""),
    );
}

impl SeatPlot {
    pub(super) fn draw(self, title: &str, id: &str) -> Result<String, Error> {
        let mut svg = Svg::new(WIDTH, HEIGHT, title, id);
        side(&mut svg);
        above(&mut svg);
        svg.finish(title)
    }
}

/// From the side, y′ into the page.
fn side(svg: &mut Svg) {
    let small = "font-size=\"11\" fill=\"#444\"";
    svg.text(
        (190.0, 18.0),
        Anchor::Middle,
        "from the side, y′ into the page",
        small,
    );
    let toe = (110.0, 250.0);
    let slope = heading(ALPHA);
    let top = along(toe, slope, 240.0);
    svg.line(
        (30.0, 250.0),
        (370.0, 250.0),
        &format!("stroke=\"{INK}\" stroke-width=\"2.5\""),
    );
    svg.text((372.0, 266.0), Anchor::End, "table", small);
    svg.path(
        &[toe, top, (top.0, 250.0)],
        true,
        &format!("fill=\"#eee\" stroke=\"{INK}\" stroke-width=\"1.2\""),
    );
    svg.text((270.0, 236.0), Anchor::Middle, "wedge", small);
    // The device on the face.
    let normal = heading(ALPHA + 90.0);
    let first = along(toe, slope, 110.0);
    let corners = [
        first,
        along(first, slope, 50.0),
        along(along(first, slope, 50.0), normal, 26.0),
        along(first, normal, 26.0),
    ];
    svg.path(
        &corners,
        true,
        &format!("fill=\"#fbe3d3\" stroke=\"{DEVICE}\" stroke-width=\"1.4\""),
    );
    let middle = along(along(first, slope, 25.0), normal, 13.0);
    let x = arrow(svg, middle, ALPHA, 105.0, DEVICE, false);
    word(
        svg,
        (x.0 + 6.0, x.1 + 2.0),
        Anchor::Start,
        "x (ω = 0)",
        DEVICE,
    );
    let z = arrow(svg, middle, ALPHA + 90.0, 100.0, DEVICE, false);
    word(svg, (z.0 - 4.0, z.1 - 6.0), Anchor::Middle, "z", DEVICE);
    let origin = (48.0, 210.0);
    let across = arrow(svg, origin, 0.0, 55.0, TABLE, false);
    word(
        svg,
        (across.0 + 5.0, across.1 - 6.0),
        Anchor::Middle,
        "x′",
        TABLE,
    );
    let up = arrow(svg, origin, 90.0, 120.0, TABLE, false);
    // It is longer than the margin left of the arrow.
    word(
        svg,
        (12.0, up.1 - 8.0),
        Anchor::Start,
        "z′ = excitation",
        TABLE,
    );
    // y′ leaves the onlooker: the feathers of an arrow.
    svg.path(
        &(0..=24)
            .map(|k| along(origin, heading(15.0 * f64::from(k)), 6.0))
            .collect::<Vec<_>>(),
        true,
        &format!("fill=\"#fff\" stroke=\"{TABLE}\" stroke-width=\"1.4\""),
    );
    for turn in [45.0, 135.0] {
        let ends = [turn, turn + 180.0].map(|a| along(origin, heading(a), 6.0));
        svg.line(
            ends[0],
            ends[1],
            &format!("stroke=\"{TABLE}\" stroke-width=\"1.4\""),
        );
    }
    word(
        svg,
        (origin.0 - 10.0, origin.1 + 18.0),
        Anchor::Middle,
        "y′",
        TABLE,
    );
    arc(svg, toe, 62.0, [0.0, ALPHA]);
    word(svg, (toe.0 + 76.0, toe.1 - 14.0), Anchor::Start, "α", INK);
}

/// From above on the face, its normal towards the onlooker.
fn above(svg: &mut Svg) {
    let small = "font-size=\"11\" fill=\"#444\"";
    svg.text(
        (575.0, 18.0),
        Anchor::Middle,
        "from above on the face, z towards the onlooker",
        small,
    );
    let centre = (560.0, 175.0);
    let corner = |angle: f64, turn: f64| along(centre, heading(angle + turn), 52.0);
    let square = |turn: f64| [45.0, 135.0, 225.0, 315.0].map(|a| corner(a, turn));
    svg.path(
        &square(0.0),
        true,
        "fill=\"none\" stroke=\"#999\" stroke-width=\"1\" stroke-dasharray=\"4 4\"",
    );
    svg.path(
        &square(-OMEGA),
        true,
        &format!("fill=\"#fbe3d3\" stroke=\"{DEVICE}\" stroke-width=\"1.4\""),
    );
    let slope = arrow(svg, centre, 0.0, 125.0, "#999", true);
    svg.text(
        (slope.0 + 4.0, slope.1 - 8.0),
        Anchor::Middle,
        "up the slope",
        small,
    );
    let x = arrow(svg, centre, -OMEGA, 110.0, DEVICE, false);
    word(svg, (x.0 + 6.0, x.1 + 8.0), Anchor::Start, "x", DEVICE);
    let y = arrow(svg, centre, 90.0 - OMEGA, 110.0, DEVICE, false);
    word(svg, (y.0 + 4.0, y.1 - 6.0), Anchor::Start, "y", DEVICE);
    let across = arrow(svg, centre, 90.0, 105.0, TABLE, true);
    word(
        svg,
        (across.0 - 6.0, across.1 - 4.0),
        Anchor::End,
        "y′",
        TABLE,
    );
    arc(svg, centre, 82.0, [0.0, -OMEGA]);
    word(
        svg,
        (centre.0 + 92.0, centre.1 + 24.0),
        Anchor::Start,
        "ω",
        INK,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_the_device_is_right_handed_in_both_views() {
        // Seen from above, y is a quarter turn counter-clockwise from x; from the side z likewise, with y away from the
        // onlooker.
        let turn = |a: Vector, b: Vector| a.0 * b.1 - a.1 * b.0;
        assert!((turn(heading(-OMEGA), heading(90.0 - OMEGA)) - 1.0).abs() < 1e-12);
        assert!((turn(heading(ALPHA), heading(ALPHA + 90.0)) - 1.0).abs() < 1e-12);
        let drawn = SeatPlot.draw("frame", "f").unwrap();
        for label in ["x′", "y′", "z′", "α", "ω"] {
            assert!(drawn.contains(label), "{label}");
        }
    }
}
