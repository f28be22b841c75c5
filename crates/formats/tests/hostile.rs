//! Files that were made to fill the memory, to run without end or to be printed: each is refused or read in bounds.

#[path = "support/damage.rs"]
mod damage;

use flate2::Compression;
use flate2::write::{DeflateEncoder, ZlibEncoder};
use proofmass_formats::{Clock, Container, FORMATS, RemarkKind, recognise};
use std::io::{Cursor, Write as _};

type Opened = Result<Container, proofmass_formats::Error>;

fn open(bytes: &[u8]) -> Opened {
    Container::open(Box::new(Cursor::new(bytes.to_vec())))
}

/// Reads all of a file, in the bounds that hold for every file; what opening it gives.
#[track_caller]
fn bounded(what: &str, bytes: &[u8]) -> Opened {
    let cost = damage::read(bytes);
    assert!(cost.seconds < 2.0, "{what}: {} s", cost.seconds);
    assert!(cost.bytes < 64_000_000, "{what}: {} bytes", cost.bytes);
    let opened = open(bytes);
    let said = match &opened {
        Ok(container) => {
            let names = container.streams().iter().flat_map(|s| {
                let channels = s.channels.iter();
                channels.flat_map(|c| [Some(c.name.clone()), c.unit.clone()])
            });
            let streams = container.streams().iter().map(|s| s.name.clone());
            let texts = container.remarks().iter().map(|r| r.text.clone());
            names.flatten().chain(streams).chain(texts).collect()
        }
        Err(error) => vec![error.to_string()],
    };
    for text in said {
        assert!(!text.contains(char::is_control), "{what}: {text:.200?}");
        assert!(text.chars().count() <= 1000, "{what}: {} bytes", text.len());
    }
    opened
}

#[track_caller]
fn refused(what: &str, bytes: &[u8]) -> String {
    match bounded(what, bytes) {
        Ok(container) => panic!("{what}: {:?}", container.streams()),
        Err(error) => error.to_string(),
    }
}

fn numbers(all: &[u32]) -> Vec<u8> {
    all.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// Bytes that look like chance, the same each time.
fn noise(length: usize) -> Vec<u8> {
    let mut state = 0x1234_5678_9ABC_DEF1_u64;
    let step = |_| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state as u8
    };
    (0..length).map(step).collect()
}

fn zlib(content: &[u8]) -> Vec<u8> {
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::best());
    packed.write_all(content).unwrap();
    packed.finish().unwrap()
}

/// An archive of deflated members, all of which are the same bytes of the file.
fn archive(names: &[&str], content: &[u8]) -> Vec<u8> {
    let mut packed = DeflateEncoder::new(Vec::new(), Compression::best());
    packed.write_all(content).unwrap();
    let packed = packed.finish().unwrap();
    let mut crc = flate2::Crc::new();
    crc.update(content);
    let common = |name: &str| {
        let sizes = [crc.sum(), packed.len() as u32, content.len() as u32];
        let fixed = [20, 0, 0, 0, 8, 0, 0, 0, 0, 0];
        let length = (name.len() as u16).to_le_bytes();
        [&fixed[..], &numbers(&sizes), &length, &[0, 0]].concat()
    };
    let mut all = [b"PK\x03\x04", &common("")[..], &packed].concat();
    let begin = all.len();
    for name in names {
        let head = common(name);
        all.extend([b"PK\x01\x02\x14\0", &head[..], &[0; 14], name.as_bytes()].concat());
    }
    let length = (all.len() - begin) as u32;
    let count = (names.len() as u16).to_le_bytes();
    all.extend(b"PK\x05\x06\0\0\0\0");
    all.extend([count, count].concat());
    all.extend(numbers(&[length, begin as u32]));
    all.extend([0, 0]);
    all
}

