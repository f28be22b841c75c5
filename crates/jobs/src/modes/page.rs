//! The report of the modes of a fixture.

use super::outcome::{BesideOutcome, LayerEnd, ModesOutcome};
use crate::page::AXES;
use crate::page::answer::stated_as;
use crate::page::columns::{coverage_factor, filed, number};
use crate::page::words::words;
use proofmass_documents::StatedQuantity;
use proofmass_fixture::{
    Convergence, Found, FrequencySensitivity, Goal, Level, LineMotion, NaturalMode, Search,
    TransferPoint, Trial, Update, round,
};
use proofmass_report::Rounding::{Decimals, Plain, TwoDigits};
use proofmass_report::number::{plain, rounded, two_digits};
use proofmass_report::plot::BodyPlot;
use proofmass_report::{
    Axis, Block, Cell, Field, KeyFigure, Report, Section, Series, Table, XyPlot, scientific,
};

/// Deformed shapes that are drawn.
const DRAWN: usize = 6;
/// Modes shown by line.
const LINES: usize = 4;

fn hertz(f: f64) -> String {
    if f >= 1000.0 {
        format!("{:.2} kHz", 1e-3 * f)
    } else {
        format!("{f:.1} Hz")
    }
}

fn percent(share: f64) -> String {
    two_digits(1e2 * share)
}

pub(super) fn add(page: Report, outcome: &ModesOutcome) -> Report {
    let quantities = outcome.stated();
    let mut page = page
        .subtitle("Natural frequencies and mode shapes by finite elements")
        .verdict(outcome.verdict())
        .answers(outcome.answers(&quantities))
        .section(outcome.frequencies(&quantities).summarised());
    let mut files = Vec::new();
    if !outcome.free {
        let table = |points: &[TransferPoint], file| outcome.table_of_transfer(points).file(file);
        files.push(table(&outcome.transfer, "spurious.csv"));
        if let Some(below) = &outcome.below {
            files.push(table(&below.transfer, "gluing.csv"));
        }
    }
    let lines = outcome.lines.iter().zip(["slope.csv", "across.csv"]);
    files.extend(lines.map(|(line, name)| table_of_line(line).file(name)));
    if let Some(ends) = &outcome.ends {
        page = page.section(outcome.layer(ends).summarised());
    }
    if let Some(update) = &outcome.update {
        page = page.section(updated(update).summarised());
    }
    if let Some(beside) = &outcome.beside {
        page = page.section(side_by_side(outcome, beside).summarised());
    }
    if let Some((wanted, found)) = &outcome.search {
        page = page.section(searched(wanted, found).summarised());
        files.push(Table::of("", search_fields(wanted, found), &found.trials).file("search.csv"));
    }
    if !outcome.free {
        page = page.section(outcome.above_base());
    }
    page = page.section(outcome.deformed(&quantities));
    if !outcome.free {
        page = page.section(outcome.along());
    }
    if !outcome.sensitivities.is_empty() {
        page = page.section(outcome.budget());
    }
    let model = outcome
        .description
        .iter()
        .cloned()
        .map(|(what, value)| [what, value]);
    page.section(outcome.meshes())
        .section(Section::new("Model").table(words("", ["what", "value"], model)))
        .section(Section::filed(files))
}

/// A mode with its frequency and what the meshes say of it.
type Mode<'a> = (
    usize,
    (&'a NaturalMode, &'a StatedQuantity),
    Option<&'a Convergence>,
);

impl ModesOutcome {
    fn verdict(&self) -> String {
        let first = self
            .modes
            .first()
            .map_or(String::new(), |m| hertz(m.frequency));
        match self.modes.iter().find(|m| m.weight() >= self.weight) {
            _ if self.free => format!("The free body swings first at {first}."),
            Some(m) => format!(
                "The first mode lies at {first}, the first relevant one at {}.",
                hertz(m.frequency)
            ),
            None => {
                format!("The first mode lies at {first}; none of those calculated is relevant.")
            }
        }
    }

