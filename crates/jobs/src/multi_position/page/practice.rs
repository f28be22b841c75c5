//! The result in the units of practice: mg, percent, degrees, K⁻¹, and what a compensated reading is worth.

use proofmass_core::STANDARD_GRAVITY;
use proofmass_report::number::{rounded, two_digits};
use proofmass_report::{Cell, Column, Section, Table};
use proofmass_static::{
    CompensatedReading, Ferraris, Limiting, Misfit, MultiPositionFit, NextAttitude, WithoutSuspects,
};

const AXES: [&str; 3] = ["x", "y", "z"];

pub(super) fn section(
    fit: &MultiPositionFit,
    reading: Option<&CompensatedReading>,
    next: &[NextAttitude],
) -> Section {
    let mut section = Section::new("For practice").paragraph(format!(
        "{} Intervals hold the true value with a probability of approximately {:.0} %, the effects of gravity and of what \
         varies between the standstills included.",
        frame(fit),
        100.0 * fit.probability()
    ));
    if let Some(reading) = reading {
        let mg = |a: f64| two_digits(1e3 * a / STANDARD_GRAVITY);
        let direction = signed(reading.worst_direction);
        section = section.paragraph(format!(
            "A compensated reading under 1 g has along its worst axis an expanded uncertainty between {} and {} mg over the \
             sphere, half of all directions below {} mg; the worst direction is {direction}. The noise of the \
             reading itself is not in it.",
            mg(reading.smallest),
            mg(reading.largest),
            mg(reading.median),
        ));
    }
    section = section.table(values(fit)).table(inverse(fit));
    section = match fit.without_suspects() {
        Some(without) if without.quantities.is_some() => section.table(beside(fit, without)),
        Some(_) => section.paragraph(
            "Without the standstills that are out of line the others do not determine every quantity.",
        ),
        None => section,
    };
    section = self::next(section, fit, next);
    if !fit.misfits().is_empty() {
        section = section.table(checked(fit.misfits()));
    }
    section
}

/// Further standstills are worth a table where four of them narrow the intervals by more than this.
const WORTH: f64 = 0.97;

/// Where to hold the sensor next, and what it does; or that it does little, and what would do more.
pub(super) fn next(section: Section, fit: &MultiPositionFit, next: &[NextAttitude]) -> Section {
    match next.last() {
        None => section,
        Some(last) if last.expected > WORTH => section.paragraph(format!(
            "More attitudes hardly help: {} further ones, wherever the sensor points, would lower the expanded uncertainties \
             to {:.0} % in the mean square. {}",
            next.len(),
            1e2 * last.expected,
            match fit.limiting() {
                _ if fit.chi_square().is_none() =>
                    "Most of the uncertainty is the scatter of the readings: means of many samples in place of single \
                     readings average it down.",
                Limiting::Noise =>
                    "Most of the uncertainty is noise within the standstills: longer ones average it down.",
                Limiting::Between =>
                    "Most of the uncertainty is what varies from standstill to standstill: lay the sensor down firmly \
                     instead of holding it, and let its temperature settle; or record several times as many standstills.",
                Limiting::Attitudes =>
                    "Most of the uncertainty is that of the given attitudes: level the fixture better.",
                _ => "Most of the uncertainty is common to all standstills: it is that of gravity, which a better known place \
                      or a measured value lowers.",
            }
        )),
        Some(_) => section.table(attitudes(next)),
    }
}

fn attitudes(next: &[NextAttitude]) -> Table {
    let mut table = Table::new(
        "Further standstills that tell most: what should point up in the axes of the sensor, and U after it against now, in the mean square",
        [
            Column::number("standstill", ""),
            Column::number("x", ""),
            Column::number("y", ""),
            Column::number("z", ""),
            Column::number("U", "%"),
        ],
    );
    for (index, attitude) in next.iter().enumerate() {
        let [x, y, z] = attitude
            .direction
            .map(|v| Cell::number(format!("{v:+.2}").replace('-', "−")));
        let u = Cell::number(format!("{:.0}", 1e2 * attitude.expected));
        table = table.row([Cell::number(format!("+{}", index + 1)), x, y, z, u]);
    }
    table
}

/// A direction by its components, with true minus signs.
fn signed([x, y, z]: [f64; 3]) -> String {
    format!("({x:+.2}, {y:+.2}, {z:+.2})").replace('-', "−")
}

fn frame(fit: &MultiPositionFit) -> &'static str {
    if fit.attitudes_given() {
        "The frame is that in which the attitudes were given."
    } else {
        "Without given attitudes ‖a‖ = g shows neither a rotation of the sensor nor a mirror image of it (an axis wired \
         backwards); with an upper-triangular K the z axis is that of the z element and the y axis lies in the plane of the \
         y and z elements, with a symmetric K the frame lies evenly among the three."
    }
}

