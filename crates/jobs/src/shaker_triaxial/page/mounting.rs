//! Mounting angles: what the runs tell of them, and what no run can.

use crate::page::columns::{frequency, printed, words};
use proofmass_report::number::plain;
use proofmass_report::plot::Style;
use proofmass_report::{Axis, Block, Field, Section, Series, Table, XyPlot};
use proofmass_shaker::{AngleInformation, AngleResult, FrameTurn, Identifiability, MethodResult};

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
    let of_key = |key| result.angles.iter().filter(move |a| a.key == key);
    let mut plot: Option<XyPlot> = None;
    for &key in &keys {
        let of_key: Vec<_> = of_key(key).collect();
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
    let rows = keys.iter().flat_map(|key| of_key(*key));
    let table = Table::of("Mounting angles", fields(), rows);
    Some(section.folded("All mounting angles", [Block::Table(table)]))
}

fn degrees(angle: f64) -> String {
    format!("{:.3}", angle.to_degrees())
}

fn fields() -> [Field<'static, AngleResult>; 6] {
    type A = AngleResult;
    [
        words("input", |a: &A| a.key.clone()),
        printed("α", "°", |a: &A| {
            plain(a.configuration.inclination.to_degrees())
        }),
        printed("ω", "°", |a: &A| {
            let whole = a.key.contains("wedge");
            (!whole).then(|| plain(a.configuration.rotation.to_degrees()))
        }),
        printed("estimated error", "°", |a: &A| degrees(a.value)),
        printed("u estimated", "°", |a: &A| degrees(a.standard_uncertainty)),
        printed("u declared", "°", |a: &A| degrees(a.prior)),
    ]
}

/// What the runs tell of the mounting, and what none can, in words and numbers.
fn identifiability(section: Section, known: &Identifiability) -> Section {
    type Input = AngleInformation;
    type Turn = FrameTurn;
    let inputs = [
        words("input", |i: &Input| i.key.clone()),
        printed("angles", "", |i: &Input| i.count.to_string()),
        printed("told by the runs", "", |i: &Input| {
            format!("{:.1}", i.freedom)
        }),
        printed("u declared", "°", |i: &Input| degrees(i.declared)),
        printed("u after the runs", "°", |i: &Input| degrees(i.after)),
    ];
    let inputs = Table::of("What the runs tell of each kind of angle", inputs, &known.inputs)
        .note("Told by the runs: degrees of freedom Σ λ/(1 + λ), λ the information of the runs over that of the declaration.");
    let turns = [
        frequency(|t: &Turn| t.frequency),
        words("about", |t: &Turn| t.about.clone()),
        words("terms", |t: &Turn| match t.about.as_str() {
            "x" => "S_yz, S_zy",
            "y" => "S_xz, S_zx",
            _ => "S_xy, S_yx",
        }),
        printed("u of the turn", "°", |t: &Turn| degrees(t.turn)),
        printed("u of the right angle", "°", |t: &Turn| {
            degrees(t.right_angle)
        }),
    ];
    let caption = "A turn of the whole device, and the right angles between its sensitive axes";
    let turns = Table::of(caption, turns, &known.turns).note(
        "The turn is ½ (S_ik/S_kk − S_ki/S_ii), the departure from a right angle ½ (S_ik/S_kk + S_ki/S_ii); a turn that is not in \
         the budget (tilt or rotation common to all gluings) is not in u either.",
    );
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