    fn answers(&self, quantities: &[StatedQuantity]) -> Vec<KeyFigure> {
        let figure = |label: &str, m: usize| quantities.get(m).map(|q| stated_as(label, q));
        let mut figures: Vec<KeyFigure> = figure("first mode", 0).into_iter().collect();
        if !self.free {
            let relevant = self.modes.iter().position(|m| m.weight() >= self.weight);
            match relevant {
                Some(m) => figures.extend(figure("first relevant mode", m)),
                None => figures.push(
                    KeyFigure::new("first relevant mode", "none", "")
                        .note(format!("of the {} calculated", self.modes.len())),
                ),
            }
            let below = format!("below {} % spurious motion", percent(self.share));
            figures.push(match self.usable {
                Some(f) => KeyFigure::new("usable up to", format!("{f:.0}"), "Hz").note(below),
                None => KeyFigure::new(
                    "usable up to",
                    format!("{:.0}", self.modes.last().map_or(0.0, |m| m.frequency)),
                    "Hz",
                )
                .note("the last mode calculated"),
            });
        }
        figures
    }

    fn frequencies(&self, quantities: &[StatedQuantity]) -> Section {
        let mut table = self.table_of_modes(quantities);
        if !self.free {
            table = table.note(format!(
                "Weight: the residue of the mode, what it adds to the acceleration of the {}, over that of the base along z′, far above its resonance; at \
                 resonance it is 1/(2ζ) = {:.0} times as much. A mode is relevant from {} % on.",
                self.point(),
                0.5 / self.damping.ratio,
                percent(self.weight)
            ));
        }
        Section::new("Natural frequencies").table(table)
    }

