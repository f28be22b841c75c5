//! A plot with no more points and digits than can be seen, as it is kept with a result.

use super::axis::{Axis, Scale};
use super::body::BodyPlot;
use super::xy::{Panel, Series, Style, XyPlot};
use super::{Plot, decimate};
use std::collections::BTreeSet;

/// Points of a line from which on the picture needs fewer.
const MANY: usize = 1500;
/// Columns that a line is reduced to, each with four points at most: one for two pixels of a page.
const COLUMNS: f64 = 350.0;
/// Steps over the range of an axis: four for every pixel.
const STEPS: f64 = 3000.0;
/// Digits after the first where only ratios are seen.
const DIGITS: usize = 4;

impl Plot {
    /// The same picture from fewer points and digits.
    ///
    /// A number keeps a quarter of a pixel, on a logarithmic axis five digits.
    #[must_use]
    pub(crate) fn shortened(self) -> Self {
        match self {
            Self::Xy(plot) => Self::Xy(shortened(plot)),
            Self::Body(plot) => Self::Body(body(plot)),
            Self::Sphere(mut plot) => {
                for point in &mut plot.points {
                    point.direction = point.direction.map(significant);
                    point.value = significant(point.value);
                }
                Self::Sphere(plot)
            }
            other => other,
        }
    }
}

fn shortened(mut plot: XyPlot) -> XyPlot {
    for panel in &mut plot.panels {
        for series in &mut panel.series {
            thin(series, &plot.x);
        }
    }
    let series = |panel: &Panel| panel.series.clone();
    let all: Vec<Series> = plot.panels.iter().flat_map(series).collect();
    let x = Step::of(&plot.x, all.iter().map(|s| &s.x));
    for panel in &mut plot.panels {
        let ordinates = panel.series.iter().flat_map(|s| {
            let edges = s.band.iter().chain(&s.bars);
            std::iter::once(&s.y).chain(edges.flat_map(|(low, high)| [low, high]))
        });
        let y = Step::of(&panel.y, ordinates);
        for series in &mut panel.series {
            x.round(&mut series.x);
            y.round(&mut series.y);
            for (low, high) in series.band.iter_mut().chain(&mut series.bars) {
                y.round(low);
                y.round(high);
            }
        }
    }
    plot
}

/// Of a long line, or many markers, the points that are seen.
fn thin(series: &mut Series, axis: &Axis) {
    let rises = series.x.windows(2).all(|pair| pair[0] <= pair[1]);
    let plain = series.bars.is_none() && matches!(series.style, Style::Line | Style::Markers);
    let edges = || series.band.iter().flat_map(|(low, high)| [low, high]);
    let lines: Vec<&Vec<f64>> = std::iter::once(&series.y).chain(edges()).collect();
    let even = lines.iter().all(|line| line.len() == series.x.len());
    if series.x.len() < MANY || !even || !rises || !plain {
        return;
    }
    let place = |v: f64| if axis.scale == Scale::Log { v.ln() } else { v };
    let (Some(first), Some(last)) = (series.x.first(), series.x.last()) else {
        return;
    };
    let (low, high) = (place(*first), place(*last));
    let per_unit = COLUMNS / (high - low);
    let known = lines.iter().all(|line| line.iter().all(|v| v.is_finite()));
    if !per_unit.is_finite() || !known {
        return;
    }
    let columns = || series.x.iter().map(|v| (place(*v) - low) * per_unit);
    let kept = lines
        .iter()
        .flat_map(|line| decimate::indices(columns().zip(line.iter().copied())));
    let kept: BTreeSet<usize> = kept.collect();
    let thinned = |line: &[f64]| kept.iter().map(|i| line[*i]).collect::<Vec<f64>>();
    let band = series.band.as_ref();
    let band = band.map(|(low, high)| (thinned(low), thinned(high)));
    (series.x, series.y, series.band) = (thinned(&series.x), thinned(&series.y), band);
}

fn body(mut plot: BodyPlot) -> BodyPlot {
    let short = |list: &mut Vec<[f64; 3]>| {
        let step = Step::over(list.iter().flatten().copied());
        for point in list {
            *point = point.map(|v| step.rounded(v));
        }
    };
    short(&mut plot.points);
    for state in &mut plot.states {
        short(&mut state.displacement);
    }
    plot
}

/// The smallest difference that is kept.
enum Step {
    Ratio,
    Decimals(usize),
    None,
}

impl Step {
    fn of<'a>(axis: &Axis, values: impl Iterator<Item = &'a Vec<f64>>) -> Self {
        if axis.scale == Scale::Log {
            return Self::Ratio;
        }
        match axis.range {
            Some((low, high)) => Self::over([low, high].into_iter()),
            None => Self::over(values.flatten().copied()),
        }
    }

    fn over(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        match (STEPS / (high - low)).log10().ceil() {
            d if d <= 0.0 => Self::Decimals(0),
            d if d <= 300.0 => Self::Decimals(d as usize),
            _ => Self::None,
        }
    }

    fn rounded(&self, value: f64) -> f64 {
        match self {
            Self::Ratio => significant(value),
            Self::Decimals(n) => format!("{value:.n$}").parse().unwrap_or(value),
            Self::None => value,
        }
    }

    fn round(&self, values: &mut [f64]) {
        for value in values {
            *value = self.rounded(*value);
        }
    }
}

fn significant(value: f64) -> f64 {
    format!("{value:.DIGITS$e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_number_moves_by_less_than_a_quarter_of_a_pixel() {
        let x: Vec<f64> = (0..100).map(|k| 1e3 + f64::from(k) / 7.0).collect();
        let y: Vec<f64> = x.iter().map(|x| 9.8 + 1e-5 * (x * 3.0).sin()).collect();
        let plot = XyPlot::new(Axis::linear("t", "s"), Axis::linear("a", "m/s²"))
            .series(Series::line("a", &x, &y));
        let short = shortened(plot);
        let series = &short.panels[0].series[0];
        for k in 0..100 {
            assert!((series.x[k] - x[k]).abs() < 14.2 / 3000.0);
            assert!((series.y[k] - y[k]).abs() < 2e-5 / 3000.0);
        }
    }

    #[test]
    fn law_a_long_line_keeps_its_ends_and_extremes() {
        let x: Vec<f64> = (0..1_000_000).map(f64::from).collect();
        let mut y: Vec<f64> = x.iter().map(|x| (x / 1e4).sin()).collect();
        y[77_777] = 5.0;
        let plot = XyPlot::new(Axis::linear("t", "s"), Axis::linear("a", "m/s²"))
            .series(Series::line("a", &x, &y))
            .series(Series::line("b", &x, &x).band(&y, &x));
        let short = shortened(plot);
        let band = &short.panels[0].series[1];
        assert!(band.x.len() < 12 * 381 && band.band.as_ref().unwrap().0.contains(&5.0));
        let series = &short.panels[0].series[0];
        assert!(series.x.len() < 4 * 381, "{}", series.x.len());
        assert_eq!((series.x[0], series.x.last()), (0.0, Some(&999_999.0)));
        assert!(series.x.contains(&77_777.0) && series.y.contains(&5.0));
    }
}
