use crate::stream::tests::{columns, open, survives};
use crate::{Clock, RemarkKind};

fn message(kind: u8, content: &[u8]) -> Vec<u8> {
    let length = (content.len() as u16).to_le_bytes();
    [&length[..], &[kind], content].concat()
}

fn header(start: u64) -> Vec<u8> {
    [b"ULog\x01\x12\x35\x01", &start.to_le_bytes()[..]].concat()
}

fn flags(incompatible: u8, appended: u64) -> Vec<u8> {
    let mut content = [0; 40];
    content[8] = incompatible;
    content[16..24].copy_from_slice(&appended.to_le_bytes());
    message(b'B', &content)
}

fn subscription(id: u8, instance: u8, name: &str) -> Vec<u8> {
    message(b'A', &[&[instance, id, 0][..], name.as_bytes()].concat())
}

const ACCEL: &[u8] = b"sensor_accel:uint64_t timestamp;uint64_t timestamp_sample;float x;float[2] yz;point p;char[3] word;uint8_t[5] _padding0;";
const POINT: &[u8] = b"point:int16_t a;uint8_t[2] _padding0;";

/// A message of the above, taken 100 µs before it is published; without the padding.
fn accel(id: u8, sampled: u64, x: f32) -> Vec<u8> {
    let mut content = vec![id, 0];
    content.extend((sampled + 100).to_le_bytes());
    content.extend(sampled.to_le_bytes());
    content.extend([x, 2.0 * x, 3.0 * x].iter().flat_map(|v| v.to_le_bytes()));
    content.extend([0xFE, 0xFF, 9, 9, b'a', b'b', b'c']);
    message(b'D', &content)
}

fn definitions() -> Vec<u8> {
    [
        header(1_000_000),
        flags(0, 0),
        message(b'F', POINT),
        message(b'F', ACCEL),
        message(b'F', b"cpuload:uint64_t timestamp;float load;"),
        message(b'I', b"\x0Fchar[3] sys_name"),
        subscription(3, 0, "sensor_accel"),
        subscription(4, 1, "sensor_accel"),
        subscription(5, 0, "cpuload"),
    ]
    .concat()
}

fn log() -> Vec<u8> {
    [
        definitions(),
        accel(3, 1_250_000, 0.5),
        accel(4, 1_500_000, 8.0),
        super::SYNC.to_vec(),
        message(b'O', &[20, 0]),
        message(b'D', &[5; 14]),
        message(b'O', &[22, 1]),
        accel(3, 1_251_000, 1.5),
    ]
    .concat()
}

#[test]
fn known_topics_their_instances_and_dropouts() {
    let mut content = log();
    let cpu = content.windows(3).position(|w| w == [5, 5, 5]).unwrap();
    content[cpu..cpu + 2].copy_from_slice(&[5, 0]);
    let container = open(&content).unwrap();
    let streams = container.streams();
    let names: Vec<&str> = streams.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["sensor_accel", "sensor_accel_1"]);
    assert_eq!(streams[0].clock, Clock::Times);
    assert_eq!(streams[0].origin_ns, Some(1_000_000_000));
    let words = streams[0].channels.iter();
    let words: Vec<_> = words
        .map(|c| (c.name.as_str(), c.unit.as_deref()))
        .collect();
    assert_eq!(
        words,
        [
            ("x", Some("m/s2")),
            ("yz[0]", None),
            ("yz[1]", None),
            ("p.a", None),
            ("time", Some("s"))
        ]
    );
    let said: Vec<_> = container
        .remarks()
        .iter()
        .map(|r| (r.kind, r.text.as_str()))
        .collect();
    assert_eq!(
        said,
        [
            (
                RemarkKind::Damaged,
                "what the logger could not write in time: 2 dropouts, 298 ms in all"
            ),
            (RemarkKind::PassedOver, "the topics cpuload")
        ]
    );
    let all = columns(container, 0);
    assert_eq!(all[0], [0.5, 1.5]);
    assert_eq!(all[2], [1.5, 4.5]);
    assert_eq!(all[3], [-2.0, -2.0]);
    // When it was sampled, from the beginning of the log on.
    assert_eq!(all[4], [0.25, 0.251]);
    assert_eq!(columns(open(&content).unwrap(), 1)[0], [8.0]);
    survives(&content);
}

#[test]
fn known_clock_where_nothing_was_sampled() {
    // The padding may be there.
    let mut padded = accel(3, 0, 1.5);
    padded.extend([0; 5]);
    padded[0] += 5;
    let content = [definitions(), accel(3, 1_250_000, 0.5), padded].concat();
    let all = columns(open(&content).unwrap(), 0);
    assert_eq!(all[4], [0.2501, -0.9999]);
}

