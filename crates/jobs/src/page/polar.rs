//! Complex sensitivities in polar form, as tables state them.

use super::columns::{coverage_factor, filed, number};
use proofmass_report::Rounding::TwoDigits;
use proofmass_report::number::rounded;
use proofmass_report::{Cell, Field};
use proofmass_shaker::derived::Expanded;
use proofmass_uncertainty::DegreesOfFreedom;

/// Phases in degrees for a plot: whole turns are added so that a step stays within half a turn of the last phase whose
/// expanded uncertainty is below 60°. Where noise alone is left they stay near that one.
pub(crate) fn continuous(phase: &[f64], expanded: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut last = 0.0;
    let each = phase.iter().enumerate().map(|(k, &p)| {
        let shown = p - 360.0 * ((p - last) / 360.0).round();
        if expanded(k) < 60.0 {
            last = shown;
        }
        shown
    });
    each.collect()
}

/// A complex number with modulus and phase, each with what is known of its uncertainty.
pub(crate) struct Polar {
    /// Real and imaginary part, where there is a phase.
    pub(crate) parts: Option<[f64; 2]>,
    /// Modulus.
    pub(crate) modulus: f64,
    /// Its standard uncertainty.
    pub(crate) u: Option<f64>,
    /// Its expanded uncertainty.
    pub(crate) expanded: Option<f64>,
    /// Coverage factor of the modulus.
    pub(crate) k: f64,
    /// Effective degrees of freedom of the modulus; `None` for infinitely many.
    pub(crate) dof: Option<f64>,
    /// Phase in degrees, its standard and its expanded uncertainty.
    pub(crate) phase: Option<[f64; 3]>,
}

impl Polar {
    /// What is stated of modulus and phase.
    pub(crate) fn new(
        parts: Option<[f64; 2]>,
        modulus: &Expanded,
        phase: Option<&Expanded>,
    ) -> Self {
        Self {
            parts,
            modulus: modulus.value,
            u: Some(modulus.standard_uncertainty),
            expanded: Some(modulus.expanded),
            k: modulus.coverage_factor,
            dof: modulus.dof,
            phase: phase
                .map(|p| [p.value, p.standard_uncertainty, p.expanded].map(f64::to_degrees)),
        }
    }
}

/// Columns behind those that name a row: in the unit of the device; on a page, where there is one, in another unit and
/// times a factor.
pub(crate) fn polar<'a, H: 'a>(
    unit: &str,
    page: Option<(&str, f64)>,
) -> [Field<'a, (H, Polar)>; 11] {
    type Row<H> = (H, Polar);
    let unit = unit.replace('²', "2");
    let (shown, factor) = page.map_or(("", None), |(unit, factor)| (unit, Some(factor)));
    let modulus = move |p: &Polar| Some(rounded(factor? * p.modulus, factor? * p.expanded?));
    let phase = move |p: &Polar| factor.and(p.phase).map(|[phase, _, u]| rounded(phase, u));
    let cell = |value: f64, text: Option<String>| match text {
        Some(text) => Cell::printed(value, text),
        None => value.into(),
    };
    [
        filed(format!("real_{unit}"), |r: &Row<H>| r.1.parts.map(|p| p[0])),
        filed(format!("imaginary_{unit}"), |r: &Row<H>| {
            r.1.parts.map(|p| p[1])
        }),
        filed(format!("modulus_{unit}"), move |r: &Row<H>| {
            cell(r.1.modulus, modulus(&r.1).map(|m| m.0))
        })
        .page("modulus", shown),
        filed(format!("u_modulus_{unit}"), |r: &Row<H>| r.1.u),
        filed(format!("U_modulus_{unit}"), move |r: &Row<H>| {
            Some(cell(r.1.expanded?, modulus(&r.1).map(|m| m.1)))
        })
        .page("U", shown),
        number("", ("U relative", "%"), TwoDigits, move |r: &Row<H>| {
            Some(100.0 * factor.and(r.1.expanded)? / r.1.modulus)
        }),
        coverage_factor("k", |r: &Row<H>| r.1.k),
        filed("nu_eff", |r: &Row<H>| {
            let nu = r.1.dof.and_then(DegreesOfFreedom::new);
            let nu = nu.unwrap_or(DegreesOfFreedom::INFINITE);
            Cell::printed(r.1.dof, nu.to_string())
        })
        .page("ν_eff", ""),
        filed("phase_deg", move |r: &Row<H>| {
            Some(cell(r.1.phase?[0], phase(&r.1).map(|p| p.0)))
        })
        .page("phase", "°"),
        filed("u_phase_deg", |r: &Row<H>| Some(r.1.phase?[1])),
        filed("U_phase_deg", move |r: &Row<H>| {
            Some(cell(r.1.phase?[2], phase(&r.1).map(|p| p.1)))
        })
        .page("U phase", "°"),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stored_result::as_filed;
    use proofmass_report::Table;
    use proofmass_uncertainty::{DegreesOfFreedom, Quantity};

    #[test]
    fn known_phases_go_on_where_they_are_known() {
        let wrapped = [-170.0, 175.0, 160.0, -30.0, 170.0, -160.0];
        let sure = continuous(&wrapped, |_| 1.0);
        assert_eq!(sure, [-170.0, -185.0, -200.0, -30.0, -190.0, -160.0]);
        // A phase of which nothing is known does not take the others along.
        let doubtful = continuous(&[10.0, -175.0, 10.0], |k| if k == 1 { 180.0 } else { 1.0 });
        assert_eq!(doubtful, [10.0, 185.0, 10.0]);
    }

    #[test]
    fn known_file_of_a_sensitivity_with_and_without_a_phase() {
        let quantity = |value: f64, u: f64| {
            let quantity = Quantity {
                name: "modulus".into(),
                unit: "V/(m/s²)".into(),
                value,
                standard_uncertainty: u,
                dof: DegreesOfFreedom::INFINITE,
            };
            Expanded::of(quantity, Some(2.0))
        };
        let (modulus, phase) = (quantity(0.5, 0.125), quantity(0.0, 0.25));
        let rows = [
            ("a", Polar::new(Some([0.5, 0.0]), &modulus, Some(&phase))),
            ("b", Polar::new(None, &modulus, None)),
        ];
        let mut fields = vec![Field::new("run", |r: &(&str, Polar)| r.0.into())];
        fields.extend(polar("V/(m/s²)", Some(("mV/(m/s²)", 1e3))));
        let table = as_filed(&Table::of("", fields, rows)).unwrap();
        let text = String::from_utf8(table).unwrap();
        let [head, a, b] = text.lines().collect::<Vec<_>>().try_into().unwrap();
        assert_eq!(
            head,
            "run,real_V/(m/s2),imaginary_V/(m/s2),modulus_V/(m/s2),u_modulus_V/(m/s2),U_modulus_V/(m/s2),k,nu_eff,\
             phase_deg,u_phase_deg,U_phase_deg"
        );
        assert_eq!(
            a,
            "a,0.5,0.0,0.5,0.125,0.25,2.0,,0.0,14.32394487827058,28.64788975654116"
        );
        assert_eq!(b, "b,,,0.5,0.125,0.25,2.0,,,,");
    }
}
