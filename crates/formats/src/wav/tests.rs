use crate::stream::tests::{columns, open, survives};
use crate::{Clock, RemarkKind};

/// A file of two channels at 1 kHz; `size` is what the data chunk claims.
fn file(
    kind: &[u8; 4],
    form: u16,
    bits: u16,
    valid: Option<u16>,
    size: u32,
    data: &[u8],
) -> Vec<u8> {
    let big = kind == b"RIFX";
    let u16 = |v: u16| {
        if big {
            v.to_be_bytes()
        } else {
            v.to_le_bytes()
        }
    };
    let u32 = |v: u32| {
        if big {
            v.to_be_bytes()
        } else {
            v.to_le_bytes()
        }
    };
    let frame = 2 * bits.div_ceil(8);
    let mut format = [
        &u16(if valid.is_some() { 0xFFFE } else { form })[..],
        &u16(2),
        &u32(1000),
        &u32(1000 * u32::from(frame)),
        &u16(frame),
        &u16(bits),
    ]
    .concat();
    if let Some(valid) = valid {
        let more = [&u16(22)[..], &u16(valid), &u32(3), &u32(u32::from(form))];
        format.extend(more.concat());
        format.extend(b"\0\0\x10\0\x80\0\0\xaa\0\x38\x9b\x71");
    }
    let mut all = [&kind[..], &u32(u32::MAX), b"WAVE"].concat();
    if kind == b"RF64" {
        all.extend(
            [
                &b"ds64"[..],
                &u32(28),
                &[0; 8],
                &(data.len() as u64).to_le_bytes(),
                &[0; 12],
            ]
            .concat(),
        );
    }
    // A chunk of odd length before the samples.
    all.extend([&b"LIST"[..], &u32(3), b"abc\0"].concat());
    all.extend([&b"fmt "[..], &u32(format.len() as u32), &format].concat());
    all.extend([&b"data"[..], &u32(size), data].concat());
    all
}

#[test]
fn known_numbers_of_every_form() {
    let three = |v: i32| v.to_le_bytes()[..3].to_vec();
    let cases: [(u16, u16, Vec<u8>, [f64; 4]); 6] = [
        (1, 8, vec![0, 128, 255, 129], [-128.0, 0.0, 127.0, 1.0]),
        (
            1,
            16,
            [-1_i16, 2, i16::MIN, i16::MAX]
                .iter()
                .flat_map(|v| v.to_le_bytes())
                .collect(),
            [-1.0, 2.0, -32768.0, 32767.0],
        ),
        (
            1,
            24,
            [-1, 2, -8_388_608, 8_388_607]
                .into_iter()
                .flat_map(three)
                .collect(),
            [-1.0, 2.0, -8_388_608.0, 8_388_607.0],
        ),
        (
            1,
            32,
            [-1_i32, 2, i32::MIN, i32::MAX]
                .iter()
                .flat_map(|v| v.to_le_bytes())
                .collect(),
            [-1.0, 2.0, -2_147_483_648.0, 2_147_483_647.0],
        ),
        (
            3,
            32,
            [0.5_f32, -0.25, 1.0, 0.0]
                .iter()
                .flat_map(|v| v.to_le_bytes())
                .collect(),
            [0.5, -0.25, 1.0, 0.0],
        ),
        (
            3,
            64,
            [0.1_f64, -0.2, 0.3, 0.0]
                .iter()
                .flat_map(|v| v.to_le_bytes())
                .collect(),
            [0.1, -0.2, 0.3, 0.0],
        ),
    ];
    for (form, bits, data, want) in cases {
        let size = data.len() as u32;
        for (kind, valid, size) in [
            (b"RIFF", None, size),
            (b"RIFF", Some(bits), size),
            (b"RF64", None, u32::MAX),
        ] {
            let bytes = file(kind, form, bits, valid, size, &data);
            let container = open(&bytes).unwrap();
            let stream = &container.streams()[0];
            assert_eq!(
                stream.clock,
                Clock::Rate {
                    hz: 1000.0,
                    start_s: 0.0
                }
            );
            assert_eq!(
                stream.full_scale,
                (form == 1).then(|| 2_f64.powi(i32::from(bits) - 1))
            );
            assert!(container.remarks().is_empty());
            assert_eq!(
                columns(container, 0),
                [[want[0], want[2]], [want[1], want[3]]]
            );
        }
        survives(&file(b"RIFF", form, bits, Some(bits), size, &data));
    }
    let big: Vec<u8> = [-1_i16, 2, 3, -4]
        .iter()
        .flat_map(|v| v.to_be_bytes())
        .collect();
    for valid in [None, Some(12)] {
        let container = open(&file(b"RIFX", 1, 16, valid, 8, &big)).unwrap();
        assert_eq!(columns(container, 0), [[-1.0, 3.0], [2.0, -4.0]]);
    }
}

#[test]
fn known_file_of_a_recorder_that_was_stopped() {
    let data: Vec<u8> = [1_i16, 2, 3, 4, 5]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    for size in [0, u32::MAX, 400] {
        let container = open(&file(b"RIFF", 1, 16, None, size, &data)).unwrap();
        assert_eq!(container.remarks()[0].kind, RemarkKind::Cut, "{size}");
        assert_eq!(columns(container, 0), [[1.0, 3.0], [2.0, 4.0]]);
    }
}

#[test]
fn refuses_compressed_samples_by_name() {
    for (form, name) in [(7, "µ-law"), (6, "A-law"), (0x11, "ADPCM")] {
        let refused = open(&file(b"RIFF", form, 8, None, 4, &[0; 4])).map(|_| ());
        assert!(refused.is_err_and(|e| e.to_string().contains(name)));
    }
}
