//! Drawing of an [`XyPlot`]: layout of the panels, series, references, legend.

use super::axis::{Mapping, Scale};
use super::frame::{Frame, SMALL, left_margin, room_across, room_upwards};
use super::svg::{Anchor, Svg, text_width};
use super::ticks::Ticks;
use super::xy::{Panel, Series, Style, XyPlot};
use super::{check_finite, check_length, check_positive, colour, decimate};
use crate::Error;

const GAP: f64 = 16.0;
const FOOT: f64 = 46.0;
/// White behind a text that may cross a line.
const HALO: &str =
    "paint-order=\"stroke\" stroke=\"#fff\" stroke-width=\"3\" stroke-linejoin=\"round\"";
const SHADES: [&str; 3] = ["#dfe8ee", "#f3e6d3", "#e3eee0"];

impl XyPlot {
    pub(super) fn draw(&self, title: &str, id: &str) -> Result<String, Error> {
        for panel in &self.panels {
            panel.check(self.x.scale)?;
        }
        let x_range = self.x.shown(self.x_extent(), 0.02)?;
        let mut ranges = Vec::new();
        for panel in &self.panels {
            ranges.push(panel.y.shown(panel.y_extent(), 0.05)?);
        }
        let y_ticks: Vec<Ticks> = self
            .panels
            .iter()
            .zip(&ranges)
            .map(|(panel, range)| panel.y.ticks(*range, room_upwards(panel.height)))
            .collect();
        let left = y_ticks.iter().map(left_margin).fold(50.0, f64::max);
        let right = self.width - self.right_margin();
        let x_ticks = self.x.ticks(x_range, room_across(right - left));
        let heads: Vec<f64> = self.panels.iter().map(|p| p.head(left, right)).collect();
        let total = 6.0
            + FOOT
            + self.panels.iter().map(|p| p.height).sum::<f64>()
            + heads.iter().sum::<f64>()
            + GAP * (self.panels.len().max(1) - 1) as f64;
        let mut svg = Svg::new(self.width, total, title, id);
        let mut top = 6.0;
        for (i, panel) in self.panels.iter().enumerate() {
            top += heads[i];
            let bottom = top + panel.height;
            let frame = Frame {
                left,
                right,
                top,
                bottom,
                x: Mapping::new(self.x.scale, x_range, left, right),
                y: Mapping::new(panel.y.scale, ranges[i], bottom, top),
            };
            frame.grid(
                &mut svg,
                &x_ticks,
                &y_ticks[i],
                (self.x.scale, panel.y.scale),
            );
            svg.open_clip(&format!("{id}-clip-{i}"), (left, top), frame.size());
            panel.data(&mut svg, &frame);
            svg.close();
            let last = i + 1 == self.panels.len();
            frame.axes(&mut svg, (&self.x, &x_ticks), (&panel.y, &y_ticks[i]), last);
            panel.labels(&mut svg, &frame);
            panel.legend(&mut svg, &frame, top - heads[i]);
            top = bottom + GAP;
        }
        svg.finish(title)
    }

    fn x_extent(&self) -> Option<(f64, f64)> {
        extent(self.panels.iter().flat_map(|p| {
            let shades = p
                .shades
                .iter()
                .flat_map(|s| s.intervals.iter().flat_map(|i| [i.0, i.1]));
            p.series
                .iter()
                .flat_map(|s| s.x.iter().copied())
                .chain(p.vertical.iter().map(|r| r.at))
                .chain(shades)
        }))
    }

    /// Labels of horizontal references and slopes stand right of the panels.
    fn right_margin(&self) -> f64 {
        let widest = self
            .panels
            .iter()
            .flat_map(|p| {
                p.horizontal
                    .iter()
                    .map(|r| &r.label)
                    .chain(p.slopes.iter().map(|s| &s.label))
            })
            .map(|label| text_width(label, SMALL))
            .fold(0.0, f64::max);
        let half_label = 16.0;
        (widest + 12.0).max(half_label).min(0.35 * self.width)
    }
}

fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |range, v| match range {
        None => Some((v, v)),
        Some((low, high)) => Some((v.min(low), v.max(high))),
    })
}

impl Panel {
    fn check(&self, x_scale: Scale) -> Result<(), Error> {
        for series in &self.series {
            let name = if series.name.is_empty() {
                "series"
            } else {
                series.name.as_str()
            };
            check_length(&format!("y of {name}"), series.x.len(), series.y.len())?;
            check_finite(&format!("x of {name}"), &series.x)?;
            check_finite(name, &series.y)?;
            if x_scale == Scale::Log {
                check_positive(&format!("x of {name}"), &series.x)?;
            }
            if self.y.scale == Scale::Log {
                check_positive(name, &series.y)?;
            }
            for (lower, upper) in series.bars.iter().chain(&series.band) {
                for edge in [lower, upper] {
                    check_length(&format!("interval of {name}"), series.x.len(), edge.len())?;
                    check_finite(&format!("interval of {name}"), edge)?;
                }
            }
        }
        for (what, references, scale) in [
            ("horizontal line", &self.horizontal, self.y.scale),
            ("vertical line", &self.vertical, x_scale),
        ] {
            for (index, reference) in references.iter().enumerate() {
                let refused = |error| match error {
                    Error::NotFinite { series, value, .. } => Error::NotFinite {
                        series,
                        index,
                        value,
                    },
                    Error::NotPositive { series, value, .. } => Error::NotPositive {
                        series,
                        index,
                        value,
                    },
                    other => other,
                };
                let name = format!("{what} {}", reference.label);
                check_finite(&name, &[reference.at]).map_err(refused)?;
                if scale == Scale::Log {
                    check_positive(&name, &[reference.at]).map_err(refused)?;
                }
            }
        }
        for slope in &self.slopes {
            let point = [slope.through.0, slope.through.1, slope.exponent];
            check_finite(&format!("slope {}", slope.label), &point)?;
            check_positive(&format!("slope {}", slope.label), &point[..2])?;
        }
        for shade in &self.shades {
            for (index, &(a, b)) in shade.intervals.iter().enumerate() {
                check_finite(&format!("interval {index} of {}", shade.name), &[a, b])?;
                if x_scale == Scale::Log {
                    check_positive(&format!("interval {index} of {}", shade.name), &[a, b])?;
                }
            }
        }
        for (index, note) in self.notes.iter().enumerate() {
            check_finite(&format!("note {index}"), &[note.0, note.1])?;
        }
        Ok(())
    }

    fn y_extent(&self) -> Option<(f64, f64)> {
        let series = self.series.iter().flat_map(|s| {
            let edges = s.bars.iter().chain(&s.band);
            s.y.iter()
                .chain(edges.flat_map(|(a, b)| a.iter().chain(b)))
                .copied()
        });
        let log = self.y.scale == Scale::Log;
        extent(
            series
                .chain(self.horizontal.iter().map(|r| r.at))
                .filter(|&v| !log || v > 0.0),
        )
    }

