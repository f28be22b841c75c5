//! What every output promises, whatever is put into the report.

use proofmass_report::{
    Axis, BarPlot, Block, Cell, Column, Error, KeyFigure, MatrixPlot, Place, Plot, Report, Section,
    Series, SpherePlot, Table, XyPlot, html, terminal,
};
use proofmass_uncertainty::Severity;

#[path = "../examples/gallery/content.rs"]
mod gallery;

/// A page without its script, which is no markup.
fn without_script(page: &str) -> String {
    let Some((before, rest)) = page.split_once("<script>") else {
        return page.to_owned();
    };
    let (script, after) = rest.split_once("</script>").expect("its end");
    for outside in [
        "http:",
        "https:",
        "fetch",
        "XMLHttpRequest",
        "import",
        "innerHTML",
    ] {
        let foreign = script.replace("http://www.w3.org/2000/svg", "");
        assert!(!foreign.contains(outside), "the script has {outside}");
    }
    format!("{before}{after}")
}

/// Refuses markup whose tags do not balance, whose text carries a bare `<` or `&`, whose identifiers repeat or
/// whose coordinates are no numbers.
fn assert_well_formed(xml: &str) {
    let xml = &without_script(xml);
    let mut open = Vec::new();
    let mut names = std::collections::HashSet::new();
    for piece in xml.split('<').skip(1) {
        let (tag, text) = piece.split_once('>').expect("a tag ends");
        for part in [tag, text] {
            for entity in part.split('&').skip(1) {
                let name = entity.split(';').next().unwrap_or("");
                assert!(
                    ["lt", "gt", "amp", "quot", "#39"].contains(&name),
                    "bare & in {piece}"
                );
            }
        }
        assert!(!tag.contains("NaN") && !tag.contains("\"inf") && !tag.contains("\"-inf"));
        if let Some((_, id)) = tag.split_once(" id=\"") {
            let id = id.split('"').next().unwrap_or("");
            assert!(names.insert(id.to_string()), "id {id} repeats");
        }
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(tag.split_whitespace().next().expect("a name").to_string());
        }
    }
    assert!(open.is_empty(), "left open: {open:?}");
}

fn axes() -> (Axis, Axis) {
    (Axis::linear("a <&> \"b\"", "s"), Axis::log("y", "m/s²"))
}

#[test]
fn law_every_svg_is_well_formed() {
    let (x, y) = axes();
    let plots: [Plot; 5] = [
        XyPlot::new(x, y)
            .series(Series::line("<&>", &[0.0, 1.0], &[1e-9, 1.0]))
            .slope("s", (1.0, 1.0), 1.0)
            .into(),
        XyPlot::new(Axis::linear("", ""), Axis::linear("", ""))
            .series(Series::line("", &[], &[]))
            .into(),
        SpherePlot::new("r", "1")
            .point([0.0, 0.0, -2.0], -1.0, "<p>")
            .into(),
        MatrixPlot {
            names: Vec::new(),
            elements: Vec::new(),
        }
        .into(),
        BarPlot::shares("&").bar("<b>", 0.0, "").into(),
    ];
    for plot in plots {
        assert_well_formed(&plot.svg("title <&>", "f").unwrap());
    }
}

#[test]
fn law_the_gallery_is_one_well_formed_page() {
    let page = html::render(&gallery::report().unwrap()).unwrap();
    let body = page.strip_prefix("<!DOCTYPE html>").unwrap();
    assert_well_formed(body);
    let body = &without_script(body);
    // Every link has its target, and nothing is referred to outside but the name space of the drawings.
    for link in body.split("href=\"#").skip(1) {
        let id = link.split('"').next().unwrap_or("");
        assert!(body.contains(&format!(" id=\"{id}\"")), "{id}");
    }
    assert_eq!(
        body.matches("http").count(),
        body.matches("xmlns=\"http://www.w3.org/2000/svg\"").count()
    );
}

#[test]
fn regress_small_drawing() {
    let plot = Plot::from(
        XyPlot::new(
            Axis::linear("time", "s"),
            Axis::log("noise", "(m/s²)/√Hz").range(1e-5, 1e-2),
        )
        .height(80.0)
        .series(Series::line("x", &[0.0, 1.0], &[1e-4, 1e-3])),
    );
    insta::assert_snapshot!(plot.svg("A line", "f").unwrap());
}

