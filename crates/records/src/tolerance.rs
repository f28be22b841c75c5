//! Whether quantities keep their limits, by a decision rule.

use crate::due::rule;
use crate::engine::Engine;
use crate::entry::{FiledQuantity, FiledResult};
use crate::filing::name_of;
use proofmass_jobs::Result;
use proofmass_jobs::findings::filing as findings;
use proofmass_uncertainty::{DecisionRule, Finding, Limits, Measured, Quantity};

/// A guard band of U: what is accepted conforms with the probability of the interval at least.
const RULE: DecisionRule = DecisionRule::GuardBand { factor: 1.0 };

/// What a quantity is worth against its limits: whether it is accepted, and the probability of conformity. `None` without uncertainty.
pub(crate) fn judge(q: &FiledQuantity, [lower, upper]: [f64; 2]) -> Result<Option<(bool, f64)>> {
    let Some(quantity) = as_quantity(q) else {
        return Ok(None);
    };
    let limits = Limits::between(lower, upper)?;
    let expanded = q.expanded.unwrap_or_else(|| quantity.expanded(0.95));
    let decision = limits.decide(&Measured::of(&quantity), expanded, RULE, None)?;
    Ok(Some((decision.accepted, decision.probability)))
}

/// A filed quantity with its uncertainty.
pub(crate) fn as_quantity(q: &FiledQuantity) -> Option<Quantity> {
    let u = q.u.or_else(|| Some(q.expanded? / q.k.unwrap_or(2.0)))?;
    Some(Quantity {
        name: q.name.clone(),
        unit: q.unit.clone(),
        value: q.value,
        standard_uncertainty: u,
        dof: crate::history::freedom(q.nu),
    })
}

/// Limits that a result does not keep.
pub(crate) fn doubts(
    engine: &mut dyn Engine,
    device: i64,
    result: &FiledResult,
) -> Result<Vec<Finding>> {
    let Some(rule) = rule(engine, device)? else {
        return Ok(Vec::new());
    };
    let mut doubts = Vec::new();
    for tolerance in &rule.tolerances {
        let Some(limits) = tolerance.limits else {
            continue;
        };
        let named = result
            .quantities
            .iter()
            .filter(|q| tolerance.is_of(&q.name));
        for q in named {
            if let Some((false, probability)) = judge(q, limits)? {
                let name = name_of(engine, device)?;
                let [lower, upper] = limits;
                doubts.push(findings::tolerance_not_kept(
                    &name,
                    &q.name,
                    q.value,
                    lower,
                    upper,
                    &q.unit,
                    probability,
                ));
            }
        }
    }
    Ok(doubts)
}
