//! Files whose headings or rows say too little or too much, made for it: 400 rows at 100 Hz with gravity along z.

use std::fmt::Write;

/// What has to come of a file.
#[derive(Clone, Copy, Debug)]
pub enum Due {
    /// A refusal with these words in what it says or advises.
    Refused(&'static str),
    /// The right numbers, with these words in the line that tells how it was read.
    Right(&'static str),
}

/// A file and what has to come of it.
pub struct Odd {
    pub name: &'static str,
    pub bytes: Vec<u8>,
    /// Where the columns are named.
    pub named: Due,
    /// Where the reader has to find the accelerometer by itself; as `named` without it.
    pub alone: Option<Due>,
    /// Where all columns of numbers are read; as `named` without it.
    pub all: Option<Due>,
    /// Of a table of readings, which has no clock.
    pub table: Due,
    /// Columns of x, y, z and of a position, by heading or number.
    pub axes: [&'static str; 3],
    pub position: &'static str,
}

/// Position in metres, as a column that only the velocity reads.
fn rows(stamp: impl Fn(usize) -> String, gravity: f64) -> impl Iterator<Item = [String; 5]> {
    let wobble = |k: usize| ((7919 * k) % 13) as f64 - 6.0;
    (0..400).map(move |i| {
        let small = gravity * 1e-4;
        let whole = gravity >= 500.0;
        let digits = |v: f64| {
            if whole {
                format!("{v:.0}")
            } else {
                format!("{v:.6}")
            }
        };
        [
            stamp(i),
            digits(small * wobble(i)),
            digits(small * wobble(i + 3)),
            digits(gravity + small * wobble(i + 7)),
            format!("{:.5}", 0.01 * i as f64),
        ]
    })
}

fn text(heading: &str, stamp: impl Fn(usize) -> String, gravity: f64) -> String {
    let mut text = format!("{heading}\n");
    for row in rows(stamp, gravity) {
        writeln!(text, "{}", row.join(",")).unwrap();
    }
    text
}

fn seconds(i: usize) -> String {
    format!("{:.2}", i as f64 / 100.0)
}

const HEADING: &str = "t,ax_m/s2,ay_m/s2,az_m/s2,p (m)";

impl Odd {
    /// A file that all readers read alike but for tables.
    fn new(name: &'static str, bytes: impl Into<Vec<u8>>, named: Due, table: Due) -> Self {
        Self {
            name,
            bytes: bytes.into(),
            named,
            alone: None,
            all: None,
            table,
            axes: ["ax", "ay", "az"],
            position: "p",
        }
    }

    pub fn all() -> Vec<Self> {
        use Due::{Refused, Right};
        let in_order = Right("in m/s² by the heading");
        let whole = |step: usize| move |i: usize| (step * i).to_string();
        let stamped = |step: usize| text(&HEADING.replace("t,", "timestamp,"), whole(step), 9.81);
        let mut all = vec![
            Self::new("ms.csv", stamped(10), Refused("--time-unit ms"), in_order),
            Self::new(
                "us.csv",
                stamped(10_000),
                Refused("--time-unit us"),
                in_order,
            ),
            Self::new(
                "ns.csv",
                stamped(10_000_000),
                Refused("--time-unit ns"),
                in_order,
            ),
            Self::new(
                "since-1970.csv",
                text(HEADING, |i| (1_700_000_000_000 + 10 * i).to_string(), 9.81),
                Right("100 Hz by column 1 t in ms assumed"),
                in_order,
            ),
            Self::new(
                "days.csv",
                text(
                    HEADING,
                    |i| format!("{:.11}", 45_000.123 + 0.01 * i as f64 / 86_400.0),
                    9.81,
                ),
                Right("100 Hz by column 1 t in d assumed"),
                in_order,
            ),
            Self::new(
                "seconds.csv",
                text(HEADING, seconds, 9.81),
                Right("100 Hz by column 1 t in s assumed"),
                in_order,
            ),
            Self::new(
                "constant.csv",
                text(HEADING, |_| "12.5".into(), 9.81),
                Refused("stands still"),
                in_order,
            ),
        ];
        // Hours, minutes and seconds, from two to twelve; past midnight no date tells the day; minutes and seconds alone are no time.
        let of_day = |from: usize| {
            move |i: usize| {
                let t = (from + i) % 8_640_000;
                let (s, part) = (t / 100, t % 100);
                format!("{:02}:{:02}:{:02}.{part:02}", s / 3600, s / 60 % 60, s % 60)
            }
        };
        all.push(Self::new(
            "time-of-day.csv",
            text(HEADING, of_day(4_319_800), 9.81),
            Right("100 Hz by column 1 t by date or time of day"),
            in_order,
        ));
        all.push(Self::new(
            "midnight.csv",
            text(HEADING, of_day(8_639_800), 9.81),
            Refused("pass midnight"),
            in_order,
        ));
        all.push(Self::new(
            "minutes-and-seconds.csv",
            text(HEADING, |i| format!("00:{:05.2}", 0.01 * i as f64), 9.81),
            Refused("hh:mm:ss"),
            in_order,
        ));
        let likely = [
            ("g.csv", 1.0, "unit g"),
            ("m-per-s2.csv", 9.81, "unit m/s2"),
            ("mg.csv", 1000.0, "unit mg"),
        ];
        for (name, gravity, word) in likely {
            let heading = "t_s,ax,ay,az,p (m)";
            all.push(Self::new(
                name,
                text(heading, seconds, gravity),
                Refused(word),
                // Of one axis by itself.
                Refused("--output-unit"),
            ));
        }
        // A gyroscope in front, without units where it has none.
        let gyroscope = |heading: &str| {
            let mut text = format!("{heading}\n");
            for (k, row) in rows(seconds, 9.81).enumerate() {
                let spin = 0.01 * ((k % 7) as f64 - 3.0);
                let [t, x, y, z, p] = row;
                writeln!(text, "{t},{spin},{spin},{spin},{x},{y},{z},{p}").unwrap();
            }
            text
        };
        let read = Right("7 az in m/s² by the heading");
        let seen = Some(Right("5 ax, 6 ay, 7 az in m/s² by the heading"));
        all.push(Self {
            alone: seen,
            all: Some(Right("2 imu.gyro.x, 3 imu.gyro.y, 4 imu.gyro.z in rad/s")),
            ..Self::new(
                "gyroscope.csv",
                gyroscope("t_s,imu.gyro.x_rad/s,imu.gyro.y_rad/s,imu.gyro.z_rad/s,ax_m/s2,ay_m/s2,az_m/s2,p (m)"),
                read,
                in_order,
            )
        });
        all.push(Self {
            alone: seen,
            all: Some(Refused("the unit of wx, wy, wz is not said")),
            ..Self::new(
                "gyroscope-without-unit.csv",
                gyroscope("t_s,wx,wy,wz,ax_m/s2,ay_m/s2,az_m/s2,p (m)"),
                read,
                in_order,
            )
        });
        all.push(Self {
            alone: Some(Refused("more than one sensor")),
            all: Some(Right("in m/s² by the heading")),
            ..Self::new(
                "two-accelerometers.csv",
                gyroscope("t_s,a2x_m/s2,a2y_m/s2,a2z_m/s2,ax_m/s2,ay_m/s2,az_m/s2,p (m)"),
                read,
                in_order,
            )
        });
        let no_headings = text(HEADING, seconds, 9.81);
        let no_headings = no_headings.split_once('\n').map_or("", |t| t.1);
        all.push(Self {
            alone: Some(Refused("without headings it is not known which columns")),
            axes: ["2", "3", "4"],
            position: "5",
            ..Self::new(
                "no-headings.csv",
                no_headings,
                // Neither the clock nor the unit is said.
                Refused(""),
                Refused("--output-unit"),
            )
        });
        let comma = text(HEADING, seconds, 9.81)
            .replace(',', ";")
            .replace('.', ",");
        all.push(Self::new(
            "decimal-comma.csv",
            comma,
            Right("100 Hz by column 1 t in s assumed"),
            in_order,
        ));
        for (name, big) in [("utf-16.csv", false), ("utf-16-big-endian.csv", true)] {
            let units = text(HEADING, seconds, 9.81);
            let units = std::iter::once(0xFEFF).chain(units.encode_utf16());
            let bytes = |u: u16| {
                if big {
                    u.to_be_bytes()
                } else {
                    u.to_le_bytes()
                }
            };
            all.push(Self::new(
                name,
                units.flat_map(bytes).collect::<Vec<u8>>(),
                Right("100 Hz by column 1 t in s assumed"),
                in_order,
            ));
        }
        let refused = Refused("7 headings stand above 5 columns");
        all.push(Self::new(
            "seven-headings.csv",
            text("t,ax_m/s2,ay_m/s2,az_m/s2,p (m),T_degC,q", seconds, 9.81),
            refused,
            refused,
        ));
        all
    }
}
