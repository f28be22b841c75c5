//! Messages of ROS that hold measured quantities with a stamp: a header, then numbers of double precision.
//!
//! **Source** `[ROS]`, `[CDR]`.

use crate::bytes::{Bytes, Order};

/// A type of message.
pub(super) struct Layout {
    /// Package and name.
    pub(super) name: &'static str,
    /// Texts between the header and the numbers.
    texts: usize,
    /// Numbers behind them, those that are passed over too.
    doubles: usize,
    pub(super) groups: &'static [Group],
}

/// Numbers that are present together.
pub(super) struct Group {
    pub(super) name: &'static str,
    pub(super) axes: &'static [&'static str],
    pub(super) unit: Option<&'static str>,
    /// Place of the first among the numbers.
    at: usize,
    /// Place of the first covariance, which is −1 where the group is absent.
    covariance: Option<usize>,
}

const XYZ: &[&str] = &[".x", ".y", ".z"];
const XYZW: &[&str] = &[".x", ".y", ".z", ".w"];
const ONE: &[&str] = &[""];

const fn group(
    name: &'static str,
    axes: &'static [&'static str],
    unit: Option<&'static str>,
    at: usize,
) -> Group {
    Group {
        name,
        axes,
        unit,
        at,
        covariance: None,
    }
}

const fn with_covariance(mut group: Group) -> Group {
    group.covariance = Some(group.at + group.axes.len());
    group
}

/// Every type that is read.
pub(super) const LAYOUTS: &[Layout] = &[
    Layout {
        name: "sensor_msgs/Imu",
        texts: 0,
        doubles: 37,
        groups: &[
            with_covariance(group("orientation", XYZW, None, 0)),
            with_covariance(group("angular_velocity", XYZ, Some("rad/s"), 13)),
            with_covariance(group("linear_acceleration", XYZ, Some("m/s2"), 25)),
        ],
    },
    Layout {
        name: "geometry_msgs/AccelStamped",
        texts: 0,
        doubles: 6,
        groups: &[
            group("accel.linear", XYZ, Some("m/s2"), 0),
            group("accel.angular", XYZ, Some("rad/s2"), 3),
        ],
    },
    Layout {
        name: "geometry_msgs/AccelWithCovarianceStamped",
        texts: 0,
        doubles: 42,
        groups: &[
            group("accel.accel.linear", XYZ, Some("m/s2"), 0),
            group("accel.accel.angular", XYZ, Some("rad/s2"), 3),
        ],
    },
    Layout {
        name: "geometry_msgs/TwistStamped",
        texts: 0,
        doubles: 6,
        groups: &[
            group("twist.linear", XYZ, Some("m/s"), 0),
            group("twist.angular", XYZ, Some("rad/s"), 3),
        ],
    },
    Layout {
        name: "geometry_msgs/Vector3Stamped",
        texts: 0,
        doubles: 3,
        groups: &[group("vector", XYZ, None, 0)],
    },
    Layout {
        name: "nav_msgs/Odometry",
        texts: 1,
        doubles: 85,
        groups: &[
            group("pose.pose.position", XYZ, Some("m"), 0),
            group("pose.pose.orientation", XYZW, None, 3),
            group("twist.twist.linear", XYZ, Some("m/s"), 43),
            group("twist.twist.angular", XYZ, Some("rad/s"), 46),
        ],
    },
    Layout {
        name: "sensor_msgs/MagneticField",
        texts: 0,
        doubles: 12,
        groups: &[group("magnetic_field", XYZ, Some("T"), 0)],
    },
    Layout {
        name: "sensor_msgs/Temperature",
        texts: 0,
        doubles: 2,
        groups: &[group("temperature", ONE, Some("degC"), 0)],
    },
];

/// How messages are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Without gaps, the least significant byte first.
    Ros1,
    /// Numbers at multiples of their size, order by the head.
    Cdr,
}

