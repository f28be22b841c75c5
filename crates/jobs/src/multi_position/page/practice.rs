//! The result in the units of practice: mg, percent, degrees, K⁻¹, and what a compensated reading is worth.

use crate::multi_position::MultiPositionOutcome;
use crate::page::measures::lines;
use crate::page::{AXES, MG};
use proofmass_report::number::{rounded, two_digits};
use proofmass_report::{Cell, Field, KeyFigure, Section, SpherePlot, Table};
use proofmass_static::{
    CompensatedReading, Ferraris, Limiting, Misfit, MultiPositionFit, NextAttitude, WithoutSuspects,
};

pub(super) fn section(fit: &MultiPositionFit, reading: &CompensatedReading) -> Section {
    let mg = |a: f64| two_digits(MG * a);
    let [x, y, z] = reading.worst_direction;
    let mut section = Section::new("For practice")
        .paragraph(format!(
            "{} Intervals hold the true value with a probability of approximately {:.0} %, the effects of gravity and of what \
             varies between the standstills included.",
            frame(fit),
            100.0 * fit.probability()
        ))
        .paragraph(format!(
            "A compensated reading under 1 g has along its worst axis an expanded uncertainty between {} and {} mg over the \
             sphere, half of all directions below {} mg; the worst direction is {}. The noise of the \
             reading itself is not in it.",
            mg(reading.smallest),
            mg(reading.largest),
            mg(reading.median),
            format!("({x:+.2}, {y:+.2}, {z:+.2})").replace('-', "−"),
        ))
        .table(values(fit))
        .table(inverse(fit));
    section = match fit.without_suspects() {
        Some(without) if without.quantities.is_some() => section.table(beside(fit, without)),
        Some(_) => section.paragraph(
            "Without the standstills that are out of line the others do not determine every quantity.",
        ),
        None => section,
    };
    match fit.misfits() {
        [] => section,
        misfits => section.table(checked(misfits)),
    }
}

/// Further standstills are worth a table where four of them narrow the intervals by more than this.
const WORTH: f64 = 0.97;

/// Where to hold the sensor next, and what it does; or that it does little, and what would do more.
pub(super) fn next(fit: &MultiPositionFit, next: &[NextAttitude]) -> Option<Section> {
    let expected = next.last()?.expected;
    let section = Section::new("Further standstills");
    if expected <= WORTH {
        return Some(section.table(attitudes(next)));
    }
    let remedy = match fit.limiting() {
        _ if fit.chi_square().is_none() => {
            "Most of the uncertainty is the scatter of the readings: means of many samples in place of single \
             readings average it down."
        }
        Limiting::Noise => {
            "Most of the uncertainty is noise within the standstills: longer ones average it down."
        }
        Limiting::Between => {
            "Most of the uncertainty is what varies from standstill to standstill: lay the sensor down firmly \
             instead of holding it, and let its temperature settle; or record several times as many standstills."
        }
        Limiting::Attitudes => {
            "Most of the uncertainty is that of the given attitudes: level the fixture better."
        }
        _ => {
            "Most of the uncertainty is common to all standstills: it is that of gravity, which a better known place \
             or a measured value lowers."
        }
    };
    Some(section.paragraph(format!(
        "More attitudes hardly help: {} further ones, wherever the sensor points, would lower the expanded uncertainties \
         to {:.0} % in the mean square. {remedy}",
        next.len(),
        1e2 * expected,
    )))
}

/// The next direction, as it is held.
fn pointing(attitude: &NextAttitude) -> String {
    let [x, y, z] = attitude.direction;
    format!("x {x:+.2}, y {y:+.2}, z {z:+.2}").replace('-', "−")
}

/// What the further standstills are worth, and which is the next.
pub(super) fn planned(next: &[NextAttitude]) -> Option<String> {
    let (first, last) = (next.first()?, next.last()?);
    let to = 1e2 * last.expected;
    Some(match last.expected <= WORTH {
        true => format!(
            "{} further standstills lower the expanded uncertainties to {to:.0} % in the mean square. The next: what points up at {}.",
            next.len(),
            pointing(first)
        ),
        false => format!(
            "Further standstills hardly help: {} would lower the expanded uncertainties to {to:.0} % in the mean square.",
            next.len()
        ),
    })
}

