//! The report of a multi-position calibration.

mod models;
mod practice;

use proofmass_report::number::{freedom, rounded, two_digits};
use proofmass_report::{
    Axis, BarPlot, Cell, Column, Head, KeyFigure, MatrixPlot, Report, Section, Series, SpherePlot,
    Table, XyPlot,
};
use proofmass_signal::Trace;
use proofmass_static::{
    CompensatedReading, ModelEvidence, MultiPositionFit, NextAttitude, PoseResidual,
    StandstillCalibration,
};
use proofmass_uncertainty::{Format, Quantity};

/// What the report tells beside the calibration itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct MultiPositionReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// Name of the method as the campaign gives it.
    pub method: String,
    /// Probability of the intervals.
    pub probability: f64,
    /// Outputs x, y, z against time, s, for their plot.
    pub outputs: Option<&'a [Trace; 3]>,
    /// The statistic of the standstill search against time, for its plot.
    pub windowed: Option<&'a Trace>,
    /// Beginning and end of each standstill, s.
    pub standstills: &'a [(f64, f64)],
    /// What a compensated reading is worth over the sphere.
    pub reading: Option<&'a CompensatedReading>,
    /// The next best attitudes, each given those before it.
    pub next: &'a [NextAttitude],
    /// Other models of the same standstills.
    pub models: &'a [ModelEvidence],
}

