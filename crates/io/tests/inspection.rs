//! What `inspect` says of a recording, against numbers computed otherwise.

use proofmass_io::{Inspection, Statistics, inspect};

fn inspected(text: &str) -> Inspection {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.csv");
    std::fs::write(&path, text).unwrap();
    inspect(&path).unwrap_or_else(|e| panic!("{e}"))
}

/// NIST StRD, univariate summary statistics, "NumAcc3": 1 000 000.2 once, then 500 times each 1 000 000.1 and
/// 1 000 000.3; certified mean 1 000 000.2 and standard deviation 0.1.
///
/// A number of that size in binary is off by up to 2⁻³⁴ ≈ 5.8e-11, which bounds the error of the mean and, against
/// a deviation of 0.1, that of the standard deviation.
#[test]
fn published_numacc3_mean_and_standard_deviation() {
    let mut text = String::from("1000000.2\n");
    for _ in 0..500 {
        text.push_str("1000000.1\n1000000.3\n");
    }
    let i = inspected(&format!("value,one\n{}", text.replace('\n', ",1\n")));
    let s = i.columns[0].statistics.unwrap();
    assert_eq!((s.count, s.distinct), (1001, Some(3)));
    assert!((s.mean - 1_000_000.2).abs() < 2e-10, "{}", s.mean);
    let deviation = s.standard_deviation.unwrap();
    assert!((deviation - 0.1).abs() < 1.2e-10, "{deviation}");
    assert!((s.resolution.unwrap() - 0.1).abs() < 2e-10);
}

#[test]
fn statistics_of_small_columns() {
    // 2, 4, 4, 4, 5, 5, 7, 9: sum 40, squares about the mean 32, so s² = 32/7.
    let text: String = [2, 4, 4, 4, 5, 5, 7, 9]
        .iter()
        .map(|v| format!("{v},-0.0,still\n"))
        .collect();
    let i = inspected(&format!("a_g,b,label\n{text}"));
    assert_eq!((i.rows, i.bad_count), (8, 0));
    let a = &i.columns[0];
    assert_eq!((a.name.as_str(), a.number), ("a", 1));
    assert_eq!(a.unit.unwrap().to_string(), "g");
    let s = a.statistics.unwrap();
    assert_eq!(
        s,
        Statistics {
            count: 8,
            min: 2.0,
            max: 9.0,
            mean: 5.0,
            standard_deviation: s.standard_deviation,
            distinct: Some(5),
            resolution: Some(1.0),
        }
    );
    assert!((s.standard_deviation.unwrap() - (32.0_f64 / 7.0).sqrt()).abs() < 1e-15);
    let zeros = i.columns[1].statistics.unwrap();
    assert_eq!((zeros.distinct, zeros.resolution), (Some(1), None));
    assert_eq!(i.columns[2].statistics, None);
}

#[test]
fn times_gaps_and_steps_backwards() {
    // 10 ms steps, then one of 50 ms after line 4, a repeated time on line 7 and a restart on line 9.
    let i = inspected("t (ms),a\n0,1\n10,1\n20,1\n70,1\n80,1\n80,1\n90,1\n5,1\n15,1\n");
    let t = i.time.unwrap();
    assert_eq!(t.column, "t");
    assert!((t.rate_hz - 100.0).abs() < 1e-9, "{}", t.rate_hz);
    assert_eq!((t.gap_count, t.gaps.len()), (1, 1));
    let gap = t.gaps[0];
    assert_eq!((gap.after_sample, gap.line), (2, 4));
    assert!((gap.at_s - 0.02).abs() < 1e-12 && (gap.step_s - 0.05).abs() < 1e-12);
    assert_eq!(t.backward_lines, [7, 9]);

    // Steps of 9 and 11 ms in turn: about the median of 10 ms, s = sqrt(n/(n−1)) ms for an even number n of steps.
    let mut text = String::from("time_s,a\n");
    let mut ms = 0;
    for i in 0..=1000 {
        text.push_str(&format!("{:.3},0\n", f64::from(ms) * 1e-3));
        ms += if i % 2 == 0 { 9 } else { 11 };
    }
    let t = inspected(&text).time.unwrap();
    let expected = 1e-3 * (1000.0_f64 / 999.0).sqrt();
    assert!((t.jitter_s.unwrap() - expected).abs() < 1e-12, "{t:?}");
    assert!((t.duration_s - 10.01).abs() < 1e-9, "{t:?}");
}

#[test]
fn bad_fields_are_listed_and_left_out_of_the_statistics() {
    let mut text = String::from("t,a,b\n");
    for i in 0..1000 {
        match i {
            10 => text.push_str("10,,1\n"),
            20 => text.push_str("20,2,nan\n"),
            30 => text.push_str("30,oops,-inf\n"),
            _ => text.push_str(&format!("{i},2,{}\n", i % 3)),
        }
    }
    let i = inspected(&text);
    let listed: Vec<_> = i
        .bad
        .iter()
        .map(|b| (b.line, b.column.as_str(), b.text.as_str()))
        .collect();
    assert_eq!(
        listed,
        [
            (12, "a", ""),
            (22, "b", "nan"),
            (32, "a", "oops"),
            (32, "b", "-inf")
        ]
    );
    assert_eq!((i.rows, i.bad_count), (1000, 4));
    let a = i.columns[1].statistics.unwrap();
    assert_eq!(
        (a.count, a.mean, a.standard_deviation),
        (998, 2.0, Some(0.0))
    );
    // Of 0, 1, 2 in turn over 1000 rows: 334, 333, 333; row 10 stays (1), rows 20 (2) and 30 (0) are lost.
    let b = i.columns[2].statistics.unwrap();
    assert_eq!(b.count, 998);
    let mean = f64::from(333 + 2 * 332) / 998.0;
    assert!((b.mean - mean).abs() < 1e-14, "{} {mean}", b.mean);

    // More than a hundred are counted but not listed.
    let many = format!("a,b\n{}", "x,1\n1,1\n2,1\n".repeat(150));
    let i = inspected(&many);
    assert_eq!((i.bad.len(), i.bad_count), (100, 150));
}

#[test]
fn regress_rows_of_another_width_are_listed_and_left_out() {
    let mut text = String::from("t,a,b\n");
    for i in 0..5000 {
        match i {
            10 => text.push_str("10,1\n"),
            20 => text.push_str("20,1,2,3\n"),
            4000 => text.push_str("4000,12000,1\nlost\n"),
            _ => text.push_str(&format!("{i},{},1\n", i % 5)),
        }
    }
    let i = inspected(&text);
    let listed: Vec<_> = i.bad_rows.iter().map(|b| (b.line, b.fields)).collect();
    assert_eq!(listed, [(12, 2), (22, 4), (4003, 1)]);
    assert_eq!((i.rows, i.bad_row_count), (4998, 3));
    assert_eq!(i.bad_rows[2].text, "lost");
    // Recordings are refused at the first of them.
    let source = proofmass_io::Source::from_bytes("r", text).unwrap();
    let options = proofmass_io::RecordingOptions {
        columns: vec!["a".into()],
        time_unit: Some(proofmass_io::TimeUnit::Second),
        ..Default::default()
    };
    let error = proofmass_io::Recording::from_source(source, &options).unwrap_err();
    assert_eq!(error.line_number(), Some(12));
}
