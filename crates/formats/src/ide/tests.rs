use crate::RemarkKind;
use crate::stream::tests::{columns, open, survives};

/// An element, its size in two bytes.
fn element(id: u32, content: &[u8]) -> Vec<u8> {
    let id = id.to_be_bytes();
    let zeros = id.iter().take_while(|b| **b == 0).count();
    let size = (0x4000 | content.len() as u16).to_be_bytes();
    [&id[zeros..], &size, content].concat()
}

fn list(id: u32, elements: &[Vec<u8>]) -> Vec<u8> {
    element(id, &elements.concat())
}

fn polynomial(
    id: u8,
    reference: f64,
    coefficients: &[f64],
    other: Option<(u8, u8, f64)>,
) -> Vec<u8> {
    let mut all = vec![
        element(0x4B03, &[id]),
        element(0x4B04, &reference.to_be_bytes()),
    ];
    if let Some((channel, subchannel, reference)) = other {
        all.push(element(0x4B05, &(reference as f32).to_be_bytes()));
        all.push(element(0x4B06, &[channel]));
        all.push(element(0x4B07, &[subchannel]));
    }
    all.extend(
        coefficients
            .iter()
            .map(|c| element(0x4B08, &c.to_be_bytes())),
    );
    list(if other.is_some() { 0x4B02 } else { 0x4B01 }, &all)
}

/// Name, unit and calibration of each field.
fn channel(
    id: u8,
    name: &str,
    format: &str,
    calibration: Option<u8>,
    fields: &[(&str, &str, u8)],
) -> Vec<u8> {
    let mut all = vec![
        element(0x5272, &[id]),
        element(0x5273, name.as_bytes()),
        element(0x5275, format.as_bytes()),
        element(0x5277, b"1.0/1000"),
        element(0x5278, &[0x10, 0]),
    ];
    all.extend(calibration.map(|c| element(0x5274, &[c])));
    for (i, (name, unit, calibration)) in (0..).zip(fields) {
        let mut one = vec![
            element(0x52A1, &[i]),
            element(0x52A2, name.as_bytes()),
            element(0x52A6, unit.as_bytes()),
        ];
        if *calibration > 0 {
            one.push(element(0x52A3, &[*calibration]));
        }
        all.push(list(0x52A0, &one));
    }
    list(0x5271, &all)
}

fn block(channel: u8, start: u16, end: u16, payload: &[u8]) -> Vec<u8> {
    list(
        0xA1,
        &[
            element(0xB0, &[channel]),
            element(0xB8, &start.to_be_bytes()),
            element(0xB9, &end.to_be_bytes()),
            element(0xEC, &[0xFF; 3]),
            element(0xB2, payload),
        ],
    )
}

