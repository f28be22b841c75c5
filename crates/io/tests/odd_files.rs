//! Files whose headings say too little: a refusal where two readings are plausible, else the right number with the assumption.

use proofmass_io::{
    ColumnRef, DecimalMark, Error, Layout, LayoutOptions, Recording, RecordingOptions, SaidBy,
    Source, TimeUnit, Unit, inspect_source,
};

/// Rows at 100 Hz with a column of times as `stamp` writes it, and gravity along z.
fn text(heading: &str, stamp: impl Fn(u64) -> String, gravity: f64) -> String {
    let rows = (0..400).map(|i| {
        let wobble = f64::from((i * 7919 % 13) as u32) * 1e-3;
        format!("{},{wobble},{},{}\n", stamp(i), -wobble, gravity + wobble)
    });
    format!("{heading}\n{}", rows.collect::<String>())
}

fn read(text: &str, change: impl FnOnce(&mut RecordingOptions)) -> Result<Recording, Error> {
    let mut options = RecordingOptions {
        columns: vec!["ax".into(), "ay".into(), "az".into()],
        ..RecordingOptions::default()
    };
    change(&mut options);
    Recording::from_source(Source::from_bytes("odd.csv", text.to_owned())?, &options)
}

#[test]
fn whole_stamps_are_never_seconds_at_an_absurd_rate() {
    for (step, unit, word) in [
        (10, TimeUnit::Millisecond, "ms"),
        (10_000, TimeUnit::Microsecond, "us"),
        (10_000_000, TimeUnit::Nanosecond, "ns"),
    ] {
        let text = text("timestamp,ax,ay,az", |i| (step * i).to_string(), 9.81);
        let refused = read(&text, |_| {}).unwrap_err();
        assert_eq!(refused.field(), Some("timestamp"));
        let hint = refused.hint().unwrap();
        assert!(hint.contains(&format!("--time-unit {word} ")), "{hint}");
        // Said, it is the right rate, and the reading tells who said it.
        let said = read(&text, |o| o.time_unit = Some(unit)).unwrap();
        assert!((said.time.rate_hz() - 100.0).abs() < 1e-6);
        assert_eq!(said.reading().time.by, SaidBy::Person);
        // A look at the file does not refuse; it asks.
        let source = Source::from_bytes("odd.csv", text).unwrap();
        let seen = inspect_source(source, &RecordingOptions::default(), 10).unwrap();
        let time = seen.time.unwrap();
        assert_eq!(time.unit, unit);
        assert!((time.rate_hz - 100.0).abs() < 1e-6);
        assert!(seen.findings.iter().any(|f| f.code() == "time-unit-open"));
    }
}

#[test]
fn what_is_plain_is_assumed_and_told() {
    let since_1970 = |i: u64| (1_700_000_000_000 + 10 * i).to_string();
    let days = |i: u64| format!("{:.11}", 45_000.123 + i as f64 * 0.01 / 86_400.0);
    let seconds = |i: u64| format!("{:.2}", i as f64 / 100.0);
    let stamps: [(&dyn Fn(u64) -> String, TimeUnit); 3] = [
        (&since_1970, TimeUnit::Millisecond),
        (&days, TimeUnit::Day),
        (&seconds, TimeUnit::Second),
    ];
    for (stamp, unit) in stamps {
        let read = read(&text("t,ax,ay,az", stamp, 9.81), |_| {}).unwrap();
        // Days of eleven decimals have a resolution of 0.9 µs.
        assert!((read.time.rate_hz() / 100.0 - 1.0).abs() < 1e-6, "{unit}");
        assert_eq!(read.reading().time.unit, Some(unit));
        assert_eq!(read.reading().time.by, SaidBy::Nobody);
        let told = |f: &proofmass_uncertainty::Finding| f.code() == "time-unit-assumed";
        assert!(read.findings().iter().any(told));
        let input = read.input().reading.unwrap().line("odd.csv");
        assert!(input.contains(&format!("in {unit} assumed")), "{input}");
    }
}

