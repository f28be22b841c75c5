//! Words in an [`XyPlot`](super::XyPlot): legend, labels of references, power laws and notes, none over another.

use super::axis::Mapping;
use super::colour;
use super::decimate;
use super::drawing::{SHADES, marker, slope_points, stroke};
use super::frame::{Frame, SMALL};
use super::placing::{AID, Area, DATA, Ink, TEXT};
use super::svg::{Anchor, Svg, shortened, text_width};
use super::xy::{Panel, Series, Shade, Style};

const INK: &str = "font-size=\"11\" fill=\"#444\"";
/// A label of a horizontal reference up to this long stands in the right margin, a longer one on its line.
const MARGIN: f64 = 150.0;
/// Height of a letter of size [`SMALL`] over its base line.
const LETTER: f64 = 9.0;
const LEGEND_ROW: f64 = 18.0;
const LABEL_ROW: f64 = 13.0;

/// One line of a legend.
#[derive(Clone, Copy)]
pub(super) enum Entry<'a> {
    Line(&'a Series, usize),
    Area(&'a Shade, usize),
}

impl Entry<'_> {
    fn name(&self) -> &str {
        match self {
            Self::Line(series, _) => &series.name,
            Self::Area(shade, _) => &shade.name,
        }
    }

    /// Same name and same look: one entry is enough for both.
    fn repeats(&self, other: &Entry) -> bool {
        self.name() == other.name()
            && match (self, other) {
                (Self::Line(a, i), Entry::Line(b, j)) => {
                    i == j && a.style == b.style && a.band.is_some() == b.band.is_some()
                }
                (Self::Area(_, i), Entry::Area(_, j)) => i == j,
                _ => false,
            }
    }
}

/// What the legend of each panel names: everything with a name that no panel above has explained.
pub(super) fn legends(panels: &[Panel]) -> Vec<Vec<Entry<'_>>> {
    let mut seen: Vec<Entry> = Vec::new();
    panels
        .iter()
        .map(|panel| {
            let lines = panel.series.iter().enumerate();
            let areas = panel.shades.iter().enumerate();
            let mut entries: Vec<Entry> = lines
                .map(|(i, series)| Entry::Line(series, series.look.unwrap_or(i)))
                .chain(areas.map(|(i, shade)| Entry::Area(shade, i % SHADES.len())))
                .collect();
            entries.retain(|e| !e.name().is_empty() && !seen.iter().any(|s| s.repeats(e)));
            seen.extend(&entries);
            entries
        })
        .collect()
}

/// Left end and row of each entry.
fn legend_places(entries: &[Entry], left: f64, right: f64) -> Vec<(f64, usize)> {
    let mut places = Vec::new();
    let (mut x, mut row) = (left, 0);
    for entry in entries {
        let width = 34.0 + text_width(entry.name(), 12.0) + 18.0;
        if x + width - 18.0 > right && x > left {
            x = left;
            row += 1;
        }
        places.push((x, row));
        x += width;
    }
    places
}

/// Draws a legend whose first row begins at `top`.
pub(super) fn draw_legend(svg: &mut Svg, frame: &Frame, entries: &[Entry], top: f64) {
    let places = legend_places(entries, frame.left, frame.right);
    for (entry, (x, row)) in entries.iter().zip(places) {
        let y = top + 9.0 + LEGEND_ROW * row as f64;
        match *entry {
            Entry::Line(series, look) => {
                if series.band.is_some() {
                    let style = format!("fill=\"{}\" fill-opacity=\"0.18\"", colour::series(look));
                    svg.rect((x, y - 6.0), (28.0, 12.0), &style);
                }
                if series.style != Style::Markers {
                    svg.line((x, y), (x + 28.0, y), &stroke(look));
                }
                if matches!(series.style, Style::Markers | Style::LineAndMarkers) {
                    marker(svg, (x + 14.0, y), look, "");
                }
            }
            Entry::Area(_, fill) => {
                let style = format!("fill=\"{}\" stroke=\"#bbb\"", SHADES[fill]);
                svg.rect((x, y - 6.0), (28.0, 12.0), &style);
            }
        }
        let ink = "fill=\"#111\"";
        let name = shortened(entry.name(), 12.0, frame.right - x - 34.0);
        svg.text((x + 34.0, y + 4.0), Anchor::Start, &name, ink);
    }
}

