//! The page of a multi-position calibration.

mod models;
mod practice;

use super::outcome::MultiPositionOutcome;
use crate::campaign::MethodModel;
use crate::page::measures::lines;
use crate::page::parameters::stated_parameters;
use crate::page::{AXES, MG};
use proofmass_documents::StatedQuantity;
use proofmass_report::number::{concise, freedom, rounded, two_digits};
use proofmass_report::plot::Style;
use proofmass_report::{
    Axis, BarPlot, Block, Cell, Field, KeyFigure, MatrixPlot, Report, Rounding, Section, Series,
    SpherePlot, Table, XyPlot,
};
use proofmass_static::{MultiPositionFit, PoseResidual, ThresholdSweep};
use proofmass_uncertainty::Quantity;

pub(super) fn add(page: Report, outcome: &MultiPositionOutcome) -> Report {
    let fit = &outcome.calibration.fit;
    let gravity = fit.gravity();
    let mut page = page
        .subtitle(format!(
            "Multi-position calibration of a triaxial accelerometer: method {}, {}, g = {} m/s²",
            outcome.method.name(),
            counted(fit),
            concise(gravity.value(), gravity.standard_uncertainty()),
        ))
        .verdict(match outcome.planned {
            true => practice::planned(&outcome.next_attitudes).unwrap_or_else(|| verdict(fit)),
            false => verdict(fit),
        });
    let mut next = practice::next(fit, &outcome.next_attitudes);
    if let (Some(section), Some([hold, rate])) = (next.as_mut(), outcome.shortest_hold) {
        *section = std::mem::take(section).paragraph(practice::hold(hold, rate));
    }
    if let Some(section) = next.take_if(|_| outcome.planned) {
        page = page.answers(practice::tiles(outcome)).section(
            section
                .figure(
                    "Directions that were measured, and those to add, numbered",
                    practice::directions(fit, &outcome.next_attitudes),
                )
                .summarised(),
        );
    }
    let mut page = page
        .section(
            Section::new("Result")
                .key_figures(key_figures(fit))
                .table(parameters(outcome))
                .summarised(),
        )
        .section(model(fit, outcome.method == MethodModel::Ferraris))
        .section(practice::section(fit, &outcome.reading));
    if let Some(section) = next {
        page = page.section(section.summarised());
    }
    page = page.section(agreement(outcome)).section(budget(fit));
    if let Some(section) = models::section(fit, outcome.models()) {
        page = page.section(match fit.beyond() {
            Some(_) => section.summarised(),
            None => section,
        });
    }
    if let Some(typed) = typed(fit) {
        page = page.copied(Block::Code(typed));
    }
    page.section(standstills(outcome))
        .section(method(fit))
        .section(Section::filed(files(outcome)))
}

/// What is left of ‖a‖ − g, and whether noise explains it.
fn verdict(fit: &MultiPositionFit) -> String {
    let left = fit.residual_rms();
    let left = format!("{} mg RMS", two_digits(left * MG));
    let (noun, birge) = (noun(fit), fit.birge_ratio().zip(fit.scatter()));
    let at = at_reference(fit).map_or_else(String::new, |at| {
        format!(" Bias and scale are those {at}; they follow the temperature.")
    });
    let agreement = match birge {
        Some((birge, scatter)) if birge <= scatter.birge_range[1] => {
            format!(
                "The model fits the {noun}s within their noise: ‖a‖ is {} within {left}.",
                length(fit)
            )
        }
        Some((birge, _)) => format!(
            "The model fits the {noun}s within {left} of {}. That is {} times what their noise explains, and the intervals allow for it.",
            length(fit),
            two_digits(birge)
        ),
        None => format!(
            "The model fits the {noun}s within {left} of {}.",
            length(fit)
        ),
    };
    agreement + &at
}

/// The temperature at which K and b hold, where they follow it.
fn at_reference(fit: &MultiPositionFit) -> Option<String> {
    let thermal = fit.beyond()?.thermal?;
    let at = format!("at T₀ = {:.2} °C", thermal.reference);
    Some(proofmass_report::number::minus_signs(at))
}

/// What ‖a‖ is held against.
fn length(fit: &MultiPositionFit) -> &'static str {
    match fit.lengths_given() {
        true => "‖a_true‖",
        false => "g",
    }
}