#[test]
fn law_widths_of_tables_are_known_to_the_page() {
    let table = (0..30).fold(
        Table::new("t", [Column::text("n"), Column::number("v", "m")]),
        |table, i| table.row([Cell::text("a"), Cell::number(format!("{i}.5"))]),
    );
    let page = html::render(&Report::new("T").section(Section::new("S").table(table))).unwrap();
    // Two digits before the point and two characters after it, plus a tenth each for rounding.
    assert!(page.contains("class=\"whole\" style=\"min-width:2.1ch\">29<"));
    assert!(page.contains("class=\"table\" style=\"--ch:"));
}

#[test]
fn regress_one_figure_that_cannot_be_drawn_does_not_take_the_page_with_it() {
    let plot = XyPlot::new(Axis::linear("t", "s"), Axis::linear("y", "")).series(Series::line(
        "trace",
        &[0.0, 1.0],
        &[0.0, 1e305],
    ));
    let section = Section::new("S")
        .figure("Far beyond.", Plot::from(plot))
        .paragraph("all the rest");
    let page = html::render(&Report::new("T").section(section)).unwrap();
    assert!(page.contains("cannot be drawn: trace: element 1 is 1e305"));
    assert!(page.contains("Far beyond.") && page.contains("all the rest"));
}

#[test]
fn law_hostile_text_neither_steers_the_terminal_nor_turns_the_page() {
    let hostile = "a\u{1b}]0;pwned\u{7}b\u{202e}txt.exe\u{9b}31m";
    let report = Report::new(hostile)
        .meta(hostile, hostile)
        .section(Section::new(hostile).paragraph(hostile));
    let options = terminal::Options {
        width: 80,
        colour: false,
        filed: true,
        details: true,
    };
    let text = terminal::render(&report, &options).unwrap();
    assert!(text.contains(r"a\u{1b}]0;pwned\u{7}b\u{202e}txt"));
    let page = html::render(&report).unwrap();
    for c in ['\u{1b}', '\u{7}', '\u{202e}', '\u{9b}'] {
        assert!(!text.contains(c) && !page.contains(c), "{c:?}");
    }
}

#[test]
fn refuses_points_that_cannot_be_drawn() {
    let plot = |y: &[f64], axis: Axis| {
        Plot::from(
            XyPlot::new(Axis::linear("t", "s"), axis).series(Series::line("trace", &[0.0, 1.0], y)),
        )
        .svg("t", "f")
    };
    let refused = plot(&[0.0, f64::NAN], Axis::linear("y", "")).unwrap_err();
    assert!(matches!(refused, Error::NotFinite { ref series, index: 1, .. } if series == "trace"));
    let refused = plot(&[0.0, 1.0], Axis::log("y", "")).unwrap_err();
    assert!(matches!(refused, Error::NotPositive { index: 0, .. }));
    assert!(matches!(
        plot(&[0.0], Axis::linear("y", "")),
        Err(Error::Length { .. })
    ));
}

#[test]
fn law_html_escapes_text_and_fetches_nothing() {
    let page =
        html::render(&Report::new("<script>&\"").section(Section::new("s").paragraph("a < b & c")))
            .unwrap();
    assert!(page.contains("&lt;script&gt;&amp;&quot;") && page.contains("a &lt; b &amp; c"));
    assert!(!page.contains("<script") && !page.contains("src=") && !page.contains("url(http"));
}

#[test]
fn regress_terminal_table() {
    let table = Table::new(
        "Caption",
        [Column::text("name"), Column::number("value", "m")],
    )
    .row([Cell::text("a"), Cell::number("-1.5")])
    .row([Cell::text("b"), Cell::number("10.25(3)")])
    .row([Cell::text("c"), Cell::Empty]);
    let report = Report::new("T").section(Section::new("S").table(table));
    let text = terminal::render(
        &report,
        &terminal::Options {
            width: 60,
            colour: false,
            filed: true,
            details: true,
        },
    )
    .unwrap();
    assert_eq!(
        text,
        "T\n\nS\nCaption\n name │ value / m\n──────┼───────────\n a    │ −1.5\n b    │ 10.25(3)\n c    │\n"
    );
}

