//! What the gallery shows; the tests of the crate read the same report.

use proofmass_report::{
    Axis, BarPlot, Block, Cell, Column, HistogramPlot, KeyFigure, MatrixPlot, Report, Section,
    Series, SpherePlot, Table, XyPlot, plot::Style,
};
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Quantity};

/// The whole report.
pub fn report() -> Result<Report, proofmass_report::Error> {
    Ok(
        Report::new("Multi-position calibration of a triaxial accelerometer")
            .subtitle("Invented numbers that exercise every block and plot")
            .meta("Device", "EXAMPLE-3 <no. 0042> & \"friends\"")
            .meta("Recorded", "2000-01-01T12:00:00Z")
            .meta("Local gravity", "9.807 25(10) m/s²")
            .meta(
                "SHA-256",
                "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08",
            )
            .findings(findings())
            .section(results())
            .section(recording()?)
            .section(attitudes())
            .section(correlations())
            .section(budget())
            .section(noise())
            .section(edges())
            .footer("proofmass 0.1.0, schema 1"),
    )
}

/// A reproducible number between −1 and 1 that looks random.
fn jitter(i: usize) -> f64 {
    let mut z = (i as u64)
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(0x1234_5678);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

proofmass_uncertainty::findings! {
    /// Findings of the gallery.
    pub CATALOGUE;

    /// Few attitudes point downwards.
    few_attitudes_below(below: usize, all: usize, coverage: f64) =
        "few-attitudes-below", [Note],
        what "only {below} of {all} attitudes point downwards",
        evidence "coverage of the lower hemisphere {coverage} %";

    /// The residuals are too large.
    excess_residuals(chi_squared: f64, dof: usize, factor: f64) =
        "excess-residuals", [Warning],
        what "the residuals exceed the noise of the means",
        evidence "χ² = {chi_squared} with {dof} degrees of freedom",
        advice "check that the sensor stood still; the covariance was scaled by {factor}";

    /// A standstill contradicts the others.
    outlying_standstill(number: usize, residual: f64, deviations: f64) =
        "outlying-standstill", [Decision],
        what "standstill {number} is out of line",
        evidence "residual {residual} mm/s², {deviations} standard deviations",
        advice "keep it or leave it out, and say so in the record";
}

fn findings() -> Vec<Finding> {
    vec![
        few_attitudes_below(7, 38, 31.0),
        excess_residuals(311.2, 105, 2.96),
        outlying_standstill(17, 8.4, 6.1),
    ]
}

fn quantity(name: &str, unit: &str, value: f64, u: f64) -> Quantity {
    Quantity {
        name: name.into(),
        unit: unit.into(),
        value,
        standard_uncertainty: u,
        dof: DegreesOfFreedom::new(28.4).unwrap_or(DegreesOfFreedom::INFINITE),
    }
}

fn results() -> Section {
    let parameters = [
        ("bias.x", "m/s²", 0.0312, 0.0014),
        ("bias.y", "m/s²", -0.1504, 0.0011),
        ("bias.z", "m/s²", 12.204_5, 0.0021),
        ("scale.x", "1", 1.000_213, 0.000_041),
        ("scale.y", "1", 0.998_740, 0.000_038),
        ("scale.z", "1", 1.012_001, 0.000_055),
        ("misalignment.xy", "rad", -0.000_012, 0.000_063),
        ("misalignment.xz", "rad", 3.2e-7, 4.1e-8),
        ("counts.per.unit", "1/(m/s²)", 41_632.0, 1_250.0),
        ("known.exactly", "1", 1.0, 0.0),
    ];
    let mut table = Table::new(
        "Parameters with standard uncertainty in parentheses",
        [
            Column::text("parameter"),
            Column::number("estimate", ""),
            Column::number("U (95 %)", ""),
            Column::number("ν", ""),
            Column::text("meaning"),
        ],
    );
    for (name, unit, value, u) in parameters {
        table = table.row([
            Cell::text(name),
            Cell::quantity(quantity(name, unit, value, u)),
            if u > 0.0 {
                Cell::number(proofmass_report::scientific(2.05 * u, 2))
            } else {
                Cell::Empty
            },
            Cell::number("28.4"),
            Cell::text("output of the axis at rest, free of gravity"),
        ]);
    }
    Section::new("Results")
        .key_figures([
            KeyFigure::new("Residual, root mean square", "1.04", "mm/s²").note("105 degrees of freedom"),
            KeyFigure::new("Attitudes", "38", "1").note("of 41 standstills found"),
            KeyFigure::new("Condition number", "3.2", "1"),
            KeyFigure::new("Bias x", "-0.0312(14)", "m/s²").note("k = 2.05 at 95 %"),
        ])
        .paragraph("Gravity seen by a resting sensor has the same magnitude in every attitude; what differs is the error of the sensor. Text with <, > & \"quotes\" stands as written.")
        .table(table.note("Pure numbers carry no unit."))
        .block(Block::Code("f = K (y − b)\n    K upper triangular".into()))
}

fn recording() -> Result<Section, proofmass_report::Error> {
    let n = 1_000_000;
    let t: Vec<f64> = (0..n).map(|i| i as f64 * 512.0 / n as f64).collect();
    let stand: Vec<(f64, f64)> = (0..38)
        .map(|k| (8.0 + 13.0 * k as f64, 15.0 + 13.0 * k as f64))
        .collect();
    let trace = |axis: f64| -> Vec<f64> {
        t.iter()
            .enumerate()
            .map(|(i, &t)| {
                let pose = ((t - 8.0) / 13.0).floor();
                let still = (t - 8.0).rem_euclid(13.0) < 7.0;
                let swing = if still { 0.02 } else { 3.0 };
                9.8 * (pose * (1.1 + axis) + axis).sin() + swing * jitter(3 * i + axis as usize)
            })
            .collect()
    };
    let (x, y, z) = (trace(0.0), trace(1.0), trace(2.0));
    let plot = XyPlot::new(Axis::linear("time", "s"), Axis::linear("x", "m/s²"))
        .series(Series::line("", &t, &x))
        .shade("standstill", &stand)
        .below(Axis::linear("y", "m/s²"))
        .series(Series::line("", &t, &y).look(1))
        .shade("", &stand)
        .below(Axis::linear("z", "m/s²"))
        .series(Series::line("", &t, &z).look(2))
        .shade("", &stand)
        .vertical(201.0, "shock");
    let index: Vec<f64> = (1..=38).map(f64::from).collect();
    let r: Vec<f64> = (0..38).map(|i| 1.5e-3 * jitter(i)).collect();
    let (lo, hi): (Vec<f64>, Vec<f64>) = r.iter().map(|v| (v - 8e-4, v + 8e-4)).unzip();
    let residuals = XyPlot::new(
        Axis::linear("standstill", ""),
        Axis::linear("|f| − g", "m/s²"),
    )
    .series(Series::markers("residual with standard uncertainty", &index, &r).bars(&lo, &hi))
    .horizontal(0.0, "")
    .horizontal(9.8e-3 * 0.2, "+0.02 %")
    .horizontal(-9.8e-3 * 0.2, "−0.02 %")
    .note(17.0, r[16], "no. 17");
    Ok(Section::new("Recording and residuals")
        .figure(
            "Recording of 10⁶ samples with the standstills used (shaded).",
            plot,
        )
        .figure("Residual of each standstill.", residuals))
}

fn attitudes() -> Section {
    let mut sphere = SpherePlot::new("residual", "m/s²");
    let mut labelled = SpherePlot::new("distance from gravity", "mg");
    let mut crowded = SpherePlot::new("residual over its uncertainty, noise density", "(m/s²)/√Hz");
    crowded.axes = ["east", "north", "up"].map(String::from);
    for i in 0..38 {
        // A golden-angle spiral, slightly disturbed.
        let z = 1.0 - 2.0 * (i as f64 + 0.5) / 38.0;
        let phi = i as f64 * 2.399_963;
        let r = (1.0 - z * z).sqrt();
        let d = [r * phi.cos(), r * phi.sin(), z];
        sphere = sphere.point(d, 1.5e-3 * jitter(i), (i + 1).to_string());
        crowded = crowded.point(d, 3e-7 * jitter(i + 5), format!("pose {}", i + 1));
        if i % 6 == 0 {
            labelled = labelled.point(d, jitter(i).abs(), format!("pose {i}"));
        }
    }
    labelled = labelled
        .point([0.0, 0.0, 1.0], 0.2, "pole")
        .point([1.0, 0.0, 0.0], 0.3, "rim");
    Section::new("Attitudes")
        .figure(
            "Directions of gravity in the sensor frame, coloured by residual.",
            sphere,
        )
        .figure("Values without a sign.", labelled)
        .figure("Long labels and names of axes.", crowded)
        .figure("No attitude at all.", SpherePlot::new("residual", "m/s²"))
        .figure(
            "One attitude, residual zero.",
            SpherePlot::new("residual", "m/s²").point([0.0, 0.0, -1.0], -0.0, ""),
        )
}

fn correlation(names: &[&str]) -> MatrixPlot {
    let n = names.len();
    let elements = (0..n * n)
        .map(|k| {
            let (i, j) = (k / n, k % n);
            Some(if i == j {
                1.0
            } else {
                jitter(i.min(j) * 31 + i.max(j)).powi(3)
            })
        })
        .collect();
    MatrixPlot {
        names: names.iter().map(ToString::to_string).collect(),
        elements,
    }
}

fn correlations() -> Section {
    let mut unknown = correlation(&[
        "a",
        "temperature coefficient of the misalignment of x to y",
        "exactly known",
    ]);
    for k in [2, 5, 6, 7, 8] {
        unknown.elements[k] = None;
    }
    Section::new("Correlations")
        .figure(
            "Twelve parameters.",
            correlation(&[
                "bias.x",
                "bias.y",
                "bias.z",
                "scale.x",
                "scale.y",
                "scale.z",
                "misalignment.xy",
                "misalignment.xz",
                "misalignment.yx",
                "misalignment.yz",
                "misalignment.zx",
                "misalignment.zy",
            ]),
        )
        .figure(
            "Two of three parameters; the third is exactly known.",
            unknown,
        )
}

fn budget() -> Section {
    let bars = BarPlot::shares("share of the variance of bias.x")
        .bar("noise of the standstill means", 0.712, "A")
        .bar("local gravity from latitude and height, normal gravity formula with free-air correction", 0.221, "B")
        .bar("a_name_without_any_space_that_is_longer_than_the_margin_left_of_the_bars.xy", 0.1, "B")
        .bar("temperature", 0.0667, "B")
        .bar("quantisation", 0.000_3, "B")
        .bar("nothing", 0.0, "");
    let edges: Vec<f64> = (0..=40).map(|i| -4.0 + 0.2 * f64::from(i)).collect();
    let density = |x: f64| (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let heights: Vec<f64> = (0..40)
        .map(|i| (density(edges[i] + 0.1) * (1.0 + 0.1 * jitter(i))).max(0.0))
        .collect();
    let x: Vec<f64> = (0..=200).map(|i| -4.0 + 0.04 * f64::from(i)).collect();
    let y: Vec<f64> = x.iter().map(|&x| density(x)).collect();
    let histogram = HistogramPlot::new(
        Axis::linear("normalised residual", ""),
        Axis::linear("density", ""),
        &edges,
        &heights,
    )
    .curve(Series::line("standard normal", &x, &y))
    .mark(-1.96, "2.5 %")
    .mark(1.96, "97.5 %");
    Section::new("Budget")
        .figure("Where the uncertainty comes from.", bars)
        .figure("Residuals over their standard uncertainty.", histogram)
}

fn noise() -> Section {
    let tau: Vec<f64> = (0..=36)
        .map(|i| 10f64.powf(-3.0 + 0.25 * f64::from(i)))
        .collect();
    let sigma: Vec<f64> = tau
        .iter()
        .map(|t| (1e-8 / t + 4e-10 + 1e-15 * t * t).sqrt())
        .collect();
    let (lo, hi): (Vec<f64>, Vec<f64>) = tau
        .iter()
        .zip(&sigma)
        .map(|(t, s)| {
            (
                s * (1.0 - 0.2 * (t / 1e3).min(4.5)),
                s * (1.0 + 0.2 * (t / 1e3).min(8.0)),
            )
        })
        .unzip();
    let allan = XyPlot::new(
        Axis::log("averaging time τ", "s"),
        Axis::log("Allan deviation", "m/s²"),
    )
    .series(
        Series::line("overlapping, 68 % interval", &tau, &sigma)
            .style(Style::LineAndMarkers)
            .band(&lo, &hi),
    )
    .slope("τ⁻¹ᐟ²  velocity random walk", (1.0, 1e-4), -0.5)
    .slope("τ¹  drift", (1e4, 3e-4), 1.0)
    .horizontal(2e-5, "bias instability")
    .note(30.0, 2.8e-5, "smallest at 30 s");
    let f: Vec<f64> = (0..=60)
        .map(|i| 10f64.powf(1.0 + f64::from(i) / 15.0))
        .collect();
    let modulus: Vec<f64> = f
        .iter()
        .map(|f| 1.0 / ((1.0 - (f / 2e4_f64).powi(2)).powi(2) + 4e-4).sqrt())
        .collect();
    let phase: Vec<f64> = f
        .iter()
        .map(|f| {
            -(0.02 * f / 2e4)
                .atan2(1.0 - (f / 2e4_f64).powi(2))
                .to_degrees()
                * 1.0
        })
        .collect();
    let bode = XyPlot::new(Axis::log("frequency", "Hz"), Axis::linear("modulus", ""))
        .series(Series::line("model", &f, &modulus))
        .series(Series::markers("measured", &f[..45], &modulus[..45]).look(1))
        .vertical(5000.0, "5 kHz")
        .vertical(7000.0, "limit of use")
        .below(Axis::linear("phase", "°"))
        .series(Series::line("model", &f, &phase));
    Section::new("Noise and frequency response")
        .figure("Allan deviation over nine decades.", allan)
        .figure("Modulus and phase over a common axis.", bode)
}

fn edges() -> Section {
    let linear = || {
        XyPlot::new(
            Axis::linear("abscissa", "s"),
            Axis::linear("ordinate", "m/s²"),
        )
        .height(140.0)
    };
    let long =
        "a name that is much longer than anything a sensible person would put into a legend, twice";
    let many = (0..9).fold(linear().height(220.0), |plot, k| {
        let x: Vec<f64> = (0..20).map(f64::from).collect();
        let y: Vec<f64> = x
            .iter()
            .map(|x| (0.3 * x + k as f64).sin() + k as f64)
            .collect();
        plot.series(Series::line(format!("series {k}"), &x, &y).style(Style::LineAndMarkers))
    });
    let f: Vec<f64> = (0..=40).map(|i| 10f64.powf(0.1 * f64::from(i))).collect();
    let density: Vec<f64> = f.iter().map(|f| (1e-10 / f + 1e-12).sqrt()).collect();
    let crowded = XyPlot::new(
        Axis::log("frequency", "Hz"),
        Axis::log("noise density", "(m/s²)/√Hz"),
    )
    .series(Series::line("density", &f, &density))
    .slope("f⁻¹ᐟ²  flicker", (1.0, 1e-5), -0.5)
    .slope("f⁻¹  red", (1.0, 2e-5), -1.0)
    .slope("f⁰  white", (1.0, 1e-6), 0.0)
    .horizontal(1e-6, "data sheet")
    .horizontal(1.05e-6, "earlier sample")
    .horizontal(0.95e-6, "later sample")
    .horizontal(
        8e-6,
        "largest density at which six minutes of standstill are enough for the aim",
    )
    .note(100.0, 1.4e-6, "corner at 100 Hz")
    .vertical(50.0, "mains")
    .vertical(60.0, "mains elsewhere")
    .vertical(70.0, "fan")
    .vertical(1000.0, "anti-alias filter")
    .vertical(9999.0, "Nyquist frequency");
    Section::new("Edge cases")
        .figure(
            "One point.",
            linear().series(Series::line("one", &[1.0], &[2.0])),
        )
        .figure(
            "All equal.",
            linear().series(Series::line("equal", &[0.0, 1.0, 2.0], &[9.81; 3])),
        )
        .figure(
            "Empty series.",
            linear().series(Series::line("empty", &[], &[])),
        )
        .figure(
            "Very large.",
            linear().series(Series::line("large", &[0.0, 1e12], &[-1e299, 1e300])),
        )
        .figure(
            "Very small.",
            linear().series(Series::line("small", &[0.0, 1e-9], &[-3e-280, 1e-280])),
        )
        .figure(
            "Small changes of a large number.",
            linear().series(Series::line(
                "gravity",
                &[0.0, 1.0, 2.0, 3.0],
                &[9.806_650_001, 9.806_650_004, 9.806_650_002, 9.806_650_009],
            )),
        )
        .figure(
            "Steps and long names <&>.",
            linear()
                .series(Series::line(long, &[0.0, 1.0, 2.0], &[1.0, 3.0, 2.0]).style(Style::Steps))
                .series(Series::markers(long, &[0.5, 1.5], &[1.0, -0.0])),
        )
        .figure("Nine series.", many)
        .figure("Many labels.", crowded)
        .table(
            Table::new(
                "Numbers in all forms",
                [
                    Column::text("form"),
                    Column::number("number", ""),
                    Column::text("remark"),
                ],
            )
            .row([
                Cell::text("negative zero"),
                Cell::number("-0.00"),
                Cell::Empty,
            ])
            .row([Cell::text("integer"), Cell::number("12345"), Cell::Empty])
            .row([
                Cell::text("small"),
                Cell::number("-0.000012"),
                Cell::text("six places"),
            ])
            .row([
                Cell::text("large"),
                Cell::quantity(quantity("q", "m/s²", 6.02e23, 1.5e21)),
                Cell::text("with its unit"),
            ])
            .row([
                Cell::text("text"),
                Cell::text("not determined"),
                Cell::text("under the heading"),
            ]),
        )
        .table(wide_table())
        .table(Table::new(
            "A table without rows",
            [Column::text("a"), Column::number("b", "m")],
        ))
}

/// More columns and rows than a sheet of paper holds at the usual size.
fn wide_table() -> Table {
    let mut columns = vec![Column::text("standstill"), Column::text("remark")];
    for axis in ["x", "y", "z"] {
        columns.push(Column::number(format!("mean {axis}"), "m/s²"));
        columns.push(Column::number(format!("noise {axis}"), "(m/s²)/√Hz"));
        columns.push(Column::number(format!("scale {axis}"), "count/(m/s²)"));
    }
    columns.push(Column::number("a heading of several words", "kg·m²·s⁻²"));
    let mut table = Table::new("A long table of many columns", columns);
    for i in 0..60 {
        let mut row = vec![
            Cell::text(format!("{}", i + 1)),
            Cell::text(if i % 9 == 0 {
                "moved by hand while the sensor warmed up"
            } else {
                ""
            }),
        ];
        for axis in 0..3 {
            let k = 3 * i + axis;
            row.push(Cell::quantity(quantity("f", "m/s²", 9.8 * jitter(k), 3e-4)));
            row.push(Cell::number(format!("{:.2e}", 1e-4 + 5e-5 * jitter(k + 7))));
            row.push(Cell::quantity(quantity(
                "K",
                "count/(m/s²)",
                1671.0 + jitter(k),
                1.25,
            )));
        }
        row.push(Cell::number(format!("{:.3}", 100.0 * jitter(i + 99))));
        table = table.row(row);
    }
    table.note("A note that must stay with its table.")
}
