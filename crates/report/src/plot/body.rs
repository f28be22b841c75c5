//! Deformed bodies, shaded, beside each other: what a mode looks like.

use super::colour;
use super::svg::{Anchor, Svg};
use super::{check_finite, check_length};
use crate::Error;
use proofmass_core::dot;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One surface in several deformed states, seen from the same point.
///
/// Orthographic view from the side of the rising face; colour is the size of the displacement over its largest, light
/// falls from above. The edges of the body at rest are thin lines. Displacements are drawn so that the largest is a
/// tenth of the body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BodyPlot {
    /// Points of the surface at rest.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) points: Vec<[f64; 3]>,
    /// Triangles, corners turning outwards.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) triangles: Vec<[u32; 3]>,
    /// States.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) states: Vec<BodyState>,
}

/// One deformed state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BodyState {
    /// Words above it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) title: String,
    /// Words below it, smaller.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) note: String,
    /// Displacement of every point, in any unit.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) displacement: Vec<[f64; 3]>,
}

/// Width of the drawing.
const WIDTH: f64 = 760.0;
/// Bodies in a row.
const ACROSS: usize = 3;
/// Direction towards the onlooker: before the rising face, to its right, above.
const VIEW: [f64; 3] = [-0.66, -0.60, 0.45];
/// Share of the size of the body by which the largest displacement is drawn.
const DRAWN: f64 = 0.10;
/// Cosine between two faces below which their common edge is an edge of the body.
const CREASE: f64 = 0.85;

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let size = dot(a, a).sqrt();
    if size > 0.0 { a.map(|c| c / size) } else { a }
}

/// Directions of the picture: right, up, towards the onlooker.
fn camera() -> [[f64; 3]; 3] {
    let towards = unit(VIEW);
    let right = unit(cross([0.0, 0.0, 1.0], towards));
    [right, cross(towards, right), towards]
}

impl BodyPlot {
    /// A surface at rest.
    pub fn new(points: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        Self {
            points,
            triangles,
            states: Vec::new(),
        }
    }

    /// Adds a deformed state.
    #[must_use]
    pub fn state(
        mut self,
        title: impl Into<String>,
        note: impl Into<String>,
        displacement: Vec<[f64; 3]>,
    ) -> Self {
        self.states.push(BodyState {
            title: title.into(),
            note: note.into(),
            displacement,
        });
        self
    }