    fn data(&self, svg: &mut Svg, frame: &Frame) {
        for (i, shade) in self.shades.iter().enumerate() {
            let fill = format!("fill=\"{}\"", SHADES[i % SHADES.len()]);
            for &(from, to) in &shade.intervals {
                let (a, b) = (frame.x.at(from.min(to)), frame.x.at(from.max(to)));
                // At least a pixel, or a short standstill in a long recording vanishes.
                svg.rect(
                    (a, frame.top),
                    ((b - a).max(1.0), frame.bottom - frame.top),
                    &fill,
                );
            }
        }
        for (i, series) in self.series.iter().enumerate() {
            let look = series.look.unwrap_or(i);
            if let Some((lower, upper)) = &series.band {
                let edge = |values: &[f64]| {
                    decimate::line(
                        series
                            .x
                            .iter()
                            .zip(values)
                            .map(|(&x, &y)| (frame.x.at(x), frame.y.at(y))),
                    )
                };
                let mut outline = edge(lower);
                outline.extend(edge(upper).into_iter().rev());
                let style = format!(
                    "fill=\"{}\" fill-opacity=\"0.18\" stroke=\"none\"",
                    colour::series(look)
                );
                svg.path(&outline, true, &style);
            }
        }
        let dashed = "stroke=\"#555\" stroke-dasharray=\"5 4\"";
        for reference in &self.horizontal {
            let y = frame.y.at(reference.at);
            svg.line((frame.left, y), (frame.right, y), dashed);
        }
        for reference in &self.vertical {
            let x = frame.x.at(reference.at);
            svg.line((x, frame.top), (x, frame.bottom), dashed);
        }
        for slope in &self.slopes {
            svg.path(
                &slope.points(frame),
                false,
                "fill=\"none\" stroke=\"#777\" stroke-dasharray=\"2 4\"",
            );
        }
        for (i, series) in self.series.iter().enumerate() {
            draw_series(svg, frame, series, series.look.unwrap_or(i));
        }
    }

    /// Labels of references, in the right margin and over the frame, none over another.
    fn labels(&self, svg: &mut Svg, frame: &Frame) {
        let mut wanted: Vec<(f64, &str)> = self
            .horizontal
            .iter()
            .filter(|r| !r.label.is_empty() && frame.y.inside(r.at))
            .map(|r| (frame.y.at(r.at), r.label.as_str()))
            .collect();
        let small = "font-size=\"11\" fill=\"#444\"";
        for slope in self.slopes.iter().filter(|s| !s.label.is_empty()) {
            let y = slope.points(frame).last().map_or(frame.top, |p| p.1);
            if y >= frame.top && y <= frame.bottom {
                wanted.push((y, slope.label.as_str()));
            } else if let Some((x, y, anchor)) = slope.leaves(frame) {
                svg.text((x, y), anchor, &slope.label, &format!("{small} {HALO}"));
            }
        }
        wanted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut lowest = f64::NEG_INFINITY;
        for (y, label) in wanted {
            let y = y.max(lowest + 13.0);
            svg.text((frame.right + 6.0, y + 4.0), Anchor::Start, label, small);
            lowest = y;
        }
        for (at, label, row) in self.vertical_labels(frame) {
            let width = text_width(label, SMALL);
            let x = at.clamp(
                frame.left + 0.5 * width,
                (frame.right - 0.5 * width).max(frame.left + 0.5 * width),
            );
            svg.text(
                (x, frame.top - 5.0 - 13.0 * row as f64),
                Anchor::Middle,
                label,
                small,
            );
        }
        for (x, y, text) in &self.notes {
            let (x, y) = (frame.x.at(*x), frame.y.at(*y));
            let width = text_width(text, SMALL);
            let (x, anchor) = if x + 6.0 + width > frame.right {
                (x - 6.0, Anchor::End)
            } else {
                (x + 6.0, Anchor::Start)
            };
            let y = (y - 6.0).clamp(frame.top + 12.0, frame.bottom - 4.0);
            svg.text(
                (x, y),
                anchor,
                text,
                &format!("font-size=\"11\" fill=\"#111\" {HALO}"),
            );
        }
    }

    /// Position, label and row above the frame of each vertical reference.
    fn vertical_labels(&self, frame: &Frame) -> Vec<(f64, &str, usize)> {
        let mut ends: Vec<f64> = Vec::new();
        let mut placed = Vec::new();
        let mut sorted: Vec<_> = self
            .vertical
            .iter()
            .filter(|r| !r.label.is_empty() && frame.x.inside(r.at))
            .collect();
        sorted.sort_by(|a, b| a.at.total_cmp(&b.at));
        for reference in sorted {
            let x = frame.x.at(reference.at);
            let half = 0.5 * text_width(&reference.label, SMALL) + 4.0;
            let row = ends
                .iter()
                .position(|&end| end <= x - half)
                .unwrap_or(ends.len());
            if row == ends.len() {
                ends.push(0.0);
            }
            ends[row] = x + half;
            placed.push((x, reference.label.as_str(), row));
        }
        placed
    }

