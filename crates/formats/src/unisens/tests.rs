//! A recording built by hand from the published description of the format (movisens, docs.movisens.com/Unisens/UnisensFileFormat).

use crate::stream::SeekRead;
use crate::{Clock, Container, Error, RemarkKind};
use std::io::Cursor;

const DESCRIPTION: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<u:unisens xmlns:u="http://www.unisens.org/unisens2.0" measurementId="m" timestampStart="2008-07-04T13:27:57" version="2.0">
  <u:signalEntry id="acc.bin" dataType="int16" sampleRate="64" lsbValue="0.00048828125" baseline="2" adcZero="9" unit="g">
    <u:binFileFormat endianess="LITTLE"/>
    <u:channel name="accX"/><u:channel name="accY"/>
  </u:signalEntry>
  <u:signalEntry id="press.bin" dataType="float" sampleRate="8" unit="Pa">
    <u:binFileFormat endianess="BIG"/><u:channel name="p"/>
  </u:signalEntry>
  <u:signalEntry id="temp.csv" dataType="double" sampleRate="0.5" unit="degrees Celsius">
    <u:csvFileFormat separator=";" decimalSeparator=","/><u:channel name="temp"/>
  </u:signalEntry>
  <u:valuesEntry id="rr.csv" dataType="int32" lsbValue="0.5" sampleRate="4" unit="mmHg">
    <u:csvFileFormat separator="," decimalSeparator="."/><u:channel name="up"/><u:channel name="down"/>
  </u:valuesEntry>
  <u:eventEntry id="trigger.csv" sampleRate="200"><u:csvFileFormat separator=","/></u:eventEntry>
  <u:signalEntry id="../secret.bin" dataType="int16" sampleRate="64"><u:binFileFormat/><u:channel name="s"/></u:signalEntry>
  <u:signalEntry id="gone.bin" dataType="int16" sampleRate="64"><u:binFileFormat/><u:channel name="s"/></u:signalEntry>
</u:unisens>"#;

fn file(name: &str) -> Option<Vec<u8>> {
    let numbers: [i16; 4] = [2, 2050, -2046, 4];
    Some(match name {
        // A byte of a sample that was not finished.
        "acc.bin" => [&numbers.map(i16::to_le_bytes).concat()[..], &[7]].concat(),
        "press.bin" => [1.5_f32, -2.0].map(f32::to_be_bytes).concat(),
        "temp.csv" => b"21,25;\r\n21,5;\r\n".to_vec(),
        "rr.csv" => b"0,120,80\n6,121,79".to_vec(),
        "gone.bin" => return None,
        _ => panic!("{name} was asked for"),
    })
}

fn open(description: &str) -> Result<Container, Error> {
    let own = Box::new(Cursor::new(description.as_bytes().to_vec()));
    Container::open_beside(own, &mut |name| {
        Ok(file(name).map(|bytes| Box::new(Cursor::new(bytes)) as Box<dyn SeekRead>))
    })
}

fn numbers(stream: usize, channels: usize) -> Vec<Vec<f64>> {
    let all: Vec<usize> = (0..channels).collect();
    let mut rows = open(DESCRIPTION).unwrap().rows(stream, &all).unwrap();
    let mut block = vec![Vec::new(); channels];
    rows.next_block(&mut block).unwrap();
    block
}

#[test]
fn known_files_beside_a_description() {
    let container = open(DESCRIPTION).unwrap();
    let streams = container.streams();
    let names: Vec<&str> = streams.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["acc.bin", "press.bin", "temp.csv", "rr.csv"]);
    let rate = |hz| Clock::Rate { hz, start_s: 0.0 };
    assert_eq!(streams[0].clock, rate(64.0));
    assert_eq!(streams[2].clock, rate(0.5));
    assert_eq!(streams[3].clock, Clock::Times);
    // `date -u -d 2008-07-04T13:27:57 +%s`
    assert_eq!(streams[0].origin_ns, Some(1_215_178_077_000_000_000));
    assert_eq!(streams[0].channels[1].name, "accY");
    assert_eq!(streams[0].channels[1].unit.as_deref(), Some("g"));
    assert_eq!(streams[0].channels[1].scaling.as_deref(), Some("linear"));
    assert_eq!(streams[1].channels[0].scaling, None);
    assert_eq!(numbers(0, 2), [[0.0, -1.0], [1.0, 2.0 / 2048.0]]);
    assert_eq!(numbers(1, 1), [[1.5, -2.0]]);
    assert_eq!(numbers(2, 1), [[21.25, 21.5]]);
    assert_eq!(numbers(3, 3), [[60.0, 60.5], [40.0, 39.5], [0.0, 1.5]]);
    let remarks = container.remarks();
    let said = |kind, words: &str| {
        let all = remarks.iter().filter(|r| r.kind == kind);
        assert_eq!(
            all.filter(|r| r.text.contains(words)).count(),
            1,
            "{words}: {remarks:?}"
        );
    };
    said(RemarkKind::Cut, "\"acc.bin\" ends within sample 3");
    said(RemarkKind::PassedOver, "\"gone.bin\"");
    said(RemarkKind::PassedOver, "\"trigger.csv\"");
    said(
        RemarkKind::PassedOver,
        "\"../secret.bin\": is no name of a file beside",
    );
    assert_eq!(remarks.len(), 4);
}

#[test]
fn refuses_a_description_alone() {
    let own = Box::new(Cursor::new(DESCRIPTION.as_bytes().to_vec()));
    let error = Container::open(own).err().unwrap().to_string();
    assert!(error.contains("of which nothing lies beside it"), "{error}");
}

/// Cut or damaged anywhere: the files that are still described, or an error; never more than the files that are there.
#[test]
fn law_a_damaged_description_ends_nothing() {
    for at in 0..DESCRIPTION.len() {
        let mut bytes = DESCRIPTION.as_bytes().to_vec();
        bytes.truncate(at);
        for bytes in [bytes, {
            let mut inverted = DESCRIPTION.as_bytes().to_vec();
            inverted[at] = !inverted[at];
            inverted
        }] {
            let opened = Container::open_beside(Box::new(Cursor::new(bytes)), &mut |name| {
                assert!(!name.contains(['/', '\\']), "{name}");
                let there = ["acc.bin", "press.bin", "temp.csv", "rr.csv"].contains(&name);
                let bytes = there.then(|| file(name)).flatten();
                Ok(bytes.map(|b| Box::new(Cursor::new(b)) as Box<dyn SeekRead>))
            });
            let Ok(container) = opened else {
                continue;
            };
            let rows = container.streams().iter().map(|s| s.rows);
            assert!(rows.max().is_some_and(|rows| rows <= 9));
        }
    }
}

#[test]
fn refuses_fields_that_are_no_numbers() {
    let container = open(&DESCRIPTION.replace("decimalSeparator=\",\"", "decimalSeparator=\".\""));
    let remarks = container.unwrap().remarks().to_vec();
    let what = "\"temp.csv\": line 1: \"21,25\" in column 1 is no number";
    assert!(remarks.iter().any(|r| r.text == what), "{remarks:?}");
}