impl MultiPositionReport<'_> {
    /// The whole report.
    pub(crate) fn full(&self, calibration: &StandstillCalibration) -> Report {
        let fit = &calibration.fit;
        let mut report = self.head(fit);
        report = report
            .section(self.result(fit))
            .section(practice::section(fit, self.reading, self.next))
            .section(self.agreement(fit))
            .section(self.budget(fit));
        if let Some(section) = models::section(fit, self.models) {
            report = report.section(section);
        }
        if self.outputs.is_some() {
            report = report.section(self.standstills(calibration));
        }
        report
            .section(self.provenance(fit))
            .footer(self.head.footer.clone())
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self, calibration: &StandstillCalibration) -> Report {
        let fit = &calibration.fit;
        let mut section = Section::new("Result")
            .key_figures(key_figures(fit))
            .table(self.parameters(fit));
        section = practice::next(section, fit, self.next);
        let mut report = self.head(fit).section(section);
        if fit.beyond().is_some()
            && let Some(section) = models::section(fit, self.models)
        {
            report = report.section(section);
        }
        report
    }

    fn head(&self, fit: &MultiPositionFit) -> Report {
        let gravity = fit.gravity();
        let report = self.head.open().subtitle(format!(
            "Multi-position calibration of a triaxial accelerometer: method {}, {}, g = {} m/s²",
            self.method,
            counted(fit),
            concise(gravity.value(), gravity.standard_uncertainty()),
        ));
        report.findings(self.head.findings.iter().cloned())
    }

    fn result(&self, fit: &MultiPositionFit) -> Section {
        let mut section = Section::new("Result")
            .paragraph(
                "Model ã = K a + b: output ã under the specific force a. Scale factors are the diagonal of K, \
                 misalignments its other elements divided by the diagonal element of their row. Compensation is \
                 a = K⁻¹ (ã − b).",
            )
            .key_figures(key_figures(fit))
            .table(self.parameters(fit))
            .table(matrix(fit));
        if let Some(text) = models::beyond(fit) {
            section = section.paragraph(text);
        }
        if self.method == "ferraris" {
            section = section.table(practice::ferraris(fit));
        }
        section
    }

    fn parameters(&self, fit: &MultiPositionFit) -> Table {
        let percent = 100.0 * self.probability;
        let mut table = Table::new(
            format!(
                "Parameters with their {} % intervals, value ± U",
                significant(percent)
            ),
            [
                Column::text("quantity"),
                Column::number("value", ""),
                Column::number("U", ""),
                Column::text("unit"),
                Column::number("k", ""),
                Column::number("ν_eff", ""),
            ],
        );
        for quantity in fit.quantities() {
            let (value, expanded) = rounded(quantity.value, quantity.expanded(self.probability));
            table = table.row([
                Cell::text(quantity.name.clone()),
                Cell::number(value),
                Cell::number(expanded),
                Cell::text(quantity.unit.clone()),
                Cell::number(format!("{:.2}", quantity.coverage_factor(self.probability))),
                Cell::number(freedom(quantity.dof.get())),
            ]);
        }
        table
    }

    fn agreement(&self, fit: &MultiPositionFit) -> Section {
        let residuals = fit.residuals();
        let number: Vec<f64> = (1..=residuals.len()).map(|i| i as f64).collect();
        let value: Vec<f64> = residuals
            .iter()
            .map(|r| 1e3 * r.magnitude_residual)
            .collect();
        let spread: Vec<f64> = residuals
            .iter()
            .map(|r| 2e3 * r.noise.hypot(fit.excess()))
            .collect();
        let low: Vec<f64> = value.iter().zip(&spread).map(|(v, s)| v - s).collect();
        let high: Vec<f64> = value.iter().zip(&spread).map(|(v, s)| v + s).collect();
        let plot = XyPlot::new(
            Axis::linear(noun(fit), "").range(0.0, residuals.len() as f64 + 1.0),
            Axis::linear("‖a‖ − g", "mm/s²"),
        )
        .horizontal(0.0, "")
        .series(Series::markers("", &number, &value).bars(&low, &high));
        let mut sphere = SpherePlot::new("‖a‖ − g", "mm/s²");
        for (i, r) in residuals.iter().enumerate() {
            sphere = sphere.point(
                r.acceleration,
                1e3 * r.magnitude_residual,
                // Numbers that nobody could read are left away.
                if residuals.len() > LEGIBLE {
                    String::new()
                } else {
                    format!("{}", i + 1)
                },
            );
        }
        Section::new(format!("Agreement of the {}s", noun(fit)))
            .paragraph(format!(
                "{} Attitudes: {}; the largest part of the sphere without an attitude has a radius of {:.0}°. Condition \
                 number {:.1}.",
                scatter(fit),
                fit.coverage(),
                fit.coverage().largest_hole_deg,
                fit.condition(),
            ))
            .figure(
                format!(
                    "Residual of each {}; bars are two standard uncertainties of its noise and any excess",
                    noun(fit)
                ),
                plot,
            )
            .figure(
                "Directions of the specific force in the axes of the sensor, coloured by the residual",
                sphere,
            )
            .table(standstill_table(fit))
    }

    fn budget(&self, fit: &MultiPositionFit) -> Section {
        let estimate = fit.estimate();
        let names: Vec<&str> = estimate
            .components()
            .iter()
            .map(|c| c.name.as_str())
            .collect();
        // One row per quantity: the standstills, taken apart, then every cause that no residual shows.
        let others: Vec<(&str, &str)> = estimate
            .influences()
            .iter()
            .filter(|i| i.key != "standstills")
            .map(|i| (i.key.as_str(), i.description.as_str()))
            .collect();
        let attitudes = fit.scatter_parts().iter().any(|p| p.attitude > 0.0);
        let mut columns = vec![
            Column::text("quantity"),
            Column::number("noise", ""),
            Column::number("between standstills", ""),
        ];
        if attitudes {
            columns.push(Column::number("each attitude", ""));
        }
        columns.extend(others.iter().map(|(_, what)| Column::number(*what, "")));
        columns.push(Column::number("u", ""));
        columns.push(Column::text("unit"));
        columns.push(Column::number("ν_eff", ""));
        let mut table = Table::new(
            "Budget: contribution of each cause to the standard uncertainty",
            columns,
        );
        let mut bars = BarPlot::shares("share of the variance, mean over all quantities");
        let mut mean_share: Vec<(String, f64)> = Vec::new();
        for (quantity, parts) in fit.quantities().iter().zip(fit.scatter_parts()) {
            let u = quantity.standard_uncertainty;
            let number = |value: f64| Cell::number(contribution(value, (value / u).powi(2)));
            let mut row = vec![
                Cell::text(quantity.name.clone()),
                number(parts.noise),
                number(parts.between),
            ];
            let mut shares = vec![
                ("noise of the means", parts.noise),
                ("between standstills", parts.between),
            ];
            if attitudes {
                row.push(number(parts.attitude));
                shares.push(("each attitude", parts.attitude));
            }
            let lines = estimate.budget(&quantity.name).unwrap_or_default();
            for (key, what) in &others {
                let line = lines.iter().find(|l| l.key == *key);
                let value = line.map_or(0.0, |l| l.contribution);
                row.push(number(value));
                shares.push((*what, value));
            }
            row.push(Cell::number(two_digits(u)));
            row.push(Cell::text(quantity.unit.clone()));
            row.push(Cell::number(freedom(quantity.dof.get())));
            table = table.row(row);
            for (what, value) in shares {
                let share = (value / u).powi(2) / names.len() as f64;
                match mean_share.iter_mut().find(|(name, _)| name == what) {
                    Some((_, sum)) => *sum += share,
                    None => mean_share.push((what.to_owned(), share)),
                }
            }
        }
        mean_share.sort_by(|a, b| b.1.total_cmp(&a.1));
        for (name, share) in mean_share {
            bars = bars.bar(name, share, "");
        }
        Section::new("Uncertainty")
            .paragraph(
                "Noise comes from the samples of the standstills, their autocorrelation included; what varies between \
                 standstills from the residuals. Both are type A and one influence with common degrees of freedom, for \
                 the residuals fix only their sum. Gravity and attitudes enter as type B. Contributions of one quantity \
                 add in squares to its variance; quantities of the same fit are correlated, so combine them through the \
                 joint covariance of result.json.",
            )
            .figure("Causes of uncertainty", bars)
            .figure(
                "Correlation of the quantities",
                MatrixPlot::correlation(&names, estimate.covariance()),
            )
            .table(table)
    }

    fn standstills(&self, calibration: &StandstillCalibration) -> Section {
        let sweep = &calibration.sweep;
        let mut section = Section::new("The recording and its standstills");
        section = section.paragraph(match sweep.threshold {
            Some(threshold) if sweep.candidates.is_empty() => {
                format!("Standstills were found with the given threshold of {threshold:.1} times the noise floor.")
            }
            Some(threshold) => format!(
                "Standstills were found by the variance in a sliding window. Of {} thresholds the fit was as good as \
                 the best at {threshold:.1} times the noise floor, the strictest that breaks fewest standstills.",
                sweep.candidates.len()
            ),
            None if calibration.fit.effective_readings().is_some() => TUMBLE.to_owned(),
            None if noun(&calibration.fit) == "reading" => {
                "Every row is a reading in an attitude of its own.".to_owned()
            }
            None => "The standstills were given.".to_owned(),
        });
        if let Some(outputs) = self.outputs {
            let shades = self.standstills;
            let unit = calibration.fit.output_unit();
            let mut plot = XyPlot::new(Axis::linear("time", "s"), Axis::linear("output", unit));
            for (name, output) in ["x", "y", "z"].iter().zip(outputs) {
                plot = plot.series(Series::line(*name, &output.x, &output.y));
            }
            plot = plot.shade("standstill", shades);
            if let Some(windowed) = self.windowed {
                plot = plot
                    .below(Axis::log("variance / floor", ""))
                    .series(Series::line("windowed variance", &windowed.x, &windowed.y).look(3))
                    .shade("", shades);
                if let Some(threshold) = sweep.threshold {
                    plot = plot.horizontal(threshold, "threshold");
                }
            }
            let caption = match shades {
                [] => "The recording",
                _ => "The recording; shaded: the standstills that were used",
            };
            section = section.figure(caption, plot);
        }
        let tried: Vec<_> = sweep
            .candidates
            .iter()
            .filter_map(|c| Some((c.threshold, c.figure?)))
            .collect();
        if tried.len() > 1 {
            let (x, y): (Vec<f64>, Vec<f64>) = tried.into_iter().unzip();
            let plot = XyPlot::new(
                Axis::log("threshold / noise floor", ""),
                Axis::log("relative width of the intervals", ""),
            )
            .series(Series::line("", &x, &y).style(proofmass_report::plot::Style::LineAndMarkers))
            .vertical(sweep.threshold.unwrap_or(x[0]), "chosen");
            section = section.figure("The sweep of the threshold", plot);
        }
        if !sweep.excluded.is_empty() {
            section = section.paragraph(format!(
                "Left out on request: standstill {}.",
                sweep.excluded.join(", ")
            ));
        }
        let Some(noise) = &calibration.noise else {
            return section;
        };
        let inflation = noise.variance_inflation();
        section.paragraph(format!(
            "Noise of single samples: {} {unit} (x), {} {unit} (y), {} {unit} (z); correlation of neighbouring samples \
             makes the variance of long means {:.2}, {:.2} and {:.2} times that of uncorrelated ones.",
            two_digits(noise.deviation()[0]),
            two_digits(noise.deviation()[1]),
            two_digits(noise.deviation()[2]),
            inflation[0],
            inflation[1],
            inflation[2],
            unit = calibration.fit.output_unit(),
        ))
    }

    fn provenance(&self, fit: &MultiPositionFit) -> Section {
        Section::new("Inputs and method")
            .inputs(&self.head.inputs)
            .paragraph(format!(
                "Model {}: {} parameters, {} iterations of weighted least squares. Uncertainty: law of propagation, \
                 coverage factors from Student's t at the effective degrees of freedom (JCGM 100:2008). Standstill \
                 search and ‖a‖ = g fit after Tedaldi, Pretto and Menegatti (ICRA 2014).",
                fit.form(),
                fit.parameters(),
                fit.iterations(),
            ))
    }
}