fn words(numbers: &[i16]) -> Vec<u8> {
    numbers.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// What stands before the samples.
fn description() -> Vec<u8> {
    let calibrations = list(
        0x4B00,
        &[
            polynomial(1, 0.0, &[0.25, 0.0], None),
            polynomial(2, 0.0, &[0.5, 2.0, 0.0, 1.0], Some((9, 0, 20.0))),
            polynomial(3, 1.0, &[3.0, 0.0, 1.0], None),
        ],
    );
    let fields = [("X", "g", 2), ("Y", "g", 3), ("Z", "g", 0)];
    let channels = list(
        0x5270,
        &[
            channel(8, "acceleration", "<hhh", Some(1), &fields),
            channel(9, "warmth", ">f", None, &[("temperature", "&#176;C", 0)]),
            channel(10, "positions", "<b", None, &[("text", "", 0)]),
            channel(11, "warmth", "<B", None, &[("other", "%", 0)]),
        ],
    );
    [
        list(0x1A45_DFA3, &[element(0x4282, b"mide")]),
        calibrations,
        list(
            0x1852_6570,
            &[element(0x5210, b"\x52\x15\x84Name"), channels],
        ),
        element(0xFA, b"ZZZZ"),
        element(0x4F00, b"unknown"),
    ]
    .concat()
}

/// Two accelerations after a gap and a turn of the time codes, and two temperatures.
fn blocks() -> [Vec<u8>; 5] {
    let warmth = [21.0_f32, 23.0].map(f32::to_be_bytes).concat();
    [
        block(8, 4000, 4020, &words(&[4, 0, 7, 8, 4, 8, -4, 8, 9])),
        block(9, 4000, 4050, &warmth),
        block(11, 4001, 4001, &[40]),
        // The code 4090 + 10 is 4, and 60 ms of it are missing.
        block(8, 4, 14, &words(&[0, 0, 1, 12, 0, 2])),
        block(8, 24, 34, &words(&[0, 0, 3, 0, 0, 4])),
    ]
}

#[test]
fn known_channels_calibrations_and_times() {
    let file = [description(), blocks().concat()].concat();
    let container = open(&file).unwrap();
    assert_eq!(container.remarks(), []);
    let names: Vec<&str> = container
        .streams()
        .iter()
        .map(|s| s.name.as_str())
        .collect();
    assert_eq!(names, ["acceleration", "warmth 9", "warmth 11"]);
    let about = &container.streams()[0].channels;
    assert_eq!(about[0].unit.as_deref(), Some("g"));
    assert_eq!(
        about[0].scaling.as_deref(),
        Some("linear at temperature = 22.000")
    );
    assert_eq!(about[1].scaling.as_deref(), Some("linear then polynomial"));
    let warmth = &container.streams()[1].channels[0];
    assert_eq!(
        (warmth.unit.as_deref(), &warmth.scaling),
        (Some("°C"), &None)
    );
    let all = columns(container, 0);
    // x = raw/4; 0.5·x·(22 - 20) + 2·x + 1 = 0.75·raw + 1.
    assert_eq!(all[0], [4.0, 7.0, -2.0, 1.0, 10.0, 1.0, 1.0]);
    // 3·(raw/4 - 1)² + 1.
    assert_eq!(all[1], [4.0, 1.0, 4.0, 4.0, 4.0, 4.0, 4.0]);
    assert_eq!(all[2], [1.75, 2.0, 2.25, 0.25, 0.5, 0.75, 1.0]);
    let times = [4.0, 4.01, 4.02, 4.1, 4.11, 4.12, 4.13];
    assert!(all[3].iter().zip(times).all(|(a, b)| (a - b).abs() < 1e-12));
    let stored = open(&file).unwrap().without_scaling();
    assert_eq!(stored.streams()[0].channels[0].unit, None);
    assert_eq!(columns(stored, 0)[1], [0.0, 4.0, 8.0, 0.0, 0.0, 0.0, 0.0]);
    survives(&file);
}

#[test]
fn known_cut_and_damaged_blocks() {
    let [first, warmth, _, third, last] = blocks();
    let whole = [description(), warmth, first, third.clone(), last.clone()].concat();
    // In the last sample of the last block.
    let container = open(&whole[..whole.len() - 1]).unwrap();
    assert_eq!(container.remarks()[0].kind, RemarkKind::Cut);
    let place = format!("byte {}", whole.len() - last.len());
    assert!(container.remarks()[0].text.ends_with(&place));
    let all = columns(container, 0);
    assert_eq!((all[2].len(), all[3][5]), (6, 4.12));
    // The size of the block before it is another: reading goes on with the last one.
    for (place, byte) in [(1, 0x5F), (2, 0x05), (0, 0x00)] {
        let mut broken = whole.clone();
        broken[whole.len() - last.len() - third.len() + place] = byte;
        let container = open(&broken).unwrap();
        assert_eq!(container.remarks()[0].kind, RemarkKind::Damaged);
        assert_eq!(columns(container, 0)[2], [1.75, 2.0, 2.25, 0.75, 1.0]);
    }
}

#[test]
fn known_channels_that_are_passed_over() {
    let said = |file: &[u8]| {
        let container = open(file).unwrap();
        let said: Vec<String> = container.remarks().iter().map(|r| r.text.clone()).collect();
        said.join("; ")
    };
    let [first, _, other, ..] = blocks();
    // Without temperatures the reference is taken, and said.
    let cold = [description(), first.clone()].concat();
    assert!(
        said(&cold).contains("taken at its reference, 20"),
        "{}",
        said(&cold)
    );
    assert_eq!(columns(open(&cold).unwrap(), 0)[0], [3.0, 5.0, -1.0]);
    let unknown = [description(), other.clone(), block(77, 0, 0, &[1])].concat();
    assert!(said(&unknown).contains("channel 77"));
    let mut odd = [description(), other.clone(), first].concat();
    let at = odd.windows(4).position(|w| w == b"<hhh").unwrap();
    odd[at] = b'@';
    assert!(said(&odd).contains("\"@hhh\""));
    let plain = [list(0x1A45_DFA3, &[element(0x4282, b"mide")]), other].concat();
    let refused = open(&plain).map(|_| ()).unwrap_err();
    assert!(refused.to_string().contains("does not describe"));
    // A film is EBML too.
    let film = list(0x1A45_DFA3, &[element(0x4282, b"webm")]);
    assert!(crate::recognise(&film).is_none());
}

#[test]
fn known_seed_of_the_fuzzer() {
    let seed = [description(), blocks().concat()].concat();
    assert_eq!(include_bytes!("../../tests/seeds/two.ide")[..], seed);
}
