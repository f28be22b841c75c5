//! Mounting angles: what the runs tell of them, and what no run can.

use super::sign;
use proofmass_report::number::plain;
use proofmass_report::plot::Style;
use proofmass_report::{Axis, Block, Cell, Column, Section, Series, Table, XyPlot};
use proofmass_shaker::{Identifiability, MethodResult};

/// Mounting angles before and after the data, for a joint fit.
pub(super) fn angles(result: &MethodResult) -> Option<Section> {
    let mut keys: Vec<&str> = vec![];
    for a in &result.angles {
        if !keys.contains(&a.key.as_str()) {
            keys.push(&a.key);
        }
    }
    if keys.is_empty() {
        return None;
    }
    let mut section = Section::new("Mounting angles").paragraph(
        "The angles of wedges and gluings are the same at every frequency, so the data speak about them. Declared: what the \
         budget says before the data; estimated: after them. What stays is almost entirely common to all angles of a \
         kind, a rotation of the whole device that no data can tell from a device whose axes are turned.",
    );
    let mut table = Table::new(
        "Mounting angles",
        [
            Column::text("input"),
            Column::number("α", "°"),
            Column::number("ω", "°"),
            Column::number("estimated error", "°"),
            Column::number("u estimated", "°"),
            Column::number("u declared", "°"),
        ],
    );
    let mut plot: Option<XyPlot> = None;
    for key in &keys {
        let of_key: Vec<_> = result.angles.iter().filter(|a| a.key == *key).collect();
        let number: Vec<f64> = (1..=of_key.len()).map(|i| i as f64).collect();
        let value: Vec<f64> = of_key.iter().map(|a| a.value.to_degrees()).collect();
        let spread: Vec<f64> = of_key
            .iter()
            .map(|a| 2.0 * a.standard_uncertainty.to_degrees())
            .collect();
        let low: Vec<f64> = value.iter().zip(&spread).map(|(v, s)| v - s).collect();
        let high: Vec<f64> = value.iter().zip(&spread).map(|(v, s)| v + s).collect();
        let prior = 2.0 * of_key[0].prior.to_degrees();
        let axis = Axis::linear(key.replace('.', " "), "°");
        let x = Axis::linear("mounting", "");
        let mut next = match plot.take() {
            None => XyPlot::new(x, axis),
            Some(plot) => plot.below(axis),
        };
        if let Some(panel) = next.panels.last_mut() {
            panel.height = 190.0;
        }
        next = next
            .horizontal(prior, "declared ± 2 u")
            .horizontal(-prior, "")
            .series(
                Series::line("", &number, &value)
                    .style(Style::Markers)
                    .bars(&low, &high)
                    .look(0),
            );
        plot = Some(next);
        for a in of_key {
            let whole = a.key.contains("wedge");
            table = table.row([
                Cell::text(a.key.clone()),
                Cell::number(plain(a.configuration.inclination.to_degrees())),
                if whole {
                    Cell::Empty
                } else {
                    Cell::number(plain(a.configuration.rotation.to_degrees()))
                },
                Cell::number(sign(format!("{:.3}", a.value.to_degrees()))),
                Cell::number(format!("{:.3}", a.standard_uncertainty.to_degrees())),
                Cell::number(format!("{:.3}", a.prior.to_degrees())),
            ]);
        }
    }
    if let Some(plot) = plot {
        section = section.figure(
            "Estimated error of every mounting angle, in the order of the plan; bars are two standard uncertainties, lines \
             two declared ones",
            plot,
        );
    }
    if let Some(known) = &result.identifiability {
        section = identifiability(section, known);
    }
    Some(section.folded("All mounting angles", [Block::Table(table)]))
}

/// What the runs tell of the mounting, and what none can, in words and numbers.
fn identifiability(section: Section, known: &Identifiability) -> Section {
    let degrees = |angle: f64| format!("{:.3}", angle.to_degrees());
    let mut inputs = Table::new(
        "What the runs tell of each kind of angle",
        [
            Column::text("input"),
            Column::number("angles", ""),
            Column::number("told by the runs", ""),
            Column::number("u declared", "°"),
            Column::number("u after the runs", "°"),
        ],
    )
    .note("Told by the runs: degrees of freedom Σ λ/(1 + λ), λ the information of the runs over that of the declaration.");
    for input in &known.inputs {
        inputs = inputs.row([
            Cell::text(input.key.clone()),
            Cell::number(input.count.to_string()),
            Cell::number(format!("{:.1}", input.freedom)),
            Cell::number(degrees(input.declared)),
            Cell::number(degrees(input.after)),
        ]);
    }
    let mut turns = Table::new(
        "A turn of the whole device, and the right angles between its sensitive axes",
        [
            Column::number("f", "Hz"),
            Column::text("about"),
            Column::text("terms"),
            Column::number("u of the turn", "°"),
            Column::number("u of the right angle", "°"),
        ],
    )
    .note(
        "The turn is ½ (S_ik/S_kk − S_ki/S_ii), the departure from a right angle ½ (S_ik/S_kk + S_ki/S_ii); a turn that is not in \
         the budget (tilt or rotation common to all gluings) is not in u either.",
    );
    for turn in &known.turns {
        turns = turns.row([
            Cell::number(plain(turn.frequency)),
            Cell::text(turn.about.clone()),
            Cell::text(match turn.about.as_str() {
                "x" => "S_yz, S_zy",
                "y" => "S_xz, S_zx",
                _ => "S_xy, S_yx",
            }),
            Cell::number(degrees(turn.turn)),
            Cell::number(degrees(turn.right_angle)),
        ]);
    }
    let [strong, more, less, weak, none] = known.directions;
    section
        .paragraph(format!(
            "Of {} angles the runs tell {:.1}: in {strong} directions they know more than ten times what the declaration says, in \
             {more} more than it, in {less} and {weak} less, and in {none} next to nothing. A small turn θ of the frame of the \
             device, S + [θ]× S, gives the same outputs in every run at every frequency: tilt common to all gluings (about x: \
             S_yz against S_zy; about y: S_xz against S_zx) and the zero of the mask (S_xy against S_yx) are known as \
             declared and not better, however many runs there are. What such a turn leaves as it is, lengths and the angles \
             between the sensitive axes, the runs do tell.",
            known.count(),
            known.freedom()
        ))
        .table(inputs)
        .folded("Turns of the device", [Block::Table(turns)])
}
