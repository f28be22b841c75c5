//! The report of an estimate: velocity with its uncertainty, and what speaks against it.

use super::{facts, figures, given_back, noise, pairing};
use crate::page::answer::{plus_minus, stated_by, with_unit};
use crate::page::columns::{filed, number};
use crate::velocity::VelocityEstimate;
use crate::velocity::outcome::Head;
use proofmass_documents::StatedQuantity;
use proofmass_motion::{
    Episode, EstimateResult, ReadingSource, RippleLine, VelocityTrace, excerpt,
};
use proofmass_report::Rounding::{Decimals, Significant};
use proofmass_report::{
    Axis, Field, KeyFigure, Report, Section, Series, Table, XyPlot, scientific,
};
use std::ops::Range;

pub(in crate::velocity) fn estimate(page: Report, outcome: &VelocityEstimate) -> Report {
    let (head, result) = (&outcome.head, &outcome.result);
    let n = result.trace.velocity.len();
    let mut shown = result.smoother.velocity.clone();
    for out in &result.left_out {
        let before = shown[out.start.saturating_sub(1)];
        shown[out.clone()].fill(before);
    }
    let zoom = excerpt(&shown);
    let part = head.part();
    let over = match part {
        Some(_) => "what is used of the recording",
        None => "the whole recording",
    };
    let caption = format!("Velocity over {over}, with the interval of 95 % that the model states");
    let part = part.unwrap_or_default();
    let curves = Section::new("Velocity in parts")
        .figure(
            format!(
                "The liveliest part, {} s to {} s",
                scientific(head.time(zoom.start), 4),
                scientific(head.time(zoom.end.saturating_sub(1)), 4)
            ),
            head.curves(result, zoom.clone()),
        )
        .figure(
            "The method beside the smoother in the same part: their difference, within the method's interval of 95 %",
            head.difference(result, zoom.clone()),
        );
    let mut sensors = Section::new("Sensors as they entered").figure(
        "Readings of the same part",
        head.raw(&outcome.reading, zoom.clone()),
    );
    if !head.alone {
        let t = head.times(zoom.clone());
        let plot = XyPlot::new(
            Axis::linear("time", "s"),
            Axis::linear("acceleration", head.unit("m/s²")),
        );
        sensors = sensors.figure(
            "Acceleration of the same part",
            plot.series(Series::line("", &t, &outcome.acceleration[zoom])),
        );
    }
    let offset = result.offset.as_ref();
    let sections = [
        Some(head.trust(result).summarised()),
        Some(curves),
        Some(sensors),
        offset.map(|(offset, u)| head.offset(offset, u)),
        head.episodes(result),
        head.ripple(result),
        Some(Section::filed([samples(outcome)])),
    ];
    let largest = head.quantities.first();
    let by = outcome.stated_by();
    let figure = |q: &StatedQuantity| match head.angular {
        true => {
            let turns = 30.0 / std::f64::consts::PI;
            let turns = plus_minus(turns * q.value, turns * q.expanded);
            stated_by(q, &format!("{by}; {turns} r/min"))
        }
        false => stated_by(q, &by),
    };
    let mut page = head.opened(page, result.stated().count());
    if let Some(q) = largest {
        let corner = result.low_corner.map_or(String::new(), given_back);
        page = page.verdict(format!("The speed reaches {}.{corner}{part}", with_unit(q)));
    }
    let page = page
        .answers(largest.map(figure))
        .answers(head.key_figures(result))
        .shown_by(caption, head.curves(result, 0..n));
    sections.into_iter().flatten().fold(page, Report::section)
}