/// What a plan opens with.
pub(super) fn tiles(outcome: &MultiPositionOutcome) -> Vec<KeyFigure> {
    let next = &outcome.next_attitudes;
    let measured = outcome.calibration.fit.poses().len();
    let mut tiles = vec![KeyFigure::new(
        "standstills so far",
        measured.to_string(),
        "",
    )];
    tiles.extend(next.last().map(|last| {
        let share = format!("{:.0}", 1e2 * last.expected);
        let name = format!("U after {} more, over now", next.len());
        KeyFigure::new(name, share, "%").note("mean square of all quantities")
    }));
    tiles.extend(next.first().map(|first| {
        KeyFigure::new("the next", pointing(first), "")
            .note("what points up, in the axes of the sensor")
    }));
    tiles.extend(outcome.shortest_hold.map(|[hold, _]| {
        KeyFigure::new("hold each for", format!("{hold:.1}"), "s").note("or longer")
    }));
    tiles
}

/// Where the sensor was held, and where it is to be held next.
pub(super) fn directions(fit: &MultiPositionFit, next: &[NextAttitude]) -> SpherePlot {
    let mut sphere = SpherePlot::new("U after over now", "%");
    for residual in fit.residuals() {
        sphere = sphere.point(residual.acceleration, 100.0, "");
    }
    for (k, attitude) in next.iter().enumerate() {
        sphere = sphere.point(
            attitude.direction,
            1e2 * attitude.expected,
            format!("+{}", k + 1),
        );
    }
    sphere
}

/// How long each attitude must be held.
pub(super) fn hold(shortest: f64, rate: f64) -> String {
    format!(
        "At {} samples per second hold each attitude for {shortest:.1} s or longer: shorter ones the search may not tell from motion.",
        two_digits(rate)
    )
}

fn attitudes(next: &[NextAttitude]) -> Table {
    let signed = |v: f64| Cell::number(format!("{v:+.2}").replace('-', "−"));
    let rows = next.iter().enumerate().map(|(index, attitude)| {
        let [x, y, z] = attitude.direction.map(signed);
        let u = Cell::number(format!("{:.0}", 1e2 * attitude.expected));
        [Cell::number(format!("+{}", index + 1)), x, y, z, u]
    });
    lines(
        "Further standstills that tell most: what should point up, and U in the mean square",
        [
            ("standstill", ""),
            ("x", ""),
            ("y", ""),
            ("z", ""),
            ("U after over now", "%"),
        ],
        rows,
    )
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
    let quantities = fit.quantities();
    let rows = quantities.iter().filter_map(|q| {
        // Bias of an axis, scale of an axis; coefficients of the temperature and curvature have three parts to their name.
        let terms = q.name.matches('.').count() > 1;
        let (name, offset, factor, unit) = if q.unit == "rad" {
            (q.name.clone(), 0.0, 180.0 / std::f64::consts::PI, "°")
        } else if terms || !fit.are_accelerations() {
            return None;
        } else if q.name.starts_with("bias") {
            (q.name.clone(), 0.0, MG, "mg")
        } else {
            (format!("{} less 1", q.name), 1.0, 1e2, "%")
        };
        let expanded = factor * q.expanded(fit.probability());
        let (value, expanded) = rounded(factor * (q.value - offset), expanded);
        Some([
            name.into(),
            Cell::number(value),
            Cell::number(expanded),
            unit.into(),
        ])
    });
    let expanded = format!("U ({:.0} %)", 100.0 * fit.probability());
    lines(
        "The quantities in other units",
        [
            ("quantity", ""),
            ("value", ""),
            (&expanded, ""),
            ("unit", ""),
        ],
        rows,
    )
}