#[test]
fn known_rows_before_a_cut_and_behind_damage() {
    let one = |i: u64| accel(3, 1_000_000 + 1000 * i, i as f32);
    let rows: Vec<Vec<u8>> = (0..4).map(one).collect();
    let start = definitions().len();
    let content = [definitions(), rows.concat()].concat();
    for at in start..content.len() {
        let whole = (at - start) / rows[0].len();
        match open(&content[..at]) {
            Ok(container) => {
                assert_eq!(container.streams()[0].rows, whole as u64);
                let cut = container
                    .remarks()
                    .iter()
                    .any(|r| r.kind == RemarkKind::Cut);
                assert_eq!(cut, !(at - start).is_multiple_of(rows[0].len()));
            }
            Err(_) => assert_eq!(whole, 0),
        }
    }
    // A length that leads into nowhere: reading goes on with the next synchronisation.
    let mut damaged = [&content[..], super::SYNC, &one(7)].concat();
    damaged[start + rows[0].len()] = 9;
    let container = open(&damaged).unwrap();
    let text = container.remarks()[0].text.clone();
    assert!(text.contains("are no messages, in 1 places"), "{text}");
    let x = columns(container, 0).swap_remove(0);
    assert_eq!((x[0], x.last()), (0.0, Some(&7.0)));
    // What was being written when data were appended ends there.
    let broken = &one(9)[..20];
    let at = (start + rows.concat().len() + broken.len()) as u64;
    let mut appended = [&content[..], broken, &one(8)].concat();
    appended[16..59].copy_from_slice(&flags(1, at));
    let all = columns(open(&appended).unwrap(), 0);
    assert_eq!(all[0], [0.0, 1.0, 2.0, 3.0, 8.0]);
    // Messages of another length than their definition.
    let short = message(b'D', &[3, 0, 1, 2, 3]);
    let container = open(&[content, short].concat()).unwrap();
    assert!(
        container.remarks()[0]
            .text
            .starts_with("1 messages of sensor_accel")
    );
}

#[test]
fn known_samples_of_a_fifo() {
    let fields = "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float dt;float scale;uint8_t samples;int16_t[4] x;int16_t[4] y;int16_t[4] z;";
    let mut content = vec![1, 0];
    content.extend(
        [5_000_300_u64, 5_000_000]
            .iter()
            .flat_map(|v| v.to_le_bytes()),
    );
    content.extend(1_u32.to_le_bytes());
    content.extend([125.0_f32, 0.5].iter().flat_map(|v| v.to_le_bytes()));
    content.push(3);
    content.extend((0..12_i16).flat_map(|v| (v - 5).to_le_bytes()));
    let content = [
        header(0),
        message(b'F', format!("sensor_accel_fifo:{fields}").as_bytes()),
        subscription(1, 0, "sensor_accel_fifo"),
        message(b'D', &content),
    ]
    .concat();
    // The last sample is at the stamp, those before it 125 µs earlier each.
    let all = columns(open(&content).unwrap(), 0);
    assert_eq!(all[0], [-2.5, -2.0, -1.5]);
    assert_eq!(all[2], [1.5, 2.0, 2.5]);
    assert_eq!(all[3], [4.99975, 4.999875, 5.0]);
    survives(&content);
}

#[test]
fn refuses_what_it_does_not_know() {
    let other = [header(0), flags(2, 0)].concat();
    let error = open(&other).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("incompatible flags 0x2"), "{error}");
    let no_sensor = [definitions(), message(b'D', &[5, 0, 0, 0])].concat();
    let error = open(&no_sensor).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("holds the topics cpuload"), "{error}");
    // Types in themselves, and types of nothing many times over.
    for fields in [
        "sensor_accel a;",
        "none[65535] a;",
        "uint64_t timestamp;uint8_t[9999] b;",
    ] {
        let content = [
            header(0),
            message(b'F', b"none:"),
            message(b'F', format!("sensor_accel:{fields}").as_bytes()),
            subscription(1, 0, "sensor_accel"),
            message(b'D', &[1, 0, 0]),
        ];
        assert!(open(&content.concat()).is_err(), "{fields}");
    }
}

/// The seed of the fuzz target is made by this, so that it can be made again.
#[test]
fn known_seed() {
    let seed = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/seeds/two.ulg");
    assert!(std::fs::read(seed).unwrap() == log());
}
