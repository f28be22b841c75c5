//! Every kind of bad recording gives one message that names place and remedy.

use proofmass_io::{ColumnRef, ErrorKind, LayoutOptions, Recording, RecordingOptions};
use std::fmt::Write;
use std::path::PathBuf;

fn file(name: &str, bytes: impl AsRef<[u8]>) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

fn options(columns: &[&str]) -> RecordingOptions {
    RecordingOptions {
        columns: columns.iter().map(|w| ColumnRef::from_word(w)).collect(),
        ..RecordingOptions::default()
    }
}

fn refused(bytes: impl AsRef<[u8]>, options: &RecordingOptions) -> proofmass_io::Error {
    let (_folder, path) = file("r.csv", bytes);
    let error = Recording::read(&path, options).expect_err("must be refused");
    assert!(error.path().is_some(), "{error}");
    assert!(error.hint().is_some(), "{error}");
    assert!(!error.to_string().contains('\n'), "{error}");
    error
}

fn xyz() -> RecordingOptions {
    options(&["x", "y", "z"])
}

#[test]
fn refuses_files_without_rows() {
    for (text, word) in [
        ("", "empty"),
        ("\n\n", "empty"),
        ("t,x,y,z\n", "no row"),
        ("# only a comment\n", "no rows"),
        ("t,x,y,z\n0,1,2,3\n", "1 row"),
    ] {
        let error = refused(text, &xyz());
        assert!(error.to_string().contains(word), "{text:?}: {error}");
        assert_eq!(error.kind(), ErrorKind::Format);
    }
}

#[test]
fn refuses_what_is_no_text_file() {
    let error = refused(b"t,x\n\x00\x01\x02\x03", &xyz());
    assert!(error.to_string().contains("binary"), "{error}");
    let unmarked: Vec<u8> = "t,x\n0,1\n1,2\n"
        .repeat(20)
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    let error = refused(unmarked, &xyz());
    assert!(
        error
            .to_string()
            .contains("UTF-16 without a byte order mark"),
        "{error}"
    );
    let error = refused("1,".repeat(3_000_000), &xyz());
    assert!(error.to_string().contains("longer than 4 MiB"), "{error}");
    let folder = tempfile::tempdir().unwrap();
    let error = Recording::read(folder.path(), &xyz()).unwrap_err();
    assert!(error.to_string().contains("folder"), "{error}");
    let error = Recording::read(&folder.path().join("none.csv"), &xyz()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::NotFound);
}

fn long(rows: usize, bad_row: usize, bad: &str) -> String {
    let mut text = String::from("t,x,y,z\n");
    for i in 1..=rows {
        if i == bad_row {
            writeln!(text, "{bad}").unwrap();
        } else {
            writeln!(text, "{:.2},0.{},0.02,9.81", i as f64 * 0.01, i % 100).unwrap();
        }
    }
    text
}

#[test]
fn refuses_bad_fields_by_line_and_column() {
    for (bad, column, word) in [
        ("700.00,nan,1,1", "x", "\"nan\" is not a finite"),
        ("700.00,1,-Inf,1", "y", "\"-Inf\" is not a finite"),
        (
            "700.00,1,1,1e999",
            "z",
            "\"1e999\" is too large for a reading",
        ),
        ("700.00,1,1,12abc", "z", "\"12abc\" is not a number"),
        ("700.00,,1,1", "x", "empty"),
        ("700.00,1,1,", "z", "empty"),
    ] {
        let error = refused(long(80_000, 70_000, bad), &xyz());
        assert_eq!(error.kind(), ErrorKind::Field, "{error}");
        assert_eq!(error.line_number(), Some(70_001), "{error}");
        assert_eq!(error.field(), Some(column), "{error}");
        assert!(error.to_string().contains(word), "{error}");
        assert!(
            error
                .to_string()
                .contains(&format!("r.csv:70001: column \"{column}\": ")),
            "{error}"
        );
    }
}

#[test]
fn refuses_a_row_of_another_width() {
    for bad in ["700.00,1,1", "700.00,1,1,1,1", "700.00", "700.00,1,1,1,,"] {
        let error = refused(long(80_000, 70_000, bad), &xyz());
        assert_eq!(error.kind(), ErrorKind::Row, "{bad}: {error}");
        assert_eq!(error.line_number(), Some(70_001), "{error}");
    }
    // A short first row is not taken for a preamble.
    let mut o = options(&["2", "3", "4"]);
    o.sampling_rate_hz = Some(10.0);
    let error = refused("1,2,3\n0,1,2,3\n1,1,2,3\n", &o);
    assert_eq!(
        (error.kind(), error.line_number()),
        (ErrorKind::Row, Some(1))
    );
}