    /// Edges of triangles that are edges of the body, smaller index first.
    fn creases(&self) -> Vec<(u32, u32)> {
        let mut normals: BTreeMap<(u32, u32), Vec<[f64; 3]>> = BTreeMap::new();
        for t in &self.triangles {
            let [a, b, c] = t.map(|i| self.points[i as usize]);
            let e: [f64; 3] = std::array::from_fn(|k| b[k] - a[k]);
            let f: [f64; 3] = std::array::from_fn(|k| c[k] - a[k]);
            let n = unit(cross(e, f));
            for (p, q) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                normals.entry((p.min(q), p.max(q))).or_default().push(n);
            }
        }
        normals
            .into_iter()
            .filter(|(_, n)| n.len() != 2 || dot(n[0], n[1]) < CREASE)
            .map(|(edge, _)| edge)
            .collect()
    }

    pub(super) fn draw(&self, title: &str, id: &str) -> Result<String, Error> {
        check_finite(title, self.points.as_flattened())?;
        let largest_index = self.triangles.iter().flatten().copied().max();
        if let Some(index) = largest_index.filter(|&i| i as usize >= self.points.len()) {
            return Err(Error::Length {
                name: format!("points of {title}"),
                expected: index as usize + 1,
                got: self.points.len(),
            });
        }
        for state in &self.states {
            check_length(&state.title, self.points.len(), state.displacement.len())?;
            check_finite(&state.title, state.displacement.as_flattened())?;
        }
        let [right, up, _] = camera();
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for p in &self.points {
            for (k, v) in [dot(*p, right), -dot(*p, up)].into_iter().enumerate() {
                low[k] = low[k].min(v);
                high[k] = high[k].max(v);
            }
        }
        let span = [high[0] - low[0], high[1] - low[1]];
        let size = span[0].max(span[1]).max(f64::MIN_POSITIVE);
        let cell = WIDTH / ACROSS as f64;
        // Room for the displacement on either side.
        let scale = ((cell - 16.0) / (span[0] + 2.2 * DRAWN * size))
            .min(280.0 / (span[1] + 2.2 * DRAWN * size));
        let tall = scale * (span[1] + 2.2 * DRAWN * size);
        let row = tall + 52.0;
        let rows = self.states.len().div_ceil(ACROSS).max(1);
        let mut svg = Svg::new(WIDTH, row * rows as f64 + 44.0, title, id);
        let creases = self.creases();
        for (n, state) in self.states.iter().enumerate() {
            let left = cell * (n % ACROSS) as f64;
            let top = row * (n / ACROSS) as f64;
            let centre = [left + 0.5 * cell, top + 40.0 + 0.5 * tall];
            let middle = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])];
            let place = |p: [f64; 3]| {
                (
                    centre[0] + scale * (dot(p, right) - middle[0]),
                    centre[1] + scale * (-dot(p, up) - middle[1]),
                )
            };
            svg.text(
                (centre[0], top + 16.0),
                Anchor::Middle,
                &state.title,
                "font-weight=\"bold\" fill=\"#111\"",
            );
            svg.text(
                (centre[0], top + 31.0),
                Anchor::Middle,
                &state.note,
                "font-size=\"10.5\" fill=\"#444\"",
            );
            for &(a, b) in &creases {
                svg.line(
                    place(self.points[a as usize]),
                    place(self.points[b as usize]),
                    "stroke=\"#9a9a9a\" stroke-width=\"0.7\"",
                );
            }
            self.surface(&mut svg, state, size, &creases, &place);
        }
        legend(&mut svg, row * rows as f64 + 8.0);
        svg.finish(title)
    }

    /// Triangles that face the onlooker, the far ones first.
    fn surface(
        &self,
        svg: &mut Svg,
        state: &BodyState,
        size: f64,
        creases: &[(u32, u32)],
        place: &dyn Fn([f64; 3]) -> (f64, f64),
    ) {
        let [_, up, towards] = camera();
        let light = unit([
            0.5 * towards[0] + 0.5 * up[0] - 0.35,
            0.5 * towards[1] + 0.5 * up[1] + 0.1,
            0.5 * towards[2] + 0.8 * up[2],
        ]);
        let length = |u: &[f64; 3]| dot(*u, *u).sqrt();
        let largest = state.displacement.iter().map(length).fold(0.0, f64::max);
        let unit_size = if largest > 0.0 { largest } else { 1.0 };
        let factor = DRAWN * size / unit_size;
        let moved: Vec<[f64; 3]> = self
            .points
            .iter()
            .zip(&state.displacement)
            .map(|(p, u)| std::array::from_fn(|k| p[k] + factor * u[k]))
            .collect();
        let mut visible: Vec<(f64, usize, f64)> = self
            .triangles
            .iter()
            .enumerate()
            .filter_map(|(i, t)| {
                let [a, b, c] = t.map(|i| moved[i as usize]);
                let e: [f64; 3] = std::array::from_fn(|k| b[k] - a[k]);
                let f: [f64; 3] = std::array::from_fn(|k| c[k] - a[k]);
                let n = unit(cross(e, f));
                let depth = dot(a, towards) + dot(b, towards) + dot(c, towards);
                (dot(n, towards) > 0.0).then(|| (depth, i, dot(n, light).max(0.0)))
            })
            .collect();
        visible.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, i, light) in visible {
            let t = self.triangles[i];
            let value = t
                .iter()
                .map(|&i| length(&state.displacement[i as usize]))
                .sum::<f64>()
                / (3.0 * unit_size);
            let fill = colour::shaded(value, 0.55 + 0.45 * light);
            let corners = t.map(|i| place(moved[i as usize]));
            // The stroke of its own colour closes the hair lines between triangles.
            svg.path(
                &corners,
                true,
                &format!("fill=\"{fill}\" stroke=\"{fill}\" stroke-width=\"0.6\""),
            );
            for (p, q) in [(0, 1), (1, 2), (2, 0)] {
                let edge = (t[p].min(t[q]), t[p].max(t[q]));
                if creases.binary_search(&edge).is_ok() {
                    svg.line(
                        corners[p],
                        corners[q],
                        "stroke=\"#1a1a1a\" stroke-width=\"0.8\"",
                    );
                }
            }
        }
    }
}

/// What colours and lines mean.
fn legend(svg: &mut Svg, top: f64) {
    let ink = "font-size=\"10.5\" fill=\"#333\"";
    let (left, width, steps) = (250.0, 150.0, 50);
    for k in 0..steps {
        let part = f64::from(k) / f64::from(steps);
        let style = format!("fill=\"{}\"", colour::sequential(part));
        let wide = width / f64::from(steps) + 0.4;
        svg.rect((left + width * part, top), (wide, 10.0), &style);
    }
    svg.rect(
        (left, top),
        (width, 10.0),
        "fill=\"none\" stroke=\"#333\" stroke-width=\"0.6\"",
    );
    svg.text(
        (left - 6.0, top + 9.0),
        Anchor::End,
        "displacement: none",
        ink,
    );
    svg.text(
        (left + width + 6.0, top + 9.0),
        Anchor::Start,
        "largest",
        ink,
    );
    svg.line(
        (520.0, top + 5.0),
        (545.0, top + 5.0),
        "stroke=\"#9a9a9a\" stroke-width=\"0.9\"",
    );
    svg.text((551.0, top + 9.0), Anchor::Start, "at rest", ink);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_edges_of_a_tetrahedron_and_refusals() {
        let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let plot = BodyPlot::new(points.clone(), triangles.clone());
        assert_eq!(plot.creases().len(), 6);
        let drawn = plot
            .clone()
            .state("mode 1", "", vec![[0.0, 0.0, 1.0]; 4])
            .draw("t", "i")
            .unwrap();
        assert!(drawn.contains("<path") && drawn.contains("mode 1"));
        // No displacement at all is drawn at rest.
        assert!(
            plot.clone()
                .state("", "", vec![[0.0; 3]; 4])
                .draw("t", "i")
                .is_ok()
        );
        assert!(plot.clone().state("", "", vec![]).draw("t", "i").is_err());
        let bad = vec![[f64::NAN; 3]; 4];
        assert!(plot.state("", "", bad).draw("t", "i").is_err());
        assert!(
            BodyPlot::new(points, vec![[0, 1, 9]])
                .draw("t", "i")
                .is_err()
        );
    }
}