#[test]
fn law_a_page_opens_with_the_answer_and_folds_the_rest() {
    let plot = || {
        XyPlot::new(Axis::linear("t", "s"), Axis::linear("a", "m/s²")).series(Series::line(
            "first",
            &[0.0, 1.0, 2.0],
            &[0.0, 5.0, 1.0],
        ))
    };
    let rows = (0..40).map(|k| vec![Cell::from(f64::from(k))]);
    let long = rows.fold(
        Table::new("Readings", [Column::number("v", "m/s")]),
        |t, row| t.row(row),
    );
    let report = Report::new("Test")
        .verdict("Kept: all of it lies within -3 dB.")
        .answers([KeyFigure::new("peak", "1.20 ± 0.05", "m/s²").note("k = 2.00, 95 %")])
        .section(
            Section::new("Result")
                .table(long.file("readings.csv"))
                .summarised(),
        )
        .section(
            Section::new("Curves")
                .figure("The curve", plot())
                .figure("Another", plot()),
        )
        .answer_first();
    assert_eq!(report.clone().answer_first(), report);
    let page = html::render(&report.clone().of(Place::Page)).unwrap();
    assert_eq!(page, html::render(&report.clone().of(Place::Page)).unwrap());
    assert_well_formed(page.strip_prefix("<!DOCTYPE html>").unwrap());
    let at = |text: &str| {
        page.find(text)
            .unwrap_or_else(|| panic!("no {text}:\n{page}"))
    };
    let order = [
        "1.20 ± 0.05",
        "k = 2.00, 95 %",
        "within −3 dB",
        "<figure>",
        "Details</h2>",
        // A table for those who look a row up belongs to the appendix.
        "Result</h3>: 40 rows",
        "Curves</h3>",
        "Another",
        "<script>",
    ];
    for pair in order.windows(2) {
        assert!(at(pair[0]) < at(pair[1]), "{pair:?}");
    }
    assert_eq!(page.matches("<script").count(), 1);
    // What a pointer reads is what was drawn: the vertices and the axes are in the drawing.
    assert!(page.contains("data-panels=\"[[") && page.contains("data-series=\"first\""));
    let text = terminal::render(
        &report.of(Place::Summary),
        &terminal::Options {
            width: 80,
            colour: false,
            filed: true,
            details: true,
        },
    )
    .unwrap();
    assert!(text.contains("1.20 ± 0.05 m/s²") && text.contains("16 more rows: readings.csv."));
    assert!(!text.contains("Curves"), "{text}");
}

/// Tables that a number is looked up in: in the page they fold out, on paper the rule of the page hides them, and their files are written.
#[test]
fn law_what_is_looked_up_is_not_printed_on_paper() {
    let table = |file: &str| {
        Table::new("Readings", [Column::number("v", "m/s")])
            .row([Cell::from(1.0)])
            .file(file)
    };
    let report = Report::new("Test")
        .section(Section::new("Opened").folded("Open", [Block::Table(table("open.csv"))]))
        .section(Section::new("Part").looked_up("Closed", [Block::Table(table("part.csv"))]))
        .section(Section::new("Whole").table(table("whole.csv")).off_paper());
    let files: Vec<&str> = report
        .filed_tables()
        .iter()
        .map(|t| t.file.as_str())
        .collect();
    assert_eq!(files, ["open.csv", "part.csv", "whole.csv"]);
    let page = html::render(&report.of(Place::Page)).unwrap();
    assert_well_formed(page.strip_prefix("<!DOCTYPE html>").unwrap());
    assert_eq!(page.matches("<details class=\"off-paper\">").count(), 2);
    assert!(page.contains("<details class=\"off-paper\">\n<summary><h3>Whole</h3></summary>"));
    assert!(page.contains(".off-paper > div { display: none; }"));
    let inputs = |count: usize| {
        let files: Vec<_> = (0..count)
            .map(|n| (format!("{n}.csv"), "0".repeat(64)))
            .collect();
        let report = Report::new("Test").section(Section::new("Inputs").inputs(&files));
        html::render(&report.of(Place::Page)).unwrap()
    };
    let off = |page: String| page.matches("<details class=\"off-paper\">").count();
    assert_eq!(
        (off(inputs(12)), off(inputs(13))),
        (0, 1),
        "digests of many files"
    );
}