    fn table_of_modes(&self, quantities: &[StatedQuantity]) -> Table {
        let heading = format!("U ({} %)", plain(1e2 * self.probability));
        let mut fields = vec![
            number("mode", ("mode", ""), Decimals(0), |m: &Mode<'_>| {
                (m.0 + 1) as f64
            }),
            Field::new("frequency_Hz", |(_, (_, q), _): &Mode<'_>| {
                Cell::printed(q.value, rounded(q.value, q.expanded).0)
            })
            .page("frequency", "Hz"),
            filed("u_frequency_Hz", |(_, (_, q), _): &Mode<'_>| q.u),
            Field::new("U_frequency_Hz", |(_, (_, q), _): &Mode<'_>| {
                Cell::printed(q.expanded, rounded(q.value, q.expanded).1)
            })
            .page(heading, "Hz"),
            coverage_factor("k", |(_, (_, q), _): &Mode<'_>| q.k),
            number(
                "",
                ("error of the mesh", "%"),
                TwoDigits,
                |(.., c): &Mode<'_>| c.map(|c| 1e2 * (c.error / c.frequency)),
            ),
            filed("mesh_error_Hz", |(.., c): &Mode<'_>| c.map(|c| c.error)),
            filed("order", |(.., c): &Mode<'_>| c.and_then(|c| c.order)),
        ];
        fields.extend((0..3).map(|k| {
            filed(
                format!("participation_{}_sqrt(kg)", AXES[k]),
                move |(_, (mode, _), _): &Mode<'_>| mode.participation[k],
            )
        }));
        for (k, axis) in AXES.into_iter().enumerate() {
            let field = Field::new(format!("weight_{axis}"), move |m: &Mode<'_>| {
                let weight = m.1.0.residue()[k];
                // A mode the symmetry forbids leaves rounding.
                let none = weight.abs() < 5e-5;
                Cell::printed(
                    weight,
                    if none {
                        "0".into()
                    } else {
                        format!("{:.2}", 1e2 * weight)
                    },
                )
            });
            fields.push(match self.free {
                true => field,
                false => field.page(format!("weight {axis}′"), "%"),
            });
        }
        if !self.free {
            fields.push(Field::shown("relevant", "", |m: &Mode<'_>| {
                let relevant = m.1.0.weight() >= self.weight;
                if relevant { "yes" } else { "no" }.into()
            }));
        }
        let modes = self.modes.iter().zip(quantities).enumerate();
        let rows = modes.map(|(m, mode)| (m, mode, self.convergence.get(m)));
        Table::of("", fields, rows).file("modes.csv")
    }

    fn table_of_transfer(&self, points: &[TransferPoint]) -> Table {
        let inclination = round(self.inclination.to_degrees(), 9);
        let mut fields = vec![
            filed("inclination_deg", move |_: &TransferPoint| inclination),
            filed("frequency_Hz", |p: &TransferPoint| p.frequency),
        ];
        for (k, axis) in AXES.into_iter().enumerate() {
            // Along z′ the departure from the excitation, as vibrometers' tables have it.
            let wanted = f64::from(u8::from(k == 2));
            let spread = move |p: &TransferPoint| {
                let [rr, ri, ii] = p.covariance[k];
                let (u, v) = (rr.max(0.0).sqrt(), ii.max(0.0).sqrt());
                let r = if u * v > 0.0 {
                    (ri / (u * v)).clamp(-1.0, 1.0)
                } else {
                    0.0
                };
                [u, v, r]
            };
            fields.push(filed(format!("{axis}_real"), move |p: &TransferPoint| {
                p.ratio[k][0] - wanted
            }));
            fields.push(filed(
                format!("{axis}_imaginary"),
                move |p: &TransferPoint| p.ratio[k][1],
            ));
            let names = [
                format!("u_{axis}_real"),
                format!("u_{axis}_imaginary"),
                format!("r_{axis}"),
            ];
            let names = names.into_iter().enumerate();
            fields
                .extend(names.map(|(i, name)| filed(name, move |p: &TransferPoint| spread(p)[i])));
        }
        Table::of("", fields, points)
    }

    fn deformed(&self, quantities: &[StatedQuantity]) -> Section {
        let (points, triangles, shapes) = self.body.surface();
        let mut plot = BodyPlot::new(points, triangles);
        for (m, shape) in shapes.into_iter().take(DRAWN).enumerate() {
            let Some(mode) = self.modes.get(m) else { break };
            let frequency = quantities.get(m).map_or(mode.frequency, |q| q.value);
            let note = if self.free {
                String::new()
            } else if mode.weight() >= self.weight {
                format!("relevant: weight {} %", percent(mode.weight()))
            } else {
                "not driven along z′".to_owned()
            };
            plot = plot.state(format!("mode {}: {}", m + 1, hertz(frequency)), note, shape);
        }
        Section::new("Mode shapes").figure(
            "The first modes, displacements enlarged to a tenth of the body",
            plot,
        )
    }

    fn above_base(&self) -> Section {
        let (plot, silent) = self.spurious_plot(&self.plotted);
        let point = self.point();
        let mut words = format!(
            "Acceleration of the {point} beyond the wanted one, per unit acceleration of the base along z′, with ζ = {} for every mode \
             (u(ζ) = {}). The part along z′ is the departure from one.",
            scientific(self.damping.ratio, 2),
            scientific(self.damping.u, 2)
        );
        if !silent.is_empty() {
            words.push_str(&format!(
                " Along {} nothing moves: the body is its own mirror image.",
                silent.join(", ")
            ));
        }
        let mut section = Section::new(format!("From base to {point}"))
            .paragraph(words)
            .figure("Spurious motion over frequency", plot);
        if let Some(below) = &self.below {
            let (plot, _) = self.spurious_plot(&below.plotted);
            section = section
                .paragraph(format!(
                    "The wedge under the device moves otherwise: below {} % up to {}.",
                    percent(self.share),
                    self.reach(below.usable)
                ))
                .figure(
                    "The same of the gluing point on the wedge, under the layer",
                    plot,
                );
        }
        section
    }

    /// What the motion is that of.
    fn point(&self) -> &'static str {
        match self.below {
            Some(_) => "device",
            None => "gluing point",
        }
    }

    fn reach(&self, usable: Option<f64>) -> String {
        match usable {
            Some(f) => hertz(f),
            None => "the last mode calculated".into(),
        }
    }

    /// Spurious motion along every axis that has any, and the axes that have none.
    fn spurious_plot(&self, points: &[TransferPoint]) -> (XyPlot, Vec<&'static str>) {
        let f: Vec<f64> = points.iter().map(|p| p.frequency).collect();
        let floor = 1e-6;
        let mut plot = XyPlot::new(
            Axis::log("frequency", "Hz"),
            Axis::log("spurious acceleration over that of the base", ""),
        )
        .height(320.0);
        let mut silent = vec![];
        for (k, name) in ["x′", "y′", "z′"].into_iter().enumerate() {
            let y: Vec<f64> = points.iter().map(|p| p.spurious()[k]).collect();
            if y.iter().all(|v| *v < floor) {
                silent.push(name);
                continue;
            }
            let y: Vec<f64> = y.into_iter().map(|v| v.max(floor)).collect();
            plot = plot.series(Series::line(format!("along {name}"), &f, &y).look(k));
        }
        let plot = plot.horizontal(self.share, format!("{} %", percent(self.share)));
        (plot, silent)
    }

    /// Frequencies and motion from the softest to the stiffest layer.
    fn layer(&self, ends: &[LayerEnd; 2]) -> Section {
        let [soft, stiff] = ends;
        let row = |m: usize| (m, self.modes[m].frequency);
        type Row = (usize, f64);
        let end = |end: &'static str, of: &LayerEnd| {
            let frequencies = of.frequencies.clone();
            number(
                format!("{end}_Hz"),
                (&format!("{end} layer"), "Hz"),
                Decimals(0),
                move |(m, _): &Row| frequencies.get(*m).copied(),
            )
        };
        let fields = vec![
            number("mode", ("mode", ""), Decimals(0), |(m, _): &Row| {
                (m + 1) as f64
            }),
            end("softest", soft),
            number(
                "middle_Hz",
                ("as calculated", "Hz"),
                Decimals(0),
                |(_, f): &Row| *f,
            ),
            end("stiffest", stiff),
        ];
        let table = Table::of("", fields, (0..self.modes.len()).map(row)).file("layer.csv");
        let section = Section::new("From the softest to the stiffest layer").paragraph(
            "A stiffer layer lowers no frequency, so that the two ends enclose what lies between. Half the interval, the farther              end of the two, is part of U as a rectangular distribution.",
        );
        if !self.free {
            let section = section.paragraph(format!(
                "The device moves as wanted up to {} on the softest layer, {} as calculated, {} on the stiffest.",
                self.reach(soft.usable),
                self.reach(self.usable),
                self.reach(stiff.usable)
            ));
            let y = |p: &TransferPoint| p.spurious().into_iter().fold(1e-6, f64::max);
            let mut plot = XyPlot::new(
                Axis::log("frequency", "Hz"),
                Axis::log("largest spurious acceleration over that of the base", ""),
            )
            .height(260.0);
            let three = [
                ("softest layer", &soft.plotted),
                ("as calculated", &self.plotted),
                ("stiffest layer", &stiff.plotted),
            ];
            for (k, (name, points)) in three.into_iter().enumerate() {
                let f: Vec<f64> = points.iter().map(|p| p.frequency).collect();
                let y: Vec<f64> = points.iter().map(y).collect();
                plot = plot.series(Series::line(name, &f, &y).look(k));
            }
            let plot = plot.horizontal(self.share, format!("{} %", percent(self.share)));
            return section.table(table).figure(
                "Spurious motion of the device by stiffness of the layer",
                plot,
            );
        }
        section.table(table)
    }

    fn along(&self) -> Section {
        let mut section = Section::new("Along lines through the gluing point").paragraph(
            "Above, the modulus of the displacement over the largest of the whole body; below, at resonance, per unit \
             acceleration of the base along z′.",
        );
        for line in &self.lines {
            let x: Vec<f64> = line.distance.iter().map(|d| 1e3 * d).collect();
            let mut plot = XyPlot::new(
                Axis::linear("distance along the line", "mm"),
                Axis::linear("displacement", ""),
            )
            .below(Axis::linear("at resonance", "nm/(m/s²)"));
            let (mut above, mut below) = (vec![], vec![]);
            for (m, (shape, response)) in line
                .shape
                .iter()
                .zip(&line.response)
                .take(LINES)
                .enumerate()
            {
                let name = format!("mode {}", m + 1);
                above.push(Series::line(name.clone(), &x, shape).look(m));
                let y: Vec<f64> = response.iter().map(|v| 1e9 * v).collect();
                below.push(Series::line(name, &x, &y).look(m));
            }
            let mark = 1e3 * line.gluing;
            let [first, second] = plot.panels.as_mut_slice() else {
                continue;
            };
            first.series = above;
            second.series = below;
            for (panel, label) in [(first, "gluing point"), (second, "")] {
                panel.height = 190.0;
                panel.vertical.push(proofmass_report::plot::ReferenceLine {
                    at: mark,
                    label: label.into(),
                });
            }
            section = section.figure(&line.name, plot);
        }
        section
    }

    fn budget(&self) -> Section {
        let shown = self.modes.len().min(LINES);
        // None is the mesh.
        type Cause<'a> = Option<&'a FrequencySensitivity>;
        let unit = |s: &Cause<'_>, value: fn(&FrequencySensitivity) -> f64| {
            s.map(|s| with_unit(value(s), &s.unit)).into()
        };
        let mut fields = vec![
            Field::shown("cause", "", |s: &Cause<'_>| {
                s.map_or("remaining error of the mesh", |s| &s.name).into()
            }),
            Field::shown("value", "", move |s: &Cause<'_>| unit(s, |s| s.value)),
            Field::shown("u", "", move |s: &Cause<'_>| unit(s, |s| s.cause.u)),
        ];
        fields.extend((0..shown).map(|m| {
            let part = move |s: &Cause<'_>| match s {
                Some(s) => (s.slopes[m] * self.modes[m].frequency * s.cause.u).abs(),
                None => self.convergence.get(m).map_or(0.0, |c| c.error) / 3f64.sqrt(),
            };
            number("", (&format!("mode {}", m + 1), "Hz"), TwoDigits, part)
        }));
        let table = Table::of(
            "Standard uncertainty of the calculated frequencies from every cause",
            fields,
            self.sensitivities.iter().map(Some).chain([None]),
        );
        Section::new("Where the uncertainty comes from")
            .paragraph("Derivatives of the eigenvalues with the modes held fixed; nodes move with a dimension, no mesh is made anew.")
            .table(table)
    }

    fn meshes(&self) -> Section {
        let shown = self.modes.len().min(LINES);
        let mut fields = vec![
            Field::shown("elements", "", |l: &Level| l.elements.into()),
            Field::shown("unknowns", "", |l: &Level| l.unknowns.into()),
        ];
        fields.extend((0..shown).map(|m| {
            let heading = format!("mode {}", m + 1);
            number("", (&heading, "Hz"), Decimals(1), move |l: &Level| {
                l.frequencies.get(m).copied()
            })
        }));
        let table = Table::of("", fields, &self.levels);
        let orders: Vec<String> = self
            .convergence
            .iter()
            .take(shown)
            .map(|c| c.order.map_or("none".into(), |p| format!("{p:.1}")))
            .collect();
        let limits: Vec<String> = self
            .convergence
            .iter()
            .take(shown)
            .map(|c| {
                c.extrapolated
                    .map_or("none".into(), |f| format!("{f:.1} Hz"))
            })
            .collect();
        let count = match self.effort.complete {
            Some(true) => {
                "The count of modes by the signs of the factorisation agrees: none is missed."
            }
            Some(false) => "The count of modes by the signs of the factorisation disagrees.",
            None => "The count of modes could not be made.",
        };
        let observed = match orders.iter().any(|o| o != "none") {
            true => format!(
                "Observed order of convergence: {}; extrapolated to no mesh at all: {}. Smooth shapes give 4, edges that cut into the body and the edge \
                 of a clamped base less.",
                orders.join(", "),
                limits.join(", ")
            ),
            false => "No order of convergence was observed: that takes three meshes. The error is the change between the last two."
                .to_owned(),
        };
        Section::new("Convergence of the mesh")
            .paragraph(observed)
            .table(table)
            .paragraph(format!(
                "{count} Ten-node tetrahedra; largest relative residual of a mode {}.",
                scientific(self.effort.residual, 1)
            ))
    }
}

