//! What speaks against a pulse.

use super::pulse::{Pulse, PulseMeasures};
use proofmass_core::STANDARD_GRAVITY;
use proofmass_uncertainty::{Finding, Severity};

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
    let mut findings = Vec::new();
    let PulseContext { rate, unit, role } = *context;
    let decision = |code: &str, what: String| Finding::new(Severity::Decision, code, what);
    if pulse.end.is_none() {
        findings.push(
            decision("pulse-cut-off", format!("the {role} ends within the pulse"))
                .evidence(format!(
                    "last sample at {:.0} % of the peak",
                    100.0 * pulse.sign * (record[record.len() - 1] - pulse.baseline) / measures.peak.abs()
                ))
                .advice("record longer after the pulse; duration, velocity change and what follows from them are not given"),
        );
    }
    if pulse.start.is_none() {
        findings.push(
            decision(
                "pulse-begins-before-record",
                format!("the {role} begins within the pulse"),
            )
            .advice("use a trigger with a stretch before it of several pulse durations"),
        );
    }
    if !pulse.others.is_empty() {
        let times: Vec<String> = pulse
            .others
            .iter()
            .take(4)
            .map(|k| format!("{:.4} s", *k as f64 / rate))
            .collect();
        findings.push(
            decision(
                "more-than-one-pulse",
                format!("the {role} holds more than one pulse; the greatest is evaluated"),
            )
            .evidence(format!(
                "the greatest at {:.4} s, others at {}",
                measures.peak_time,
                times.join(", ")
            ))
            .advice("a rebound is caught by a brake; cut the record to the pulse that is meant"),
        );
    }
    saturation(&mut findings, pulse, measures, record, role);
    if let Some((shift, u)) = measures.zero_shift
        && shift.abs() > 0.01 * measures.peak.abs()
        && shift.abs() > 5.0 * u
    {
        findings.push(
            Finding::new(Severity::Warning, "zero-shift", format!("the {role} does not return to its level"))
                .evidence(format!("{:.1} % of the peak, {:.0} standard uncertainties", 100.0 * shift / measures.peak, (shift / u).abs()))
                .advice("a piezoelectric element or its amplifier was overloaded, or the mounting moved; do not use the integral"),
        );
    }
    if let Some((share, frequency)) = measures.ringing
        && share > 0.05
    {
        findings.push(
            Finding::new(Severity::Warning, "ringing", format!("the {role} rings after the pulse"))
                .evidence(format!("{:.0} % of the peak at {frequency:.0} Hz", 100.0 * share))
                .advice("the peak may be that of the ringing: compare with the sensitivities by integral and by spectrum, damp the fixture, or filter both channels alike"),
        );
    }
    if measures.samples > 0 && measures.samples < 10 {
        findings.push(
            Finding::new(
                Severity::Warning,
                "few-samples",
                format!("the pulse of the {role} has few samples"),
            )
            .evidence(format!("{} within it", measures.samples))
            .advice("sample at least ten times within the pulse, better fifty"),
        );
    }
    if unit == "m/s²" {
        plausibility(&mut findings, pulse, measures, role);
    }
    findings
}

fn saturation(
    findings: &mut Vec<Finding>,
    pulse: &Pulse,
    measures: &PulseMeasures,
    record: &[f64],
    role: &str,
) {
    let greatest = record[pulse.top];
    // Equal samples at the very top: of a smooth top with noise, or with a step far below the peak, few are equal. A
    // coarse converter repeats values everywhere, so the run is held against those elsewhere in the pulse.
    let from = pulse.start.map_or(0, |s| s as usize);
    let to = pulse.end.map_or(record.len(), |e| e as usize + 1);
    let (mut longest_elsewhere, mut run) = (1, 1);
    for k in from + 1..to {
        run = if record[k] == record[k - 1] && record[k] != greatest {
            run + 1
        } else {
            1
        };
        longest_elsewhere = longest_elsewhere.max(run);
    }
    // At the top of an unsaturated pulse of n samples in steps of δ, √(8δ/A) n/π samples share a step.
    let mut steps: Vec<f64> = record[from..to]
        .windows(2)
        .map(|w| (w[1] - w[0]).abs())
        .filter(|d| *d > 0.0)
        .collect();
    steps.sort_by(f64::total_cmp);
    let step = steps.first().copied().unwrap_or(0.0);
    let natural = (8.0 * step / measures.peak.abs().max(f64::MIN_POSITIVE)).sqrt()
        * (to - from) as f64
        / std::f64::consts::PI;
    let flat = measures.flat_top;
    if flat >= 4 && flat as f64 > 2.0 * natural + 2.0 && flat > 2 * longest_elsewhere {
        findings.push(
            Finding::new(
                Severity::Decision,
                "saturated",
                format!("the top of the pulse in the {role} is cut: the peak is a lower bound"),
            )
            .evidence(format!("{flat} samples at {greatest:.6}, at most {longest_elsewhere} equal elsewhere"))
            .advice("widen the range of converter or amplifier; no sensitivity follows from this record"),
        );
    }
}

fn plausibility(findings: &mut Vec<Finding>, pulse: &Pulse, measures: &PulseMeasures, role: &str) {
    let unit = |what: &str, evidence: String, advice: &str| {
        Finding::new(Severity::Decision, "unit-contradicts-data", what.to_owned())
            .evidence(evidence)
            .advice(advice.to_owned())
    };
    // A device that measures down to rest shows gravity before the shock: ±9.8 in the right unit.
    let level = pulse.baseline.abs();
    let g = STANDARD_GRAVITY;
    for (factor, believed, real) in [(g, "g", "m/s²"), (1.0 / g, "m/s²", "g")] {
        // Known to a hundredth, and far above what the noise could make of zero.
        if (level / (g * factor) - 1.0).abs() < 0.01
            && pulse.quiet >= 16
            && level > 20.0 * pulse.noise / (pulse.quiet as f64).sqrt()
        {
            findings.push(unit(
                &format!("the level before the pulse in the {role} is gravity in another unit"),
                format!("{level:.4} m/s² as read: in {believed} by its heading, 1 g if it were in {real}"),
                "check the unit in the heading of the column",
            ));
        }
    }
    if let Some(dv) = measures.velocity_change
        && dv.abs() > 150.0
    {
        findings.push(unit(
            &format!("the velocity change of the {role} is beyond any shock machine"),
            format!(
                "{:.0} m/s, the fall from {:.0} m",
                dv.abs(),
                dv * dv / (2.0 * g)
            ),
            "check the units of acceleration and time in the headings",
        ));
    }
}