proofmass_uncertainty::findings! {
    DOUBTS;

    /// Something is doubtful.
    doubt(n: f64) = "doubt", [Note, Warning, Decision],
        what "number {n}: something that takes more than one line of a terminal to be said is doubtful about this result",
        evidence "seen {n} times",
        advice "do what has to be done about it, and then do it once more";
}

/// Behind the opening stands the first table of few rows; what else there is, is named and printed on demand.
#[test]
fn law_long_tables_of_a_terminal_are_asked_for() {
    let table = |caption: &str, rows: usize, columns: usize| {
        let columns = (0..columns).map(|c| Column::number(format!("column {c}"), "m/s"));
        let count = columns.len();
        let table = Table::new(caption, columns);
        (0..rows).fold(table, |table, row| {
            table.row(vec![Cell::from(row as f64); count])
        })
    };
    let report = Report::new("Test")
        .verdict("The result is known.")
        .section(Section::new("Points").table(table("", 13, 2)))
        .section(Section::new("Wide").table(table("", 2, 40)))
        .section(Section::new("Budget").table(table("", 12, 2)))
        .section(Section::new("Others").table(table("", 3, 2)));
    let shown = |details: bool, filed: bool| {
        let options = terminal::Options {
            width: 80,
            colour: false,
            filed,
            details,
        };
        terminal::render(&report, &options).expect("text")
    };
    let whole = shown(true, false);
    for title in ["Points", "Wide", "Budget", "Others"] {
        assert!(whole.lines().any(|line| line == title), "{whole}");
    }
    assert!(!whole.contains("--details"), "{whole}");
    for (filed, more) in [
        (false, "more with --details: Points, Wide, Others"),
        (
            true,
            "more in the page, or with --details: Points, Wide, Others",
        ),
    ] {
        let brief = shown(false, filed);
        assert!(brief.lines().any(|line| line == "Budget"), "{brief}");
        assert!(brief.lines().any(|line| line == more), "{brief}");
        assert!(brief.lines().count() <= 25, "{brief}");
    }
}

/// However much is found, result, verdict, findings and what was read fit a screen; of few findings everything is said.
#[test]
fn law_the_opening_of_a_terminal_fits_a_screen() {
    assert_eq!(DOUBTS.len(), 1);
    let kinds = [
        "a", "b", "c", "d", "e", "f", "g", "h", "i", "j", "k", "l", "m", "n",
    ];
    let report = |count: usize| {
        let findings = kinds[..count].iter().enumerate().map(|(n, kind)| {
            let severity = [Severity::Note, Severity::Warning, Severity::Decision][n % 3];
            doubt(n as f64).at(severity).of_part(kind)
        });
        Report::new("Noise of a sensor")
            .verdict("The noise is known.")
            .answers((0..6).map(|n| KeyFigure::new(format!("N {n}"), "1.0 ± 0.1", "m/s²")))
            .meta("Read", "a.csv: columns 1, 2, 3 in g by the heading; 100 Hz by column 1 time in s by the heading")
            .meta("Model", "ADXL355")
            .meta("Evaluated on", "2026-01-01")
            .findings(findings)
    };
    for (count, width) in [(0, 100), (1, 100), (3, 100), (7, 100), (14, 100), (14, 60)] {
        let options = terminal::Options {
            width,
            colour: false,
            filed: true,
            details: true,
        };
        let text = terminal::render(&report(count), &options).expect("text");
        assert!(text.lines().count() <= 25, "{count} of {width}:\n{text}");
        assert!(text.lines().all(|l| l.chars().count() <= width), "{text}");
        assert!(text.contains("The noise is known."), "{text}");
        assert!(
            text.contains("Model  ADXL355 · Evaluated on  2026-01-01"),
            "{text}"
        );
    }
    let options = terminal::Options {
        width: 100,
        colour: false,
        filed: true,
        details: true,
    };
    let few = terminal::render(&report(3), &options).expect("text");
    assert!(few.contains("do what has to be done"), "{few}");
}