/// K⁻¹ and b as they are typed into firmware; the bias to a hundredth of its U.
fn typed(fit: &MultiPositionFit) -> Option<String> {
    let inverse = fit.model().k().inverse().ok()?.0;
    let bias = fit.model().bias();
    let smallest = inverse.iter().flatten().fold(0.0f64, |m, v| m.max(v.abs()));
    let places = (6.0 - smallest.log10().floor()).clamp(0.0, 15.0) as usize;
    let of_bias = |i: usize| {
        let u = fit
            .quantities()
            .get(i)
            .map_or(0.0, |q| q.expanded(fit.probability()));
        let places = if u > 0.0 {
            (2.0 - u.log10().floor()).clamp(0.0, 12.0) as usize
        } else {
            6
        };
        format!("{:.places$}", bias[i])
    };
    let row = |r: &[f64; 3]| {
        let numbers: Vec<String> = r.iter().map(|v| format!("{v:.places$}")).collect();
        format!("{{{}}}", numbers.join(", "))
    };
    let rows: Vec<String> = inverse.iter().map(row).collect();
    let at = at_reference(fit).map_or_else(String::new, |at| format!(" {at}"));
    let followed = fit.beyond().and_then(|b| b.thermal).map_or("", |_| {
        "\nb and K follow the temperature: their terms stand in the table of parameters and in calibration.json"
    });
    Some(format!(
        "a = K⁻¹ (ã − b){at}, ã in {}, a in m/s²\nK⁻¹ = {{{}}}\nb   = {{{}}}{followed}",
        fit.output_unit(),
        rows.join(",\n       "),
        [0, 1, 2].map(of_bias).join(", ")
    ))
}

fn parameters(outcome: &MultiPositionOutcome) -> Table {
    let percent = (1e6 * outcome.probability).round() / 1e4;
    let caption = format!("Parameters with their {percent} % intervals, value ± U");
    let printed = |q: &StatedQuantity| <[String; 2]>::from(rounded(q.value, q.expanded));
    let fitted = outcome.calibration.fit.estimate().components().len();
    stated_parameters(caption, &outcome.quantities[..fitted], printed)
}

fn model(fit: &MultiPositionFit, ferraris: bool) -> Section {
    let mut section = Section::new("Model")
        .paragraph(
            "Model ã = K a + b: output ã under the specific force a. Scale factors are the diagonal of K, \
             misalignments its other elements divided by the diagonal element of their row. Compensation is \
             a = K⁻¹ (ã − b).",
        )
        .table(matrix(fit));
    if let Some(text) = models::beyond(fit) {
        section = section.paragraph(text);
    }
    match ferraris {
        true => section.table(practice::ferraris(fit)),
        false => section,
    }
}

