//! The seeds were written by h5py 3.16 (`new.h5` with its heap of texts cut to what is used), which gives the numbers that are
//! expected here.

use crate::stream::tests::{columns, open, survives};
use crate::{Container, RemarkKind};

const OLD: &[u8] = include_bytes!("../../tests/seeds/old.h5");
const NEW: &[u8] = include_bytes!("../../tests/seeds/new.h5");
const DENSE: &[u8] = include_bytes!("../../tests/seeds/dense.h5");
const GROWING: &[u8] = include_bytes!("../../tests/seeds/growing.h5");
const MATLAB: &[u8] = include_bytes!("../../tests/seeds/struct.mat");

/// Every channel by its name, whatever its stream.
fn channels(file: &[u8]) -> Vec<(String, Vec<f64>)> {
    let mut all = Vec::new();
    for stream in 0..open(file).unwrap().streams().len() {
        let container = open(file).unwrap();
        let names = container.streams()[stream].channels.iter();
        let names: Vec<String> = names.map(|c| c.name.clone()).collect();
        all.extend(names.into_iter().zip(columns(container, stream)));
    }
    all
}

#[track_caller]
fn assert_channels(file: &[u8], wanted: &[(&str, &[f64])]) {
    let found = channels(file);
    let found: Vec<(&str, &[f64])> = found.iter().map(|(n, v)| (n.as_str(), &v[..])).collect();
    let shown = |all: &[(&str, &[f64])]| format!("{all:?}");
    assert_eq!(shown(&found), shown(wanted));
}

fn remarks(container: &Container) -> Vec<(RemarkKind, &str)> {
    let all = container.remarks().iter();
    all.map(|r| (r.kind, r.text.as_str())).collect()
}

/// Tables of symbols, trees of version 1, addresses of four bytes, three filters, a chunk that was never written.
#[test]
fn known_numbers_of_the_older_form() {
    let none = f64::NAN;
    let packed = |c: f64| [0, 1, 2, 3, 4, 5, 6].map(|i| 10.0 * f64::from(i) + c + 0.5);
    assert_channels(
        OLD,
        &[
            ("gap", &[7.0, 8.0, none, none, 9.0, 10.0]),
            ("raw/counts", &[1.0, -2.0, 300.0, -400.0, 5.0, 6.0]),
            ("packed(:,1)", &packed(0.0)),
            ("packed(:,2)", &packed(1.0)),
            ("records.t", &[1.0, 2.0, 3.0, 4.0]),
            ("records.acc(1)", &[0.0, 0.75, 1.5, 2.25]),
            ("records.acc(2)", &[0.25, 1.0, 1.75, 2.5]),
            ("records.acc(3)", &[0.5, 1.25, 2.0, 2.75]),
        ],
    );
    let container = open(OLD).unwrap();
    assert_eq!(container.format().word, "hdf5");
    assert_eq!(
        container.streams()[0].channels[1].unit.as_deref(),
        Some("mV")
    );
    let kinds = [RemarkKind::Cut, RemarkKind::Damaged, RemarkKind::PassedOver];
    let said = remarks(&container);
    assert_eq!(said.iter().map(|r| r.0).collect::<Vec<_>>(), kinds);
    assert_eq!(said[0].1, "6 of 8 samples of gap were written");
    assert!(said[1].1.starts_with("1 of 3 chunks of gap are missing"));
    assert_eq!(said[2].1, "records.tag, texts");
}

/// Links in messages and in a heap; a fixed and an extensible array of chunks, a single chunk under lzf, floats of 16 bits.
#[test]
fn known_numbers_of_the_newer_form() {
    assert_channels(
        NEW,
        &[
            ("complex real", &[1.0, 3.0]),
            ("complex imaginary", &[2.0, -4.0]),
            ("fixed(:,1)", &[0.0, 0.25, 0.5, 0.75, 1.0]),
            ("fixed(:,2)", &[0.125, 0.375, 0.625, 0.875, 1.125]),
            ("single(1,:)", &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]),
            ("single(2,:)", &[6.0, 7.0, 8.0, 9.0, 10.0, 11.0]),
        ],
    );
    let container = open(NEW).unwrap();
    let said = [(RemarkKind::PassedOver, "cube, an array of 3 dimensions")];
    assert_eq!(remarks(&container), said);
    assert_eq!(
        container.streams()[1].channels[0].unit.as_deref(),
        Some("g")
    );
    assert_channels(
        DENSE,
        &[
            ("channel 1", &[0.0, 0.0]),
            ("channel 2", &[1.0, -1.0]),
            ("channel 3", &[2.0, -2.0]),
        ],
    );
    let squares: Vec<f64> = (0..14).map(|i| f64::from(i * i)).collect();
    assert_channels(GROWING, &[("growing", &squares)]);
}

