//! The head of a data set 58b: a signal of double precision at equal steps of time.
//!
//! **Source** `[UFF58]`.

/// Stands behind the numbers of a data set.
pub const UFF_END: &[u8] = b"\n    -1\n";

/// Characters of a name that are read again.
const NAME: usize = 10;

/// A signal of a universal file.
#[derive(Clone, Debug, PartialEq)]
pub struct UffSignal {
    /// Its name; ten characters of it are read again.
    pub name: String,
    /// Word for its unit; twenty characters at most.
    pub unit: Option<String>,
    /// Whether it is an acceleration.
    pub acceleration: bool,
    /// Time of the first sample, s.
    pub start_s: f64,
    /// Seconds from one sample to the next.
    pub step_s: f64,
    /// Samples.
    pub rows: u64,
}

/// What stands before the little-endian doubles of a signal.
pub fn uff_head(signal: &UffSignal) -> Vec<u8> {
    let bytes = 8 * signal.rows;
    let name = plain(&signal.name, 80);
    let entity = uff_name(&signal.name);
    let unit = plain(signal.unit.as_deref().unwrap_or("NONE"), 20);
    let kind = if signal.acceleration { 12 } else { 0 };
    let label = if signal.acceleration {
        "Acceleration"
    } else {
        "Signal"
    };
    let lines = [
        "    -1".to_owned(),
        format!("    58b     1     2          11{bytes:12}     0     0           0           0"),
        name,
        "NONE".to_owned(),
        "NONE".to_owned(),
        "NONE".to_owned(),
        "NONE".to_owned(),
        format!(
            "    1         0    0         0 {entity:<10}         0   0 NONE               0   0"
        ),
        format!(
            "         4{:10}         1{:>13}{:>13}{:>13}",
            signal.rows,
            thirteen(signal.start_s),
            thirteen(signal.step_s),
            thirteen(0.0)
        ),
        format!("        17    0    0    0 {:<20} {:<20}", "Time", "s"),
        format!("{kind:10}    0    0    0 {label:<20} {unit:<20}"),
        format!("         0    0    0    0 {:<20} {:<20}", "NONE", "NONE"),
        format!("         0    0    0    0 {:<20} {:<20}", "NONE", "NONE"),
    ];
    let mut head = lines.join("\n").into_bytes();
    head.push(b'\n');
    head
}

/// A time of a head as it is read again.
pub fn uff_stored(seconds: f64) -> f64 {
    thirteen(seconds).parse().unwrap_or(seconds)
}

/// A name as it is read again, without the word for its quantity.
pub fn uff_name(name: &str) -> String {
    plain(name, NAME)
}

/// Printable ASCII, so many characters at most.
fn plain(text: &str, most: usize) -> String {
    let kept = text.chars().map(|c| match c {
        ' '..='~' => c,
        _ => '_',
    });
    kept.take(most).collect()
}

/// A number with as many digits as thirteen characters hold beside a blank.
fn thirteen(number: f64) -> String {
    let digits = (0..8).rev();
    let mut forms = digits.map(|digits| format!("{number:.digits$E}"));
    forms.find(|form| form.len() <= 12).unwrap_or_default()
}
