//! The report of the modes of a fixture.

use proofmass_fixture::{
    Convergence, Damping, Effort, Found, FrequencySensitivity, Level, NaturalMode, Search,
    TransferPoint, Update,
};
use proofmass_report::number::{plain, two_digits};
use proofmass_report::plot::BodyPlot;
use proofmass_report::{
    Axis, Block, Cell, Column, Head, KeyFigure, Report, Section, Series, Table, XyPlot, scientific,
};
use proofmass_uncertainty::Estimate;

/// A line on the face of the gluing point with what the modes do along it.
#[derive(Clone, Debug)]
pub(crate) struct ModesLine<'a> {
    /// What line it is.
    pub name: &'a str,
    /// Distance along it in m.
    pub distance: &'a [f64],
    /// Distance of the gluing point in m.
    pub gluing: f64,
    /// Modulus of the displacement per mode, over the largest of the body.
    pub shape: &'a [Vec<f64>],
    /// Modulus of the displacement at resonance per unit acceleration of the base, per mode, in s².
    pub response: &'a [Vec<f64>],
}

/// What the report tells.
#[derive(Clone, Debug)]
pub(crate) struct ModesReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// Probability of the intervals.
    pub probability: f64,
    /// Label and value of the model: dimensions, materials, support.
    pub model: &'a [(String, String)],
    /// Frequencies, updated where resonances were measured.
    pub estimate: &'a Estimate,
    /// The modes as calculated.
    pub modes: &'a [NaturalMode],
    /// A mode matters when its weight is at least this.
    pub weight: f64,
    /// What the meshes say.
    pub convergence: &'a [Convergence],
    /// The meshes.
    pub levels: &'a [Level],
    /// Of the finest.
    pub effort: Effort,
    /// Surface at rest: points and triangles.
    pub surface: (&'a [[f64; 3]], &'a [[u32; 3]]),
    /// Displacement of the points of the surface, per mode.
    pub shapes: &'a [Vec<[f64; 3]>],
    /// Lines through the gluing point.
    pub lines: Vec<ModesLine<'a>>,
    /// Damping.
    pub damping: Damping,
    /// From base to gluing point, dense, for the plot.
    pub transfer: &'a [TransferPoint],
    /// Highest frequency with less spurious motion than `share`; `None` beyond the last mode.
    pub usable: Option<f64>,
    /// Share of the acceleration of the base.
    pub share: f64,
    /// What the frequencies depend on.
    pub sensitivities: &'a [FrequencySensitivity],
    /// What measured resonances say.
    pub update: Option<&'a Update>,
    /// A search over shapes.
    pub search: Option<(&'a Search, &'a Found)>,
    /// Whether the body is free: no base drives it.
    pub free: bool,
}

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

