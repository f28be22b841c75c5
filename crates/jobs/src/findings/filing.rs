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
        what "the number {number} is that of another result",
        evidence "result {other} has it",
        advice "give the result a number of its own, or supersede the other one with the reason";

    /// A serial number that differs from a known one in its spelling alone.
    serial_spelled_otherwise(serial: &str, known: &str, device: &str) =
        "serial-spelled-otherwise", [Decision],
        what "the serial number {serial} is that of another device in another spelling",
        evidence "device {device} has the serial number {known}",
        advice "if they are one device, file the result again with --device, --supersedes and --reason; if not, nothing is to be done (--new-device says so at once)";

    /// A result reads a file of a result that no longer counts.
    input_superseded(path: &str, result: &str, reason: &str) =
        "input-superseded", [Decision],
        what "{path} is a file of the result {result}, which no longer counts",
        evidence "superseded because: {reason}",
        advice "evaluate it again with the result that took its place",
        false_alarms "none: digests are compared";

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
        evidence "none of its inputs is the file of a certificate or result filed here, and none was named",
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