fn agreement(outcome: &MultiPositionOutcome) -> Section {
    let fit = &outcome.calibration.fit;
    let residuals = fit.residuals();
    let number: Vec<f64> = (1..=residuals.len()).map(|i| i as f64).collect();
    // Two standard uncertainties of the noise and any excess to either side.
    let part = |k: f64| -> Vec<f64> {
        let spread = |r: &PoseResidual| r.noise.hypot(fit.excess());
        let values = residuals.iter();
        values
            .map(|r| 1e3 * r.magnitude_residual + k * (2e3 * spread(r)))
            .collect()
    };
    let plot = XyPlot::new(
        Axis::linear(noun(fit), "").range(0.0, residuals.len() as f64 + 1.0),
        Axis::linear(format!("‖a‖ − {}", length(fit)), "mm/s²"),
    )
    .height(240.0)
    .horizontal(0.0, "")
    .series(Series::markers("", &number, &part(0.0)).bars(&part(-1.0), &part(1.0)));
    let mut sphere = SpherePlot::new(format!("‖a‖ − {}", length(fit)), "mm/s²");
    for (i, r) in residuals.iter().enumerate() {
        // Numbers that nobody could read are left away.
        let name = match residuals.len() > LEGIBLE {
            true => String::new(),
            false => (i + 1).to_string(),
        };
        sphere = sphere.point(r.acceleration, 1e3 * r.magnitude_residual, name);
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
        .table(standstill_table(outcome))
}

/// Contributions of each cause, row by row.
fn budget(fit: &MultiPositionFit) -> Section {
    type Row<'a> = (&'a Quantity, Vec<f64>);
    let estimate = fit.estimate();
    let components = estimate.components().iter();
    let names: Vec<&str> = components.map(|c| c.name.as_str()).collect();
    // One row per quantity: the standstills, taken apart, then every cause that no residual shows.
    let others = estimate.influences().iter();
    let others: Vec<_> = others.filter(|i| i.key != "standstills").collect();
    let attitudes = fit.scatter_parts().iter().any(|p| p.attitude > 0.0);
    let mut causes = vec![
        ("noise", "noise of the means"),
        ("between standstills", "between standstills"),
    ];
    causes.extend(attitudes.then_some(("each attitude", "each attitude")));
    let described = others.iter().map(|i| i.description.as_str());
    causes.extend(described.map(|what| (what, what)));
    let mut rows: Vec<Row<'_>> = Vec::new();
    let mut mean_share: Vec<(&str, f64)> = Vec::new();
    for (quantity, parts) in fit.quantities().iter().zip(fit.scatter_parts()) {
        let mut contributions = vec![parts.noise, parts.between];
        contributions.extend(attitudes.then_some(parts.attitude));
        let lines = estimate.budget(&quantity.name).unwrap_or_default();
        contributions.extend(others.iter().map(|other| {
            let line = lines.iter().find(|l| l.key == other.key);
            line.map_or(0.0, |l| l.contribution)
        }));
        for ((_, what), value) in causes.iter().zip(&contributions) {
            let share = (value / quantity.standard_uncertainty).powi(2) / names.len() as f64;
            match mean_share.iter_mut().find(|(name, _)| name == what) {
                Some((_, sum)) => *sum += share,
                None => mean_share.push((what, share)),
            }
        }
        rows.push((quantity, contributions));
    }
    mean_share.sort_by(|a, b| b.1.total_cmp(&a.1));
    let bars = BarPlot::shares("share of the variance, mean over all quantities");
    let bars = mean_share
        .into_iter()
        .fold(bars, |bars, (name, share)| bars.bar(name, share, ""));
    let mut fields = vec![Field::shown("quantity", "", |r: &Row<'_>| {
        r.0.name.as_str().into()
    })];
    fields.extend(causes.iter().enumerate().map(|(k, (heading, _))| {
        Field::shown(*heading, "", move |(q, values): &Row<'_>| {
            contribution(values[k], q.standard_uncertainty)
        })
    }));
    fields.extend([
        Field::shown("u", "", |r: &Row<'_>| r.0.standard_uncertainty.into())
            .rounded(Rounding::TwoDigits),
        Field::shown("unit", "", |r: &Row<'_>| r.0.unit.as_str().into()),
        Field::shown("ν_eff", "", |r: &Row<'_>| {
            Cell::number(freedom(r.0.dof.get()))
        }),
    ]);
    let caption = "Budget: contribution of each cause to the standard uncertainty";
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
        .table(Table::of(caption, fields, rows))
}