/// Two fixtures: frequencies, spurious motion, displacement along the slope.
fn side_by_side(first: &ModesOutcome, beside: &BesideOutcome) -> Section {
    let both = [first, &beside.other];
    let names = &beside.names;
    let stated = both.map(ModesOutcome::stated);
    let mut fields: Vec<Field<'_, usize>> =
        vec![number("mode", ("mode", ""), Decimals(0), |m: &usize| {
            (*m + 1) as f64
        })];
    for (k, key) in ["first", "second"].into_iter().enumerate() {
        let quantities = &stated[k];
        let outcome = both[k];
        fields.push(
            Field::new(format!("{key}_Hz"), move |m: &usize| {
                match quantities.get(*m) {
                    Some(q) => Cell::printed(q.value, rounded(q.value, q.expanded).0),
                    None => Cell::Empty,
                }
            })
            .page(names[k].clone(), "Hz"),
        );
        fields.push(
            Field::new(format!("{key}_U_Hz"), move |m: &usize| {
                match quantities.get(*m) {
                    Some(q) => Cell::printed(q.expanded, rounded(q.value, q.expanded).1),
                    None => Cell::Empty,
                }
            })
            .page(format!("U ({} %)", plain(1e2 * outcome.probability)), "Hz"),
        );
        fields.push(coverage_factor(&format!("{key}_k"), move |m: &usize| {
            quantities.get(*m).map(|q| q.k)
        }));
        fields.push(
            number(
                format!("{key}_weight"),
                ("weight", "%"),
                Decimals(2),
                move |m: &usize| outcome.modes.get(*m).map(NaturalMode::weight),
            )
            .scaled(1e2),
        );
    }
    let count = first.modes.len().max(beside.other.modes.len());
    let table = Table::of("Natural frequencies", fields, 0..count).file("beside.csv");
    let whole = [
        (
            "first relevant mode",
            both.map(|o| {
                let relevant = o.modes.iter().find(|m| m.weight() >= o.weight);
                relevant.map_or("none of those calculated".into(), |m| hertz(m.frequency))
            }),
        ),
        (
            "usable up to",
            both.map(|o| format!("{}, below {} %", o.reach(o.usable), percent(o.share))),
        ),
        (
            "mass, accelerometer included",
            both.map(|o| format!("{} g", round(1e3 * o.mass, 1))),
        ),
    ];
    let rows = whole.map(|(what, [a, b])| [what.to_owned(), a, b]);
    let mut section = Section::new("Side by side").table(words(
        "",
        ["what", names[0].as_str(), names[1].as_str()],
        rows,
    ));
    section = section.table(table);
    if first.free || beside.other.free {
        return section;
    }
    let largest = |p: &TransferPoint| p.spurious().into_iter().fold(0.0, f64::max);
    let mut plot = XyPlot::new(
        Axis::log("frequency", "Hz"),
        Axis::log("largest spurious acceleration over that of the base", ""),
    )
    .height(260.0);
    for (k, outcome) in both.into_iter().enumerate() {
        let f: Vec<f64> = outcome.plotted.iter().map(|p| p.frequency).collect();
        let y: Vec<f64> = outcome
            .plotted
            .iter()
            .map(|p| largest(p).max(1e-6))
            .collect();
        plot = plot.series(Series::line(names[k].clone(), &f, &y).look(k));
    }
    let plot = plot.horizontal(first.share, format!("{} %", percent(first.share)));
    // Frequencies that both tables have.
    let rows: Vec<(f64, [f64; 2])> = first
        .transfer
        .iter()
        .filter_map(|p| {
            let mut others = beside.other.transfer.iter();
            let other = others.find(|o| o.frequency == p.frequency)?;
            Some((p.frequency, [largest(p), largest(other)]))
        })
        .collect();
    type Row = (f64, [f64; 2]);
    let mut fields = vec![number("frequency_Hz", ("f", "Hz"), Plain, |r: &Row| r.0)];
    for (k, key) in ["first", "second"].into_iter().enumerate() {
        fields.push(number(key, (&names[k], "%"), TwoDigits, move |r: &Row| r.1[k]).scaled(1e2));
    }
    let motion =
        Table::of("Largest spurious motion along any axis", fields, rows).file("beside-motion.csv");
    section = section
        .figure("Spurious motion of the two over frequency", plot)
        .table(motion);
    // The first relevant modes along the slope, from the gluing point, at resonance.
    let mut plot = XyPlot::new(
        Axis::linear("distance from the gluing point", "mm"),
        Axis::linear("displacement at resonance", "nm/(m/s²)"),
    )
    .height(240.0);
    let mut look = 0;
    for (outcome, name) in both.into_iter().zip(names) {
        let Some(line) = outcome.lines.first() else {
            continue;
        };
        let x: Vec<f64> = line
            .distance
            .iter()
            .map(|d| 1e3 * (d - line.gluing))
            .collect();
        let relevant = outcome.modes.iter().enumerate();
        for (m, mode) in relevant
            .filter(|(_, m)| m.weight() >= outcome.weight)
            .take(2)
        {
            let Some(response) = line.response.get(m) else {
                continue;
            };
            let y: Vec<f64> = response.iter().map(|v| 1e9 * v).collect();
            let label = format!("{name}, {}", hertz(mode.frequency));
            plot = plot.series(Series::line(label, &x, &y).look(look));
            look += 1;
        }
    }
    match look {
        0 => section,
        _ => section.figure("The first two relevant modes along the slope", plot),
    }
}