/// Bias in mg, scale errors in percent, misalignments in degrees.
fn values(fit: &MultiPositionFit) -> Table {
    let mut table = Table::new(
        "The quantities in other units",
        [
            Column::text("quantity"),
            Column::number("value", ""),
            Column::number("U", ""),
            Column::text("unit"),
        ],
    );
    for q in fit.quantities() {
        // Bias of an axis, scale of an axis; coefficients of the temperature and curvature have three parts to their name.
        let terms = q.name.matches('.').count() > 1;
        let (name, offset, factor, unit) = if q.unit == "rad" {
            (q.name.clone(), 0.0, 180.0 / std::f64::consts::PI, "°")
        } else if terms || !fit.are_accelerations() {
            continue;
        } else if q.name.starts_with("bias") {
            (q.name.clone(), 0.0, 1e3 / STANDARD_GRAVITY, "mg")
        } else {
            (format!("{} less 1", q.name), 1.0, 1e2, "%")
        };
        let (value, expanded) = rounded(
            factor * (q.value - offset),
            factor * q.expanded(fit.probability()),
        );
        table = table.row([
            Cell::text(name),
            Cell::number(value),
            Cell::number(expanded),
            Cell::text(unit),
        ]);
    }
    table
}

/// K⁻¹, which compensation multiplies with.
fn inverse(fit: &MultiPositionFit) -> Table {
    let unit = if fit.are_accelerations() {
        String::new()
    } else {
        format!("(m/s²)/{}", fit.output_unit())
    };
    let mut table = Table::new(
        "K⁻¹ of a = K⁻¹ (ã − b)",
        std::iter::once(Column::text("acceleration"))
            .chain(AXES.map(|axis| Column::number(format!("output {axis}"), unit.clone()))),
    );
    let inverse = fit.model().k_inverse().0;
    for (axis, row) in AXES.iter().zip(inverse) {
        let largest = row.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let places = (7 - largest.max(1e-12).log10().ceil() as i32).clamp(0, 12) as usize;
        let cells = row.map(|v| match v == 0.0 {
            true => Cell::number("0"),
            false => Cell::number(format!("{v:.places$}")),
        });
        table = table.row(std::iter::once(Cell::text(*axis)).chain(cells));
    }
    table
}

/// With and without the standstills that are suspected.
fn beside(fit: &MultiPositionFit, without: &WithoutSuspects) -> Table {
    let names: Vec<&str> = without.suspects.iter().map(|s| s.name.as_str()).collect();
    let mut table = Table::new(
        format!(
            "The result without {}{} {}, beside that with all",
            super::noun(fit),
            if names.len() == 1 { "" } else { "s" },
            names.join(", ")
        ),
        [
            Column::text("quantity"),
            Column::number("with all", ""),
            Column::number("U", ""),
            Column::number("without", ""),
            Column::number("U", ""),
            Column::text("unit"),
        ],
    );
    let p = fit.probability();
    for (all, other) in fit
        .quantities()
        .iter()
        .zip(without.quantities.iter().flatten())
    {
        let (a, u) = rounded(all.value, all.expanded(p));
        let (b, v) = rounded(other.value, other.expanded(p));
        table = table.row([
            Cell::text(all.name.clone()),
            Cell::number(a),
            Cell::number(u),
            Cell::number(b),
            Cell::number(v),
            Cell::text(all.unit.clone()),
        ]);
    }
    table
}

/// What was looked for in the residuals, found or not.
fn checked(misfits: &[Misfit]) -> Table {
    let mut table = Table::new(
        "Looked for in the residuals",
        [
            Column::text("what"),
            Column::number("x", "mg"),
            Column::number("y", "mg"),
            Column::number("z", "mg"),
            Column::number("probability by chance", ""),
            Column::text("found"),
        ],
    );
    for misfit in misfits {
        let [x, y, z] = misfit
            .amplitudes_mg
            .map(|a| Cell::number(format!("{a:.2}")));
        let p = if misfit.p_value < 1e-4 {
            "< 0.0001".to_owned()
        } else {
            format!("{:.4}", misfit.p_value)
        };
        table = table.row([
            Cell::text(misfit.cause.to_string()),
            x,
            y,
            z,
            Cell::text(p),
            Cell::text(if misfit.found { "yes" } else { "no" }),
        ]);
    }
    table
}

/// K as a scale factor and a direction of each sensitive axis.
pub(super) fn ferraris(fit: &MultiPositionFit) -> Table {
    let ferraris = Ferraris::of(&fit.model().k().0);
    let unit = format!("{}/(m/s²)", fit.output_unit());
    let mut table = Table::new(
        "Ferraris' form K = diag(K_a) R_a",
        [
            Column::text("output"),
            Column::number("K_a", unit),
            Column::number("R_a x", ""),
            Column::number("R_a y", ""),
            Column::number("R_a z", ""),
        ],
    );
    for (i, axis) in ["x", "y", "z"].iter().enumerate() {
        let mut cells = vec![
            Cell::text(*axis),
            Cell::number(format!("{:.5}", ferraris.scale[i])),
        ];
        cells.extend(
            ferraris.directions[i]
                .iter()
                .map(|v| Cell::number(format!("{v:.7}"))),
        );
        table = table.row(cells);
    }
    table
}