const TUMBLE: &str = "The sensor was turned all the time. Every sample counts: the magnitudes of a part are averaged in its \
                      mean direction. Neighbouring parts share errors, so that fewer count as independent: their number divided \
                      by the sum of the correlations of the residuals.";

/// Points that can be told apart by their numbers.
const LEGIBLE: usize = 80;

/// What the fit is made of.
fn noun(fit: &MultiPositionFit) -> &'static str {
    let single = || fit.poses().iter().all(|p| p.segment.len() == 1);
    if fit.effective_readings().is_some() {
        "part"
    } else if single() {
        "reading"
    } else {
        "standstill"
    }
}

fn counted(fit: &MultiPositionFit) -> String {
    let n = fit.poses().len();
    match fit.effective_readings() {
        Some(effective) => {
            format!("a tumble of {n} parts of which {effective:.0} count as independent")
        }
        None => format!("{n} {}s", noun(fit)),
    }
}

/// What the residuals say of the standstills, and what the intervals do with it.
fn scatter(fit: &MultiPositionFit) -> String {
    let tau = 1e3 * fit.excess();
    let (Some(chi_square), Some(birge)) = (fit.chi_square(), fit.birge_ratio()) else {
        return format!(
            "The noise of the readings is not known: their scatter about the model, {tau:.2} mm/s², is all there is.",
        );
    };
    let nu = fit.degrees_of_freedom();
    let range = fit.scatter().map_or(String::new(), |s| {
        let [low, high] = s.birge_range;
        format!("; {low:.2} to {high:.2} in 95 % of cases where the noise is all there is")
    });
    format!(
        "χ² = {chi_square:.1} with {nu} degrees of freedom against the noise of the means (Birge ratio {birge:.2}{range}). \
         The estimated standard deviation between standstills beyond that noise is {tau:.2} mm/s²; the intervals carry \
         it, and how well the residuals fix it, without a test in between.",
    )
}