#[test]
fn slow_seconds_since_1970_are_likely_and_counted_rows_are_offered() {
    let slow = |i: u64| (1_700_000_000 + 10 * i).to_string();
    let refused = read(&text("timestamp,ax,ay,az", slow, 9.81), |_| {}).unwrap_err();
    let hint = refused.hint().unwrap();
    assert!(
        hint.contains("likely it is s: say --time-unit s "),
        "{hint}"
    );
    for first in [0, 1] {
        let counted = |missing: u64| {
            let count = move |i: u64| (first + i + missing * (i / 200)).to_string();
            text("t,ax,ay,az", count, 9.81)
        };
        let refused = read(&counted(0), |_| {}).unwrap_err();
        let hint = refused.hint().unwrap();
        assert!(
            hint.starts_with("they may count the rows: say --time-unit index "),
            "{hint}"
        );
        assert!(hint.contains("1 kHz as ms, 1 Hz as s"), "{hint}");
        // The rate beside it leaves out no row in the middle.
        let said = read(&counted(1), |o| {
            o.time_unit = Some(TimeUnit::Index);
            o.sampling_rate_hz = Some(100.0);
        });
        let said = said.unwrap();
        assert!((said.time.rate_hz() - 100.0).abs() < 1e-6);
        assert_eq!(said.time.gaps().len(), 1);
    }
}

#[test]
fn a_clock_that_is_put_forward_is_named() {
    let told = |pause: u64| {
        let stamp = |i: u64| format!("{:.2}", (i + pause * (i / 200)) as f64 / 100.0);
        let read = read(&text("t_s,ax,ay,az", stamp, 9.81), |_| {}).unwrap();
        assert!((read.time.rate_hz() / 100.0 - 1.0).abs() < 1e-6);
        let codes = read.findings().iter().map(|f| f.code().to_owned());
        codes.collect::<Vec<_>>()
    };
    assert_eq!(told(360_000), ["clock-put-forward"]);
    // Half an hour is a gap.
    assert_eq!(told(180_000), ["gaps-in-record"]);
}

#[test]
fn a_title_and_a_count_above_one_column_are_no_heading() {
    let rows: String = (0..400)
        .map(|k| format!("{:.2E}\n", 1e-7 * f64::from(k % 17 + 1)))
        .collect();
    let text = format!("test motion\n4684 0.0100\n{rows}");
    let mut source = Source::from_bytes("motion.txt", text.clone()).unwrap();
    let layout = Layout::of(&mut source, &LayoutOptions::default()).unwrap();
    assert_eq!((layout.columns, layout.header.as_deref()), (1, None));
    let column = |rate: Option<f64>| {
        let options = RecordingOptions {
            columns: vec![1.into()],
            sampling_rate_hz: rate,
            ..RecordingOptions::default()
        };
        Recording::from_source(
            Source::from_bytes("motion.txt", text.clone()).unwrap(),
            &options,
        )
    };
    let asked = column(None).unwrap_err();
    let hint = asked.hint().unwrap();
    assert!(
        hint.contains("\"4684 0.0100\" in line 2 ") && hint.contains("--rate 100 "),
        "{hint}"
    );
    assert_eq!(column(Some(100.0)).unwrap().samples(), 400);
}

#[test]
fn marks_of_thousands_beside_decimals_are_called_so() {
    let row = "0.01;1,021.13;39.81;44.31\n";
    let text = format!("t_s;ax;ay;az\n{}", row.repeat(20));
    let refused = read(&text, |_| {}).unwrap_err();
    assert!(
        refused
            .to_string()
            .contains("\"1,021.13\" has marks of thousands"),
        "{refused}"
    );
}

#[test]
fn a_clock_that_stands_still_is_named() {
    let refused = read(&text("t,ax,ay,az", |_| "12.5".into(), 9.81), |_| {}).unwrap_err();
    assert!(refused.to_string().contains("stands still"), "{refused}");
}

#[test]
fn headings_that_are_not_as_many_as_columns_are_refused() {
    let text = "t,ax,ay,az,gx\n".to_owned() + &"0.01,1,2,3\n".repeat(20);
    let refused = read(&text, |_| {}).unwrap_err();
    assert!(
        refused
            .to_string()
            .contains("5 headings stand above 4 columns"),
        "{refused}"
    );
}

#[test]
fn mixed_marks_are_refused_with_their_line() {
    let row = "0,01;0,5;0,25;9,75\n";
    let text = format!("t;ax;ay;az\n{}0,02;1.234;0,25;9,75\n", row.repeat(20));
    let refused = read(&text, |o| o.layout.decimal = Some(DecimalMark::Comma)).unwrap_err();
    assert_eq!(refused.line_number(), Some(22));
    assert!(refused.to_string().contains("has a point"), "{refused}");
}

