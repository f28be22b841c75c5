use crate::stream::tests::{columns, open, survives};
use crate::{Clock, RemarkKind};

/// A data set 58 of text; the head says type, number of points, spacing, start and step.
fn set(kind: u32, points: usize, even: bool, time: bool, step: f64, data: &str) -> String {
    let (abscissa, unit) = if time { (17, "s") } else { (18, "Hz") };
    format!(
        "    -1\n    58\nan operator\n    -1\n01-Jan-26\nNONE\nNONE\n\
         {:5}{:10}{:5}{:10} {:10}{:10}{:4} {:10}{:10}{:4}\n\
         {kind:10}{points:10}{:10}{:13.5e}{step:13.5e}{:13.5e}\n\
         {abscissa:10}{:5}{:5}{:5} {:20} {unit:20}\n\
         {:10}{:5}{:5}{:5} {:20} {:20}\n\
         {:10}{:5}{:5}{:5} {:20} {:20}\n\
         {:10}{:5}{:5}{:5} {:20} {:20}\n{data}    -1\n",
        if time { 1 } else { 4 },
        0,
        0,
        0,
        "NONE",
        7,
        -3,
        "NONE",
        1,
        1,
        u32::from(even),
        0.0,
        0.0,
        0,
        0,
        0,
        "NONE",
        12,
        0,
        0,
        0,
        "NONE",
        "m/s^2",
        0,
        0,
        0,
        0,
        "NONE",
        if time { "NONE" } else { "N" },
        0,
        0,
        0,
        0,
        "NONE",
        "NONE",
    )
}

/// Lines of numbers in fields of their width; some fill it, so that fields touch.
fn lines(kind: u32, even: bool, rows: &[&[&str]]) -> String {
    let widths: &[usize] = match (kind, even) {
        (2 | 5, _) => &[13],
        (_, true) => &[20],
        (4, false) => &[13, 20],
        _ => &[13, 20, 20],
    };
    let line = |row: &&[&str]| {
        let fields = row.iter().zip(widths.iter().cycle());
        let fields = fields.map(|(word, width)| format!("{word:>width$}"));
        fields.collect::<String>() + "\n"
    };
    rows.iter().map(line).collect()
}

type Case = (
    u32,
    bool,
    &'static [&'static [&'static str]],
    &'static [&'static [f64]],
);

#[test]
fn known_types_even_and_uneven() {
    // Fields that touch, an exponent of D, a −1 in the lines of the head.
    let cases: [Case; 7] = [
        (
            2,
            true,
            &[&["1.00000E+00", "-2.000000D+00"], &["3.00000E+00"]],
            &[&[1.0, -2.0, 3.0]],
        ),
        (
            4,
            true,
            &[
                &["1.250000000000E+00", "-2.5000000000000D+00"],
                &["3.000000000000E+00"],
            ],
            &[&[1.25, -2.5, 3.0]],
        ),
        (
            5,
            true,
            &[
                &["1.00000E+00", "2.00000E+00", "-3.000000E+00"],
                &["4.0E+00", "5.0", "-6.0"],
            ],
            &[&[1.0, -3.0, 5.0], &[2.0, 4.0, -6.0]],
        ),
        (
            6,
            true,
            &[
                &["1.0E+00", "2.0E+00", "-3.0000000000000E+00", "4.0"],
                &["5.0", "-6.0"],
            ],
            &[&[1.0, -3.0, 5.0], &[2.0, 4.0, -6.0]],
        ),
        (
            2,
            false,
            &[&["0.0", "1.0", "1.0E-01", "-2.000000E+00", "3.0E-01", "3.0"]],
            &[&[1.0, -2.0, 3.0], &[0.0, 0.1, 0.3]],
        ),
        (
            4,
            false,
            &[
                &["0.0", "1.0", "1.0E-01", "-2.0000000000000D+00"],
                &["3.0E-01", "3.0"],
            ],
            &[&[1.0, -2.0, 3.0], &[0.0, 0.1, 0.3]],
        ),
        (
            6,
            false,
            &[
                &["0.0", "1.0", "-1.0"],
                &["1.0E-01", "2.0", "-2.0"],
                &["3.0E-01", "3.0", "-3.0"],
            ],
            &[&[1.0, 2.0, 3.0], &[-1.0, -2.0, -3.0], &[0.0, 0.1, 0.3]],
        ),
    ];
    for (kind, even, rows, want) in cases {
        let data = &lines(kind, even, rows);
        let time = !matches!(kind, 5 | 6);
        for line_end in ["\n", "\r\n"] {
            let file = set(kind, 3, even, time, 0.5, data).replace('\n', line_end);
            let container = open(file.as_bytes()).unwrap();
            let stream = &container.streams()[0];
            assert_eq!(
                stream.clock,
                match (time, even) {
                    (true, true) => Clock::Rate {
                        hz: 2.0,
                        start_s: 0.0
                    },
                    (true, false) => Clock::Times,
                    _ => Clock::Unsaid,
                }
            );
            let unit = if time { "m/s^2" } else { "m/s^2/N" };
            assert_eq!(stream.channels[0].unit.as_deref(), Some(unit));
            assert!(
                stream.channels[0].name.contains("7-Z"),
                "{}",
                stream.channels[0].name
            );
            assert!(container.remarks().is_empty(), "{:?}", container.remarks());
            let mut want: Vec<Vec<f64>> = want.iter().map(|column| column.to_vec()).collect();
            if even && !time {
                // Frequencies, which no clock tells.
                want.push((0..want[0].len()).map(|i| 0.5 * i as f64).collect());
            }
            assert_eq!(columns(container, 0), want, "type {kind}, even {even}");
        }
        survives(set(kind, 3, even, time, 0.5, data).as_bytes());
    }
}