impl ModesReport<'_> {
    /// The whole report.
    pub(crate) fn full(&self) -> Report {
        let mut report = self.summary().section(self.deformed());
        if !self.free {
            report = report.section(self.transfer()).section(self.along());
        }
        if !self.sensitivities.is_empty() {
            report = report.section(self.budget());
        }
        report = report.section(self.meshes());
        let mut model = Table::new("", [Column::text("what"), Column::text("value")]);
        for (label, value) in self.model {
            model = model.row([Cell::text(label.clone()), Cell::text(value.clone())]);
        }
        report = report.section(Section::new("Model").table(model));
        report.foot(&self.head)
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self) -> Report {
        let mut report = self
            .head
            .open()
            .subtitle("Natural frequencies and mode shapes by finite elements");
        report = report
            .findings(self.head.findings.iter().cloned())
            .section(self.frequencies());
        if let Some(update) = self.update {
            report = report.section(self.updated(update));
        }
        if let Some((wanted, found)) = self.search {
            report = report.section(searched(wanted, found));
        }
        report
    }

    fn frequencies(&self) -> Section {
        let quantities = self.estimate.quantities();
        let mut section = Section::new("Natural frequencies");
        let figure = |label: &str, m: usize| {
            quantities.get(m).map(|q| {
                let (value, expanded) =
                    proofmass_report::number::rounded(q.value, q.expanded(self.probability));
                KeyFigure::new(label, value, "Hz").note(format!(
                    "± {expanded} Hz, {} %",
                    plain(1e2 * self.probability)
                ))
            })
        };
        let mut figures: Vec<KeyFigure> = figure("first mode", 0).into_iter().collect();
        if !self.free {
            let matters = self.modes.iter().position(|m| m.weight() >= self.weight);
            match matters {
                Some(m) => figures.extend(figure("first mode that matters", m)),
                None => figures.push(
                    KeyFigure::new("first mode that matters", "none", "")
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
        section = section.key_figures(figures);
        let mut columns = vec![
            Column::number("mode", ""),
            Column::number("frequency", "Hz"),
            Column::number(format!("U ({} %)", plain(1e2 * self.probability)), "Hz"),
            Column::number("error of the mesh", "%"),
        ];
        if !self.free {
            columns.extend([
                Column::number("weight x′", "%"),
                Column::number("weight y′", "%"),
                Column::number("weight z′", "%"),
                Column::text("matters"),
            ]);
        }
        let mut table = Table::new("", columns);
        for (m, mode) in self.modes.iter().enumerate() {
            let Some(q) = quantities.get(m) else { continue };
            let (value, expanded) =
                proofmass_report::number::rounded(q.value, q.expanded(self.probability));
            let mut row = vec![
                Cell::number((m + 1).to_string()),
                Cell::number(value),
                Cell::number(expanded),
                self.convergence.get(m).map_or(Cell::Empty, |c| {
                    Cell::number(percent(c.error / c.frequency))
                }),
            ];
            if !self.free {
                // A mode the symmetry forbids leaves rounding.
                row.extend(mode.residue().map(|r| {
                    Cell::number(if r.abs() < 5e-5 {
                        "0".to_owned()
                    } else {
                        proofmass_report::number::minus(&format!("{:.2}", 1e2 * r))
                    })
                }));
                row.push(Cell::text(if mode.weight() >= self.weight {
                    "yes"
                } else {
                    "no"
                }));
            }
            table = table.row(row);
        }
        if !self.free {
            table = table.note(format!(
                "Weight: what the mode adds to the acceleration of the gluing point, over that of the base along z′, far above its resonance; at \
                 resonance it is 1/(2ζ) = {:.0} times as much. A mode matters from {} % on.",
                0.5 / self.damping.ratio,
                percent(self.weight)
            ));
        }
        section = section.table(table);
        section
    }

    fn deformed(&self) -> Section {
        let quantities = self.estimate.quantities();
        let (points, triangles) = self.surface;
        let mut plot = BodyPlot::new(points.to_vec(), triangles.to_vec());
        for (m, shape) in self.shapes.iter().take(DRAWN).enumerate() {
            let Some(mode) = self.modes.get(m) else { break };
            let frequency = quantities.get(m).map_or(mode.frequency, |q| q.value);
            let note = if self.free {
                String::new()
            } else if mode.weight() >= self.weight {
                format!("matters: weight {} %", percent(mode.weight()))
            } else {
                "not driven along z′".to_owned()
            };
            plot = plot.state(
                format!("mode {}: {}", m + 1, hertz(frequency)),
                note,
                shape.clone(),
            );
        }
        Section::new("Mode shapes").figure(
            "The first modes, displacements enlarged to a tenth of the body",
            plot,
        )
    }

    fn transfer(&self) -> Section {
        let f: Vec<f64> = self.transfer.iter().map(|p| p.frequency).collect();
        let floor = 1e-6;
        let mut plot = XyPlot::new(
            Axis::log("frequency", "Hz"),
            Axis::log("spurious acceleration over that of the base", ""),
        )
        .height(320.0);
        let mut silent = vec![];
        for (k, name) in ["x′", "y′", "z′"].into_iter().enumerate() {
            let y: Vec<f64> = self.transfer.iter().map(|p| p.spurious()[k]).collect();
            if y.iter().all(|v| *v < floor) {
                silent.push(name);
                continue;
            }
            let y: Vec<f64> = y.into_iter().map(|v| v.max(floor)).collect();
            plot = plot.series(Series::line(format!("along {name}"), &f, &y).look(k));
        }
        plot = plot.horizontal(self.share, format!("{} %", percent(self.share)));
        let mut words = format!(
            "Acceleration of the gluing point beyond the wanted one, per unit acceleration of the base along z′, with ζ = {} for every mode \
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
        Section::new("From base to gluing point")
            .paragraph(words)
            .figure("Spurious motion over frequency", plot)
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
            for (m, (shape, response)) in
                line.shape.iter().zip(line.response).take(LINES).enumerate()
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
            section = section.figure(line.name, plot);
        }
        section
    }

    fn budget(&self) -> Section {
        let shown = self.modes.len().min(LINES);
        let mut columns = vec![
            Column::text("cause"),
            Column::text("value"),
            Column::text("u"),
        ];
        columns.extend((0..shown).map(|m| Column::number(format!("mode {}", m + 1), "Hz")));
        let mut table = Table::new(
            "Standard uncertainty of the calculated frequencies from every cause",
            columns,
        );
        for s in self.sensitivities {
            let mut row = vec![
                Cell::text(s.name.clone()),
                Cell::text(with_unit(s.value, &s.unit)),
                Cell::text(with_unit(s.cause.u, &s.unit)),
            ];
            row.extend((0..shown).map(|m| {
                let f = self.modes[m].frequency;
                Cell::number(two_digits((s.slopes[m] * f * s.cause.u).abs()))
            }));
            table = table.row(row);
        }
        let mut row = vec![
            Cell::text("remaining error of the mesh"),
            Cell::Empty,
            Cell::Empty,
        ];
        row.extend((0..shown).map(|m| {
            let error = self.convergence.get(m).map_or(0.0, |c| c.error);
            Cell::number(two_digits(error / 3f64.sqrt()))
        }));
        Section::new("Where the uncertainty comes from")
            .paragraph("Derivatives of the eigenvalues with the modes held fixed; nodes move with a dimension, no mesh is made anew.")
            .table(table.row(row))
    }

    fn updated(&self, update: &Update) -> Section {
        let mut table = Table::new(
            "Parameters before and after the measured resonances",
            [
                Column::text("parameter"),
                Column::text("before"),
                Column::text("u"),
                Column::text("after"),
                Column::text("u"),
            ],
        );
        for p in &update.parameters {
            table = table.row([
                Cell::text(p.name.clone()),
                Cell::text(with_unit(p.before[0], &p.unit)),
                Cell::text(with_unit(p.before[1], &p.unit)),
                Cell::text(with_unit(p.after[0], &p.unit)),
                Cell::text(with_unit(p.after[1], &p.unit)),
            ]);
        }
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

    fn meshes(&self) -> Section {
        let shown = self.modes.len().min(LINES);
        let mut columns = vec![
            Column::number("elements", ""),
            Column::number("unknowns", ""),
        ];
        columns.extend((0..shown).map(|m| Column::number(format!("mode {}", m + 1), "Hz")));
        let mut table = Table::new("", columns);
        for level in self.levels {
            let mut row = vec![
                Cell::number(level.elements.to_string()),
                Cell::number(level.unknowns.to_string()),
            ];
            row.extend(
                level
                    .frequencies
                    .iter()
                    .take(shown)
                    .map(|f| Cell::number(format!("{f:.1}"))),
            );
            table = table.row(row);
        }
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

fn searched(wanted: &Search, found: &Found) -> Section {
    let mut columns: Vec<Column> = wanted
        .vary
        .iter()
        .map(|v| {
            let unit = match v.0.unit() {
                "m" => "mm",
                "rad" => "°",
                _ => "",
            };
            Column::number(v.0.name().replace('-', " "), unit)
        })
        .collect();
    columns.extend([
        Column::number("first mode", "Hz"),
        Column::number("first that matters", "Hz"),
        Column::number("mass", "g"),
        Column::number("centre of mass from gluing point", "mm"),
        Column::text(""),
    ]);
    let mut table = Table::new(
        "Shapes that no other beats in frequency without being heavier; the first and the best shape marked",
        columns,
    );
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
    for trial in rows {
        let mut row: Vec<Cell> = trial
            .values
            .iter()
            .zip(&wanted.vary)
            .map(|(v, (d, ..))| {
                let value = match d.unit() {
                    "m" => 1e3 * v,
                    "rad" => v.to_degrees(),
                    _ => *v,
                };
                Cell::number(plain(value))
            })
            .collect();
        row.extend([
            Cell::number(format!("{:.0}", trial.first)),
            trial
                .matters
                .map_or(Cell::text("none"), |f| Cell::number(format!("{f:.0}"))),
            Cell::number(format!("{:.0}", 1e3 * trial.mass)),
            Cell::number(format!("{:.1}", 1e3 * trial.offset)),
            Cell::text(match () {
                () if Some(trial) == found.trials.first() => "as given",
                () if Some(trial) == best => "best",
                () => "",
            }),
        ]);
        table = table.row(row);
    }
    let gain = match (found.trials.first(), best) {
        (Some(first), Some(best)) => {
            let f = |t: &proofmass_fixture::Trial| t.matters.unwrap_or(t.first);
            format!(
                "{} shapes solved on one coarse mesh size{}. The first mode that matters rises from {} to {}, {:+.0} %.",
                found.trials.len(),
                if found.impossible > 0 {
                    format!(", {} could not be made", found.impossible)
                } else {
                    String::new()
                },
                hertz(f(first)),
                hertz(f(best)),
                1e2 * (f(best) / f(first) - 1.0)
            )
        }
        _ => String::new(),
    };
    Section::new("Search for a better shape")
        .paragraph(gain)
        .folded("Trade of frequency against mass", [Block::Table(table)])
}
