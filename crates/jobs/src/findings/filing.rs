//! What may be found when something is filed with the records of a laboratory: declared here, beside the catalogue, and raised by
//! `proofmass-records`, which stands above the jobs.

use proofmass_uncertainty::findings;

findings! {
    /// What may be found when something is filed.
    pub CATALOGUE;

    /// A certificate had expired, or was not yet valid, when its standard was used.
    certificate_not_valid(standard: &str, number: &str, from: &str, until: &str, used: &str) =
        "certificate-not-valid", [Decision],
        what "the certificate {number} of the standard {standard} was not valid when it was used",
        evidence "used on {used}, valid from {from} to {until}",
        advice "file the certificate that was valid then, or have the standard calibrated and repeat the result",
        false_alarms "none: dates are compared";

    /// Two results claim the same number.
    number_taken(number: &str, other: &str) =
        "number-taken", [Decision],
        what "the number {number} is taken",
        evidence "entry {other} has it",
        advice "give it a number of its own, or supersede the other one with the reason";

    /// A serial number that differs from a known one in its spelling alone.
    serial_spelled_otherwise(serial: &str, known: &str, device: &str) =
        "serial-spelled-otherwise", [Decision],
        what "the serial number {serial} is, but for spelling or type, that of another device",
        evidence "device {device} has the serial number {known}",
        advice "if they are one device, file the result again with --device, --supersedes and --reason; if not, nothing is to be done (--new-device says so at once)";

    /// A result reads a file of a result that no longer counts.
    input_superseded(path: &str, result: &str, reason: &str) =
        "input-superseded", [Decision],
        what "{path} is a file of the result {result}, which no longer counts",
        evidence "superseded because: {reason}",
        advice "evaluate it again with the result that took its place",
        false_alarms "none: digests are compared";

    /// The known value of a check is another than before.
    check_against_another(device: &str, quantity: &str, reference: f64, before: f64, unit: &str) =
        "check-against-another", [Decision],
        what "{device}: {quantity} was checked against another known value than before",
        evidence "{reference:.5e} {unit} now, {before:.5e} {unit} before",
        advice "look at value and unit; a wrong entry is taken back with `records supersede`";

    /// A result is filed for another device than it names.
    device_named_otherwise(device: &str, named: &str) =
        "device-named-otherwise", [Decision],
        what "the result names another device than {device}, for which it was filed",
        evidence "it names {named}",
        advice "supersede it and file it for its own device, or let it stand with the reason in the campaign",
        false_alarms "none: serial numbers are compared";

    /// A quantity of a device comes in another unit.
    unit_otherwise(device: &str, quantity: &str, unit: &str, known: &str) =
        "unit-otherwise", [Decision],
        what "{device}: {quantity} comes in another unit than before",
        evidence "in {unit}; before in {known}",
        advice "convert the numbers: in two units a quantity has two histories",
        false_alarms "none: units are compared";

    /// A device is used after it was withdrawn.
    device_withdrawn(device: &str) =
        "device-withdrawn", [Warning],
        what "{device} was out of use on that day",
        evidence "the last event before is its withdrawal",
        advice "file its return (`records add event DEVICE return`), or look at the day";

    /// Results rest on one that was just superseded.
    rests_on_superseded(result: &str, others: &str) =
        "rests-on-superseded", [Decision],
        what "other results rest on the result {result}, which no longer counts",
        evidence "results {others}",
        advice "evaluate them again, or supersede them with the reason",
        false_alarms "none: digests are compared";

    /// The reference of a result is no standard of these records.
    standard_not_named(result: &str) =
        "standard-not-named", [Note],
        what "no standard of these records stands behind the result {result}",
        evidence "none of its inputs is the file of a certificate, or the result of a standard, filed here, and none was named",
        advice "name the standard with --standard, so that a recall finds the result";

    /// A standard was used after a check in which it failed.
    standard_in_question(standard: &str, checked: &str, en: f64) =
        "standard-in-question", [Decision],
        what "the standard {standard} had failed its last check before it was used",
        evidence "checked on {checked}, E_n = {en:.2}",
        advice "settle the standard first: `records recall` lists what rests on it";

    /// A check measurement does not agree with its reference.
    check_failed(device: &str, quantity: &str, en: f64, difference: f64, expanded: f64, unit: &str) =
        "check-failed", [Decision],
        what "{device}: {quantity} does not agree with its reference",
        evidence "difference {difference:.3e} ± {expanded:.1e} {unit}, E_n = {en:.2}",
        advice "repeat the check; where it stands, recall what rests on the device since its last good check";

    /// A tolerance is not kept by the rule that was chosen.
    tolerance_not_kept(device: &str, quantity: &str, value: f64, lower: f64, upper: f64, unit: &str, probability: f64) =
        "tolerance-not-kept", [Decision],
        what "{device}: {quantity} is not accepted within its tolerance",
        evidence "{value:.5e} {unit} between {lower:.5e} and {upper:.5e}; probability of conformity {probability:.3}",
        advice "adjust the device and calibrate it again, or use it with its own value; look at what was measured with it since the last good one";

    /// A device is used or calibrated after it was due.
    device_overdue(device: &str, due: &str, date: &str) =
        "device-overdue", [Warning],
        what "{device} was overdue",
        evidence "due on {due}, now {date}",
        advice "calibrate it; the results before this one may have run out of tolerance unseen";

    /// Imported values come without an uncertainty.
    uncertainty_not_stated(place: &str, quantities: u64) =
        "uncertainty-not-stated", [Warning],
        what "values without an uncertainty were filed from {place}",
        evidence "{quantities} values",
        advice "they are shown, and count for no drift, jump or interval; file them again with u or U where a certificate has it";
}