fn updated(update: &Update) -> Section {
    let rows = update.parameters.iter().map(|p| {
        let value = |v: f64| with_unit(v, &p.unit);
        let ([before, u], [after, left]) = (p.before.map(value), p.after.map(value));
        [p.name.clone(), before, u, after, left]
    });
    let table = words(
        "Parameters before and after the measured resonances",
        ["parameter", "before", "u", "after", "u"],
        rows,
    );
    Section::new("Measured resonances")
            .paragraph(format!(
                "The frequencies above are those after the update. Agreement of measurement and model: χ² = {}, {}.",
                two_digits(update.chi_squared),
                match update.probability {
                    p if p < 1e-6 => "p below 10⁻⁶".to_owned(),
                    p => format!("p = {}", two_digits(p)),
                }
            ))
            .table(table)
}

/// A number of the model in a unit a workshop reads.
fn with_unit(value: f64, unit: &str) -> String {
    let (factor, name) = match unit {
        "Pa" => (1e-9, "GPa"),
        "m" => (1e3, "mm"),
        "rad" => (180.0 / std::f64::consts::PI, "°"),
        "kg" => (1e3, "g"),
        "N/m" => (1e-6, "N/µm"),
        "1" => (1.0, ""),
        other => (1.0, other),
    };
    let text = scientific(value * factor, 4);
    if name.is_empty() {
        text
    } else {
        format!("{text} {name}")
    }
}