impl Panel {
    /// Height above the frame for the legend and the labels of vertical references.
    pub(super) fn head(&self, entries: &[Entry], x: &Mapping, (left, right): (f64, f64)) -> f64 {
        let rows = |last: Option<usize>| last.map_or(0.0, |row| (row + 1) as f64);
        let legend = legend_places(entries, left, right);
        let labels = self.vertical_labels(x, (left, right));
        LEGEND_ROW * rows(legend.iter().map(|p| p.1).max())
            + LABEL_ROW * rows(labels.iter().map(|l| l.2).max())
            + 6.0
    }

    /// Room that the labels of horizontal references take on the right.
    pub(super) fn right_margin(&self) -> f64 {
        self.horizontal
            .iter()
            .map(|r| text_width(&r.label, SMALL))
            .filter(|&width| width > 0.0 && width <= MARGIN)
            .fold(0.0, f64::max)
    }

    /// Centre, label and row above the frame of each vertical reference.
    fn vertical_labels(&self, x: &Mapping, (left, right): (f64, f64)) -> Vec<(f64, String, usize)> {
        let mut ends: Vec<f64> = Vec::new();
        let mut placed = Vec::new();
        let mut sorted: Vec<_> = self
            .vertical
            .iter()
            .filter(|r| !r.label.is_empty() && x.inside(r.at))
            .collect();
        sorted.sort_by(|a, b| a.at.total_cmp(&b.at));
        for reference in sorted {
            let label = shortened(&reference.label, SMALL, right - left);
            let half = 0.5 * text_width(&label, SMALL);
            let centre = x
                .at(reference.at)
                .clamp(left + half, (right - half).max(left + half));
            let row = ends.iter().position(|&end| end + 8.0 <= centre - half);
            let row = row.unwrap_or(ends.len());
            if row == ends.len() {
                ends.push(0.0);
            }
            ends[row] = centre + half;
            placed.push((centre, label, row));
        }
        placed
    }

    /// All labels of the panel.
    pub(super) fn labels(&self, svg: &mut Svg, frame: &Frame) {
        for (centre, label, row) in self.vertical_labels(&frame.x, (frame.left, frame.right)) {
            let y = frame.top - 5.0 - LABEL_ROW * row as f64;
            svg.text((centre, y), Anchor::Middle, &label, INK);
        }
        self.margin_labels(svg, frame);
        if self.needs_places() {
            let mut ink = self.ink(frame);
            self.notes(svg, frame, &mut ink);
            self.slope_labels(svg, frame, &mut ink);
            self.long_labels(svg, frame, &mut ink);
        }
    }

    fn needs_places(&self) -> bool {
        let long = |label: &str| text_width(label, SMALL) > MARGIN;
        !self.notes.is_empty()
            || self.slopes.iter().any(|s| !s.label.is_empty())
            || self.horizontal.iter().any(|r| long(&r.label))
    }

    /// Labels of horizontal references right of the frame: pushed down, then up again where they pass its foot.
    fn margin_labels(&self, svg: &mut Svg, frame: &Frame) {
        let mut wanted: Vec<(f64, &str)> = self
            .horizontal
            .iter()
            .filter(|r| !r.label.is_empty() && frame.y.inside(r.at))
            .filter(|r| text_width(&r.label, SMALL) <= MARGIN)
            .map(|r| (frame.y.at(r.at), r.label.as_str()))
            .collect();
        wanted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut free = f64::NEG_INFINITY;
        for (y, _) in &mut wanted {
            *y = y.max(free);
            free = *y + LABEL_ROW;
        }
        let mut free = frame.bottom + 2.0;
        for (y, label) in wanted.iter_mut().rev() {
            *y = y.min(free);
            free = *y - LABEL_ROW;
            svg.text((frame.right + 6.0, *y + 4.0), Anchor::Start, label, INK);
        }
    }