/// One row per sample.
fn samples(outcome: &VelocityEstimate) -> Table {
    let (head, result) = (&outcome.head, &outcome.result);
    let known = |u: &'static str, trace: &'_ VelocityTrace| {
        let values = trace.standard_uncertainty.clone().unwrap_or_default();
        Field::series(head.unit(u), values)
    };
    let source = match head.source {
        ReadingSource::Position => "position_m",
        ReadingSource::Speed => "speed_m/s",
    };
    let fields = [
        filed("time_s", |k: &usize| head.time(*k)),
        Field::series(head.unit("velocity_m/s"), &result.trace.velocity),
        known("standard_uncertainty_m/s", &result.trace),
        Field::series(head.unit("smoothed_m/s"), &result.smoother.velocity),
        known("smoothed_standard_uncertainty_m/s", &result.smoother),
        filed(head.unit(source), |k: &usize| outcome.reading[*k]),
        Field::series(head.unit("acceleration_m/s2"), &outcome.acceleration),
        filed("slip", |k: &usize| {
            usize::from(result.slip.as_ref().is_some_and(|s| s.slips(*k, 0)))
        }),
    ];
    Table::of("", fields, result.stated()).file("velocity.csv")
}

impl Head {
    fn curves(&self, result: &EstimateResult, part: Range<usize>) -> XyPlot {
        let stated: Vec<usize> = result.stated().filter(|k| part.contains(k)).collect();
        let of = |values: &[f64]| stated.iter().map(|k| values[*k]).collect::<Vec<f64>>();
        let t: Vec<f64> = stated.iter().map(|k| self.time(*k)).collect();
        let mut plot = XyPlot::new(
            Axis::linear("time", "s"),
            figures::framed(
                "velocity",
                &self.unit("m/s"),
                &of(&result.smoother.velocity),
            ),
        );
        plot = self.shaded(plot, result, part);
        for (trace, name) in [
            (&result.smoother, "smoother, off line"),
            (&result.trace, kind(&result.trace)),
        ] {
            let mut series = Series::line(name, &t, &of(&trace.velocity));
            if let Some(u) = &trace.standard_uncertainty {
                let half: Vec<f64> = of(u).iter().map(|u| 1.96 * u).collect();
                series = series.within(&half);
            }
            plot = plot.series(series);
        }
        plot
    }

    /// Slip, collisions and what is left out as a ground below the curves.
    fn shaded(&self, mut plot: XyPlot, result: &EstimateResult, part: Range<usize>) -> XyPlot {
        let inside = |from: usize, to: usize| {
            let (a, b) = (from.max(part.start), to.min(part.end));
            (a < b).then(|| (self.time(a), self.time(b - 1)))
        };
        let out = result.left_out.iter();
        let out: Vec<_> = out.filter_map(|r| inside(r.start, r.end)).collect();
        if !out.is_empty() {
            plot = plot.shade("missing", &out);
        }
        if let Some(slip) = &result.slip {
            for (name, episodes) in [("slip", &slip.slip), ("collision", &slip.collisions)] {
                let places: Vec<_> = episodes
                    .iter()
                    .filter_map(|e| inside(e.from, e.to))
                    .collect();
                if !places.is_empty() {
                    plot = plot.shade(name, &places);
                }
            }
        }
        plot
    }

    /// Method minus smoother, with the interval of the method around nothing.
    fn difference(&self, result: &EstimateResult, part: Range<usize>) -> XyPlot {
        let stated: Vec<usize> = result.stated().filter(|k| part.contains(k)).collect();
        let t: Vec<f64> = stated.iter().map(|k| self.time(*k)).collect();
        let of = |k: &usize| 1e3 * (result.trace.velocity[*k] - result.smoother.velocity[*k]);
        let off: Vec<f64> = stated.iter().map(of).collect();
        let mut series = Series::line("difference", &t, &off);
        let mut half = vec![0.0; off.len()];
        if let Some(u) = &result.trace.standard_uncertainty {
            half = stated.iter().map(|k| 1e3 * 1.96 * u[*k]).collect();
            let low: Vec<f64> = half.iter().map(|h| -h).collect();
            series = series.band(&low, &half);
        }
        let unit = self.unit("mm/s");
        let axis = figures::framed_interval("difference of velocities", &unit, &off, &half);
        XyPlot::new(Axis::linear("time", "s"), axis).series(series)
    }

    /// Readings as they entered; where there was none, no mark.
    fn raw(&self, readings: &[Option<f64>], part: Range<usize>) -> XyPlot {
        let (t, x): (Vec<f64>, Vec<f64>) = part
            .filter_map(|k| {
                readings
                    .get(k)
                    .copied()
                    .flatten()
                    .map(|x| (self.time(k), x))
            })
            .unzip();
        let axis = match self.source {
            ReadingSource::Position => Axis::linear("position", self.unit("m")),
            ReadingSource::Speed => Axis::linear("speed", self.unit("m/s")),
        };
        XyPlot::new(Axis::linear("time", "s"), axis).series(Series::markers("", &t, &x))
    }