/// Behind 512 bytes, sides as MATLAB names them; texts, empty arrays and what MATLAB keeps for itself are no channels.
#[test]
fn known_variables_of_matlab() {
    let wanted: &[(&str, &[f64])] = &[
        ("acc(:,1)", &[0.0, 1.0, 2.0]),
        ("acc(:,2)", &[3.0, 4.0, 5.0]),
        ("run.z real", &[1.0, 2.0, 3.0]),
        ("run.z imaginary", &[-1.0, -2.0, -3.0]),
    ];
    assert_channels(MATLAB, wanted);
    let container = open(MATLAB).unwrap();
    assert_eq!(container.format().word, "mat73");
    assert!(container.remarks().is_empty());
    // Older releases wrote another number there.
    let mut older = MATLAB.to_vec();
    older[9] = b'0';
    assert_eq!(open(&older).unwrap().format().word, "mat73");
    assert_channels(&older, wanted);
    // The same as a file of its own, behind bytes of somebody else.
    let moved = [&[b'.'; 512], MATLAB].concat();
    assert_eq!(open(&moved).unwrap().format().word, "hdf5");
    assert_eq!(channels(&moved).len(), 7);
}

#[test]
fn law_nothing_is_read_beyond_what_is_there() {
    for file in [OLD, NEW, DENSE, GROWING, MATLAB] {
        let start = std::time::Instant::now();
        survives(file);
        let each = start.elapsed() / (2 * file.len() as u32);
        assert!(each.as_millis() < 100, "{each:?}");
    }
}

#[test]
fn law_a_cut_is_said_wherever_it_is() {
    for file in [OLD, NEW, DENSE, GROWING, MATLAB] {
        for end in 0..file.len() {
            if let Ok(container) = open(&file[..end]) {
                let said = remarks(&container);
                assert!(
                    said.iter().any(|r| r.0 == RemarkKind::Cut),
                    "{end}: {said:?}"
                );
            }
        }
        let error = open(&file[..file.len() / 4]).err().unwrap();
        assert!(error.hint().is_some(), "{error}");
    }
}

/// Where everything has a check sum no inverted byte gives other numbers without a word.
#[test]
fn law_damage_under_check_sums_is_said() {
    let sound = channels(GROWING);
    let mut noticed = 0;
    for at in 0..GROWING.len() {
        let mut file = GROWING.to_vec();
        file[at] ^= 0xFF;
        let silent = open(&file).is_ok_and(|c| c.remarks().is_empty());
        match silent {
            true => assert_eq!(channels(&file), sound, "byte {at}"),
            false => noticed += 1,
        }
    }
    // All but bytes between the blocks.
    assert!(noticed > GROWING.len() * 3 / 4, "{noticed}");
}

#[test]
fn known_chunk_with_a_wrong_check_sum_is_a_gap() {
    // The heads of the deflated chunks.
    let mut places = (0..OLD.len()).filter(|&i| OLD[i..].starts_with(b"\x78\x5e"));
    let second = places.nth(1).unwrap();
    let mut file = OLD.to_vec();
    file[second + 8] ^= 1;
    let container = open(&file).unwrap();
    let said = remarks(&container);
    let damaged = format!(
        "1 of the chunks of packed: the check sum does not hold or it cannot be unpacked, the first at byte {second}"
    );
    assert!(
        said.contains(&(RemarkKind::Damaged, damaged.as_str())),
        "{said:?}"
    );
    let packed = &columns(container, 1)[0];
    let gap: Vec<bool> = packed.iter().map(|v| v.is_nan()).collect();
    assert_eq!(gap, [false, false, false, true, true, true, false]);
}

/// A filter that is not read is named; a dataset that claims to be larger is as long as its chunks.
#[test]
fn known_foreign_filter_and_false_claims() {
    let at = OLD.windows(8).position(|w| w == b"deflate\0").unwrap();
    let mut file = OLD.to_vec();
    file[at - 8..at - 6].copy_from_slice(&32_008_u16.to_le_bytes());
    let container = open(&file).unwrap();
    let said = remarks(&container);
    assert!(
        said.iter().any(|r| r.1.contains("bitshuffle (32008)")),
        "{said:?}"
    );
    assert_eq!(container.streams().len(), 2);
    let sides = [8_u32, 8].map(u32::to_le_bytes).concat();
    let at = OLD.windows(8).position(|w| w == sides).unwrap();
    let mut file = OLD.to_vec();
    file[at + 3] = 0x7F;
    file[at + 7] = 0x7F;
    let container = open(&file).unwrap();
    assert!(
        remarks(&container)[0]
            .1
            .starts_with("6 of 2130706440 samples of gap")
    );
    assert_eq!(columns(container, 0)[0].len(), 6);
}

/// What was kept when the chunks were checked is gone after the first pass.
#[test]
fn law_a_second_pass_gives_the_same_numbers() {
    let mut rows = open(OLD).unwrap().rows(1, &[0, 1]).unwrap();
    let mut passes = [vec![Vec::new(); 2], vec![Vec::new(); 2]];
    for pass in &mut passes {
        rows.restart(&[0, 1]).unwrap();
        assert_eq!(rows.next_block(pass).unwrap(), 7);
    }
    assert_eq!(passes[0], passes[1]);
}