/// The columns 3, 5 and 7 would be digits behind the comma, with headings that are none above them.
#[test]
fn refuses_a_comma_that_is_separator_and_decimal_mark() {
    let mut text = "t,x,y,z\n".to_owned();
    for i in 0..50 {
        writeln!(
            text,
            "0,{i:02},9,{:02},-0,{:02},0,31",
            80 + i % 7,
            10 + i % 5
        )
        .unwrap();
    }
    let error = refused(text, &options(&["3", "5", "7"]));
    assert_eq!(error.line_number(), Some(1));
    assert!(
        error
            .to_string()
            .contains("separator and decimal mark at once"),
        "{error}"
    );
    // Words above columns of other numbers are no headings, and passed over.
    let (_folder, path) = file(
        "r.csv",
        "bench,3\n0.00,1.5,1,2\n0.01,1.5,1,2\n0.02,1.5,1,2\n",
    );
    let mut timed = options(&["2", "3", "4"]);
    timed.sampling_rate_hz = Some(100.0);
    Recording::read(&path, &timed).unwrap();
}

#[test]
fn refuses_time_that_does_not_run_forward() {
    let error = refused("t,x,y,z\n0,1,1,1\n0.01,1,1,1\n# note\n0.01,1,1,1\n", &xyz());
    assert_eq!(
        (error.kind(), error.line_number(), error.field()),
        (ErrorKind::Time, Some(5), Some("t"))
    );
    assert!(error.to_string().contains("repeats"), "{error}");
    let error = refused("t,x,y,z\n0,1,1,1\n0.01,1,1,1\n0.005,1,1,1\n", &xyz());
    assert_eq!(
        (error.kind(), error.line_number()),
        (ErrorKind::Time, Some(4))
    );
    assert!(error.to_string().contains("backwards"), "{error}");
    let error = refused("a,x,y,z\n0,1,1,1\n0.01,1,1,1\n", &xyz());
    assert!(
        error.hint().unwrap().contains("sampling_rate_Hz"),
        "{error}"
    );
}

#[test]
fn refuses_columns_that_are_not_there_or_twice() {
    let text = "t,acc_x,acc_y,acc_z\n0,1,1,1\n0.01,1,1,1\n";
    let error = refused(text, &options(&["acc_x", "ac_y", "acc_z"]));
    assert!(
        error.hint().unwrap().contains("did you mean \"acc_y\""),
        "{error}"
    );
    let error = refused(text, &options(&["2", "3", "9"]));
    assert!(error.to_string().contains("no column 9"), "{error}");
    let error = refused(text, &options(&["acc_x", "acc_x", "acc_z"]));
    assert!(error.to_string().contains("twice"), "{error}");
    let error = refused("0 1 1 1\n0.01 1 1 1\n", &xyz());
    assert!(error.to_string().contains("no header"), "{error}");
    let error = refused("t,x,x,z\n0,1,1,1\n0.01,1,1,1\n", &xyz());
    assert!(error.to_string().contains("2 times"), "{error}");
}

#[test]
fn refuses_a_unit_against_the_heading() {
    let mut o = xyz();
    o.unit = Some(proofmass_io::Unit::MetrePerSecondSquared);
    let error = refused("t,x (g),y (g),z (g)\n0,1,1,1\n0.01,1,1,1\n", &o);
    assert!(
        error
            .to_string()
            .contains("the heading says g, m/s² is stated"),
        "{error}"
    );
}

#[test]
fn refuses_text_in_the_first_row_with_the_remedy() {
    let mut o = options(&["1", "2"]);
    o.sampling_rate_hz = Some(10.0);
    o.layout = LayoutOptions {
        header: Some(false),
        ..LayoutOptions::default()
    };
    let error = refused("a,b\n1,2\n3,4\n", &o);
    assert_eq!(error.line_number(), Some(1));
    assert!(
        error.hint().unwrap().contains("header = true"),
        "{:?}",
        error.hint()
    );
}

#[test]
fn refuses_a_line_of_more_than_a_mebibyte_wherever_it_stands() {
    let good = "0,1,2,3\n1,1,2,3\n";
    // Of one long line: within a block, across two blocks, at the end of the file; wide or only padded.
    for before in [2, 100_000, 260_000] {
        for long in [
            format!("2,{}3\n", "1,".repeat(700_000)),
            format!("2,1,2,{}3\n", " ".repeat(3 << 19)),
            format!("2,1,2,{}3", " ".repeat(5 << 20)),
        ] {
            let mut text = String::from("t,x,y,z\n");
            for i in 0..before {
                let _ = writeln!(text, "{i},1,2,3");
            }
            let mut o = xyz();
            o.sampling_rate_hz = Some(10.0);
            let error = refused(text + &long + good, &o);
            assert!(
                error.to_string().contains("longer than 1 MiB"),
                "{before}: {error}"
            );
            assert_eq!(error.line_number(), Some(before + 2));
        }
    }
}
