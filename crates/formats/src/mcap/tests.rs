use crate::stream::tests::{Writer, columns, open, survives};
use crate::{Clock, RemarkKind};
use flate2::Crc;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use twox_hash::XxHash32;

const LITTLE: Writer = Writer { big: false };
const BIG: Writer = Writer { big: true };
const IMU: &str = "sensor_msgs/msg/Imu";

fn word(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

fn record(op: u8, content: &[u8]) -> Vec<u8> {
    [&[op][..], &(content.len() as u64).to_le_bytes(), content].concat()
}

fn schema(id: u8, name: &str) -> Vec<u8> {
    record(
        3,
        &[
            &[id, 0][..],
            &word(name),
            &word("ros2msg"),
            &word("float64 x"),
        ]
        .concat(),
    )
}

fn channel(id: u8, schema: u8, topic: &str, encoding: &str) -> Vec<u8> {
    let fixed = [id, 0, schema, 0];
    record(
        4,
        &[&fixed[..], &word(topic), &word(encoding), &word("")].concat(),
    )
}

/// Logged a second after the stamp in it.
fn message(channel: u8, second: u32, content: &[u8]) -> Vec<u8> {
    let logged = (u64::from(second) + 1) * 1_000_000_000;
    let mut all = vec![channel, 0, 0, 0, 0, 0];
    all.extend([logged.to_le_bytes(), logged.to_le_bytes()].concat());
    all.extend(content);
    record(5, &all)
}

fn crc(bytes: &[u8]) -> u32 {
    let mut crc = Crc::new();
    crc.update(bytes);
    crc.sum()
}

fn chunk(how: &str, records: &[u8], packed: &[u8], crc: u32) -> Vec<u8> {
    let mut all = vec![0; 16];
    all.extend((records.len() as u64).to_le_bytes());
    all.extend(crc.to_le_bytes());
    all.extend(word(how));
    all.extend((packed.len() as u64).to_le_bytes());
    all.extend(packed);
    record(6, &all)
}

fn file(records: &[Vec<u8>]) -> Vec<u8> {
    [super::MAGIC, &records.concat()].concat()
}

/// The end of the data without a check sum, a summary and the footer.
fn end(data: &mut Vec<u8>, summary: &[u8]) {
    data.extend(record(15, &[0; 4]));
    let at = if summary.is_empty() {
        0
    } else {
        data.len() as u64
    };
    let mut footer = [
        &[2, 20, 0, 0, 0, 0, 0, 0, 0][..],
        &at.to_le_bytes(),
        &[0; 8],
    ]
    .concat();
    footer.extend(crc(&[summary, &footer].concat()).to_le_bytes());
    data.extend([summary, &footer, super::MAGIC].concat());
}

/// An Imu with accelerations a, 2a, 3a, and an orientation only where asked for.
fn imu_numbers(w: Writer, a: f64, oriented: bool) -> Vec<u8> {
    let mut doubles = vec![0.0; 37];
    doubles[3] = 1.0;
    doubles[4] = if oriented { 0.01 } else { -1.0 };
    doubles[13..16].copy_from_slice(&[10.0 * a, 20.0 * a, 30.0 * a]);
    doubles[25..28].copy_from_slice(&[a, 2.0 * a, 3.0 * a]);
    doubles.into_iter().flat_map(|v| w.f64(v)).collect()
}

fn imu_cdr(w: Writer, (second, ns): (u32, u32), frame: &str, a: f64, oriented: bool) -> Vec<u8> {
    let mut all = vec![0, u8::from(!w.big), 0, 0];
    for v in [second, ns, frame.len() as u32 + 1] {
        all.extend(w.u32(v));
    }
    all.extend([frame.as_bytes(), &[0]].concat());
    all.resize(4 + (all.len() - 4).next_multiple_of(8), 0xEE);
    [all, imu_numbers(w, a, oriented)].concat()
}

fn imu_ros1((second, ns): (u32, u32), frame: &str, a: f64) -> Vec<u8> {
    let head = [7, second, ns].map(u32::to_le_bytes).concat();
    [head, word(frame), imu_numbers(LITTLE, a, true)].concat()
}

fn definitions() -> Vec<u8> {
    [schema(1, IMU), channel(1, 1, "/imu", "cdr")].concat()
}

/// Two messages a second apart from a second on.
fn two(second: u32) -> Vec<u8> {
    let one = |s: u32| message(1, s, &imu_cdr(LITTLE, (s, 0), "imu", f64::from(s), false));
    [one(second), one(second + 1)].concat()
}

/// An LZ4 frame of a stored block of the first half and of a block of literals for the rest.
fn lz4(content: &[u8]) -> Vec<u8> {
    let descriptor = [0x64, 0x40];
    let (stored, literals) = content.split_at(content.len() / 2);
    let mut all = 0x184D_2204_u32.to_le_bytes().to_vec();
    all.extend(descriptor);
    all.push((XxHash32::oneshot(0, &descriptor) >> 8) as u8);
    all.extend((stored.len() as u32 | 1 << 31).to_le_bytes());
    all.extend(stored);
    let more = literals.len() - 15;
    let mut block = vec![0xF0];
    block.extend(vec![255; more / 255]);
    block.push((more % 255) as u8);
    block.extend(literals);
    all.extend((block.len() as u32).to_le_bytes());
    all.extend(block);
    all.extend([0; 4]);
    all.extend(XxHash32::oneshot(0, content).to_le_bytes());
    all
}

fn zstd(content: &[u8]) -> Vec<u8> {
    compress_to_vec(content, CompressionLevel::Fastest)
}

#[test]
fn known_messages_of_ros_1_and_2_in_both_orders_and_no_summary() {
    let odd = "an odd frame";
    let log = file(&[
        record(1, &[word("ros2"), word("a test")].concat()),
        schema(1, IMU),
        schema(2, "sensor_msgs/Imu"),
        schema(3, "std_msgs/msg/String"),
        channel(1, 1, "/big", "cdr"),
        channel(2, 2, "/one", "ros1"),
        channel(3, 3, "/chatter", "cdr"),
        channel(4, 1, "/packed", "protobuf"),
        message(
            1,
            5,
            &imu_cdr(BIG, (1_700_000_000, 123_456_789), odd, 1.5, false),
        ),
        message(2, 1, &imu_ros1((1_700_000_000, 123_456_790), "x", 2.5)),
        // Stamps that go back, and twice, stay as they are; so do frames of another length.
        message(1, 6, &imu_cdr(BIG, (1_699_999_999, 0), "", 3.5, false)),
        message(
            1,
            7,
            &imu_cdr(LITTLE, (1_699_999_999, 0), "abc", 4.5, false),
        ),
        message(3, 1, b"\0\x01\0\0\x02\0\0\0x\0"),
        message(4, 1, b"\x08\x01"),
    ]);
    let container = open(&log).unwrap();
    let names: Vec<&str> = container
        .streams()
        .iter()
        .map(|s| s.name.as_str())
        .collect();
    assert_eq!(names, ["/big", "/one"]);
    let big = &container.streams()[0];
    assert_eq!(
        (big.clock, big.origin_ns),
        (Clock::Times, Some(1_700_000_000_123_456_789))
    );
    // Without the orientation, whose covariance is −1.
    let words = big
        .channels
        .iter()
        .map(|c| (c.name.as_str(), c.unit.as_deref()));
    let words: Vec<(&str, Option<&str>)> = words.collect();
    assert_eq!(words[0], ("angular_velocity.x", Some("rad/s")));
    assert_eq!(words[3], ("linear_acceleration.x", Some("m/s2")));
    assert_eq!((words[6], words.len()), (("time", Some("s")), 7));
    assert_eq!(container.streams()[1].channels.len(), 11);
    let [cut, other] = container.remarks() else {
        panic!()
    };
    assert_eq!(cut.kind, RemarkKind::Cut);
    assert_eq!(
        other.text,
        "/chatter (std_msgs/msg/String, 1 messages), /packed (sensor_msgs/msg/Imu, 1 messages in protobuf)"
    );
    let all = columns(container, 0);
    assert_eq!(all[0], [15.0, 35.0, 45.0]);
    assert_eq!(all[5], [4.5, 10.5, 13.5]);
    assert_eq!(all[6], [0.0, -1.123456789, -1.123456789]);
    let all = columns(open(&log).unwrap(), 1);
    assert_eq!((all[3][0], all[7][0], all[10][0]), (1.0, 2.5, 1e-9));
    survives(&log);
}

#[test]
fn known_places_of_an_odometry_behind_two_texts() {
    let text = |t: &str, at: usize| {
        let mut all = vec![0; (4 - at % 4) % 4];
        all.extend((t.len() as u32 + 1).to_le_bytes());
        all.extend([t.as_bytes(), &[0]].concat());
        all
    };
    let mut log = file(&[
        schema(1, "nav_msgs/msg/Odometry"),
        channel(1, 1, "/odom", "cdr"),
    ]);
    // Position, orientation, 36 covariances; velocity, rotation, 36 covariances: by number.
    let numbers: Vec<u8> = (0..85_u8)
        .flat_map(|i| f64::from(i).to_le_bytes())
        .collect();
    for (frame, child) in [("odom", "base_link"), ("", "b"), ("a map", "")] {
        let mut content = [5_u32, 6].map(u32::to_le_bytes).concat();
        content.extend(text(frame, content.len()));
        content.extend(text(child, content.len()));
        content.resize(content.len().next_multiple_of(8), 0);
        log.extend(message(
            1,
            5,
            &[&[0, 1, 0, 0], &content[..], &numbers].concat(),
        ));
    }
    end(&mut log, &[]);
    let container = open(&log).unwrap();
    let channels = &container.streams()[0].channels;
    assert_eq!(channels[7].name, "twist.twist.linear.x");
    let all = columns(container, 0);
    for (column, number) in [(0, 0.0), (6, 6.0), (7, 43.0), (12, 48.0), (13, 0.0)] {
        assert_eq!(all[column], [number; 3]);
    }
}

#[test]
fn known_orientation_of_some_messages() {
    let at = |s: u32, oriented| message(1, s, &imu_cdr(LITTLE, (s, 0), "imu", 1.0, oriented));
    let mut log = file(&[definitions(), at(1, true), at(2, false)]);
    end(&mut log, &[]);
    let container = open(&log).unwrap();
    let said = &container.remarks()[0].text;
    assert!(said.starts_with("orientation in 1 of 2 messages of /imu"));
    let all = columns(container, 0);
    assert_eq!(all[3][0], 1.0);
    assert!(all[3][1].is_nan() && all[7] == [1.0, 1.0]);
}

#[test]
fn known_chunks_packed_and_damaged() {
    let first = [definitions(), two(10)].concat();
    let second = two(20);
    for (how, pack) in [
        ("", (|c| c.to_vec()) as fn(&[u8]) -> Vec<u8>),
        ("zstd", zstd),
        ("lz4", lz4),
    ] {
        let summed = |c: &[u8]| chunk(how, c, &pack(c), crc(c));
        let mut log = file(&[summed(&first), summed(&second), summed(&two(30))]);
        let third = log.len() - summed(&two(30)).len();
        let before = log.clone();
        end(&mut log, &definitions());
        let container = open(&log).unwrap();
        assert!(container.remarks().is_empty(), "{how}");
        let all = columns(container, 0);
        assert_eq!(all[3], [10.0, 11.0, 20.0, 21.0, 30.0, 31.0], "{how}");
        assert_eq!(all[6], [0.0, 1.0, 10.0, 11.0, 20.0, 21.0], "{how}");
        // A byte of the second chunk, of its content or its head: its time is a gap.
        let start = super::MAGIC.len() + summed(&first).len();
        for byte in [start + 9 + 60 + how.len(), start + 9 + 24] {
            let mut damaged = log.clone();
            damaged[byte] ^= 0xFF;
            let container = open(&damaged).unwrap();
            let remark = &container.remarks()[0];
            assert_eq!(remark.kind, RemarkKind::Damaged, "{how}");
            let said = format!("one chunk, at byte {start}: ");
            assert!(remark.text.starts_with(&said), "{how} {}", remark.text);
            assert_eq!(columns(container, 0)[3], [10.0, 11.0, 30.0, 31.0], "{how}");
        }
        // The first chunk, which defines the topic: the summary repeats it.
        let mut damaged = log.clone();
        damaged[80] ^= 1;
        assert_eq!(columns(open(&damaged).unwrap(), 0)[3][0], 20.0, "{how}");
        // The length of the second chunk, with and without an index of the chunks: its content is whole.
        let mut indexed = before;
        let index = [&[0; 16][..], &(third as u64).to_le_bytes(), &[0; 32]].concat();
        end(&mut indexed, &[definitions(), record(8, &index)].concat());
        for (log, byte, rows) in [
            (&indexed, 4, 6),
            (&log, 4, 4),
            (&indexed, 0, 4),
            (&log, 0, 4),
        ] {
            let mut log = log.clone();
            log[start + byte] ^= 0xFF;
            let container = open(&log).unwrap();
            assert_eq!(container.streams()[0].rows, rows, "{how}");
            let kinds: Vec<RemarkKind> = container.remarks().iter().map(|r| r.kind).collect();
            match byte {
                0 => assert!(kinds.contains(&RemarkKind::PassedOver)),
                _ => assert_eq!(kinds, [RemarkKind::Damaged]),
            }
        }
        survives(&log);
    }
}

#[test]
fn known_rows_before_a_cut() {
    let mut log = file(&[definitions(), two(1), two(3)]);
    let ends: Vec<usize> = (0..=4).map(|n| log.len() - n * two(1).len() / 2).collect();
    end(&mut log, &[]);
    for at in ends[4] + 1..log.len() - 1 {
        let rows = ends.iter().rev().filter(|end| **end <= at).count() - 1;
        match open(&log[..at]) {
            Ok(container) => {
                assert_eq!(container.streams()[0].rows, rows as u64);
                let cut = |r: &crate::Remark| r.kind == RemarkKind::Cut;
                assert!(container.remarks().iter().any(cut) || at > ends[0] + 12);
            }
            Err(_) => assert_eq!(rows, 0),
        }
    }
    // Of a packed chunk, the blocks that are whole.
    let many: Vec<u8> = (0..2000).flat_map(|i| two(2 * i)).collect();
    let content = [definitions(), many].concat();
    let log = file(&[chunk("zstd", &content, &zstd(&content), crc(&content))]);
    let container = open(&log[..log.len() - 100]).unwrap();
    assert_eq!(container.remarks()[0].kind, RemarkKind::Cut);
    let all = columns(container, 0);
    assert!(all[3].len() > 1000 && all[3].len() < 4000);
    assert!(all[3].iter().enumerate().all(|(i, v)| *v == i as f64));
}

#[test]
fn known_check_sum_of_the_data() {
    let mut log = file(&[definitions(), two(1)]);
    let mut sum = crc(&log).to_le_bytes().to_vec();
    for wrong in [false, true] {
        sum[0] ^= u8::from(wrong);
        let mut log = [log.clone(), record(15, &sum)].concat();
        let footer = [record(2, &[0; 20]), super::MAGIC.to_vec()].concat();
        log.extend(footer);
        assert_eq!(open(&log).unwrap().remarks().len(), usize::from(wrong));
    }
    end(&mut log, &[]);
    log[6] = b'\n';
    assert!(open(&log).is_err_and(|e| e.hint().is_some_and(|h| h.contains("as bytes"))));
}

#[test]
fn refuses_a_log_without_a_topic_that_is_read() {
    let records = [
        schema(1, "foxglove.Imu"),
        channel(1, 1, "/imu", "protobuf"),
        message(1, 1, b"x"),
    ];
    let error = open(&file(&records)).map(|_| ()).unwrap_err().to_string();
    assert!(
        error.contains("/imu (foxglove.Imu, 1 messages in protobuf)"),
        "{error}"
    );
}

#[test]
fn refuses_to_unpack_beyond_measure() {
    // Blocks of one byte that is repeated: four bytes make 128 KiB.
    let bomb = |blocks: usize| {
        let mut all = vec![0x28, 0xB5, 0x2F, 0xFD, 0, 0x38];
        all.extend([0x02, 0, 0x10, 5].repeat(blocks));
        all.extend([0x03, 0, 0x10, 5]);
        all
    };
    let claimed = |mib: u64, packed: &[u8]| {
        let mut all = chunk("zstd", &[], packed, 0);
        all[25..33].copy_from_slice(&(mib << 20).to_le_bytes());
        all
    };
    let good = [definitions(), two(1)].concat();
    let log = file(&[good, claimed(60, &bomb(480)), claimed(1 << 20, &bomb(500))]);
    let container = open(&log).unwrap();
    assert_eq!(container.streams()[0].rows, 2);
    let text = &container.remarks()[1].text;
    assert!(text.starts_with("2 chunks, the first at byte"), "{text}");
}

/// The seed of the fuzz target is made by this, so that it can be made again.
#[test]
fn known_seed() {
    let records = [definitions(), two(1)].concat();
    let mut log = file(&[chunk("lz4", &records, &lz4(&records), crc(&records))]);
    log.extend(two(3));
    end(&mut log, &definitions());
    let seed = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/seeds/two.mcap");
    assert!(std::fs::read(seed).unwrap() == log);
    assert_eq!(columns(open(&log).unwrap(), 0)[3], [1.0, 2.0, 3.0, 4.0]);
}
