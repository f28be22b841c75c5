//! Persons, places and notes in the headers of recordings are never passed on: not listed, not in a finding, not in a refusal, also
//! where the file is cut or damaged.

use proofmass_io::{RecordingOptions, Source, inspect_source};

/// Stands for a name, a birth date or a position.
const MARK: &str = "Jane Q Secret";

fn seed(name: &str) -> Vec<u8> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/seeds/");
    std::fs::read(format!("{folder}{name}")).unwrap()
}

fn place(file: &[u8], bytes: &[u8]) -> usize {
    let found = file.windows(bytes.len()).position(|w| w == bytes);
    found.unwrap()
}

/// Puts bytes in at a place.
fn with(mut file: Vec<u8>, at: usize, bytes: &[u8]) -> Vec<u8> {
    file.splice(at..at, bytes.iter().copied());
    file
}

/// All that is said of a file.
fn said(bytes: &[u8]) -> (bool, String) {
    let source = Source::from_bytes("r", bytes).unwrap();
    match inspect_source(source, &RecordingOptions::default(), 10) {
        Ok(seen) => (
            true,
            format!("{seen:?} {}", serde_json::to_string(&seen).unwrap()),
        ),
        Err(error) => (false, format!("{error} {:?} {error:?}", error.hint())),
    }
}

#[track_caller]
fn silent(name: &str, file: &[u8]) {
    assert!(
        file.windows(MARK.len()).any(|w| w == MARK.as_bytes()),
        "{name}"
    );
    let (read, text) = said(file);
    assert!(read, "{name}: {text}");
    let hidden = |text: &str| !["Jane", "Secret"].iter().any(|part| text.contains(part));
    assert!(hidden(&text), "{name}: {text}");
    for at in 0..file.len() {
        let (_, text) = said(&file[..at]);
        assert!(hidden(&text), "{name}, cut at {at}: {text}");
        let mut inverted = file.to_vec();
        inverted[at] ^= 0xFF;
        let (_, text) = said(&inverted);
        assert!(hidden(&text), "{name}, byte {at} inverted: {text}");
    }
}

#[test]
fn law_headers_of_loggers_are_not_passed_on() {
    // The annotation of the header of a CWA file.
    let mut cwa = seed("three.cwa");
    for at in (64..900).step_by(32) {
        cwa[at..at + MARK.len()].copy_from_slice(MARK.as_bytes());
    }
    silent("cwa", &cwa);
    let geneactiv = seed("one.geneactiv");
    let at = place(&geneactiv, b"Recorded Data");
    let lines = format!(
        "Subject Code:{MARK}\r\nDate of Birth:{MARK}\r\nSubject Notes:{MARK}\r\nRecording Location:{MARK}\r\n"
    );
    silent("geneactiv", &with(geneactiv, at, lines.as_bytes()));
    // An information, a logged text and a position of a ULog.
    let ulog = seed("two.ulg");
    let message = |kind: u8, content: &[u8]| {
        [&(content.len() as u16).to_le_bytes()[..], &[kind], content].concat()
    };
    let key = b"char[13] sys_name";
    let more = [
        message(
            b'I',
            &[&[key.len() as u8][..], key, MARK.as_bytes()].concat(),
        ),
        message(b'L', &[&[6; 9][..], MARK.as_bytes()].concat()),
    ];
    let at = ulog.len();
    silent("ulog", &with(ulog, at, &more.concat()));
    // Name of the recorder, of the user, and what is not known, before the description of an IDE file.
    let ide = seed("two.ide");
    let at = place(&ide, b"\x18\x52\x65\x70");
    let element = [
        &b"\x52\x01"[..],
        &[0x80 | MARK.len() as u8],
        MARK.as_bytes(),
    ]
    .concat();
    let tagged = [&b"\x45\x39"[..], &[0x80 | element.len() as u8], &element].concat();
    silent("ide", &with(ide, at, &tagged));
}

#[test]
fn law_notes_of_other_recordings_are_not_passed_on() {
    // The text before a MAT file, and a variable of text.
    let mut mat = seed("plain.mat");
    mat[24..24 + MARK.len()].copy_from_slice(MARK.as_bytes());
    let pad = |mut bytes: Vec<u8>| {
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    };
    let element = |kind: u32, content: &[u8]| {
        let length = content.len() as u32;
        pad([&kind.to_le_bytes()[..], &length.to_le_bytes(), content].concat())
    };
    let words = |all: &[u32]| {
        all.iter()
            .flat_map(|v| v.to_le_bytes())
            .collect::<Vec<u8>>()
    };
    let parts = [
        element(6, &words(&[4, 0])),
        element(5, &words(&[1, MARK.len() as u32])),
        element(1, b"operator"),
        element(16, MARK.as_bytes()),
    ];
    mat.extend(element(14, &parts.concat()));
    silent("mat", &mat);
    let lvm = seed("two.lvm");
    let at = place(&lvm, b"***End_of_Header***");
    let lines = format!("Operator\t{MARK}\r\nDescription\t{MARK}\r\nProject\t{MARK}\r\n");
    silent("lvm", &with(lvm, at, lines.as_bytes()));
    // A chunk of notes of a WAV file.
    let wav = seed("two.wav");
    let at = place(&wav, b"data");
    let note = [b"LIST\x1a\0\0\0INFOIART\x0e\0\0\0", MARK.as_bytes(), b"\0"].concat();
    silent("wav", &with(wav, at, &note));
    // A record of metadata and an attachment of an MCAP log.
    let mcap = seed("two.mcap");
    let word = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let pair = [word("operator"), word(MARK)].concat();
    let content = [
        word("notes"),
        (pair.len() as u32).to_le_bytes().to_vec(),
        pair,
    ]
    .concat();
    let record = [&[12][..], &(content.len() as u64).to_le_bytes(), &content].concat();
    silent("mcap", &with(mcap, 8, &record));
    // The lines of description of a universal file.
    let uff = seed("two.uff");
    let mut lines: Vec<&[u8]> = uff.split(|b| *b == b'\n').collect();
    lines[2] = MARK.as_bytes();
    lines[5] = MARK.as_bytes();
    silent("uff", &lines.join(&b'\n'));
}