    /// Innovations in time, with slip and collisions below them.
    fn innovations(&self, result: &EstimateResult) -> Option<XyPlot> {
        let seen = result.innovations.iter().enumerate();
        let (t, z): (Vec<f64>, Vec<f64>) = seen
            .filter_map(|(k, z)| z.map(|z| (self.time(k), z)))
            .unzip();
        if z.len() < 2 {
            return None;
        }
        let far = z.iter().fold(4.0f64, |m, z| m.max(1.05 * z.abs()));
        let plot = XyPlot::new(
            Axis::linear("time", "s"),
            Axis::linear("innovation over its standard deviation", "1").range(-far, far),
        );
        let plot = self.shaded(plot, result, 0..result.trace.velocity.len());
        Some(
            plot.series(Series::line("", &t, &z))
                .horizontal(1.96, "95 %")
                .horizontal(-1.96, ""),
        )
    }

    /// Why the numbers may be believed, or not.
    fn trust(&self, result: &EstimateResult) -> Section {
        let mut section =
            Section::new("Model and its tests").table(facts("Model", self.model(result)));
        if let Some(found) = &result.pairing {
            section = section.table(pairing(found, result.tuned.as_ref()));
        }
        if let Some(plot) = self.innovations(result) {
            section = section.figure(
                "Innovations: readings less their predictions, over the standard deviation the model states; 95 % lie within the lines",
                plot,
            );
        }
        if let Some(tuned) = &result.tuned {
            section = section.figure(
                "Correlation of the innovations: of a model that describes both sensors 95 % lie within the lines",
                figures::whiteness(tuned),
            );
            if let Some(plot) = figures::profile(tuned, self.angular) {
                section = section.figure("Likelihood of the acceleration's noise", plot);
            }
        }
        section
    }

    fn offset(&self, offset: &[f64], u: &[f64]) -> Section {
        let half: Vec<f64> = u.iter().map(|u| 1.96 * u).collect();
        let plot = XyPlot::new(
            Axis::linear("time", "s"),
            Axis::linear("offset", self.unit("m/s²")),
        )
        .series(Series::line("", &self.times(0..offset.len()), offset).within(&half));
        Section::new("Offset of the accelerometer")
            .figure("Offset by the smoother, with its interval of 95 %", plot)
    }

    fn episodes(&self, result: &EstimateResult) -> Option<Section> {
        let slip = result.slip.as_ref()?;
        if slip.slip.is_empty() && slip.collisions.is_empty() {
            return None;
        }
        let mut all: Vec<_> = slip
            .slip
            .iter()
            .map(|e| ("slip", e))
            .chain(slip.collisions.iter().map(|e| ("collision", e)))
            .collect();
        all.sort_by(|a, b| b.1.deviations.abs().total_cmp(&a.1.deviations.abs()));
        type Row<'a> = (&'a str, &'a Episode);
        let unit = self.unit("m/s");
        let fields = [
            Field::shown("kind", "", |(kind, _): &Row<'_>| (*kind).into()),
            number("", ("from", "s"), Decimals(3), |(_, e): &Row<'_>| {
                self.time(e.from)
            }),
            number("", ("to", "s"), Decimals(3), |(_, e): &Row<'_>| {
                self.time(e.to)
            }),
            number(
                "",
                ("velocity change", &unit),
                Decimals(4),
                |(_, e): &Row<'_>| e.velocity,
            ),
            number("", ("strength", "σ"), Decimals(1), |(_, e): &Row<'_>| {
                Some(e.deviations.abs()).filter(|s| s.is_finite())
            }),
        ];
        let mut table = Table::of(
            "Where encoder and accelerometer do not share one motion, the strongest first",
            fields,
            all.iter().take(20),
        );
        if all.len() > 20 {
            table = table.note(format!("{} more are in result.json.", all.len() - 20));
        }
        Some(Section::new("Slip and collisions").table(table))
    }
}