fn standstills(outcome: &MultiPositionOutcome) -> Section {
    let (calibration, figures) = (&outcome.calibration, &outcome.figures);
    let (fit, sweep) = (&calibration.fit, &calibration.sweep);
    let mut section = Section::new("The recording and its standstills");
    section = section.paragraph(match sweep.threshold {
        Some(threshold) if sweep.candidates.is_empty() => {
            format!("Standstills were found with the given threshold of {threshold:.1} times the noise floor.")
        }
        Some(threshold) => format!(
            "Standstills were found by the variance in a sliding window of {} s. Of {} thresholds the fit was as good as \
             the best at {threshold:.1} times the noise floor, the strictest that cuts fewest standstills.",
            sweep.window.unwrap_or_default(),
            sweep.candidates.len()
        ),
        None if fit.effective_readings().is_some() => TUMBLE.to_owned(),
        None if noun(fit) == "reading" => {
            "Every row is a reading in an attitude of its own.".to_owned()
        }
        None => "The standstills were given.".to_owned(),
    });
    if let Some(text) = attitudes(fit) {
        section = section.paragraph(text);
    }
    let shades = &figures.standstills;
    let mut plot = XyPlot::new(
        Axis::linear("time", "s"),
        Axis::linear("output", fit.output_unit()),
    );
    for (name, output) in AXES.iter().zip(&figures.outputs) {
        plot = plot.series(Series::line(*name, &output.x, &output.y));
    }
    plot = plot.shade("standstill", shades);
    if let Some(windowed) = &figures.windowed {
        plot = plot
            .below(Axis::log("variance / floor", ""))
            .series(Series::line("windowed variance", &windowed.x, &windowed.y).look(3))
            .shade("", shades);
        if let Some(threshold) = sweep.threshold {
            plot = plot.horizontal(threshold, "threshold");
        }
    }
    let caption = match shades.is_empty() {
        true => "The recording",
        false => "The recording; shaded: the standstills that were used",
    };
    section = section.figure(caption, plot);
    if let Some(plot) = tried(sweep) {
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
    let unit = fit.output_unit();
    let [x, y, z] = noise.deviation().map(two_digits);
    let [a, b, c] = noise.variance_inflation();
    section.paragraph(format!(
        "Noise of single samples: {x} {unit} (x), {y} {unit} (y), {z} {unit} (z); correlation of neighbouring samples \
         makes the variance of long means {a:.2}, {b:.2} and {c:.2} times that of uncorrelated ones.",
    ))
}

/// How the attitudes were given, and how well they are known.
fn attitudes(fit: &MultiPositionFit) -> Option<String> {
    let known = fit.poses().iter();
    let known: Vec<f64> = known
        .filter_map(|p| Some(p.segment.force_uncertainty?.across))
        .collect();
    if !fit.attitudes_given() {
        return None;
    }
    if known.is_empty() {
        return Some("The attitudes were given.".to_owned());
    }
    let in_si = |u: f64| two_digits(1e3 * u * fit.gravity().value());
    let low = known.iter().copied().fold(f64::INFINITY, f64::min);
    let high = known.iter().copied().fold(0.0, f64::max);
    let range = match low == high {
        true => in_si(low),
        false => format!("{} to {}", in_si(low), in_si(high)),
    };
    let lengths = match fit.lengths_given() {
        true => "Their lengths count as they are stated.",
        false => "Their lengths are that of gravity; what they say is the direction.",
    };
    Some(format!(
        "True accelerations were given for {} {}s, each component with a standard uncertainty of {range} mm/s². {lengths}",
        known.len(),
        noun(fit)
    ))
}

fn tried(sweep: &ThresholdSweep) -> Option<XyPlot> {
    let tried = sweep.candidates.iter();
    let tried = tried.filter_map(|c| Some((c.threshold, c.figure?)));
    let (x, y): (Vec<f64>, Vec<f64>) = tried.unzip();
    (x.len() > 1).then(|| {
        XyPlot::new(
            Axis::log("threshold / noise floor", ""),
            Axis::log("relative width of the intervals", ""),
        )
        .series(Series::line("", &x, &y).style(Style::LineAndMarkers))
        .vertical(sweep.threshold.unwrap_or(x[0]), "chosen")
    })
}

fn method(fit: &MultiPositionFit) -> Section {
    Section::new("Method").paragraph(format!(
        "Model {}: {} parameters, {} iterations of weighted least squares. Uncertainty: law of propagation, \
         coverage factors from Student's t at the effective degrees of freedom (JCGM 100:2008). Standstill \
         search and ‖a‖ = g fit after Tedaldi, Pretto and Menegatti (ICRA 2014).",
        fit.form(),
        fit.parameters(),
        fit.iterations(),
    ))
}

const TUMBLE: &str = "The sensor was turned all the time. Every sample counts: the magnitudes of a part are averaged in its \
                      mean direction. Neighbouring parts share errors, so that fewer count as independent: their number divided \
                      by the sum of the correlations of the residuals.";

/// Points that can be told apart by their numbers.
const LEGIBLE: usize = 80;
/// From more of them on the page has only the largest.
const MANY: usize = 2 * LEGIBLE;
const STANDSTILLS: &str = "standstills.csv";

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
         it, and how well the residuals fix it, without a test in between.{}",
        forms(fit)
    )
}

/// Which forms the scatter may have.
fn forms(fit: &MultiPositionFit) -> String {
    let [first, ..] = fit.scatter_forms() else {
        return String::new();
    };
    let parts: Vec<String> = fit
        .scatter_forms()
        .iter()
        .map(|w| match w.walk {
            Some(walk) => format!(
                "{} {:.1} % ({:.1} µg/√s)",
                w.form,
                1e2 * w.weight,
                1e6 * walk / proofmass_core::STANDARD_GRAVITY
            ),
            None => format!("{} {:.1} %", w.form, 1e2 * w.weight),
        })
        .collect();
    let most = match first.weight > 0.5 {
        true => format!(", most likely {}", first.form),
        false => String::new(),
    };
    format!(
        " Values and intervals are averaged over the forms that this scatter may have{most}. Weights by the residuals: {}.",
        parts.join("; ")
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
        .note(format!("‖a‖ − {}", length(fit))),
        KeyFigure::new("Birge ratio", birge, "").note("residual / noise of the means"),
        KeyFigure::new("condition number", format!("{:.1}", fit.condition()), ""),
    ]
}

