//! What speaks against a pair of channels.

use super::sensitivity::ShockCalibration;
use crate::findings;
use proofmass_core::STANDARD_GRAVITY;
use proofmass_uncertainty::Finding;

impl ShockCalibration {
    /// What the two channels say of each other.
    pub(super) fn pair_findings(&self, rate: f64, unit: &str) -> Vec<Finding> {
        let mut findings = Vec::new();
        let (r, o) = (&self.reference_pulse, &self.output_pulse);
        let apart = (self.reference.peak_time - self.output.peak_time).abs();
        let duration = self.reference.duration.unwrap_or(0.0);
        if duration > 0.0 && apart > duration {
            findings.push(findings::pulses_apart(
                self.reference.peak_time,
                self.output.peak_time,
                apart / duration,
            ));
        }
        if let Some((delay, u)) = self.delay
            && delay < -5.0 * u
            && delay < -0.02 / rate
            && -delay > 2e-4 * duration
        {
            findings.push(findings::output_leads(
                "reference",
                &format!("{:.3} µs ± {:.3} µs earlier", -1e6 * delay, 2e6 * u),
            ));
        }
        if r.sign != o.sign {
            findings.push(findings::opposite_sign());
        }
        let components = self.estimate.components();
        if unit == "m/s²"
            && let Some(c) = components
                .iter()
                .find(|c| c.name == "sensitivity.integral")
                .or(components.first())
        {
            let ratio = c.value.abs();
            let g = STANDARD_GRAVITY;
            for (factor, words) in [
                (
                    g,
                    "as if g stood under a heading of m/s² in the reference, or the reverse in the output",
                ),
                (
                    1.0 / g,
                    "as if g stood under a heading of m/s² in the output, or the reverse in the reference",
                ),
                (1e3, "as if a prefix milli were wrong"),
                (1e-3, "as if a prefix milli were wrong"),
            ] {
                if (ratio / factor - 1.0).abs() < 0.1 {
                    findings.push(proofmass_uncertainty::findings::unit_suspected(
                        "the two accelerations differ by the ratio of two units",
                        &format!("ratio {ratio:.4}, {words}"),
                    ));
                }
            }
        }
        let get = |name: &str| self.estimate.get(name);
        if let (Some(peak), Some(integral)) = (get("sensitivity.peak"), get("sensitivity.integral"))
        {
            let difference = peak.value / integral.value - 1.0;
            // The reference is common to both; what is left is noise.
            let noise = |i: usize| {
                let q = self.estimate.influences().get(i).map(|f| &f.effect);
                match q {
                    Some(proofmass_uncertainty::Effect::Joint { covariance }) => {
                        covariance.standard_uncertainty(i)
                    }
                    _ => 0.0,
                }
            };
            let u = (noise(0).powi(2) + noise(1).powi(2)).sqrt() / integral.value.abs();
            if difference.abs() > 5.0 * u && difference.abs() > 0.01 {
                findings.push(findings::peak_and_integral_differ(
                    100.0 * difference,
                    100.0 * u,
                ));
            }
        }
        findings
    }
}