    /// What is drawn in the frame, so that words find the free places.
    fn ink(&self, frame: &Frame) -> Ink {
        let mut ink = Ink::new(frame.right + 10.0, frame.bottom + 10.0);
        for series in &self.series {
            let place = |(&x, &y): (&f64, &f64)| (frame.x.at(x), frame.y.at(y));
            if let Some((lower, upper)) = &series.band {
                for edge in [lower, upper] {
                    ink.line(&decimate::line(series.x.iter().zip(edge).map(place)), AID);
                }
            }
            if let Some((lower, upper)) = &series.bars {
                for ((x, a), b) in series.x.iter().zip(lower).zip(upper) {
                    ink.line(&[place((x, a)), place((x, b))], DATA);
                }
            }
            let points: Vec<_> = series.x.iter().zip(&series.y).map(place).collect();
            if series.style != Style::Markers {
                ink.line(&decimate::line(points.iter().copied()), DATA);
            }
            if matches!(series.style, Style::Markers | Style::LineAndMarkers) {
                for i in decimate::markers(&points) {
                    let (x, y) = points[i];
                    ink.line(&[(x - 3.0, y - 3.0), (x + 3.0, y + 3.0)], DATA);
                    ink.line(&[(x - 3.0, y + 3.0), (x + 3.0, y - 3.0)], DATA);
                }
            }
        }
        for reference in &self.horizontal {
            let y = frame.y.at(reference.at);
            ink.line(&[(frame.left, y), (frame.right, y)], 2.0 * AID);
        }
        for reference in &self.vertical {
            let x = frame.x.at(reference.at);
            ink.line(&[(x, frame.top), (x, frame.bottom)], 2.0 * AID);
        }
        for slope in &self.slopes {
            ink.line(&slope_points(slope, frame), 2.0 * AID);
        }
        ink.line(&[(frame.left, frame.top), (frame.right, frame.top)], TEXT);
        ink
    }

    /// Words at a point: around it, near or a little farther.
    fn notes(&self, svg: &mut Svg, frame: &Frame, ink: &mut Ink) {
        for (x, y, text) in &self.notes {
            let (x, y) = (frame.x.at(*x), frame.y.at(*y));
            let text = shortened(text, SMALL, frame.right - frame.left - 8.0);
            let width = text_width(&text, SMALL);
            let mut places = Vec::new();
            for (n, d) in [7.0, 14.0, 24.0].into_iter().enumerate() {
                for (left, base) in [
                    (x + d, y - d + 3.0),
                    (x - d - width, y - d + 3.0),
                    (x + d, y + d + LETTER - 3.0),
                    (x - d - width, y + d + LETTER - 3.0),
                    (x - 0.5 * width, y - d),
                    (x - 0.5 * width, y + d + LETTER),
                ] {
                    let left = left.clamp(
                        frame.left + 4.0,
                        (frame.right - width - 4.0).max(frame.left + 4.0),
                    );
                    let base = base.clamp(frame.top + LETTER + 3.0, frame.bottom - 4.0);
                    places.push((text_area(left, base, width), 12.0 * n as f64));
                }
            }
            write_at_best(svg, ink, &places, &text, "font-size=\"11\" fill=\"#111\"");
        }
    }

    /// Names of power laws beside their lines, where these are clear of the data.
    fn slope_labels(&self, svg: &mut Svg, frame: &Frame, ink: &mut Ink) {
        for slope in self.slopes.iter().filter(|s| !s.label.is_empty()) {
            let label = shortened(&slope.label, SMALL, 0.6 * (frame.right - frame.left));
            let width = text_width(&label, SMALL);
            let mut places = Vec::new();
            let middle = 0.5 * (frame.left + frame.right);
            for (x, y) in slope_points(slope, frame) {
                // Of equally clear places the one farther from the corners.
                let aside = 0.01 * (x - middle).abs();
                for (left, base) in [
                    (x + 6.0, y - 5.0),
                    (x - 6.0 - width, y - 5.0),
                    (x + 6.0, y + 5.0 + LETTER),
                    (x - 6.0 - width, y + 5.0 + LETTER),
                ] {
                    places.push((text_area(left, base, width), aside));
                }
            }
            places.retain(|(area, _)| within(area, frame));
            write_at_best(svg, ink, &places, &label, INK);
        }
    }