/// K and b as they stand in calibration.json.
fn matrix(fit: &MultiPositionFit) -> Table {
    let (k, bias) = (fit.model().k().0, fit.model().bias());
    let unit = fit.output_unit();
    let k_unit = match unit {
        "m/s²" => String::new(),
        unit => format!("{unit}/(m/s²)"),
    };
    let quantities = fit.quantities();
    let expanded = |i: usize| {
        let q = quantities.get(i);
        q.map_or(0.0, |q| q.expanded(fit.probability()))
    };
    let rows = AXES.iter().enumerate().map(|(i, axis)| {
        let [x, y, z] = k[i].map(|v| Cell::number(six_digits(v, k[i][i])));
        let b = Cell::number(rounded(bias[i], expanded(i)).0);
        [(*axis).into(), x, y, z, b]
    });
    let of_k = |heading| (heading, k_unit.as_str());
    let headings = [
        ("output", ""),
        of_k("K x"),
        of_k("K y"),
        of_k("K z"),
        ("b", unit),
    ];
    lines("Sensitivity matrix K and bias b", headings, rows)
}

fn standstill_fields(outcome: &MultiPositionOutcome) -> Vec<Field<'_, PoseResidual>> {
    type Row = PoseResidual;
    let unit = outcome.unit.ascii();
    let residual = format!("‖a‖ − {}", length(&outcome.calibration.fit));
    let number = |name: &str, heading: &str, unit: &str, of: fn(&Row) -> f64| {
        Field::new(name, move |r: &Row| of(r).into()).page(heading, unit)
    };
    let mut fields = vec![
        Field::new("standstill", |r: &Row| r.name.as_str().into())
            .page(noun(&outcome.calibration.fit), ""),
        number("first_sample", "first sample", "", |r| r.samples.0 as f64).decimals(0),
        number("end_sample", "", "", |r| r.samples.1 as f64),
        Field::shown("samples", "", |r: &Row| (r.samples.1 - r.samples.0).into()),
    ];
    let axes = || AXES.iter().enumerate();
    fields.extend(axes().map(|(k, axis)| {
        Field::new(format!("output_{axis}_{unit}"), move |r: &Row| {
            r.output[k].into()
        })
    }));
    fields.extend(axes().map(|(k, axis)| {
        let name = format!("acceleration_{axis}_m/s2");
        Field::new(name, move |r: &Row| r.acceleration[k].into())
            .page(format!("a_{axis}"), "m/s²")
            .decimals(4)
    }));
    // Single readings whose uncertainty nobody stated have none.
    let noise = |r: &Row| match r.noise > 0.0 {
        true => r.noise.into(),
        false => Cell::printed(r.noise, ""),
    };
    fields.extend([
        number("residual_m/s2", &residual, "mm/s²", |r| {
            r.magnitude_residual
        })
        .scaled(1e3)
        .decimals(2),
        Field::new("residual_noise_m/s2", noise)
            .page("u (noise)", "mm/s²")
            .scaled(1e3)
            .decimals(2),
        Field::new("studentised_residual", |r: &Row| r.studentised.into())
            .page("studentised", "")
            .decimals(1),
    ]);
    fields
}

/// All of them, or those with the largest residuals where they are many.
fn standstill_table(outcome: &MultiPositionOutcome) -> Table {
    let fit = &outcome.calibration.fit;
    let name = noun(fit);
    let title = format!("{}{}s", name[..1].to_uppercase(), &name[1..]);
    let fields = standstill_fields(outcome);
    match fit.residuals().len() {
        n if n > MANY => Table::of(
            format!(
                "{title}: the {LEGIBLE} with the largest residuals of {n}; all are in standstills.csv"
            ),
            fields,
            largest(fit),
        ),
        _ => Table::of(title, fields, fit.residuals()).file(STANDSTILLS),
    }
}

/// What the page does not show.
fn files(outcome: &MultiPositionOutcome) -> Vec<Table> {
    let fit = &outcome.calibration.fit;
    let mut files = Vec::new();
    if fit.residuals().len() > MANY {
        let table = Table::of("", standstill_fields(outcome), fit.residuals());
        files.push(table.file(STANDSTILLS));
    }
    let components = fit.estimate().components();
    let mut fields = vec![Field::new("quantity", |i: &usize| {
        components[*i].name.as_str().into()
    })];
    fields.extend(components.iter().enumerate().map(|(j, c)| {
        Field::new(c.name.as_str(), move |i: &usize| {
            fit.estimate().covariance()[(*i, j)].into()
        })
    }));
    files.push(Table::of("", fields, 0..components.len()).file("covariance.csv"));
    files
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
fn contribution(value: f64, u: f64) -> Cell {
    Cell::number(match (value / u).powi(2) < 1e-12 {
        true => "0".to_owned(),
        false => two_digits(value),
    })
}

/// As many decimals as six digits of the reference leave.
fn six_digits(value: f64, reference: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let places = (5 - reference.abs().max(1e-12).log10().floor() as i32).clamp(0, 12) as usize;
    format!("{value:.places$}")
}