    /// Entries of the legend with their place: (column position, row).
    fn legend_places(&self, left: f64, right: f64) -> Vec<(f64, usize)> {
        let mut places = Vec::new();
        let (mut x, mut row) = (left, 0);
        for name in self.legend_names() {
            let width = 34.0 + text_width(name, 12.0) + 18.0;
            if x + width - 18.0 > right && x > left {
                x = left;
                row += 1;
            }
            places.push((x, row));
            x += width;
        }
        places
    }

    fn legend_names(&self) -> impl Iterator<Item = &str> {
        let series = self.series.iter().map(|s| s.name.as_str());
        let shades = self.shades.iter().map(|s| s.name.as_str());
        series.chain(shades).filter(|name| !name.is_empty())
    }

    /// Height above the frame for legend and labels of vertical references.
    fn head(&self, left: f64, right: f64) -> f64 {
        let rows = self
            .legend_places(left, right)
            .last()
            .map_or(0, |p| p.1 + 1);
        let labelled = self.vertical.iter().filter(|r| !r.label.is_empty()).count();
        // As many rows as labels could need at worst would be wasteful; they stagger over three at most.
        18.0 * rows as f64 + 13.0 * labelled.min(3) as f64 + 6.0
    }

    fn legend(&self, svg: &mut Svg, frame: &Frame, top: f64) {
        let places = self.legend_places(frame.left, frame.right);
        let mut places = places.into_iter();
        for (i, series) in self.series.iter().enumerate() {
            if series.name.is_empty() {
                continue;
            }
            let Some((x, row)) = places.next() else {
                return;
            };
            let y = top + 9.0 + 18.0 * row as f64;
            let look = series.look.unwrap_or(i);
            if series.band.is_some() {
                let style = format!("fill=\"{}\" fill-opacity=\"0.18\"", colour::series(look));
                svg.rect((x, y - 6.0), (28.0, 12.0), &style);
            }
            if series.style != Style::Markers {
                svg.line((x, y), (x + 28.0, y), &stroke(look));
            }
            if matches!(series.style, Style::Markers | Style::LineAndMarkers) {
                marker(svg, (x + 14.0, y), look);
            }
            svg.text(
                (x + 34.0, y + 4.0),
                Anchor::Start,
                &series.name,
                "fill=\"#111\"",
            );
        }
        for (i, shade) in self.shades.iter().enumerate() {
            if shade.name.is_empty() {
                continue;
            }
            let Some((x, row)) = places.next() else {
                return;
            };
            let y = top + 9.0 + 18.0 * row as f64;
            let fill = format!("fill=\"{}\" stroke=\"#bbb\"", SHADES[i % SHADES.len()]);
            svg.rect((x, y - 6.0), (28.0, 12.0), &fill);
            svg.text(
                (x + 34.0, y + 4.0),
                Anchor::Start,
                &shade.name,
                "fill=\"#111\"",
            );
        }
    }
}

impl super::xy::Slope {
    /// The law at 65 abscissae across the panel: straight in log–log, a curve elsewhere.
    fn points(&self, frame: &Frame) -> Vec<(f64, f64)> {
        (0..=64)
            .filter_map(|i| {
                let pixel = frame.left + (frame.right - frame.left) * f64::from(i) / 64.0;
                let x = frame.x.value(pixel);
                (x > 0.0).then(|| {
                    let log = self.through.1.log10()
                        + self.exponent * (x.log10() - self.through.0.log10());
                    (pixel, frame.y.at(10f64.powf(log.clamp(-300.0, 300.0))))
                })
            })
            .collect()
    }

