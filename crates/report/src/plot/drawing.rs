//! Drawing of an [`XyPlot`]: layout of the panels, series, references; its words are in `labelling`.

use super::axis::{Mapping, Scale};
use super::frame::{Frame, left_margin, room_across, room_upwards};
use super::svg::{Svg, escape};
use super::ticks::Ticks;
use super::xy::{Panel, Series, Slope, Style, XyPlot};
use super::{check_finite, check_length, check_positive, colour, decimate, labelling};
use crate::Error;

const GAP: f64 = 16.0;
const FOOT: f64 = 46.0;
pub(super) const SHADES: [&str; 3] = ["#dfe8ee", "#f3e6d3", "#e3eee0"];

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
        let margins = self.panels.iter().map(|p| p.right_margin() + 12.0);
        let right = self.width - margins.fold(16.0, f64::max);
        let x = Mapping::new(self.x.scale, x_range, left, right);
        let x_ticks = self.x.ticks(x_range, room_across(right - left));
        let legends = labelling::legends(&self.panels);
        let heads: Vec<f64> = self
            .panels
            .iter()
            .zip(&legends)
            .map(|(panel, entries)| panel.head(entries, &x, (left, right)))
            .collect();
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
                x,
                y: Mapping::new(panel.y.scale, ranges[i], bottom, top),
            };
            let log = |scale| scale == Scale::Log;
            svg.panel(
                [left, top, right, bottom],
                [
                    (log(self.x.scale), x_range),
                    (log(panel.y.scale), ranges[i]),
                ],
                [&x_ticks, &y_ticks[i]],
            );
            svg.open_ticks(i);
            frame.grid(
                &mut svg,
                &x_ticks,
                &y_ticks[i],
                (self.x.scale, panel.y.scale),
            );
            svg.close();
            svg.open_clip(&format!("{id}-clip-{i}"), (left, top), frame.size());
            panel.data(&mut svg, &frame);
            svg.close();
            let last = i + 1 == self.panels.len();
            svg.open_ticks(i);
            frame.ticks(&mut svg, &x_ticks, &y_ticks[i], last);
            panel.labels(&mut svg, &frame);
            svg.close();
            frame.axes(&mut svg, (&self.x, &x_ticks), (&panel.y, &y_ticks[i]), last);
            labelling::draw_legend(&mut svg, &frame, &legends[i], top - heads[i]);
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
                &slope_points(slope, frame),
                false,
                "fill=\"none\" stroke=\"#777\" stroke-dasharray=\"2 4\"",
            );
        }
        for (i, series) in self.series.iter().enumerate() {
            draw_series(svg, frame, series, series.look.unwrap_or(i));
        }
    }
}

/// A power law at 65 abscissae across the panel: straight in log–log, a curve elsewhere.
pub(super) fn slope_points(slope: &Slope, frame: &Frame) -> Vec<(f64, f64)> {
    (0..=64)
        .filter_map(|i| {
            let pixel = frame.left + (frame.right - frame.left) * f64::from(i) / 64.0;
            let x = frame.x.value(pixel);
            (x > 0.0).then(|| {
                let log = slope.through.1.log10()
                    + slope.exponent * (x.log10() - slope.through.0.log10());
                (pixel, frame.y.at(10f64.powf(log.clamp(-300.0, 300.0))))
            })
        })
        .collect()
}

pub(super) fn stroke(look: usize) -> String {
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
    let named = format!("data-series=\"{}\"", escape(&series.name));
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
            marker(svg, line[0], look, &named);
        }
        svg.path(&line, false, &format!("{style} {named}"));
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
        // The points of a line stand in its path.
        let named = match series.style {
            Style::Markers => named.as_str(),
            _ => "",
        };
        for &i in &shown {
            marker(svg, all[i], look, named);
        }
    }
}

/// One of six markers: disc, square, diamond, triangle up, triangle down, ring.
pub(super) fn marker(svg: &mut Svg, (x, y): (f64, f64), look: usize, named: &str) {
    let ink = colour::series(look);
    let place = format!("data-mark=\"{x:.2} {y:.2}\" {named}");
    let fill = format!("fill=\"{ink}\" {}", place.trim_end());
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
            &format!(
                "fill=\"#fff\" stroke=\"{ink}\" stroke-width=\"1.5\" {}",
                place.trim_end()
            ),
        ),
    }
}