#[test]
fn known_binary_sets_beside_text_and_others() {
    let text = set(2, 2, true, true, 0.5, "  1.00000E+00  2.00000E+00\n");
    let binary = |order: u32, numbers: Vec<u8>| {
        let head = format!(
            "    58b{order:6}{:6}{:12}{:12}{:6}{:6}{:12}{:12}",
            2, 11, 8, 0, 0, 0, 0
        );
        let (before, after) = text.split_once("    58\n").unwrap();
        let (lines, _) = after.split_at(after.len() - "  1.00000E+00  2.00000E+00\n    -1\n".len());
        [
            format!("{before}{head}\n{lines}").into_bytes(),
            numbers,
            b"\r\n    -1\r\n".to_vec(),
        ]
        .concat()
    };
    let little: Vec<u8> = [3_f32, 4.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    // A head that says of an even set that it is uneven: its bytes are those of the ordinates alone.
    let mut uneven = binary(1, little.clone());
    let spacing = b"         2         1";
    let at = uneven.windows(20).position(|w| w == spacing).unwrap();
    uneven[at + 19] = b'0';
    let big: Vec<u8> = [5_f32, 6.0].iter().flat_map(|v| v.to_be_bytes()).collect();
    let file = [
        text.clone().into_bytes(),
        b"    -1\n   151\nsomebody\n    -1\n".to_vec(),
        binary(1, little),
        binary(2, big),
    ]
    .concat();
    let container = open(&file).unwrap();
    assert_eq!(container.streams().len(), 1);
    assert_eq!(container.remarks()[0].kind, RemarkKind::PassedOver);
    assert_eq!(columns(container, 0), [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]);
    survives(&file);
    let container = open(&uneven).unwrap();
    assert_eq!(container.remarks()[0].kind, RemarkKind::Damaged);
    assert_eq!(container.streams()[0].clock, Clock::Unsaid);
    assert_eq!(columns(container, 0), [[3.0, 4.0]]);
}

#[test]
fn known_cut_set() {
    let file = set(2, 12, true, true, 0.5, &"  1.00000E+00".repeat(6));
    let file = &file[..file.len() - 7];
    let container = open(format!("{file}\n").as_bytes()).unwrap();
    assert_eq!(container.remarks()[0].kind, RemarkKind::Cut);
    assert!(container.remarks()[0].text.contains("of 12 points"));
}