fn table_of_line(line: &LineMotion) -> Table {
    let mut fields = vec![Field::series("distance_m", &line.distance)];
    for (m, (shape, response)) in line.shape.iter().zip(&line.response).enumerate() {
        fields.push(Field::series(format!("mode_{}_shape", m + 1), shape));
        fields.push(Field::series(
            format!("mode_{}_response_s2", m + 1),
            response,
        ));
    }
    Table::of("", fields, 0..line.distance.len())
}

fn search_fields<'a>(wanted: &Search, found: &'a Found) -> Vec<Field<'a, Trial>> {
    let varied = wanted.vary.iter().enumerate().map(|(k, (dimension, ..))| {
        let (name, unit) = (dimension.name(), dimension.unit());
        let (file, shown, scale) = match unit {
            "m" => ("_m", "mm", 1e3),
            "rad" => ("_rad", "°", 180.0 / std::f64::consts::PI),
            _ => ("", "", 1.0),
        };
        let heading = name.replace('-', " ");
        let file = format!("{}{file}", name.replace('-', "_"));
        number(file, (&heading, shown), Plain, move |t: &Trial| t.values[k]).scaled(scale)
    });
    let mut fields: Vec<Field<'a, Trial>> = varied.collect();
    if let Goal::LeastMotion { up_to, .. } = wanted.goal {
        let heading = format!("largest spurious motion up to {}", hertz(up_to));
        fields.push(
            Field::new("largest_motion", |t: &Trial| match t.motion {
                Some(motion) => motion.into(),
                None => Cell::Empty,
            })
            .page(heading, "%")
            .scaled(1e2)
            .rounded(TwoDigits),
        );
    }
    fields.extend([
        number(
            "first_Hz",
            ("first mode", "Hz"),
            Decimals(0),
            |t: &Trial| t.first,
        ),
        Field::new("first_that_matters_Hz", |t: &Trial| match t.matters {
            Some(f) => f.into(),
            None => Cell::Empty.worded("none"),
        })
        .page("first relevant mode", "Hz")
        .decimals(0),
        number("mass_kg", ("mass", "g"), Decimals(0), |t: &Trial| t.mass).scaled(1e3),
        number(
            "centre_from_gluing_point_m",
            ("centre of mass from gluing point", "mm"),
            Decimals(1),
            |t: &Trial| t.offset,
        )
        .scaled(1e3),
        filed("better", |t: &Trial| f64::from(u8::from(t.better))),
        Field::shown("", "", |t: &Trial| {
            Cell::from(match () {
                () if Some(t) == found.trials.first() => "as given",
                () if Some(t) == found.best_trial() => "best",
                () => "",
            })
        }),
    ]);
    fields
}

