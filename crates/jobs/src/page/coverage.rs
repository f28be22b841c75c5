//! What an expanded uncertainty is stated at, in words.

use proofmass_shaker::derived::{Expanded, PROBABILITY};

/// `95 %`, or the coverage factor that was asked for with the probabilities it has.
pub(crate) fn stated_at<'a>(quantities: impl IntoIterator<Item = &'a Expanded>) -> String {
    let mut k = None;
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for q in quantities {
        (low, high) = (low.min(q.coverage_factor), high.max(q.coverage_factor));
        if q.probability != PROBABILITY {
            k = Some(q.coverage_factor);
            (least, most) = (least.min(q.probability), most.max(q.probability));
        }
    }
    let percent = |p: f64| format!("{:.1}", 100.0 * p);
    let factor = |k: f64| format!("{k:.2}");
    match k {
        None if !(low <= high && high.is_finite()) => "95 %".to_owned(),
        None if factor(low) == factor(high) => format!("95 % (k = {})", factor(low)),
        None => format!("95 % (k = {} to {})", factor(low), factor(high)),
        Some(k) if percent(least) == percent(most) => format!("k = {k} ({} %)", percent(least)),
        Some(k) => format!("k = {k} ({} to {} %)", percent(least), percent(most)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_uncertainty::{DegreesOfFreedom, Quantity};

    #[test]
    fn known_probabilities_of_a_factor() {
        let quantity = |nu: f64, k| {
            let dof = DegreesOfFreedom::new(nu).unwrap();
            let q = Quantity {
                name: "S".into(),
                unit: "1".into(),
                value: 1.0,
                standard_uncertainty: 0.1,
                dof,
            };
            Expanded::of(q, k)
        };
        assert_eq!(stated_at(&[quantity(4.0, None)]), "95 % (k = 2.78)");
        let two = [quantity(4.0, None), quantity(f64::INFINITY, None)];
        assert_eq!(stated_at(&two), "95 % (k = 1.96 to 2.78)");
        assert_eq!(stated_at(&[]), "95 %");
        let all = [
            quantity(f64::INFINITY, Some(2.0)),
            quantity(10.0, Some(2.0)),
        ];
        assert_eq!(all[1].expanded, 0.2);
        assert_eq!(stated_at(&all[..1]), "k = 2 (95.4 %)");
        // Student's t with ten degrees of freedom holds ±2 with 92.66 %.
        assert_eq!(stated_at(&all), "k = 2 (92.7 to 95.4 %)");
    }
}