    /// Labels of horizontal references that are too long for the margin, on or under their line.
    fn long_labels(&self, svg: &mut Svg, frame: &Frame, ink: &mut Ink) {
        for reference in self.horizontal.iter().filter(|r| frame.y.inside(r.at)) {
            if text_width(&reference.label, SMALL) <= MARGIN {
                continue;
            }
            let label = shortened(&reference.label, SMALL, frame.right - frame.left - 12.0);
            let width = text_width(&label, SMALL);
            let y = frame.y.at(reference.at);
            let free = (frame.right - frame.left - width - 12.0).max(0.0);
            let mut places = Vec::new();
            for i in 0..=8 {
                let left = frame.left + 6.0 + free * (1.0 - f64::from(i) / 8.0);
                for base in [y - 5.0, y + 5.0 + LETTER] {
                    places.push((text_area(left, base, width), f64::from(i)));
                }
            }
            places.retain(|(area, _)| area[1] >= frame.top && area[3] <= frame.bottom);
            write_at_best(svg, ink, &places, &label, INK);
        }
    }
}

/// What a text covers that starts at `left` on the line `base`.
fn text_area(left: f64, base: f64, width: f64) -> Area {
    [left, base - LETTER, left + width, base + 2.0]
}

fn within(area: &Area, frame: &Frame) -> bool {
    area[0] >= frame.left + 4.0
        && area[1] >= frame.top + 4.0
        && area[2] <= frame.right - 4.0
        && area[3] <= frame.bottom - 4.0
}

fn write_at_best(svg: &mut Svg, ink: &mut Ink, places: &[(Area, f64)], text: &str, style: &str) {
    if let Some(best) = ink.place(places) {
        let area = places[best].0;
        let at = (area[0], area[3] - 2.0);
        svg.text_over(at, Anchor::Start, text, style);
    }
}

#[cfg(test)]
mod tests {
    use super::super::axis::Scale;
    use super::super::{Axis, XyPlot};
    use super::*;

    #[test]
    fn law_one_legend_entry_for_what_looks_and_is_called_alike() {
        let line = |name: &str| Series::line(name, &[0.0], &[0.0]);
        let plot = XyPlot::new(Axis::default(), Axis::default())
            .series(line("a"))
            .series(line("b"))
            .shade("still", &[])
            .below(Axis::default())
            .series(line("a"))
            .series(line("a"))
            .series(line("b").look(1).style(Style::Markers))
            .shade("still", &[]);
        let legends = legends(&plot.panels);
        let names: Vec<Vec<&str>> = legends
            .iter()
            .map(|entries| entries.iter().map(Entry::name).collect())
            .collect();
        // The second "a" below has the look of the second series, the "b" is of markers.
        assert_eq!(names, [vec!["a", "b", "still"], vec!["a", "b"]]);
    }

    #[test]
    fn law_vertical_labels_take_the_rows_they_need() {
        let x = Mapping::new(Scale::Linear, (0.0, 100.0), 0.0, 700.0);
        let head = |at: &[f64]| {
            let plot = XyPlot::new(Axis::default(), Axis::default());
            let plot = at.iter().fold(plot, |p, &at| p.vertical(at, "a mark"));
            plot.panels[0].head(&[], &x, (0.0, 700.0))
        };
        let rows = |n: f64| 6.0 + n * LABEL_ROW;
        assert_eq!(head(&[]), rows(0.0));
        assert_eq!(head(&[0.0, 20.0, 40.0, 60.0, 100.0]), rows(1.0));
        assert_eq!(head(&[98.0, 99.0, 20.0]), rows(2.0));
        assert_eq!(head(&[120.0]), rows(0.0));
    }
}