fn searched(wanted: &Search, found: &Found) -> Section {
    let mut rows = found.trade();
    if let Some(first) = found.trials.first()
        && !rows.contains(&first)
    {
        rows.insert(0, first);
    }
    let best = found.best_trial();
    if let Some(best) = best.filter(|b| !rows.contains(b)) {
        rows.push(best);
    }
    let impossible = match found.impossible {
        0 => String::new(),
        n => format!(", {n} could not be made"),
    };
    let [what, trade] = match wanted.goal {
        Goal::LeastMotion { .. } => ["motion", "Trade of motion against mass"],
        _ => ["frequency", "Trade of frequency against mass"],
    };
    let table = Table::of(
        format!(
            "Shapes that no other beats in {what} without being heavier; the first and the best shape marked"
        ),
        search_fields(wanted, found),
        rows,
    );
    let motion = |t: Option<&Trial>| t.and_then(|t| t.motion);
    let still = match (motion(found.trials.first()), motion(best), wanted.goal) {
        (Some(before), Some(after), Goal::LeastMotion { up_to, .. }) => Some(format!(
            "{} shapes solved on one coarse mesh size{impossible}. The largest spurious motion up to {} falls from {} % to {} % of the \
             acceleration of the base, {:+.0} %.",
            found.trials.len(),
            hertz(up_to),
            percent(before),
            percent(after),
            1e2 * (after / before - 1.0)
        )),
        _ => None,
    };
    let gain = match (found.trials.first(), best) {
        (Some(first), Some(best)) => {
            let f = |t: &proofmass_fixture::Trial| t.matters.unwrap_or(t.first);
            format!(
                "{} shapes solved on one coarse mesh size{impossible}. The first relevant mode rises from {} to {}, {:+.0} %.",
                found.trials.len(),
                hertz(f(first)),
                hertz(f(best)),
                1e2 * (f(best) / f(first) - 1.0)
            )
        }
        _ => String::new(),
    };
    Section::new("Search for a better shape")
        .paragraph(still.unwrap_or(gain))
        .folded(trade, [Block::Table(table)])
}