impl Head {
    fn key_figures(&self, result: &EstimateResult) -> Vec<KeyFigure> {
        let mut figures = vec![
            KeyFigure::new(
                "delay of the method",
                // What is left of a sum of weights is no delay.
                match result.trace.stated_delay {
                    rounding if rounding.abs() < 1e-12 => "0".to_owned(),
                    delay => scientific(1e3 * delay, 3),
                },
                "ms",
            )
            .note("of slow motion"),
        ];
        if let Some(u) = &result.trace.standard_uncertainty {
            let mut sorted: Vec<f64> = result.stated().map(|k| u[k]).collect();
            sorted.sort_by(f64::total_cmp);
            figures.push(
                KeyFigure::new(
                    "standard uncertainty",
                    scientific(sorted[sorted.len() / 2], 2),
                    self.unit("m/s"),
                )
                .note(format!(
                    "of the method, {}; median over the samples",
                    kind(&result.trace)
                )),
            );
        }
        if let Some(share) = result.agreement {
            figures.push(
                KeyFigure::new(
                    "filter and smoother agree",
                    format!("{:.1}", 100.0 * share),
                    "%",
                )
                .note("of the samples without slip; 95 % are due"),
            );
        }
        figures
    }

    fn model(&self, result: &EstimateResult) -> Vec<[String; 2]> {
        let mut rows = vec![["method".to_owned(), result.trace.label.clone()]];
        rows.extend(noise(&result.model, self));
        if let Some(tuned) = &result.tuned {
            let w = &tuned.whiteness;
            if let Some((below, above)) = tuned.log_q_interval {
                let q = result.model.acceleration_noise.sqrt();
                rows.push([
                    "interval of √q, 95 %".to_owned(),
                    format!(
                        "{} to {} {}",
                        scientific(q * (-0.5 * below).exp(), 3),
                        scientific(q * (0.5 * above).exp(), 3),
                        self.unit("m/s²")
                    ),
                ]);
            }
            rows.push([
                "innovations white with probability".to_owned(),
                format!(
                    "{} ({} lags, largest correlation {} at lag {})",
                    scientific(w.p_white, 2),
                    w.lags,
                    scientific(w.largest_correlation.1, 2),
                    w.largest_correlation.0
                ),
            ]);
            rows.push([
                "mean square of the normalised innovations".to_owned(),
                format!("{} (1 is expected)", scientific(w.mean_square, 4)),
            ]);
        }
        rows
    }
}

/// One word for the legend.
fn kind(trace: &VelocityTrace) -> &str {
    trace.label.split(',').next().unwrap_or_default()
}

impl Head {
    fn ripple(&self, result: &EstimateResult) -> Option<Section> {
        let ripple = result.ripple.as_ref()?;
        if ripple.lines.is_empty() && ripple.once_per_turn.is_none() {
            return None;
        }
        type Row<'a> = (&'a str, &'a RippleLine);
        let mm = self.unit("mm");
        let share = ("share of the velocity", "%");
        let fields = [
            Field::shown("line", "", |(name, _): &Row<'_>| (*name).into()),
            number("", ("period", &mm), Significant(4), |(_, l): &Row<'_>| {
                1e3 * l.period
            }),
            number(
                "",
                ("amplitude", &mm),
                Significant(3),
                |(_, l): &Row<'_>| 1e3 * l.amplitude,
            ),
            number(
                "",
                ("standard uncertainty", &mm),
                Significant(2),
                |(_, l): &Row<'_>| 1e3 * l.amplitude_uncertainty,
            ),
            number("", share, Significant(3), |(_, l): &Row<'_>| {
                100.0 * l.relative_velocity
            }),
        ];
        let turn = ripple.once_per_turn.iter().map(|l| ("once per turn", l));
        let table = Table::of(
            "Errors of the encoder that repeat with the position",
            fields,
            turn.chain(ripple.lines.iter().map(|l| ("found", l))),
        );
        Some(Section::new("Ripple of the encoder").table(table.note(format!(
        "Spectrum over {} {} of travel; a line stands five times above the median of the spectrum.",
        scientific(ripple.distance, 3),
        self.unit("m")
    ))))
    }
}
