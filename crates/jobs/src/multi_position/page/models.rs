//! Other models of the same standstills.

use super::MultiPositionFit;
use proofmass_report::{Cell, Field, Section, Table};
use proofmass_static::ModelEvidence;

/// What the model of the result has beyond the matrix, in words.
pub(super) fn beyond(fit: &MultiPositionFit) -> Option<String> {
    let beyond = fit.beyond()?;
    let mut text = String::from("K and b above are those of small accelerations");
    if let (Some(thermal), Some([low, high])) = (beyond.thermal, beyond.range) {
        text = format!(
            "K and b above hold at T₀ = {:.2} °C; with d = T − T₀ the biases are b + T1 d + T2 d² + T3 d³, and each row of K is multiplied by \
             1 + T1 d + T2 d² + T3 d³ of its scale. Measured from {low:.1} to {high:.1} °C",
            thermal.reference
        );
    }
    if beyond.curvature.is_some() {
        text.push_str(
            "; where an output would be b + s x, it is b + s (x + k₂ x² + k₃ x³), with s its diagonal element of K, x = (K a)/s, and k its curvature",
        );
    }
    text.push('.');
    Some(proofmass_report::number::minus_signs(text))
}

/// Nothing where no models were compared.
pub(super) fn section(fit: &MultiPositionFit, models: &[ModelEvidence]) -> Option<Section> {
    if models.len() < 2 {
        return None;
    }
    let mut section = Section::new("Models side by side").paragraph(
        "Nothing is chosen by this table: stated is the model that was asked for. It shows what each leaves unexplained and how well it \
         predicts standstills it has not seen.",
    );
    let stated = models.iter().find(|m| m.stated);
    let predicted = models.iter().filter_map(|m| Some((m, m.cross_validation?)));
    let best = predicted.min_by(|a, b| a.1.total_cmp(&b.1));
    if let (Some(stated), Some((best, error))) = (stated, best)
        && let Some(own) = stated.cross_validation
    {
        section = section.paragraph(match own > 1.1 * error {
            true => format!(
                "Model {best} predicts standstills with an error of {:.3} mm/s², the stated one with {:.3} mm/s²: a look at it is worth while.",
                1e3 * error,
                1e3 * own
            ),
            false => "No other predicts them more than a tenth better than the stated one.".to_owned(),
        });
    }
    Some(section.table(table(fit, models)))
}

fn table(fit: &MultiPositionFit, models: &[ModelEvidence]) -> Table {
    let fields = [
        Field::shown("model", "", |m: &ModelEvidence| m.to_string().into()),
        Field::shown("parameters", "", |m: &ModelEvidence| m.parameters.into()),
        Field::shown("ΔAICc", "", |m: &ModelEvidence| m.aicc.into()).decimals(1),
        Field::shown("weight", "", |m: &ModelEvidence| m.weight.into()).decimals(3),
        Field::shown("cross-validation", "mm/s²", |m: &ModelEvidence| {
            m.cross_validation.into()
        })
        .scaled(1e3)
        .decimals(3),
        Field::shown("", "", |m: &ModelEvidence| {
            Cell::text(if m.stated { "stated" } else { "" })
        }),
    ];
    let caption = format!("Models of the same {}s, smallest first", super::noun(fit));
    Table::of(caption, fields, models)
        .note("b(T²): biases with the temperature up to its second power; K(T): scale factors with it; a², a³: curvature.")
        .note("Cross-validation: RMS error of a tenth of them at a time, left out of the fit. ΔAICc: Akaike's criterion less that of the best model.")
}