#[test]
fn columns_with_another_decimal_mark_are_no_text() {
    let layout = |text: &str| {
        let mut source = Source::from_bytes("odd.csv", text.to_owned()).unwrap();
        Layout::of(&mut source, &LayoutOptions::default()).unwrap()
    };
    let mixed = format!("t;x;y;label\n{}", "0.01;9,8229;0.5;a,b\n".repeat(20));
    let refused = layout(&mixed).refuse_mixed_marks().unwrap_err();
    assert!(
        refused
            .to_string()
            .contains("the decimal mark of x is the comma"),
        "{refused}"
    );
    // One mark, and columns of words, dates and whole numbers.
    for row in [
        "0.01;9.8229;0.5;a,b\n",
        "2026-03-01T12:00:00.25;9;0.5;1.2.3\n",
        "0,01;9,8229;0,5;a.b\n",
    ] {
        let text = format!("t;x;y;label\n{}", row.repeat(20));
        layout(&text).refuse_mixed_marks().unwrap();
    }
}

#[test]
fn the_likely_unit_is_that_of_the_norm() {
    for (gravity, unit) in [
        (9.81, Unit::MetrePerSecondSquared),
        (1.0, Unit::StandardGravity),
        (1000.0, Unit::MilliGravity),
    ] {
        let text = text(
            "t,ax,ay,az",
            |i| format!("{:.2}", i as f64 / 100.0),
            gravity,
        );
        let mut source = Source::from_bytes("odd.csv", text).unwrap();
        let layout = Layout::of(&mut source, &LayoutOptions::default()).unwrap();
        assert_eq!(layout.likely_unit(&[1, 2, 3]), Some(unit));
        let asked = layout.ask_unit(&[1, 2, 3]);
        assert!(asked.hint().unwrap().contains(unit.ascii()));
    }
}

/// A force of 9.87 N in root mean square is no gravity, and 1024 counts are no 1024 mg.
#[test]
fn gravity_is_likely_where_an_acceleration_is_named() {
    let layout = |heading: &str, gravity: f64| {
        let stamp = |i: u64| format!("{:.2}", i as f64 / 100.0);
        let mut source = Source::from_bytes("odd.csv", text(heading, stamp, gravity)).unwrap();
        Layout::of(&mut source, &LayoutOptions::default()).unwrap()
    };
    for (name, unit) in [
        ("az", Some(Unit::MetrePerSecondSquared)),
        ("acc 1", Some(Unit::MetrePerSecondSquared)),
        ("force", Some(Unit::Newton)),
        ("Load cell", Some(Unit::Newton)),
        ("light", None),
    ] {
        let layout = layout(&format!("t,p,q,{name}"), 9.87);
        assert_eq!(layout.likely_unit(&[3]), unit, "{name}");
    }
    let rows = |gravity: u32| {
        format!(
            "t_s,ax,ay,az\n{}",
            format!("0.01,1,-2,{gravity}\n").repeat(40)
        )
    };
    for (gravity, unit) in [
        (1000, Some(Unit::MilliGravity)),
        (1024, None),
        (4096, Some(Unit::Count)),
    ] {
        let mut source = Source::from_bytes("odd.csv", rows(gravity)).unwrap();
        let layout = Layout::of(&mut source, &LayoutOptions::default()).unwrap();
        assert_eq!(layout.likely_unit(&[1, 2, 3]), unit, "{gravity}");
    }
}

#[test]
fn a_stretch_is_read_and_damage_outside_of_it_is_not() {
    let mut text = text("t,ax,ay,az", |i| format!("{:.2}", i as f64 / 100.0), 9.81);
    text += "4.00,broken,0,9.81\n";
    assert!(read(&text, |_| {}).is_err());
    let cut = read(&text, |o| o.between = Some([1.0, 2.0])).unwrap();
    assert_eq!(cut.samples(), 100);
    assert_eq!((cut.time.seconds(0), cut.line(0)), (1.0, 102));
    assert_eq!(cut.reading().between_s, Some([1.0, 2.0]));
    let by_rate = read(&text, |o| {
        o.sampling_rate_hz = Some(100.0);
        o.between = Some([1.0, 2.0]);
    });
    assert_eq!(by_rate.unwrap().samples(), 100);
    let nothing = read(&text, |o| o.between = Some([7.0, 8.0])).unwrap_err();
    assert!(nothing.to_string().contains("no row lies"), "{nothing}");
}