/// K⁻¹, which compensation multiplies with.
fn inverse(fit: &MultiPositionFit) -> Table {
    let unit = match fit.are_accelerations() {
        true => String::new(),
        false => format!("(m/s²)/{}", fit.output_unit()),
    };
    let inverse = fit.model().k_inverse().0;
    let rows = AXES.iter().zip(inverse).map(|(axis, row)| {
        let largest = row.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let places = (7 - largest.max(1e-12).log10().ceil() as i32).clamp(0, 12) as usize;
        let [x, y, z] = row.map(|v| match v == 0.0 {
            true => Cell::number("0"),
            false => Cell::number(format!("{v:.places$}")),
        });
        [(*axis).into(), x, y, z]
    });
    let headings = [
        ("acceleration", ""),
        ("output x", unit.as_str()),
        ("output y", &unit),
        ("output z", &unit),
    ];
    lines("K⁻¹ of a = K⁻¹ (ã − b)", headings, rows)
}

/// With and without the standstills that are suspected.
fn beside(fit: &MultiPositionFit, without: &WithoutSuspects) -> Table {
    let names: Vec<&str> = without.suspects.iter().map(|s| s.name.as_str()).collect();
    let p = fit.probability();
    let quantities = fit.quantities();
    let pairs = quantities.iter().zip(without.quantities.iter().flatten());
    let rows = pairs.map(|(all, other)| {
        let (a, u) = rounded(all.value, all.expanded(p));
        let (b, v) = rounded(other.value, other.expanded(p));
        let [a, u, b, v] = [a, u, b, v].map(Cell::number);
        [
            all.name.as_str().into(),
            a,
            u,
            b,
            v,
            all.unit.as_str().into(),
        ]
    });
    lines(
        format!(
            "The result without {}{} {}, beside that with all",
            super::noun(fit),
            if names.len() == 1 { "" } else { "s" },
            names.join(", ")
        ),
        [
            ("quantity", ""),
            ("with all", ""),
            ("U", ""),
            ("without", ""),
            ("U", ""),
            ("unit", ""),
        ],
        rows,
    )
}

/// What was looked for in the residuals, found or not.
fn checked(misfits: &[Misfit]) -> Table {
    let probability = |m: &Misfit| match m.p_value < 1e-4 {
        true => "< 0.0001".to_owned(),
        false => format!("{:.4}", m.p_value),
    };
    let mut fields = vec![Field::shown("what", "", |m: &Misfit| {
        m.cause.to_string().into()
    })];
    fields.extend(AXES.iter().enumerate().map(|(k, axis)| {
        Field::shown(*axis, "mg", move |m: &Misfit| m.amplitudes_mg[k].into()).decimals(2)
    }));
    fields.extend([
        Field::shown("probability by chance", "", |m: &Misfit| {
            probability(m).into()
        }),
        Field::shown("found", "", |m: &Misfit| {
            if m.found { "yes" } else { "no" }.into()
        }),
        Field::shown("found in nine of ten from", "mg", |m: &Misfit| {
            m.detectable_mg.into()
        })
        .decimals(2),
    ]);
    Table::of("Looked for in the residuals", fields, misfits).note(
        "The last column is the size on one axis alone that nine of ten recordings with these attitudes and this scatter would show. What \
         is smaller may be there; what the residuals leave open of it is in the intervals. What is not listed cannot be tested with so few standstills.",
    )
}

/// K as a scale factor and a direction of each sensitive axis.
pub(super) fn ferraris(fit: &MultiPositionFit) -> Table {
    let ferraris = Ferraris::of(&fit.model().k().0);
    let unit = format!("{}/(m/s²)", fit.output_unit());
    let rows = AXES.iter().enumerate().map(|(i, axis)| {
        let [x, y, z] = ferraris.directions[i].map(|v| Cell::number(format!("{v:.7}")));
        let scale = Cell::number(format!("{:.5}", ferraris.scale[i]));
        [(*axis).into(), scale, x, y, z]
    });
    let headings = [
        ("output", ""),
        ("K_a", unit.as_str()),
        ("R_a x", ""),
        ("R_a y", ""),
        ("R_a z", ""),
    ];
    lines("Ferraris' form K = diag(K_a) R_a", headings, rows)
}
