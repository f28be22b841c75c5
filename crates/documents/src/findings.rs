//! Every finding of this room, declared once.

use proofmass_uncertainty::findings;

findings! {
    /// What reading a certificate may find.
    pub CATALOGUE;

    /// A certificate holds an XML signature, which this program does not check.
    signature_not_checked(certificate: &str, count: usize, line: u64) =
        "signature-not-checked", [Warning],
        what "the signature in {certificate} was not checked: a value may have been changed after it was signed",
        evidence "XML signatures: {count}, the first in line {line}",
        advice "check it with the program of the laboratory that signed; as a standard the certificate is taken only where it is accepted by its number (`accept_unchecked_signature`)",
        false_alarms "none: a signature is there or not";

    /// Phases of a certificate that an accelerometer below its resonance does not have.
    phase_unlikely(phase: f64, degree: f64) =
        "phase-unlikely", [Warning],
        what "the phases of the certificate are not those of an accelerometer below its resonance: degrees may be called radian",
        evidence "a phase of {phase:.4} rad, which is {degree:.1}°",
        advice "ask the laboratory for the unit of the phase; moduli are not concerned",
        false_alarms "none where the phase at any frequency lies within 45° of 0° or 180°, and all within a turn";

    /// A coverage factor that belongs to few degrees of freedom.
    coverage_factor_large(quantity: &str, line: u64, k: f64, probability: f64, degrees: f64) =
        "coverage-factor-large", [Warning],
        what "a coverage factor belongs to very few degrees of freedom",
        evidence "{quantity}, line {line}: k = {k} at {probability} is Student's t with {degrees:.1} degrees of freedom",
        advice "ask the laboratory for the distribution: the standard uncertainty is U/k, and a wrong k gives a wrong u",
        false_alarms "none: it is raised below four degrees of freedom, five per cent apart";

    /// A value that does not lie in the interval that is stated of it.
    value_outside_interval(quantity: &str, line: u64, value: f64, low: f64, high: f64) =
        "value-outside-interval", [Warning],
        what "a value does not lie in the interval that the certificate states of it",
        evidence "{quantity}, line {line}: {value} and the interval from {low} to {high}",
        advice "ask the laboratory which of the two holds; as a standard the certificate is refused",
        false_alarms "none: the value lies in the interval or not";
}
