//! Do filter and smoother of one model agree as far as their uncertainties say?

use crate::VelocityTrace;
use crate::whiteness::spectrum_correlation;

/// Difference of filter and smoother in standard deviations of itself, away from slip.
pub(super) struct Disagreement {
    /// Share of the samples within two standard deviations.
    pub(crate) share: f64,
    /// Samples that tell something new: the differences are alike for as long as the filter remembers.
    independent: f64,
}

impl Disagreement {
    /// The smoother's error is uncorrelated with what later readings add: Var(f − s) = u_f² − u_s². `None` for a method
    /// without uncertainties, or where all slips.
    pub(super) fn of(
        trace: &VelocityTrace,
        (smooth, us): &(Vec<f64>, Vec<f64>),
        slips: &impl Fn(usize) -> bool,
    ) -> Option<Self> {
        let uf = trace.standard_uncertainty.as_ref()?;
        let (mut inside, mut off) = (0usize, Vec::new());
        for k in (0..trace.velocity.len()).filter(|k| !slips(*k)) {
            let u = (uf[k] * uf[k] - us[k] * us[k]).max(0.0).sqrt();
            let d = trace.velocity[k] - smooth[k];
            // Where the filter is hardly less certain, a rounding of both is as much as the difference may be.
            inside += usize::from(d.abs() <= (2.0 * u).max(0.5 * uf[k]));
            off.push(if u > 0.0 {
                (d / u).clamp(-5.0, 5.0)
            } else {
                0.0
            });
        }
        if off.is_empty() {
            return None;
        }
        let n = off.len() as f64;
        // Initial positive sequence of the correlation.
        let sum: f64 = spectrum_correlation(&off).map_or(0.0, |rho| {
            rho.iter().skip(1).take_while(|r| **r > 0.0).sum()
        });
        Some(Self {
            share: inside as f64 / n,
            independent: (n / (1.0 + 2.0 * sum)).max(1.0),
        })
    }

    /// Whether it is large enough to matter, and no chance: below 80 %, and four standard deviations of a share of 95 %.
    pub(super) fn matters(&self) -> bool {
        self.share < 0.8_f64.min(0.95 - 4.0 * (0.05 * 0.95 / self.independent).sqrt())
    }
}
