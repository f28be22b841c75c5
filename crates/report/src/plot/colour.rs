//! Colours, dashes and markers: Okabe–Ito for series, a diverging and a sequential scale for values.

/// The series colours of Okabe and Ito, darkest contrasts first; yellow is left out, it vanishes on paper.
const SERIES: [&str; 7] = [
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000",
];
const DASHES: [&str; 4] = ["", "7 3", "2 3", "9 3 2 3"];

pub(super) fn series(index: usize) -> &'static str {
    SERIES[index % SERIES.len()]
}

pub(super) fn dash(index: usize) -> &'static str {
    DASHES[index % DASHES.len()]
}

type Rgb = [f64; 3];

/// Blue over white to orange: the two arms differ for every colour vision.
const DIVERGING: [Rgb; 5] = [
    [5.0, 84.0, 148.0],
    [106.0, 168.0, 214.0],
    [247.0, 247.0, 245.0],
    [240.0, 165.0, 90.0],
    [172.0, 72.0, 0.0],
];
/// Viridis at eighths.
const SEQUENTIAL: [Rgb; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 45.0, 123.0],
    [59.0, 82.0, 139.0],
    [44.0, 114.0, 142.0],
    [33.0, 145.0, 140.0],
    [40.0, 174.0, 128.0],
    [94.0, 201.0, 98.0],
    [173.0, 220.0, 48.0],
    [253.0, 231.0, 37.0],
];

fn between(stops: &[Rgb], position: f64) -> Rgb {
    let p = position.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
    let i = (p as usize).min(stops.len() - 2);
    let t = p - i as f64;
    std::array::from_fn(|c| stops[i][c] + t * (stops[i + 1][c] - stops[i][c]))
}

fn hex(c: Rgb) -> String {
    let [r, g, b] = c.map(|v| v.round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Colour of a value between −1 and 1.
pub(super) fn diverging(value: f64) -> String {
    hex(between(&DIVERGING, 0.5 + 0.5 * value))
}

/// Colour of a value between 0 and 1 in light between 0 (dark) and 1.
pub(super) fn shaded(value: f64, light: f64) -> String {
    // Paler than the plain scale, so that light and shade can be told from the value.
    let light = light.clamp(0.0, 1.0);
    hex(between(&SEQUENTIAL, value).map(|c| (0.72 * c + 0.28 * 235.0) * light))
}

/// Colour of a value between 0 and 1.
pub(super) fn sequential(value: f64) -> String {
    hex(between(&SEQUENTIAL, value))
}

/// Black or white, whichever is readable on the diverging colour of a value between −1 and 1.
pub(super) fn on_diverging(value: f64) -> &'static str {
    let [r, g, b] = between(&DIVERGING, 0.5 + 0.5 * value);
    if 0.299 * r + 0.587 * g + 0.114 * b < 125.0 {
        "#fff"
    } else {
        "#111"
    }
}
