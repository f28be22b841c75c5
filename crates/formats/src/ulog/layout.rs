//! What a message holds, by the definitions that stand in the log, and the units that PX4 gives the fields of its sensors.

use crate::raw::Kind;
use std::collections::HashMap;

/// Bytes that a message can have at most.
const LONGEST: usize = 1 << 16;
/// Numbers that a message can have at most.
const MOST: usize = 512;
/// How deep types may lie in each other.
const DEEPEST: usize = 8;

/// Topics that are read, and the units of their fields by how the names begin; accelerometers first.
pub(super) const TOPICS: &[(&str, Units)] = &[
    (
        "sensor_accel",
        &[("x", "m/s2"), ("y", "m/s2"), ("z", "m/s2"), DEGREES],
    ),
    (
        "sensor_accel_fifo",
        &[("x", "m/s2"), ("y", "m/s2"), ("z", "m/s2")],
    ),
    (
        "sensor_combined",
        &[
            ("gyro_rad", "rad/s"),
            ("gyro_integral_dt", "us"),
            ("accelerometer_m_s2", "m/s2"),
            ("accelerometer_integral_dt", "us"),
            ("accelerometer_timestamp_relative", "us"),
        ],
    ),
    ("vehicle_acceleration", &[("xyz", "m/s2")]),
    (
        "vehicle_imu",
        &[
            ("delta_angle", "rad"),
            ("delta_angle_dt", "us"),
            ("delta_velocity", "m/s"),
            ("delta_velocity_dt", "us"),
        ],
    ),
    (
        "sensor_gyro",
        &[("x", "rad/s"), ("y", "rad/s"), ("z", "rad/s"), DEGREES],
    ),
    (
        "sensor_gyro_fifo",
        &[("x", "rad/s"), ("y", "rad/s"), ("z", "rad/s")],
    ),
    ("vehicle_angular_velocity", &[("xyz", "rad/s")]),
    ("vehicle_angular_acceleration", &[]),
    (
        "vehicle_imu_status",
        &[
            ("mean_accel", "m/s2"),
            ("mean_gyro", "rad/s"),
            ("temperature_accel", "degC"),
            ("temperature_gyro", "degC"),
        ],
    ),
    ("sensor_mag", &[DEGREES]),
    ("vehicle_magnetometer", &[]),
    ("sensor_baro", &[DEGREES]),
    ("vehicle_air_data", &[]),
    (
        "wheel_encoders",
        &[("wheel_speed", "rad/s"), ("wheel_angle", "rad")],
    ),
];
const DEGREES: (&str, &str) = ("temperature", "degC");

/// Names of fields and their units.
pub(super) type Units = &'static [(&'static str, &'static str)];

/// The unit of a field, of an element of it where it is an array.
pub(super) fn unit(units: Units, field: &str) -> Option<String> {
    let name = field.split_once('[').map_or(field, |(name, _)| name);
    let found = units.iter().find(|(of, _)| *of == name);
    found.map(|(_, unit)| (*unit).to_owned())
}

/// The definitions of a log.
#[derive(Default)]
pub(super) struct Definitions(HashMap<String, Vec<Field>>);

struct Field {
    kind: String,
    /// Elements, where it is an array.
    count: Option<usize>,
    name: String,
}

/// Where the numbers of a message lie.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Layout {
    /// Bytes up to the end of the last field.
    pub(super) width: usize,
    /// Bytes with the padding behind it, which need not be there.
    pub(super) padded: usize,
    pub(super) numbers: Vec<(String, usize, Kind)>,
}

impl Layout {
    /// Place of a number of a name.
    pub(super) fn at(&self, name: &str) -> Option<(usize, Kind)> {
        let found = self.numbers.iter().find(|n| n.0 == name);
        found.map(|(_, at, kind)| (*at, *kind))
    }
}

impl Definitions {
    /// Takes in a definition: `name:type field;type[2] field;`.
    pub(super) fn define(&mut self, text: &str) -> Option<()> {
        let (name, fields) = text.split_once(':')?;
        let fields = fields.split(';').map(str::trim).filter(|f| !f.is_empty());
        let fields = fields.map(|field| {
            let (kind, name) = field.split_once(' ')?;
            let (kind, count) = match kind.split_once('[') {
                Some((kind, count)) => (kind, Some(count.strip_suffix(']')?.parse().ok()?)),
                None => (kind, None),
            };
            Some(Field {
                kind: kind.to_owned(),
                count,
                name: crate::names::shown(name.trim()),
            })
        });
        self.0
            .insert(name.trim().to_owned(), fields.collect::<Option<_>>()?);
        Some(())
    }

    /// The layout of a message; nothing where a type is missing, or it cannot be.
    pub(super) fn layout(&self, name: &str) -> Option<Layout> {
        let mut layout = Layout::default();
        self.add(name, "", 0, &mut layout)?;
        (layout.width > 0).then_some(layout)
    }

    fn add(&self, name: &str, before: &str, depth: usize, to: &mut Layout) -> Option<()> {
        let start = to.padded;
        for field in self.0.get(name)? {
            let elements = field.count.unwrap_or(1);
            if elements > LONGEST {
                return None;
            }
            // Padding and texts are passed over as one.
            let padding = field.name.starts_with("_padding");
            let stored = number(&field.kind);
            if let Some((size, kind)) = stored
                && (padding || kind.is_none())
            {
                to.padded += elements * size;
                if !padding {
                    to.width = to.padded;
                }
                continue;
            }
            for i in 0..elements {
                let name = match field.count {
                    Some(_) => format!("{before}{}[{i}]", field.name),
                    None => format!("{before}{}", field.name),
                };
                match stored {
                    Some((size, kind)) => {
                        let at = to.padded;
                        to.padded += size;
                        to.width = to.padded;
                        to.numbers.extend(kind.map(|kind| (name, at, kind)));
                    }
                    None if depth < DEEPEST => {
                        self.add(&field.kind, &format!("{name}."), depth + 1, to)?;
                    }
                    None => return None,
                }
                if to.padded > LONGEST || to.numbers.len() > MOST {
                    return None;
                }
            }
        }
        // What holds nothing could be there any number of times.
        (to.padded > start).then_some(())
    }
}

/// Size and kind of a field; a character is no number.
fn number(word: &str) -> Option<(usize, Option<Kind>)> {
    let kind = match word {
        "int8_t" => Kind::I8,
        "uint8_t" | "bool" => Kind::U8,
        "int16_t" => Kind::I16,
        "uint16_t" => Kind::U16,
        "int32_t" => Kind::I32,
        "uint32_t" => Kind::U32,
        "int64_t" => Kind::I64,
        "uint64_t" => Kind::U64,
        "float" => Kind::F32,
        "double" => Kind::F64,
        "char" => return Some((1, None)),
        _ => return None,
    };
    Some((kind.size() as usize, Some(kind)))
}
