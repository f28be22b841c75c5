//! The page of a validation.

use crate::page::columns::number;
use proofmass_report::number::{minus, two_digits};
use proofmass_report::{
    Axis, Field, KeyFigure, Report, Rounding, Section, Series, SpherePlot, Table, XyPlot,
};
use proofmass_static::{AttitudeCheck, Validation};

pub(super) fn add(page: Report, validation: &Validation, before: &str) -> Report {
    let attitudes = &validation.attitudes;
    let one_axis = is_of_one_axis(attitudes);
    let number: Vec<f64> = (1..=attitudes.len()).map(|i| i as f64).collect();
    let part = |k: f64| -> Vec<f64> {
        let values = attitudes.iter();
        values
            .map(|a| 1e3 * (a.residual + k * a.standard_uncertainty))
            .collect()
    };
    let plot = XyPlot::new(
        Axis::linear("standstill", "").range(0.0, attitudes.len() as f64 + 1.0),
        Axis::linear("‖a‖ − g", "mm/s²"),
    )
    .horizontal(0.0, "")
    .series(Series::markers("", &number, &part(0.0)).bars(&part(-2.0), &part(2.0)));
    let mut sphere = SpherePlot::new("‖a‖ − g", "mm/s²");
    for (i, a) in attitudes.iter().enumerate() {
        sphere = sphere.point(a.acceleration, 1e3 * a.residual, format!("{}", i + 1));
    }
    let result = Section::new("Result")
        .key_figures(figures(validation, before))
        .table(table(attitudes));
    let outside = attitudes.iter().filter(|a| !a.within_rule).count();
    let rule = match outside {
        0 => format!(
            "Kept: all {} standstills lie within 0.1 % of g",
            attitudes.len()
        ),
        n => format!(
            "Missed: {n} of {} standstills lie further than 0.1 % from g",
            attitudes.len()
        ),
    };
    let covariance = match validation.p_value < 0.05 {
        false => "what is left agrees with the stated uncertainties",
        true => "what is left is more than the stated uncertainties allow",
    };
    let residuals = Section::new("Residuals")
        .figure("Residual of each standstill; bars are two standard uncertainties (calibration, noise, gravity)", plot);
    page.verdict(format!(
        "{rule}; {covariance} (p = {}).",
        two_digits(validation.p_value)
    ))
    .section(result.summarised())
    .section(match one_axis {
        true => residuals,
        false => residuals.figure(
            "Directions of the specific force, coloured by the residual",
            sphere,
        ),
    })
}

/// Whether the standstills are those of a single axis, which sees no other.
fn is_of_one_axis(attitudes: &[AttitudeCheck]) -> bool {
    attitudes.iter().all(|a| a.acceleration[1..] == [0.0, 0.0])
}

fn figures(validation: &Validation, word: &str) -> Vec<KeyFigure> {
    let attitudes = &validation.attitudes;
    let within = attitudes.iter().filter(|a| a.within_rule).count();
    let within = format!("{within} of {}", attitudes.len());
    let mut figures = vec![
        KeyFigure::new("within 0.1 % of g", within, ""),
        KeyFigure::new("RMS after", format!("{:.3}", validation.rms_after_mg), "mg")
            .note("compensated"),
        KeyFigure::new("χ²", format!("{:.1}", validation.chi_square), "").note(format!(
            "{} degrees of freedom, p = {:.2}",
            validation.degrees_of_freedom, validation.p_value
        )),
    ];
    if let Some(before) = validation.rms_before_mg {
        let before = KeyFigure::new("RMS before", format!("{before:.3}"), "mg");
        figures.insert(1, before.note(word.to_owned()));
    }
    if let Some(reduction) = validation.reduction_percent() {
        let figure = KeyFigure::new("reduction", minus(&format!("{reduction:.1}")), "%");
        figures.insert(3, figure.note("of the RMS"));
    }
    figures
}

fn table(attitudes: &[AttitudeCheck]) -> Table {
    type Row = AttitudeCheck;
    let value = |heading, unit, decimals, of: fn(&Row) -> f64| {
        number("", (heading, unit), Rounding::Decimals(decimals), of)
    };
    let rule = |a: &Row| if a.within_rule { "met" } else { "missed" };
    let mut fields = vec![Field::shown("standstill", "", |a: &Row| {
        a.name.as_str().into()
    })];
    match is_of_one_axis(attitudes) {
        true => fields.push(value("a", "m/s²", 4, |a| a.acceleration[0])),
        false => fields.extend([
            value("a_x", "m/s²", 4, |a| a.acceleration[0]),
            value("a_y", "m/s²", 4, |a| a.acceleration[1]),
            value("a_z", "m/s²", 4, |a| a.acceleration[2]),
        ]),
    }
    fields.extend([
        value("‖a‖ − g", "mm/s²", 2, |a| 1e3 * a.residual),
        value("u", "mm/s²", 2, |a| 1e3 * a.standard_uncertainty),
        value("size of (‖a‖ − g)/g", "%", 4, |a| 1e2 * a.relative),
        Field::shown("0.1 % rule", "", |a: &Row| rule(a).into()),
    ]);
    Table::of("Standstills", fields, attitudes)
}