#[test]
fn temperatures_become_degrees_celsius() {
    // The same 20 °C; the last two may be in another unit.
    for (heading, number, told) in [
        ("T_degC", 20.0, Some("in °C by the heading")),
        ("T (°F)", 68.0, Some("in °F by the heading")),
        ("temperature fahrenheit", 68.0, Some("in °F by the heading")),
        ("T_K", 293.15, Some("in K by the heading")),
        ("T", 20.0, Some("in °C assumed")),
        ("T", 68.0, None),
        ("T", 293.15, None),
    ] {
        let rows = (0..50).map(|i| format!("{:.2},0.1,0.2,9.8,{number}\n", f64::from(i) / 100.0));
        let text = format!("t_s,ax,ay,az,{heading}\n{}", rows.collect::<String>());
        let read = read(&text, |o| o.temperature = Some(5.into()));
        let Some(told) = told else {
            let refused = read.unwrap_err();
            assert!(
                refused.hint().unwrap().contains("T_degC or T_K"),
                "{refused}"
            );
            continue;
        };
        let read = read.unwrap();
        let temperature = read.temperature.as_ref().unwrap();
        assert_eq!(temperature.unit, Some(Unit::DegreeCelsius));
        assert!((temperature.data[7] - 20.0).abs() < 1e-12, "{heading}");
        let line = read.reading().to_string();
        assert!(line.contains(told), "{line}");
    }
}

#[test]
fn units_that_nobody_says_are_asked_for_together() {
    let text = text(
        "t_s,force,ay,az",
        |i| format!("{:.2}", i as f64 / 100.0),
        1000.0,
    );
    let mut recording = read(&text, |o| o.columns = vec!["force".into(), "az".into()]).unwrap();
    let asked = recording
        .need_units(&["--input-unit", "--output-unit"])
        .unwrap_err();
    let hint = asked.hint().unwrap();
    assert!(hint.contains("--input-unit N --output-unit mg"), "{hint}");
    recording
        .state_unit(0, Some(Unit::Newton), SaidBy::Person)
        .unwrap();
    let asked = recording
        .need_units(&["--input-unit", "--output-unit"])
        .unwrap_err();
    assert!(
        asked.to_string().contains("the unit of az is not said"),
        "{asked}"
    );
    recording
        .state_unit(1, Some(Unit::MilliGravity), SaidBy::Person)
        .unwrap();
    recording
        .need_units(&["--input-unit", "--output-unit"])
        .unwrap();
    // A heading that is a unit says it, and a person who says another one is told so.
    let volts = text.replacen("az", "mV", 1);
    let mut recording = read(&volts, |o| o.columns = vec!["mV".into()]).unwrap();
    assert_eq!(recording.columns[0].unit, Some(Unit::Millivolt));
    let refused = recording
        .state_unit(0, Some(Unit::Count), SaidBy::Person)
        .unwrap_err();
    assert!(
        refused
            .to_string()
            .contains("the heading says mV, count is stated")
    );
}

#[test]
fn an_accelerometer_among_other_columns_is_seen() {
    let text = text(
        "t_s,ax,ay,az",
        |i| format!("{:.2},0.3", i as f64 / 100.0),
        9.81,
    );
    let text = text.replacen("t_s,", "t_s,battery,", 1);
    let mut source = Source::from_bytes("odd.csv", text).unwrap();
    let layout = Layout::of(&mut source, &LayoutOptions::default()).unwrap();
    assert_eq!(
        layout.likely_unit(&[1, 2, 3, 4]),
        Some(Unit::MetrePerSecondSquared)
    );
}

#[test]
fn a_clock_is_seen_whatever_it_is_called() {
    let seconds = |i: u64| format!("{:.2}", i as f64 / 100.0);
    let date = |i: u64| format!("2026-03-01T12:00:{:02}.{:02}", i / 100, i % 100);
    let called: [(&str, &dyn Fn(u64) -> String); 5] = [
        ("Zeit (s)", &seconds),
        ("temps [s]", &seconds),
        ("Laufzeit_s", &seconds),
        ("Date", &date),
        ("Aufgenommen", &date),
    ];
    for (heading, stamp) in called {
        let heading = format!("{heading},ax,ay,az");
        let recording = read(&text(&heading, stamp, 9.81), |_| {}).unwrap();
        assert!((recording.time.rate_hz() - 100.0).abs() < 1e-6, "{heading}");
    }
    // Temperatures that rise are no times, nor is a unit of time that falls.
    for (heading, number) in [
        ("temps", &seconds as &dyn Fn(u64) -> String),
        ("left_s", &|i| format!("{}", 400 - i)),
    ] {
        let heading = format!("{heading},ax,ay,az");
        let refused = read(&text(&heading, number, 9.81), |_| {}).unwrap_err();
        assert!(
            refused.to_string().contains("neither a time column"),
            "{refused}"
        );
    }
}

