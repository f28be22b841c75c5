#![allow(missing_docs)]
//! Text logs of robots and printers, after the layouts that their programs write: EuRoC, `rostopic echo -p`, Klipper.

use proofmass_io::{Recording, RecordingOptions, SaidBy, Source, Unit, inspect_source};

/// Rows at 200 Hz from a time in ns on, which no double holds to the nanosecond.
const FIRST: u64 = 1_403_636_579_758_555_392;

fn read(text: String, columns: &[&str]) -> Recording {
    let options = RecordingOptions {
        columns: columns.iter().map(|c| (*c).into()).collect(),
        ..RecordingOptions::default()
    };
    let source = Source::from_bytes("log.csv", text).unwrap();
    Recording::from_source(source, &options).unwrap_or_else(|e| panic!("{e}, {:?}", e.hint()))
}

#[test]
fn known_euroc_log() {
    let mut text = "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],\
        a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n"
        .to_owned();
    for i in 0..400_u64 {
        let time = FIRST + 5_000_000 * i;
        text += &format!(
            "{time},-0.0991,0.147,0.0272,8.1477,-0.3759,{}\n",
            i as f64 / 64.0
        );
    }
    let log = read(text, &["w_RS_S_x", "a_RS_S_z"]);
    assert_eq!(log.columns[0].unit, Some(Unit::RadianPerSecond));
    assert_eq!(log.columns[1].unit, Some(Unit::MetrePerSecondSquared));
    assert_eq!(
        (log.columns[1].data[399], log.samples()),
        (399.0 / 64.0, 400)
    );
    assert!((log.time.rate_hz() - 200.0).abs() < 1e-6);
    assert!(log.findings().is_empty());
    assert_eq!(log.reading().time.by, SaidBy::Heading);
}

/// The times are those of the measurement, not those of the log, which came late and scattered.
#[test]
fn known_rostopic_log_by_its_stamps() {
    let mut text = "%time,field.header.seq,field.header.stamp,field.header.frame_id,\
        field.orientation_covariance0,field.angular_velocity.x,field.linear_acceleration.x\n"
        .to_owned();
    for i in 0..400_u64 {
        let stamp = FIRST + 5_000_000 * i + if i < 200 { 0 } else { 1_000_000_000 };
        let logged = stamp + 3_000_000 + 1_700_000 * (i * i % 3);
        text += &format!("{logged},{i},{stamp},imu4,-1.0,0.25,{}\n", i as f64 / 8.0);
    }
    let options = RecordingOptions::default();
    let source = Source::from_bytes("log.csv", text.as_str()).unwrap();
    let seen = inspect_source(source, &options, 10).unwrap();
    let time = seen.time.unwrap();
    assert_eq!(time.gap_count, 1);
    let log = read(text, &["field.linear_acceleration.x"]);
    assert!(
        (log.time.rate_hz() - 200.0).abs() < 1e-6,
        "{}",
        log.time.rate_hz()
    );
    assert_eq!(log.columns[0].data[399], 399.0 / 8.0);
}

#[test]
fn known_klipper_log() {
    let mut text = "#time,accel_x,accel_y,accel_z\n".to_owned();
    // Steps of the sensor are 0.0039 g; its times have six digits behind the point.
    let step = 0.0039 * 9806.65;
    for i in 0..3200 {
        let time = 1234.5 + f64::from(i) / 3200.0;
        text += &format!(
            "{time:.6},{:.6},{:.6},{:.6}\n",
            step,
            -2.0 * step,
            256.0 * step
        );
    }
    let log = read(text, &["accel_x", "accel_z"]);
    assert!((log.time.rate_hz() - 3200.0).abs() < 1e-3);
    assert_eq!(log.columns[1].data[0], 9_790.959_36);
    assert_eq!(log.columns[0].unit, None);
}
