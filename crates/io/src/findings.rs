//! Every finding of this room, declared once.

use proofmass_uncertainty::findings;

findings! {
    /// What reading a recording may find.
    pub CATALOGUE;

    /// A file that a result was computed from was changed after it was written.
    input_changed(file: &str, doubt: &str) =
        "input-changed", [Decision],
        what "{file} was changed after it was written",
        evidence "{doubt}",
        advice "find out who changed it, and fetch or compute it again; `proofmass verify` follows the whole chain",
        false_alarms "none: a file has one digest";

    /// A counter of time went over its range.
    clock_wrapped(times: u64, turn: f64, line: u64) =
        "clock-wrapped", [Note],
        what "the counter behind the time stamps started again and was continued",
        evidence "{times} times, one turn is {turn:.6} s, first in line {line}",
        advice "nothing is to be done, unless two recordings were joined there";

    /// One gap of an hour, as a clock has that is put forward for the summer.
    clock_put_forward(step: f64, at: f64, line: u64) =
        "clock-put-forward", [Warning],
        what "the clock was put forward by an hour, or nothing was recorded for one",
        evidence "{step:.4} s from one row to the next, after {at:.4} s (line {line}), and no other gap",
        advice "where summer time begins that day no sample is missing: export the times in UTC, or read the two parts with --between FROM TO",
        false_alarms "none, but of a logger that sleeps once for an hour";

    /// Stamps were given to packets, not to samples.
    stamps_in_bursts(scatter: f64, period: f64, rate: &str, treatment: &str) =
        "stamps-in-bursts", [Warning],
        what "the time stamps come in bursts: they give the time when samples were handed over, not when they were taken",
        evidence "stamps scatter by {scatter:.3e} s about equal steps of {period:.3e} s; rate {rate}",
        advice "{treatment}; record the time stamps at the sensor for anything finer";

    /// The stamps have few digits.
    stamps_coarse(resolution: &str, fraction: f64, rate: &str, treatment: &str) =
        "stamps-coarse", [Note],
        what "the time stamps are rounded to a large fraction of a sampling interval",
        evidence "resolution {resolution} s, {fraction:.0} % of a sampling interval; rate {rate}",
        advice "{treatment}; export the time with more digits";

    /// Rows are missing, and the stamps scatter too much to tell where.
    rows_missing_somewhere(missing: u64, share: f64, rate: &str) =
        "rows-missing-somewhere", [Warning],
        what "rows are missing, and the time stamps scatter too much to tell between which",
        evidence "about {missing} samples, {share:.1} %; rate {rate}, from equal steps fitted to the stamps",
        advice "the rate is right; times counted from rows are not: record the stamps at the sensor, or a counter beside them",
        false_alarms "once in 10⁹ recordings of independent errors";

    /// Nothing tells lost rows from a clock that wanders.
    rate_untested(percent: f64, rate: &str) =
        "rate-untested", [Warning],
        what "rows may be missing unnoticed: the time stamps wander, or are too coarse to show a lost row",
        evidence "rate {rate}; up to {percent:.1} % of the rows could be lost unnoticed",
        advice "state the rate of the data sheet, or record a counter of samples or finer stamps";

    /// The stamps advance at two rates.
    rate_changes(before: f64, after: f64, row: usize) =
        "rate-changes", [Warning],
        what "the sampling rate changes within the recording",
        evidence "{before:.4} Hz, then {after:.4} Hz, from about sample {row}",
        advice "split the recording there: one rate describes neither part",
        false_alarms "none in 10⁷ evenly taken samples";

    /// A sampling rate is stated beside a column of times.
    time_column_unused(column: &str, rate: f64, seen: &str) =
        "time-column-unused", [Note, Warning],
        what "the stated sampling rate is used instead of the times in the column {column}",
        evidence "{rate} Hz is stated{seen}",
        advice "leave the rate out to have it from the column, with gaps and jitter";

    /// The heading of the times has no unit.
    time_unit_assumed(column: &str, assumption: &str) =
        "time-unit-assumed", [Note],
        what "the heading of {column} names no unit, so its values are taken as {assumption}",
        advice "say --time-unit (`time_unit` in a campaign) when they are not";

    /// Nobody says what the times count, and a look at the recording takes the likely unit.
    time_unit_open(column: &str, unit: &str, rates: &str) =
        "time-unit-open", [Decision],
        what "the unit of the times in {column} is not said: they are shown as if it were {unit}",
        evidence "{rates}",
        advice "say --time-unit {unit}, or another one; a command that needs the times asks for it";

    /// The head of the file has lines that are neither data nor comments.
    preamble_skipped(line: u64, text: &str, more: &str) =
        "preamble-skipped", [Note],
        what "lines above the data that are not marked as comments were skipped",
        evidence "line {line}{text}{more}",
        advice "if one of them is a damaged row of data, correct or remove it; otherwise put # in front of them";

    /// A file of another format ends before what it announces.
    file_cut(place: &str) =
        "file-cut", [Warning],
        what "the file ends before what it announces: the samples that stand before were read",
        evidence "{place}",
        advice "compare its size with that at the source, and fetch it again; a recorder that was stopped leaves such a file";

    /// Parts of a file of another format are damaged.
    parts_damaged(place: &str) =
        "parts-damaged", [Warning],
        what "parts of the file are damaged, and their samples are left out",
        evidence "{place}",
        advice "fetch the file again from the recorder; what is left out are gaps in time";

    /// A file of another format holds more than is read.
    parts_passed_over(what: &str) =
        "parts-passed-over", [Note],
        what "the file holds parts that are not read",
        evidence "{what}",
        advice "nothing is to be done where they are not needed; else export them with the program that wrote the file";

    /// A word for a unit that is not known.
    unit_word_unknown(word: &str, more: &str) =
        "unit-word-unknown", [Note],
        what "the file names a unit that is not understood",
        evidence "{word}{more}",
        advice "say --unit (`unit` in a campaign), or correct the unit where the file is written";

    /// The file ends without a line end; a warning where the last row is shorter than those before it.
    last_row_open(line: u64, field: &str, more: &str) =
        "last-row-open", [Note, Warning],
        what "the last row has no line end: the file may have been cut inside its last number",
        evidence "line {line} ends with \"{field}\"{more}",
        advice "one sample is doubtful: compare the end of the file with its source, or remove that row";

    /// Numbers whose marks may be those of thousands.
    thousands_suspected(column: &str, number: &str) =
        "thousands-suspected", [Warning],
        what "the marks in {column} may be those of thousands: other commands refuse such numbers",
        evidence "such as {number} in count, read as a number with three decimals",
        advice "export it without marks of thousands; where they are decimals, state the mark in a campaign",
        false_alarms "of counts with exactly three decimals throughout, none below one";
}
