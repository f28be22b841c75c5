use crate::stream::is_absent;
use crate::stream::tests::{columns, open};
use crate::{Clock, RemarkKind};

/// Written by pyarrow 26: snappy, check sums, dictionaries for two columns, two row groups of 7 and 5 rows.
const NULLS: &[u8] = include_bytes!("../../tests/seeds/nulls.parquet");
/// Written by pyarrow 26: zstd, pages of version 2, differences and split bytes, a structure and a list.
const NESTED: &[u8] = include_bytes!("../../tests/seeds/nested.parquet");

/// Numbers of a column, `None` where they are absent.
fn column(file: &[u8], name: &str) -> Vec<Option<f64>> {
    let container = open(file).unwrap();
    let channels = &container.streams()[0].channels;
    let place = channels.iter().position(|c| c.name == name).unwrap();
    let numbers = columns(container, 0).swap_remove(place);
    assert!(numbers.iter().all(|v| v.is_finite() || is_absent(*v)));
    let known = numbers.iter().map(|v| (!is_absent(*v)).then_some(*v));
    known.collect()
}

/// So many numbers by their place, and places without.
fn numbers(of: impl Fn(f64) -> f64, absent: &[usize]) -> Vec<Option<f64>> {
    (0..12)
        .map(|i| (!absent.contains(&i)).then(|| of(i as f64)))
        .collect()
}

#[test]
fn crosscheck_columns_that_pyarrow_wrote() {
    let container = open(NULLS).unwrap();
    let stream = &container.streams()[0];
    assert_eq!((stream.rows, stream.clock), (12, Clock::Times));
    let names: Vec<(&str, Option<&str>)> = stream
        .channels
        .iter()
        .map(|c| (c.name.as_str(), c.unit.as_deref()))
        .collect();
    let wanted = [
        ("acc_x (m/s2)", None),
        ("acc_y", Some("g")),
        ("counts", None),
        ("big", None),
        ("flag", None),
        ("volts", None),
        ("stamp", Some("s")),
    ];
    assert_eq!(names, wanted);
    let remarks: Vec<_> = container.remarks().iter().collect();
    assert_eq!(remarks.len(), 1);
    assert_eq!(remarks[0].kind, RemarkKind::PassedOver);
    assert!(remarks[0].text.starts_with("note, "));
    for (name, wanted) in [
        ("acc_x (m/s2)", numbers(|i| 0.5 * i - 1.0, &[])),
        ("acc_y", numbers(|i| 0.25 * i, &[4, 9])),
        (
            "counts",
            numbers(
                |i| i * 1000.0 * if i % 2.0 == 0.0 { 1.0 } else { -1.0 },
                &[],
            ),
        ),
        (
            "big",
            numbers(|i| 9_223_372_036_854_775_808.0 + 2048.0 * i, &[]),
        ),
        (
            "flag",
            numbers(|i| f64::from(u8::from(i % 3.0 == 0.0)), &[3, 7, 11]),
        ),
        ("volts", numbers(|i| (i - 6.0) / 100.0, &[6])),
        (
            "stamp",
            numbers(|i| 1_700_000_000.0 + 1_250_000.0 * i / 1e9, &[]),
        ),
    ] {
        assert_eq!(column(NULLS, name), wanted, "{name}");
    }
    for (name, wanted) in [
        ("pose.x", numbers(|i| 1.5 * i, &[8])),
        ("pose.y", numbers(|i| i, &[3, 8])),
        ("half", numbers(|i| i / 8.0, &[])),
        ("small", numbers(|i| i - 5.0, &[])),
        (
            "time",
            numbers(|i| 1_767_225_600.0 + 10.0 * i / 1000.0, &[]),
        ),
    ] {
        assert_eq!(column(NESTED, name), wanted, "{name}");
    }
}