/// One column of numbers from a text, and what was found about its shape.
fn one_column(text: &str, options: LayoutOptions) -> Result<(Vec<f64>, Vec<String>), Error> {
    let options = RecordingOptions {
        layout: options,
        columns: vec![ColumnRef::Index(1)],
        sampling_rate_hz: Some(100.0),
        ..RecordingOptions::default()
    };
    let recording = Recording::from_source(Source::from_bytes("a.csv", text)?, &options)?;
    let codes = recording.findings().iter().map(|f| f.code().to_owned());
    Ok((recording.columns[0].data.clone(), codes.collect()))
}

/// Fractions about 9.8 with a decimal comma, some of which begin with a zero.
fn commas(from: u32, rows: u32) -> String {
    (0..rows)
        .map(|k| format!("9,{:05}\n", from + 37 * k))
        .collect()
}

#[test]
fn law_the_one_comma_of_a_row_is_the_mark_that_the_rows_tell() {
    let first = |text: &str| one_column(text, LayoutOptions::default()).map(|r| r.0[0]);
    // Zeros begin fractions, not whole numbers.
    assert_eq!(first(&commas(50, 40)).unwrap(), 9.0005);
    // A heading without a comma is that of one column.
    assert_eq!(
        first(&format!("a [m/s2]\n{}", commas(78394, 40))).unwrap(),
        9.78394
    );
    // Without one nobody knows.
    let error = first(&commas(78394, 40)).unwrap_err();
    assert!(
        error.to_string().contains("not known whether the comma"),
        "{error}"
    );
    assert!(error.hint().unwrap().contains("--decimal comma"));
    for (decimal, value) in [(DecimalMark::Comma, 9.78394), (DecimalMark::Point, 9.0)] {
        let said = LayoutOptions {
            decimal: Some(decimal),
            ..LayoutOptions::default()
        };
        assert_eq!(one_column(&commas(78394, 40), said).unwrap().0[0], value);
    }
    // Two columns of whole numbers stay two: by the comma of their heading, a sign, the many that begin with no zero, a rising count.
    let whole = |k: u32| format!("{},{}\n", 512 + k % 7, 100 + 97 * k % 900);
    let rows: String = (0..150).map(whole).collect();
    assert_eq!(first(&rows).unwrap(), 512.0);
    assert_eq!(first("x,y\n512,498\n511,500\n").unwrap(), 512.0);
    assert_eq!(first("512,-498\n511,500\n513,501\n").unwrap(), 512.0);
    assert_eq!(first("0,498\n1,500\n2,501\n3,505\n").unwrap(), 0.0);
}

/// A word or a clock beside a decimal comma does not make the comma a separator.
#[test]
fn regress_a_decimal_comma_beside_one_other_column() {
    for (before, separator) in [
        ("OK", ';'),
        ("10:00:00.000", ';'),
        ("2024-03-01 10:00:00", ';'),
        ("01.03.2024 10:00:00,000", ';'),
        ("OK", '\t'),
    ] {
        let row = |k: u32| format!("{before}{separator}9,{:05}\n", 78394 + k);
        let text: String = (0..30).map(row).collect();
        let options = RecordingOptions {
            columns: vec![ColumnRef::Index(2)],
            sampling_rate_hz: Some(100.0),
            ..RecordingOptions::default()
        };
        let source = Source::from_bytes("a.csv", text).unwrap();
        let read = Recording::from_source(source, &options).unwrap();
        assert_eq!(read.columns[0].data[0], 9.78394, "{before}{separator}");
    }
}

/// How many rows, their interval, the rate: numbers above the data are none of it, and that is said.
#[test]
fn law_numbers_above_the_data_are_passed_over_and_told() {
    let rows: String = (0..40).map(|k| format!("0.{:04}\n", 13 * k + 1)).collect();
    for above in ["40", "4684 0.0100", "100 Hz"] {
        let (data, codes) =
            one_column(&format!("{above}\n{rows}"), LayoutOptions::default()).unwrap();
        assert_eq!((data.len(), data[0]), (40, 0.0001), "{above}");
        assert!(
            codes.iter().any(|c| c == "preamble-skipped"),
            "{above}: {codes:?}"
        );
    }
    // A whole number among fractions is a sample where it is of their size.
    let rows = rows.replace("0.", "9.");
    let (data, codes) = one_column(&format!("10\n{rows}"), LayoutOptions::default()).unwrap();
    assert_eq!((data.len(), codes.len()), (41, 0));
}
