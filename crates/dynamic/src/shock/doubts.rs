//! What speaks against a pulse.

use super::pulse::{Pulse, PulseMeasures};
use crate::findings;
use proofmass_core::STANDARD_GRAVITY;
use proofmass_signal::saturation::{self, Rail};
use proofmass_uncertainty::Finding;

/// What the words about a pulse need to know.
#[derive(Clone, Copy, Debug)]
pub struct PulseContext<'a> {
    /// Samples per second.
    pub rate: f64,
    /// Unit of the channel.
    pub unit: &'a str,
    /// What the channel is called.
    pub role: &'a str,
}

/// What is to be doubted of one pulse.
///
/// **False alarms** on 400 healthy half-sines with white and coloured noise at most 2 % raise any of these
/// (`known_healthy_pulses_raise_nothing`).
pub fn pulse_findings(
    pulse: &Pulse,
    measures: &PulseMeasures,
    record: &[f64],
    context: &PulseContext<'_>,
) -> Vec<Finding> {
    let mut found = Vec::new();
    let PulseContext { rate, unit, role } = *context;
    if pulse.end.is_none() {
        found.push(findings::record_ends_early(
            &format!("the pulse of the {role} does"),
            &format!(
                "last sample at {:.0} % of the peak",
                100.0 * pulse.sign * (record[record.len() - 1] - pulse.baseline)
                    / measures.peak.abs()
            ),
            "duration, velocity change and what follows from them are not given",
        ));
    }
    if pulse.start.is_none() {
        found.push(findings::record_starts_late(
            &format!("within the pulse of the {role}"),
            "no sample before it is at rest",
        ));
    }
    if !pulse.others.is_empty() {
        let times: Vec<String> = pulse
            .others
            .iter()
            .take(4)
            .map(|k| format!("{:.4} s", *k as f64 / rate))
            .collect();
        found.push(findings::more_than_one_pulse(
            role,
            measures.peak_time,
            &times.join(", "),
        ));
    }
    saturation(&mut found, pulse, record, role);
    if let Some((shift, u)) = measures.zero_shift
        && shift.abs() > 0.01 * measures.peak.abs()
        && shift.abs() > 5.0 * u
    {
        found.push(findings::zero_shift(
            role,
            100.0 * shift / measures.peak,
            (shift / u).abs(),
        ));
    }
    if let Some((share, frequency)) = measures.ringing
        && share > 0.05
    {
        found.push(findings::ringing(role, 100.0 * share, frequency));
    }
    if measures.samples > 0 && measures.samples < 10 {
        found.push(findings::few_samples(role, measures.samples));
    }
    if unit == "m/s²" {
        plausibility(&mut found, pulse, measures, role);
    }
    found
}

/// Where the top of the pulse is cut off.
fn saturation(found: &mut Vec<Finding>, pulse: &Pulse, record: &[f64], role: &str) {
    let top = |rail: &Rail| rail.upper == (pulse.sign > 0.0);
    if let Some(rail) = saturation::rails(record).iter().find(|r| top(r)) {
        found.push(proofmass_uncertainty::findings::clipped(
            &format!("the top of the pulse in the {role} is cut"),
            &rail.evidence(),
            "the peak is a lower bound, and no sensitivity follows from this record",
        ));
    }
}

fn plausibility(found: &mut Vec<Finding>, pulse: &Pulse, measures: &PulseMeasures, role: &str) {
    // A device that measures down to rest shows gravity before the shock: ±9.8 in the right unit.
    let level = pulse.baseline.abs();
    let g = STANDARD_GRAVITY;
    for (factor, believed, real) in [(g, "g", "m/s²"), (1.0 / g, "m/s²", "g")] {
        // Known to a hundredth, and far above what the noise could make of zero.
        if (level / (g * factor) - 1.0).abs() < 0.01
            && pulse.quiet >= 16
            && level > 20.0 * pulse.noise / (pulse.quiet as f64).sqrt()
        {
            found.push(proofmass_uncertainty::findings::unit_suspected(
                &format!("the level before the pulse in the {role} is gravity in another unit"),
                &format!("{level:.4} m/s² as read: in {believed} by its heading, 1 g if it were in {real}"),
            ));
        }
    }
    if let Some(dv) = measures.velocity_change
        && dv.abs() > 150.0
    {
        found.push(proofmass_uncertainty::findings::unit_suspected(
            &format!("the velocity change of the {role} is beyond any shock machine"),
            &format!(
                "{:.0} m/s, the fall from {:.0} m",
                dv.abs(),
                dv * dv / (2.0 * g)
            ),
        ));
    }
}