fn npy(form: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{form}', 'fortran_order': False, 'shape': {shape}, }}\n");
    let length = (header.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\0", &length[..], header.as_bytes(), data].concat()
}

fn mat(variables: &[Vec<u8>]) -> Vec<u8> {
    let mut file = b"MATLAB 5.0 MAT-file".to_vec();
    file.resize(124, b' ');
    file.extend([0, 1, b'I', b'M']);
    [file, variables.concat()].concat()
}

fn element(kind: u32, content: &[u8]) -> Vec<u8> {
    let mut all = numbers(&[kind, content.len() as u32]);
    all.extend(content);
    all.resize(all.len().next_multiple_of(8), 0);
    all
}

/// A variable of a class, in columns.
fn matrix(class: u32, name: &str, [rows, columns]: [u32; 2], content: &[u8]) -> Vec<u8> {
    let parts = [
        element(6, &numbers(&[class, 0])),
        element(5, &numbers(&[rows, columns])),
        element(1, name.as_bytes()),
        content.to_vec(),
    ];
    element(14, &parts.concat())
}

/// HDF5 of the oldest form: the messages of the root, then what stands behind it; the root stands at byte 96.
fn hdf5(messages: &[(u16, Vec<u8>)], behind: &[u8]) -> Vec<u8> {
    let mut file = b"\x89HDF\r\n\x1a\n\0\0\0\0\0\x08\x08\0".to_vec();
    file.extend([4, 0, 16, 0, 0, 0, 0, 0]);
    for v in [0, u64::MAX, 0, u64::MAX, 0, 96, 0, 0, 0] {
        file.extend(v.to_le_bytes());
    }
    assert_eq!(file.len(), 96);
    let header = header(messages);
    [file, header, behind.to_vec()].concat()
}

fn header(messages: &[(u16, Vec<u8>)]) -> Vec<u8> {
    let mut all = Vec::new();
    for (kind, data) in messages {
        let mut data = data.clone();
        data.resize(data.len().next_multiple_of(8), 0);
        all.extend(kind.to_le_bytes());
        all.extend((data.len() as u16).to_le_bytes());
        all.extend([0; 4]);
        all.extend(data);
    }
    let count = (messages.len() as u16).to_le_bytes();
    let size = (all.len() as u32).to_le_bytes();
    [&[1, 0][..], &count, &[1, 0, 0, 0], &size, &[0; 4], &all].concat()
}

/// A name that leads to the object at an address.
fn link(name: &str, at: u64) -> (u16, Vec<u8>) {
    let length = (name.len() as u16).to_le_bytes();
    (
        6,
        [&[1, 1][..], &length, name.as_bytes(), &at.to_le_bytes()].concat(),
    )
}

/// Doubles in a side.
fn doubles(side: u64) -> [(u16, Vec<u8>); 2] {
    let space = [&[1, 1, 0, 0, 0, 0, 0, 0][..], &side.to_le_bytes()].concat();
    let form = b"\x11\x20\x3f\0\x08\0\0\0\0\0\x40\0\x34\x0b\0\x34\xff\x03\0\0".to_vec();
    [(1, space), (3, form)]
}

/// A dataset of deflated doubles in one chunk, which the bytes are.
fn packed_dataset(side: u64, chunk: u64, stored: &[u8]) -> Vec<u8> {
    let build = |at: u64| {
        let mut layout = vec![4, 2, 2, 2, 8];
        layout.extend([chunk.to_le_bytes(), 8_u64.to_le_bytes()].concat());
        layout.push(1);
        layout.extend((stored.len() as u64).to_le_bytes());
        layout.extend([0; 4]);
        layout.extend(at.to_le_bytes());
        let [space, form] = doubles(side);
        let filters = (11, vec![2, 1, 1, 0, 0, 0, 0, 0]);
        header(&[space, form, filters, (8, layout)])
    };
    let root = [link("data", 200)];
    let mut file = hdf5(&root, &[]);
    file.resize(200, 0);
    let at = 200 + build(0).len() as u64;
    file.extend(build(at));
    file.extend(stored);
    file
}

/// The beginnings of all formats that are read.
fn beginnings() -> Vec<(&'static str, Vec<u8>)> {
    let mut level5 = mat(&[]);
    level5.truncate(128);
    let mut matlab = b"MATLAB 7.3 MAT-file".to_vec();
    matlab.resize(512, b' ');
    matlab.extend(b"\x89HDF\r\n\x1a\n");
    vec![
        ("tdms", b"TDSm\x0e\0\0\0\x69\x12\0\0".to_vec()),
        ("wav", b"RIFF\xff\xff\xff\xffWAVEfmt ".to_vec()),
        ("lvm", b"LabVIEW Measurement\t\r\n".to_vec()),
        ("uff", b"    -1\r\n    58\r\n".to_vec()),
        ("mat", level5),
        ("mat73", matlab),
        (
            "mat4",
            [numbers(&[0, 9, 9, 0, 2]), b"a\0".to_vec()].concat(),
        ),
        ("npy", b"\x93NUMPY\x01\0".to_vec()),
        ("zip", b"PK\x03\x04".to_vec()),
        ("cwa", b"MD\xfc\x03".to_vec()),
        ("mcap", b"\x89MCAP0\r\n".to_vec()),
        ("hdf5", b"\x89HDF\r\n\x1a\n".to_vec()),
        ("parquet", b"PAR1".to_vec()),
        ("ulog", b"ULog\x01\x12\x35".to_vec()),
        ("ide", b"\x1a\x45\xdf\xa3\x87\x42\x82\x84mide".to_vec()),
        (
            "unisens",
            b"<unisens xmlns=\"http://www.unisens.org/unisens2.0\">".to_vec(),
        ),
        ("geneactiv", b"Device Identity\r\n".to_vec()),
    ]
}

#[test]
fn law_zeros_chance_and_repetition_behind_every_beginning() {
    let beginnings = beginnings();
    let read = FORMATS.iter().filter(|f| f.is_read());
    for format in read {
        assert!(
            beginnings.iter().any(|(word, _)| *word == format.word),
            "{}",
            format.word
        );
    }
    for (word, begin) in beginnings {
        assert_eq!(recognise(&begin).map(|f| f.word), Some(word));
        for (what, rest) in [
            ("nothing", Vec::new()),
            ("zeros", vec![0; 300_000]),
            ("ones", vec![0xFF; 300_000]),
            ("chance", noise(300_000)),
            ("itself", begin.repeat(300_000 / begin.len())),
            ("line ends", vec![b'\n'; 300_000]),
        ] {
            let file = [&begin[..], &rest].concat();
            let _ = bounded(&format!("{word} before {what}"), &file);
        }
    }
}

#[test]
fn refuses_to_unpack_without_bounds() {
    // Zeros pack to a thousandth.
    let zeros = vec![0_u8; 100 << 20];
    let variable = matrix(9, "a", [100 << 20, 1], &element(2, &zeros));
    let bomb = element(15, &zlib(&variable));
    let said = refused("mat", &mat(std::slice::from_ref(&bomb)));
    assert!(said.contains("unpacks to more than"), "{said}");
    let small = matrix(6, "x", [3, 1], &element(2, &[1, 2, 3]));
    let beside = bounded("mat beside", &mat(&[small, bomb])).unwrap();
    assert_eq!(beside.streams()[0].rows, 3);
    assert_eq!(beside.remarks()[0].kind, RemarkKind::PassedOver);
    // Many members that are the same bytes of the archive.
    let array = npy("|u1", "(4194304,)", &zeros[..4 << 20]);
    let names: Vec<String> = (0..1000).map(|i| format!("{i}.npy")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let said = refused("npz", &archive(&names, &array));
    assert!(said.contains("unpacks to more than"), "{said}");
    // A chunk of 4 GB, and one of 100 MB that is really there.
    let said = refused(
        "hdf5, 4 GB",
        &packed_dataset(1 << 29, 1 << 29, &zlib(&[0; 4096])),
    );
    assert!(said.contains("more than are unpacked"), "{said}");
    let chunk = packed_dataset(100 << 17, 100 << 17, &zlib(&zeros));
    let said = refused("hdf5, 100 MB", &chunk);
    assert!(said.contains("chunks of data"), "{said}");
    let sound = packed_dataset(512, 512, &zlib(&[0; 4096]));
    assert_eq!(bounded("hdf5", &sound).unwrap().streams()[0].rows, 512);
    let mut gt3x = b"Sample Rate: 30\r\n".to_vec();
    gt3x.resize(100 << 20, b' ');
    let said = refused("gt3x", &archive(&["info.txt", "log.bin"], &gt3x));
    assert!(said.contains("unpacks to more than"), "{said}");
    // Marks of records one after the other, each of which claims 7710 bytes.
    let marks = [&b"Sample Rate: 30\r\n"[..], &[0x1E; 4 << 20]].concat();
    let _ = bounded("gt3x of marks", &archive(&["info.txt", "log.bin"], &marks));
}

#[test]
fn refuses_sizes_that_cannot_be() {
    // TDMS: a channel of 2^63 bytes, and of as many values.
    for (raw, values) in [(1_u64 << 63, 16_u64), (16, 1 << 60), (u64::MAX, u64::MAX)] {
        let text = |t: &str| [numbers(&[t.len() as u32]), t.as_bytes().to_vec()].concat();
        let mut metadata = numbers(&[1]);
        metadata.extend(text("/'g'/'c'"));
        metadata.extend(numbers(&[20, 10, 1]));
        metadata.extend(values.to_le_bytes());
        metadata.extend(numbers(&[0]));
        let mut file = b"TDSm\x0e\0\0\0\x69\x12\0\0".to_vec();
        file.extend(raw.to_le_bytes());
        file.extend((metadata.len() as u64).to_le_bytes());
        file.extend(metadata);
        file.extend([0; 64]);
        let opened = bounded("tdms", &file);
        assert!(opened.is_err() || opened.unwrap().streams()[0].rows <= 8);
    }
    // WAV: 44 bytes, a size of all ones; no channels; no rate.
    let wav = |channels: u16, rate: u32| {
        let mut file = b"RIFF\xff\xff\xff\xffWAVEfmt \x10\0\0\0\x01\0".to_vec();
        file.extend(channels.to_le_bytes());
        file.extend(numbers(&[rate, 2 * rate]));
        file.extend(b"\x02\0\x10\0data\xff\xff\xff\xff");
        file
    };
    let said = refused("wav", &wav(1, 8000));
    assert!(said.contains("without a single sample"), "{said}");
    assert!(refused("wav", &wav(0, 8000)).contains("0 channels"));
    assert!(refused("wav", &wav(1, 0)).contains("at 0 Hz"));
    // npy: every order of too many, none and some.
    for shape in [
        "(1000000000000000000,)",
        "(0, 1000000000000000000)",
        "(1000000000000000000, 0)",
        "(1, 1000000000000000000)",
        "(3, 1000000000000000000)",
        "(1000000000, 1000000000)",
        "(99999999999999999999,)",
    ] {
        let opened = bounded(shape, &npy("<f8", shape, &[0; 64]));
        assert!(opened.is_err() || opened.unwrap().streams()[0].rows <= 8);
    }
    // MAT: an element of 4 GB; level 4 of 2^62 numbers.
    let long = [numbers(&[14, u32::MAX - 7]), vec![0; 64]].concat();
    let said = refused("mat", &mat(&[long]));
    assert!(said.contains("is longer than the file"), "{said}");
    let level4 = [
        numbers(&[0, 1 << 31, 1 << 31, 0, 2]),
        b"a\0".to_vec(),
        vec![0; 64],
    ];
    let said = refused("mat4", &level4.concat());
    assert!(
        said.contains("impossible size") || said.contains("longer than"),
        "{said}"
    );
    // HDF5: chunks of 2^40 doubles.
    let _ = refused("hdf5", &packed_dataset(1 << 62, 1 << 40, &zlib(&[0; 64])));
    // UFF: 10^12 points.
    let head = |step: &str, points: &str, form: &str| {
        let mut lines = vec!["    -1".to_owned(), "    58".to_owned()];
        lines.extend(["NONE"; 5].map(str::to_owned));
        lines.push("    1         0    0         0 NONE 1 3 NONE 1 3".to_owned());
        lines.push(format!(
            "{form:>10}{points:>10}{:>10}{:>13}{step:>13}",
            1, "0.0"
        ));
        lines.push("        17    0    0    0 Time                 s".to_owned());
        lines.extend(["         0    0    0    0 NONE                 NONE"; 3].map(str::to_owned));
        lines.push("  1.00000e+00  2.00000e+00".to_owned());
        lines.push("    -1\n".to_owned());
        lines.join("\n").into_bytes()
    };
    let long = bounded("uff", &head("1.0e-3", "9999999999", "2")).unwrap();
    assert_eq!(long.streams()[0].rows, 2);
    assert_eq!(long.remarks()[0].kind, RemarkKind::Cut);
    // Steps that are no step: the numbers are read, without a rate.
    for step in ["0.0", "-1.0e-3", "nan", "inf", "4.9e-324"] {
        let opened = bounded("uff", &head(step, "2", "2")).unwrap();
        assert_eq!(opened.streams()[0].clock, Clock::Unsaid, "{step}");
        let sound = bounded("uff", &head("1.0e-3", "2", "2")).unwrap();
        assert!(matches!(sound.streams()[0].clock, Clock::Rate { .. }));
    }
    // LVM: a million columns, in lines that have one field; a step of none.
    let lvm = |channels: usize, step: &str, lines: &str| {
        let headings = "\tx".repeat(channels);
        let steps = format!("\t{step}").repeat(channels.min(9));
        format!(
            "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tNo\n***End_of_Header***\t\n\nChannels\t{channels}\nDelta_X{steps}\n***End_of_Header***\nX_Value{headings}\n{lines}"
        )
    };
    let said = refused("lvm", &lvm(100_000, "1", &"1\n".repeat(5000)).into_bytes());
    assert!(said.contains("far fewer fields"), "{said}");
    let said = refused("lvm", &lvm(1_000_000, "1", "\t1\n").into_bytes());
    assert!(said.contains("longer than 1 MiB"), "{said}");
    for step in ["0", "-1", "NaN", "inf", "4.9e-324"] {
        let file = lvm(1, step, "\t1\n\t2\n").into_bytes();
        let opened = bounded("lvm", &file).unwrap();
        assert_eq!(opened.streams()[0].clock, Clock::Unsaid, "{step}");
    }
    // IDE: elements in each other, and one of 2^56 bytes.
    let ide =
        b"\x1a\x45\xdf\xa3\x87\x42\x82\x84mide\x18\x53\x80\x67\x01\xff\xff\xff\xff\xff\xff\xff";
    for nested in [
        &b"\x18\x52\x65\x70\xff"[..],
        b"\xa1\xff",
        b"\xa0\x01\xff\xff\xff\xff\xff\xff\xfe",
    ] {
        let _ = refused("ide", &[&ide[..], &nested.repeat(10_000)].concat());
    }
    let mut nested: Vec<u8> = Vec::new();
    for _ in 0..10_000 {
        let size = (nested.len() as u32 | 0x1000_0000).to_be_bytes();
        nested = [&b"\x52\x70"[..], &size, &nested].concat();
    }
    let size = (nested.len() as u32 | 0x1000_0000).to_be_bytes();
    let _ = refused(
        "ide",
        &[&ide[..], b"\x18\x52\x65\x70", &size, &nested].concat(),
    );
    // ULog: a message of 65535 bytes at the end.
    let ulog = include_bytes!("seeds/two.ulg");
    let whole = bounded("ulog", ulog).unwrap();
    let long = bounded("ulog", &[&ulog[..], b"\xff\xffD\0\0"].concat()).unwrap();
    assert_eq!(long.streams()[0].rows, whole.streams()[0].rows);
    assert!(long.remarks().iter().any(|r| r.kind == RemarkKind::Cut));
}

#[test]
fn refuses_circles() {
    // A group that holds itself under many names, a header that goes on in itself, an index whose node leads to itself.
    let names: Vec<_> = (0..1000).map(|i| link(&format!("{i}"), 96)).collect();
    let _ = refused("hdf5, a group in itself", &hdf5(&names, &[]));
    let on = [96_u64.to_le_bytes(), 64_u64.to_le_bytes()].concat();
    let again = [112_u64.to_le_bytes(), 24_u64.to_le_bytes()].concat();
    let _ = refused(
        "hdf5, a header as its own part",
        &hdf5(&[(16, on)], &[0; 64]),
    );
    let said = refused("hdf5, a header in itself", &hdf5(&[(16, again)], &[]));
    assert!(said.contains("circle"), "{said}");
    let table = (17, [136_u64.to_le_bytes(), 400_u64.to_le_bytes()].concat());
    let mut behind = b"TREE\0\xff\x01\0".to_vec();
    behind.extend(
        [u64::MAX, u64::MAX, 0, 136, 0]
            .iter()
            .flat_map(|v| v.to_le_bytes()),
    );
    let mut file = hdf5(&[table], &behind);
    assert_eq!(file[136..140], *b"TREE");
    file.resize(400, 0);
    file.extend(b"HEAP\0\0\0\0");
    file.extend([8_u64, u64::MAX, 432].iter().flat_map(|v| v.to_le_bytes()));
    file.extend([0; 64]);
    let said = refused("hdf5, a node in itself", &file);
    assert!(said.contains("index of a group"), "{said}");
    // Structures in each other.
    let mut inside = matrix(6, "", [2, 1], &element(2, &[1, 2]));
    for _ in 0..10_000 {
        let content = [
            element(5, &numbers(&[8])),
            element(1, b"inside\0\0"),
            inside,
        ];
        inside = matrix(2, "", [1, 1], &content.concat());
    }
    let said = refused("mat", &mat(&[inside]));
    assert!(said.contains("structures within structures"), "{said}");
    // Sides whose product is beyond every number.
    let sides = element(5, &[0xFF, 0xFF, 0xFF, 0x7F].repeat(64));
    let content = [element(6, &numbers(&[2, 0])), sides, element(1, b"s")];
    let fields = [element(5, &numbers(&[8])), element(1, b"inside\0\0")];
    let file = mat(&[element(14, &[content.concat(), fields.concat()].concat())]);
    let _ = refused("mat", &file);
}

#[test]
fn law_names_are_short_and_plain() {
    let long = "<script>\u{1b}[31m\n\u{7}".repeat(600_000);
    let variable = |name: &str| matrix(9, name, [300, 2], &element(9, &[0; 4800]));
    let twice = mat(&[
        variable(&long),
        variable("a\u{1b}[2J"),
        variable("a\u{1b}[2J"),
    ]);
    let opened = bounded("mat", &twice).unwrap();
    let names: Vec<&str> = opened.streams()[0]
        .channels
        .iter()
        .map(|c| c.name.as_str())
        .collect();
    assert_eq!(
        names[2..],
        ["a [2J(:,1)", "a [2J(:,2)", "a [2J(:,1)", "a [2J(:,2)"]
    );
    assert!(names[0].starts_with("<script> [31m") && names[0].chars().count() <= 210);
    // A name of 60 kB above a thousand objects, and above a thousand numbers of an element.
    let deep = "x".repeat(60_000);
    let at = 96 + hdf5(&[link(&deep, 0)], &[]).len() as u64 - 96;
    let objects: Vec<_> = (0..1000).map(|i| link(&format!("{i}"), 104 + i)).collect();
    let _ = bounded("hdf5", &hdf5(&[link(&deep, at)], &header(&objects)));
    // A card with a name for each of its places.
    let text = |t: &str| [numbers(&[t.len() as u32]), t.as_bytes().to_vec()].concat();
    let mut metadata = numbers(&[2]);
    for path in [
        format!("/'g\u{1b}'/'{long}'"),
        "/'g\u{1b}'/'\u{8}'".to_owned(),
    ] {
        metadata.extend(text(&path));
        metadata.extend(numbers(&[20, 10, 1]));
        metadata.extend(2_u64.to_le_bytes());
        metadata.extend(
            [
                numbers(&[1]),
                text("unit_string"),
                numbers(&[0x20]),
                text("V\u{7}"),
            ]
            .concat(),
        );
    }
    let mut file = b"TDSm\x0e\0\0\0\x69\x12\0\0".to_vec();
    file.extend((metadata.len() as u64 + 32).to_le_bytes());
    file.extend((metadata.len() as u64).to_le_bytes());
    let file = [file, metadata, vec![0; 32]].concat();
    assert_eq!(
        bounded("tdms", &file).unwrap().streams()[0].channels.len(),
        2
    );
    // ULog: a field of a long name that is an array, in sixteen instances.
    let message = |kind: u8, content: &[u8]| {
        [&(content.len() as u16).to_le_bytes()[..], &[kind], content].concat()
    };
    let mut log = b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0".to_vec();
    let format = format!(
        "sensor_accel:uint64_t timestamp;uint8_t[500] {};",
        "y".repeat(60_000)
    );
    log.extend(message(b'F', format.as_bytes()));
    for instance in 0..16 {
        log.extend(message(
            b'A',
            &[&[instance, instance, 0][..], b"sensor_accel"].concat(),
        ));
        log.extend(message(b'D', &[&[instance, 0][..], &[0; 508]].concat()));
    }
    log.extend(message(
        b'A',
        &[&[0, 99, 0][..], &[b'\x1b'; 60_000]].concat(),
    ));
    log.extend(message(b'D', &[99, 0, 1]));
    let opened = bounded("ulog", &log).unwrap();
    assert_eq!(
        (opened.streams().len(), opened.streams()[0].channels.len()),
        (16, 501)
    );
}

#[test]
fn refuses_scales_without_end() {
    // A TDMS channel of 65536 bytes that declares so many scales, each of which would be held.
    let text = |t: &str| [numbers(&[t.len() as u32]), t.as_bytes().to_vec()].concat();
    let file = |scales: u32| {
        let mut metadata = numbers(&[1]);
        metadata.extend(text("/'g'/'c'"));
        metadata.extend(numbers(&[20, 1, 1]));
        metadata.extend(65_536_u64.to_le_bytes());
        metadata.extend(
            [
                numbers(&[1]),
                text("NI_Number_Of_Scales"),
                numbers(&[7, scales]),
            ]
            .concat(),
        );
        let mut file = b"TDSm\x0e\0\0\0\x69\x12\0\0".to_vec();
        file.extend((metadata.len() as u64 + 65_536).to_le_bytes());
        file.extend((metadata.len() as u64).to_le_bytes());
        [file, metadata, vec![1; 65_536]].concat()
    };
    assert_eq!(bounded("some", &file(3)).unwrap().streams()[0].rows, 65_536);
    let said = refused("many", &file(100_000));
    assert!(said.contains("declares 100000 scales"), "{said}");
}

/// A short run of what `examples/damage.rs` does with whole folders.
#[test]
fn law_damaged_seeds_cost_no_time_or_memory() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/seeds");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let worst = damage::damage(&std::fs::read(&path).unwrap(), Some(400));
        let name = path.display();
        assert!(worst.panics.is_empty(), "{name}: {:?}", worst.panics);
        assert!(worst.seconds.0 < 2.0, "{name}: {:?}", worst.seconds);
        assert!(worst.bytes.0 < 64_000_000, "{name}: {:?}", worst.bytes);
        seen += worst.copies;
    }
    assert!(seen > 8000, "{seen}");
}