#[test]
fn known_page_with_a_wrong_check_sum_is_a_counted_gap() {
    let damaged = |at: usize| {
        let mut file = NULLS.to_vec();
        file[at] ^= 1;
        file
    };
    let told = |file: &[u8]| {
        let container = open(file).unwrap();
        let remarks = container.remarks().iter();
        let damaged = remarks.filter(|r| r.kind == RemarkKind::Damaged);
        damaged.map(|r| r.text.clone()).collect::<Vec<_>>()
    };
    // In the numbers of acc_y of the first row group, and in the dictionary of counts.
    for (at, name, place) in [(180, "acc_y", 153), (245, "counts", 208)] {
        let file = damaged(at);
        let wanted = format!(
            "column {name}, row group 1: the page at byte {place} fails its check sum, 7 numbers are missing"
        );
        assert_eq!(told(&file), [wanted]);
        let whole = column(NULLS, name);
        let left = column(&file, name);
        assert!(left[..7].iter().all(Option::is_none));
        assert_eq!(left[7..], whole[7..]);
        for other in ["acc_x (m/s2)", "big", "stamp"] {
            assert_eq!(column(&file, other), column(NULLS, other));
        }
    }
}

#[test]
fn refuses_files_without_their_index_or_against_it() {
    let refused = |file: &[u8]| open(file).map(drop).unwrap_err();
    for end in [5, 12, 100, NULLS.len() - 1] {
        let error = refused(&NULLS[..end]);
        assert!(error.to_string().contains("index at the end is missing"));
        assert!(error.hint().unwrap().contains("fetch it again"));
    }
    let mut long = NULLS.to_vec();
    let end = long.len();
    long[end - 5] = 1;
    assert!(refused(&long).to_string().contains("damaged"));
    let mut secret = NULLS.to_vec();
    secret[end - 1] = b'E';
    assert!(refused(&secret).to_string().contains("encrypted"));
}

/// Of the files with one byte inverted and no check sums, those that are opened and refused on the way.
#[test]
fn refuses_a_page_that_does_not_hold_its_numbers() {
    let file = NESTED;
    let container = open(file).unwrap();
    let count = container.streams()[0].channels.len();
    let mut told = 0;
    for at in 4..file.len() {
        let mut file = file.to_vec();
        file[at] ^= 0xFF;
        let Ok(container) = open(&file) else { continue };
        let all: Vec<usize> = (0..container.streams()[0].channels.len()).collect();
        let mut rows = container.rows(0, &all).unwrap();
        let mut block = vec![Vec::new(); all.len()];
        if let Err(error) = rows.next_block(&mut block) {
            let said = error.to_string();
            assert!(said.contains("row group") && said.contains("column "));
            told += 1;
        }
    }
    assert!(count == 5 && told > 20, "{told}");
}

/// Heads have no check sum: whatever they say wrongly must show in another way.
#[test]
fn law_no_bit_among_pages_with_check_sums_gives_another_number() {
    let whole = columns(open(NULLS).unwrap(), 0);
    let length = u32::from_le_bytes(*NULLS.last_chunk::<8>().unwrap().first_chunk().unwrap());
    let index = NULLS.len() - 8 - length as usize;
    let (mut read, mut refused) = (0, 0);
    for bit in 32..8 * index {
        let mut file = NULLS.to_vec();
        file[bit / 8] ^= 1 << (bit % 8);
        let Ok(container) = open(&file) else {
            refused += 1;
            continue;
        };
        let all: Vec<usize> = (0..whole.len()).collect();
        let mut rows = container.rows(0, &all).unwrap();
        let mut block = vec![Vec::new(); all.len()];
        if rows.next_block(&mut block).is_err() {
            refused += 1;
            continue;
        }
        read += 1;
        for (column, whole) in block.iter().zip(&whole) {
            for (v, wanted) in column.iter().zip(whole) {
                let same = v.to_bits() == wanted.to_bits();
                assert!(same || is_absent(*v), "byte {}: {v} for {wanted}", bit / 8);
            }
        }
    }
    assert!(
        read > 1000 && refused > 100,
        "{read} read, {refused} refused"
    );
}