impl Encoding {
    pub(super) fn of(word: &str) -> Option<Self> {
        match word {
            "ros1" => Some(Self::Ros1),
            "cdr" => Some(Self::Cdr),
            _ => None,
        }
    }
}

impl Layout {
    /// By the name of the schema, in the spelling of ROS 1 or 2.
    pub(super) fn of(schema: &str) -> Option<&'static Self> {
        let same = |l: &&Self| schema == l.name || schema.replacen("/msg/", "/", 1) == l.name;
        LAYOUTS.iter().find(same)
    }

    /// Bytes of a row: the stamp and the numbers of the groups.
    pub(super) fn width(&self) -> usize {
        8 * (1 + self.groups.iter().map(|g| g.axes.len()).sum::<usize>())
    }

    /// Appends a row: the stamp, ns, and the numbers; those of a group that is absent are no numbers, and it is counted. Nothing, where
    /// the message is shorter than its type.
    pub(super) fn row(
        &self,
        encoding: Encoding,
        message: &[u8],
        to: &mut Vec<u8>,
        absent: &mut [u64],
    ) -> Option<()> {
        let mut fields = Fields::new(encoding, message)?;
        let stamp = fields.header()?;
        for _ in 0..self.texts {
            fields.text()?;
        }
        fields.align(8)?;
        let order = fields.bytes.order;
        let doubles = fields.bytes.take(8 * self.doubles)?.as_chunks::<8>().0;
        let number = |i: usize| match order {
            Order::Little => doubles[i],
            Order::Big => {
                let mut bytes = doubles[i];
                bytes.reverse();
                bytes
            }
        };
        to.extend(stamp.to_le_bytes());
        for (group, absent) in self.groups.iter().zip(absent) {
            let is_absent = |at: usize| f64::from_le_bytes(number(at)) == -1.0;
            let none = group.covariance.is_some_and(is_absent);
            *absent += u64::from(none);
            for i in 0..group.axes.len() {
                match none {
                    true => to.extend(f64::NAN.to_le_bytes()),
                    false => to.extend(number(group.at + i)),
                }
            }
        }
        Some(())
    }
}

/// The fields of a message one after the other.
struct Fields<'a> {
    bytes: Bytes<'a>,
    encoding: Encoding,
    /// Bytes from which places count.
    whole: usize,
    /// Numbers lie at multiples of at most so many bytes.
    alignment: usize,
}

impl<'a> Fields<'a> {
    fn new(encoding: Encoding, message: &'a [u8]) -> Option<Self> {
        let mut bytes = Bytes::new(message, Order::Little);
        let mut alignment = 1;
        if encoding == Encoding::Cdr {
            // Plain CDR, and plain XCDR 2 by the identifiers of both its editions.
            let head = bytes.take(4)?;
            alignment = match head[1] {
                0 | 1 => 8,
                6 | 7 | 0x10 | 0x11 => 4,
                _ => return None,
            };
            if head[0] != 0 {
                return None;
            }
            if head[1] & 1 == 0 {
                bytes.order = Order::Big;
            }
        }
        let whole = bytes.rest().len();
        Some(Self {
            bytes,
            encoding,
            whole,
            alignment,
        })
    }

    fn align(&mut self, size: usize) -> Option<()> {
        let place = self.whole - self.bytes.rest().len();
        let to = place.next_multiple_of(size.min(self.alignment));
        self.bytes.take(to - place).map(|_| ())
    }

    fn text(&mut self) -> Option<()> {
        self.align(4)?;
        let length = self.bytes.u32()?;
        self.bytes.take(length as usize).map(|_| ())
    }

    /// The stamp, ns.
    fn header(&mut self) -> Option<i64> {
        let seconds = match self.encoding {
            Encoding::Ros1 => {
                self.bytes.u32()?;
                i64::from(self.bytes.u32()?)
            }
            Encoding::Cdr => i64::from(self.bytes.i32()?),
        };
        let ns = i64::from(self.bytes.u32()?);
        self.text()?;
        Some(seconds * 1_000_000_000 + ns)
    }
}
