//! Axes that are swapped, inverted or turned against the frame in which attitudes are given.

use crate::{Triple, findings};
use proofmass_core::Matrix3;
use proofmass_uncertainty::Finding;

const AXES: [&str; 3] = ["x", "y", "z"];
/// Share of a row of K that its largest element must hold to name the axis it follows.
const DOMINANT: f64 = 0.8;

/// What K says about the wiring when attitudes are given: rows follow their own axis, forwards, or a finding says so.
///
/// `kappa` is K over the nominal sensitivity.
pub(super) fn of(kappa: &[Triple; 3]) -> Option<Finding> {
    let follows: [(usize, f64, f64); 3] = std::array::from_fn(|row| {
        let norm = proofmass_core::norm(kappa[row]);
        let axis = (0..3)
            .max_by(|&a, &b| kappa[row][a].abs().total_cmp(&kappa[row][b].abs()))
            .unwrap_or(row);
        (
            axis,
            kappa[row][axis].signum(),
            kappa[row][axis].abs() / norm,
        )
    });
    let left_handed = Matrix3(*kappa).determinant() < 0.0;
    let mirror = if left_handed {
        "; det K < 0: the three outputs form a left-handed frame"
    } else {
        ""
    };
    let words = |&(axis, sign, _): &(usize, f64, f64)| {
        format!("{}{}", if sign < 0.0 { '-' } else { '+' }, AXES[axis])
    };
    let said = || {
        let parts: Vec<String> = (0..3)
            .filter(|&row| follows[row].0 != row || follows[row].1 < 0.0)
            .map(|row| format!("output {} follows {}", AXES[row], words(&follows[row])))
            .collect();
        format!("{}{mirror}", parts.join(", "))
    };
    let mut taken: Vec<usize> = follows.iter().map(|f| f.0).collect();
    taken.sort_unstable();
    if taken == [0, 1, 2] && follows.iter().all(|f| f.2 > DOMINANT) {
        let swapped = (0..3).any(|row| follows[row].0 != row);
        let inverted = follows.iter().any(|f| f.1 < 0.0);
        return match (swapped, inverted) {
            (true, _) => Some(findings::axes_swapped(&said())),
            (false, true) => Some(findings::axis_inverted(&said())),
            (false, false) => None,
        };
    }
    let rows: Vec<String> = (0..3)
        .map(|row| {
            let norm = proofmass_core::norm(kappa[row]);
            let [a, b, c] = kappa[row].map(|v| v / norm);
            format!("{} ({a:+.2}, {b:+.2}, {c:+.2})", AXES[row])
        })
        .collect();
    Some(findings::frame_turned(&format!(
        "{}{mirror}",
        rows.join(", ")
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_wirings_are_named() {
        let code = |k: [[f64; 3]; 3]| of(&k).map(|f| f.code().to_owned());
        assert_eq!(
            code([[1.0, 0.02, 0.0], [0.0, 0.98, 0.01], [0.0, 0.0, 1.0]]),
            None
        );
        let swapped = of(&[[0.01, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]).unwrap();
        assert_eq!(swapped.code(), "axes-swapped");
        assert!(swapped.evidence_text().contains("output x follows +y"));
        assert!(swapped.evidence_text().contains("left-handed"));
        assert_eq!(
            code([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]).as_deref(),
            Some("axis-inverted")
        );
        let s = std::f64::consts::FRAC_1_SQRT_2;
        assert_eq!(
            code([[s, s, 0.0], [-s, s, 0.0], [0.0, 0.0, 1.0]]).as_deref(),
            Some("frame-turned")
        );
    }
}
