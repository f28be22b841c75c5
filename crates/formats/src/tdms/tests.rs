use crate::stream::tests::{Writer, columns};
use crate::{Clock, Container, RemarkKind};

impl Writer {
    fn text(self, text: &str) -> Vec<u8> {
        [self.u32(text.len() as u32), text.as_bytes().to_vec()].concat()
    }

    fn number(self, name: &str, v: f64) -> Vec<u8> {
        [self.text(name), self.u32(10), self.f64(v)].concat()
    }

    fn count(self, name: &str, v: u32) -> Vec<u8> {
        [self.text(name), self.u32(7), self.u32(v)].concat()
    }

    fn word(self, name: &str, v: &str) -> Vec<u8> {
        [self.text(name), self.u32(0x20), self.text(v)].concat()
    }

    /// An object with numbers of 16 bits.
    fn object(self, path: &str, values: u64, properties: &[Vec<u8>]) -> Vec<u8> {
        let index = [self.u32(20), self.u32(2), self.u32(1), self.u64(values)].concat();
        self.described(path, &index, properties)
    }

    fn described(self, path: &str, index: &[u8], properties: &[Vec<u8>]) -> Vec<u8> {
        let count = self.u32(properties.len() as u32);
        [self.text(path), index.to_vec(), count, properties.concat()].concat()
    }

    fn segment(self, flags: u32, objects: &[Vec<u8>], raw: &[u8]) -> Vec<u8> {
        let metadata = match objects {
            [] => Vec::new(),
            _ => [self.u32(objects.len() as u32), objects.concat()].concat(),
        };
        let flags = flags | if self.big { 1 << 6 } else { 0 };
        [
            b"TDSm".to_vec(),
            flags.to_le_bytes().to_vec(),
            self.u32(4713),
            self.u64((metadata.len() + raw.len()) as u64),
            self.u64(metadata.len() as u64),
            metadata,
            raw.to_vec(),
        ]
        .concat()
    }

    fn numbers(self, values: &[i16]) -> Vec<u8> {
        values.iter().flat_map(|v| self.i16(*v)).collect()
    }
}

const LITTLE: Writer = Writer { big: false };
/// Metadata, a new list of objects, raw data.
const FULL: u32 = 0b1110;

fn open(bytes: Vec<u8>) -> crate::Result<Container> {
    crate::stream::tests::open(&bytes)
}

#[test]
fn known_segments_in_both_orders() {
    for w in [LITTLE, Writer { big: true }] {
        let clock = [w.number("wf_increment", 0.001), w.word("unit_string", "g")];
        let first = [
            w.described("/", &w.u32(u32::MAX), &[]),
            w.object("/'it''s'/'a'", 2, &clock),
            w.object("/'it''s'/'b'", 2, &clock[..1]),
        ];
        let file = [
            // Two chunks, then a segment of the same shape without a description, then an interleaved one.
            w.segment(FULL, &first, &w.numbers(&[1, 2, 10, 20, 3, 4, 30, 40])),
            w.segment(1 << 3, &[], &w.numbers(&[5, 6, 50, 60])),
            w.segment(1 << 3 | 1 << 5, &[], &w.numbers(&[7, 70, 8, 80, 9, 90])),
        ]
        .concat();
        let container = open(file).unwrap();
        let stream = &container.streams()[0];
        assert_eq!((container.streams().len(), stream.rows), (1, 9));
        assert_eq!(stream.name, "it's");
        assert_eq!(
            stream.clock,
            Clock::Rate {
                hz: 1000.0,
                start_s: 0.0
            }
        );
        assert_eq!(stream.channels[0].unit.as_deref(), Some("g"));
        assert_eq!(stream.channels[1].unit, None);
        assert!(container.remarks().is_empty());
        let want = [1, 2, 3, 4, 5, 6, 7, 8, 9].map(f64::from);
        assert_eq!(columns(container, 0), [want, want.map(|v| 10.0 * v)]);
    }
}