fn key_figures(fit: &MultiPositionFit) -> Vec<KeyFigure> {
    let birge = fit
        .birge_ratio()
        .map_or("–".to_owned(), |b| format!("{b:.2}"));
    vec![
        KeyFigure::new(format!("{}s", noun(fit)), fit.poses().len().to_string(), ""),
        KeyFigure::new(
            "residual, RMS",
            format!("{:.2}", 1e3 * fit.residual_rms()),
            "mm/s²",
        )
        .note("‖a‖ − g"),
        KeyFigure::new("Birge ratio", birge, "").note("residual / noise of the means"),
        KeyFigure::new("condition number", format!("{:.1}", fit.condition()), ""),
    ]
}

/// K and b as they stand in calibration.json.
fn matrix(fit: &MultiPositionFit) -> Table {
    let sensor = fit.model();
    let unit = fit.output_unit();
    let k_unit = if unit == "m/s²" {
        String::new()
    } else {
        format!("{unit}/(m/s²)")
    };
    let mut table = Table::new(
        "Sensitivity matrix K and bias b",
        [
            Column::text("output"),
            Column::number("K x", k_unit.clone()),
            Column::number("K y", k_unit.clone()),
            Column::number("K z", k_unit),
            Column::number("b", unit),
        ],
    );
    for (i, axis) in ["x", "y", "z"].iter().enumerate() {
        let mut cells = vec![Cell::text(*axis)];
        cells.extend(
            sensor.k().0[i]
                .iter()
                .map(|v| Cell::number(six_digits(*v, sensor.k().0[i][i]))),
        );
        let expanded = fit
            .quantities()
            .get(i)
            .map_or(0.0, |q| q.expanded(fit.probability()));
        cells.push(Cell::number(rounded(sensor.bias()[i], expanded).0));
        table = table.row(cells);
    }
    table
}