    /// Where a line that does not reach the right edge leaves the panel, for its label.
    fn leaves(&self, frame: &Frame) -> Option<(f64, f64, Anchor)> {
        let points = self.points(frame);
        let (x, y) = *points
            .iter()
            .rev()
            .find(|p| p.1 >= frame.top + 14.0 && p.1 <= frame.bottom - 8.0)?;
        let width = text_width(&self.label, SMALL);
        Some(if x + 4.0 + width > frame.right {
            (x - 4.0, y, Anchor::End)
        } else {
            (x + 4.0, y, Anchor::Start)
        })
    }
}

fn stroke(look: usize) -> String {
    let dash = colour::dash(look);
    let dash = if dash.is_empty() {
        String::new()
    } else {
        format!(" stroke-dasharray=\"{dash}\"")
    };
    format!(
        "fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\" stroke-linejoin=\"round\"{dash}",
        colour::series(look)
    )
}

fn draw_series(svg: &mut Svg, frame: &Frame, series: &Series, look: usize) {
    let place = |(&x, &y): (&f64, &f64)| (frame.x.at(x), frame.y.at(y));
    let points = || series.x.iter().zip(&series.y).map(place);
    let dense = series.x.len() > 4 * (frame.right - frame.left) as usize;
    if series.style != Style::Markers {
        let line = match series.style {
            Style::Steps => {
                let all: Vec<_> = points().collect();
                let corners = all.windows(2).flat_map(|w| [w[0], (w[1].0, w[0].1)]);
                decimate::line(corners.chain(all.last().copied()))
            }
            _ if dense => decimate::line(points()),
            _ => points().collect(),
        };
        // A dense trace is an area: thin, undashed strokes keep its outline true.
        let style = if dense {
            format!(
                "fill=\"none\" stroke=\"{}\" stroke-width=\"0.8\"",
                colour::series(look)
            )
        } else {
            stroke(look)
        };
        if line.len() == 1 {
            marker(svg, line[0], look);
        }
        svg.path(&line, false, &style);
    }
    let all: Vec<_> = if matches!(series.style, Style::Markers | Style::LineAndMarkers)
        || series.bars.is_some()
    {
        points().collect()
    } else {
        return;
    };
    let shown = decimate::markers(&all);
    if let Some((lower, upper)) = &series.bars {
        let ink = format!("stroke=\"{}\"", colour::series(look));
        for &i in &shown {
            let (x, a, b) = (all[i].0, frame.y.at(lower[i]), frame.y.at(upper[i]));
            svg.line((x, a), (x, b), &ink);
            for y in [a, b] {
                svg.line((x - 3.0, y), (x + 3.0, y), &ink);
            }
        }
    }
    if matches!(series.style, Style::Markers | Style::LineAndMarkers) {
        for &i in &shown {
            marker(svg, all[i], look);
        }
    }
}

/// One of six markers: disc, square, diamond, triangle up, triangle down, ring.
pub(super) fn marker(svg: &mut Svg, (x, y): (f64, f64), look: usize) {
    let ink = colour::series(look);
    let fill = format!("fill=\"{ink}\"");
    match look % 6 {
        0 => svg.circle((x, y), 3.2, &fill),
        1 => svg.rect((x - 3.0, y - 3.0), (6.0, 6.0), &fill),
        2 => svg.path(
            &[(x - 4.2, y), (x, y - 4.2), (x + 4.2, y), (x, y + 4.2)],
            true,
            &fill,
        ),
        3 => svg.path(
            &[(x - 3.8, y + 3.2), (x, y - 4.0), (x + 3.8, y + 3.2)],
            true,
            &fill,
        ),
        4 => svg.path(
            &[(x - 3.8, y - 3.2), (x, y + 4.0), (x + 3.8, y - 3.2)],
            true,
            &fill,
        ),
        _ => svg.circle(
            (x, y),
            3.2,
            &format!("fill=\"#fff\" stroke=\"{ink}\" stroke-width=\"1.5\""),
        ),
    }
}