#[test]
fn known_objects_come_and_go() {
    let w = LITTLE;
    let file = [
        w.segment(FULL, &[w.object("/'g'/'a'", 1, &[])], &w.numbers(&[1])),
        // One more object beside the first, whose description is that of before.
        w.segment(
            0b1010,
            &[w.object("/'g'/'b'", 2, &[])],
            &w.numbers(&[2, 10, 20]),
        ),
        // The first falls away.
        w.segment(
            0b1010,
            &[w.described("/'g'/'a'", &w.u32(u32::MAX), &[])],
            &w.numbers(&[30, 40]),
        ),
    ]
    .concat();
    let container = open(file).unwrap();
    let named: Vec<_> = container
        .streams()
        .iter()
        .map(|s| (s.name.clone(), s.rows))
        .collect();
    assert_eq!(named, [("g".to_owned(), 2), ("g 2".to_owned(), 4)]);
    assert_eq!(columns(container, 1), [[10.0, 20.0, 30.0, 40.0]]);
}

#[test]
fn known_converter_card_with_scales() {
    let w = LITTLE;
    let index = |scalers: &[[u32; 3]]| {
        let each: Vec<u8> = scalers
            .iter()
            .flat_map(|[kind, offset, id]| {
                [w.u32(*kind), w.u32(0), w.u32(*offset), w.u32(0), w.u32(*id)].concat()
            })
            .collect();
        [
            w.u32(0x1269),
            w.u32(u32::MAX),
            w.u32(1),
            w.u64(2),
            w.u32(scalers.len() as u32),
            each,
            w.u32(1),
            w.u32(6),
        ]
        .concat()
    };
    let scales = [
        w.word("unit_string", "g"),
        w.count("NI_Number_Of_Scales", 3),
        w.word("NI_Scale[1]_Scale_Type", "Linear"),
        w.number("NI_Scale[1]_Linear_Slope", 0.5),
        w.number("NI_Scale[1]_Linear_Y_Intercept", 1.0),
        w.count("NI_Scale[1]_Linear_Input_Source", 0),
        w.word("NI_Scale[2]_Scale_Type", "Polynomial"),
        w.count("NI_Scale[2]_Polynomial_Coefficients_Size", 2),
        w.number("NI_Scale[2]_Polynomial_Coefficients[0]", 1.0),
        w.number("NI_Scale[2]_Polynomial_Coefficients[1]", 2.0),
        w.count("NI_Scale[2]_Polynomial_Input_Source", 1),
    ];
    let objects = [
        w.described("/'g'/'a'", &index(&[[3, 0, 0]]), &scales),
        w.described("/'g'/'b'", &index(&[[5, 2, 0]]), &[]),
    ];
    let raw = [w.numbers(&[4]), w.u32(100_000), w.numbers(&[-2]), w.u32(7)].concat();
    // The flag of the card (1 << 7) may be missing: the index tells.
    let container = open(w.segment(FULL, &objects, &raw)).unwrap();
    let words = container.streams()[0].channels[0].scaling.clone();
    assert_eq!(words.as_deref(), Some("linear then polynomial"));
    assert_eq!(columns(container, 0), [[7.0, 1.0], [100_000.0, 7.0]]);
    let raw = open(w.segment(FULL, &objects, &raw))
        .unwrap()
        .without_scaling();
    let channel = &raw.streams()[0].channels[0];
    assert_eq!((&channel.unit, &channel.scaling), (&None, &None));
    assert_eq!(columns(raw, 0)[0], [4.0, -2.0]);
}

#[test]
fn known_file_of_a_program_that_was_stopped() {
    let w = LITTLE;
    let mut file = w.segment(
        FULL,
        &[w.object("/'g'/'a'", 2, &[]), w.object("/'g'/'b'", 2, &[])],
        &w.numbers(&[1, 2, 10, 20, 3, 4, 30]),
    );
    file[12..20].copy_from_slice(&u64::MAX.to_le_bytes());
    let container = open(file.clone()).unwrap();
    assert_eq!(container.remarks()[0].kind, RemarkKind::Cut);
    assert_eq!(columns(container, 0), [[1.0, 2.0, 3.0], [10.0, 20.0, 30.0]]);
    crate::stream::tests::survives(&file);
}