fn standstill_table(fit: &MultiPositionFit) -> Table {
    let name = noun(fit);
    let mut title = format!("{}{}s", name[..1].to_uppercase(), &name[1..]);
    let shown = match fit.residuals().len() {
        n if n > 2 * LEGIBLE => {
            title = format!(
                "{title}: the {LEGIBLE} with the largest residuals of {n}; all are in standstills.csv"
            );
            largest(fit)
        }
        _ => fit.residuals().iter().collect(),
    };
    let mut table = Table::new(
        title,
        [
            Column::text(name),
            Column::number("first sample", ""),
            Column::number("samples", ""),
            Column::number("a_x", "m/s²"),
            Column::number("a_y", "m/s²"),
            Column::number("a_z", "m/s²"),
            Column::number("‖a‖ − g", "mm/s²"),
            Column::number("u (noise)", "mm/s²"),
            Column::number("studentised", ""),
        ],
    );
    for r in shown {
        table = table.row([
            Cell::text(r.name.clone()),
            Cell::number(r.samples.0.to_string()),
            Cell::number((r.samples.1 - r.samples.0).to_string()),
            Cell::number(format!("{:.4}", r.acceleration[0])),
            Cell::number(format!("{:.4}", r.acceleration[1])),
            Cell::number(format!("{:.4}", r.acceleration[2])),
            Cell::number(format!("{:.2}", 1e3 * r.magnitude_residual)),
            // Single readings whose uncertainty nobody stated have none.
            match r.noise > 0.0 {
                true => Cell::number(format!("{:.2}", 1e3 * r.noise)),
                false => Cell::Empty,
            },
            r.studentised
                .map_or(Cell::Empty, |t| Cell::number(format!("{t:.1}"))),
        ]);
    }
    table
}

/// The readings furthest off, in their order.
fn largest(fit: &MultiPositionFit) -> Vec<&PoseResidual> {
    let mut all: Vec<(usize, &PoseResidual)> = fit.residuals().iter().enumerate().collect();
    let size = |r: &PoseResidual| r.magnitude_residual.abs();
    all.sort_by(|a, b| size(b.1).total_cmp(&size(a.1)));
    all.truncate(LEGIBLE);
    all.sort_by_key(|(index, _)| *index);
    all.into_iter().map(|(_, r)| r).collect()
}

/// Two digits; what is below a millionth of the uncertainty is rounding, not a contribution.
fn contribution(value: f64, share: f64) -> String {
    if share < 1e-12 {
        "0".to_owned()
    } else {
        two_digits(value)
    }
}

/// A percentage without trailing zeros.
fn significant(percent: f64) -> String {
    let text = format!("{percent:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// As many decimals as six digits of the reference leave.
fn six_digits(value: f64, reference: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let places = (5 - reference.abs().max(1e-12).log10().floor() as i32).clamp(0, 12) as usize;
    format!("{value:.places$}")
}

fn concise(value: f64, u: f64) -> String {
    let quantity = Quantity {
        name: String::new(),
        unit: String::new(),
        value,
        standard_uncertainty: u,
        dof: proofmass_uncertainty::DegreesOfFreedom::INFINITE,
    };
    quantity
        .display(&Format::concise())
        .to_string()
        .trim()
        .to_owned()
}
