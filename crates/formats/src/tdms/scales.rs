//! Scales that a channel declares (`NI_Scale[…]`).

use super::properties::Properties;
use crate::raw::Raw;
use crate::scaling::{From, Scaling, Step};

/// In place of the number of a scale: the numbers as stored.
const STORED: u32 = u32::MAX;
/// Most scales in a row, each of which is held while the next is applied, and most coefficients of a polynomial.
const MOST_SCALES: u32 = 64;
/// Most numbers of a table.
const MOST: u32 = 100_000;

/// Why numbers are not scaled.
type Outcome = Result<Scaling, String>;

/// Nothing is declared: the numbers as they are stored.
pub(super) fn stored(data: &[(u32, Raw)]) -> Outcome {
    match data {
        [(STORED, _)] => Ok(Scaling::none()),
        [_] => Ok(Scaling::none()),
        _ => Err(format!(
            "it has {} parts of a converter, and the file does not say how they are joined",
            data.len()
        )),
    }
}

/// The scaling that properties declare; `None` where they declare none.
pub(super) fn scaling(p: &Properties, data: &[(u32, Raw)]) -> Option<Outcome> {
    let scales = p.count("NI_Number_Of_Scales").or_else(|| {
        let highest = p.highest("NI_Scale[", "]_Scale_Type")?;
        Some(highest.saturating_add(1))
    })?;
    if scales == 0 {
        return None;
    }
    if p.text("NI_Scaling_Status").as_deref() == Some("scaled") {
        return Some(Ok(Scaling::none()));
    }
    if scales > MOST_SCALES {
        return Some(Err(format!("it declares {scales} scales")));
    }
    Some(steps(p, scales, data))
}

fn steps(p: &Properties, scales: u32, data: &[(u32, Raw)]) -> Outcome {
    let mut steps = Vec::new();
    let plain = || data.iter().position(|(id, _)| *id == STORED);
    for number in 0..scales {
        let prefix = format!("NI_Scale[{number}]");
        let key = |rest: &str| format!("{prefix}_{rest}");
        let missing = |rest: &str| format!("{} is missing", key(rest));
        let from = |rest: &str| match p.count(&key(rest)).unwrap_or(STORED) {
            STORED => plain().map(From::Stored).ok_or_else(|| {
                "its scale wants numbers that the converter does not store".to_owned()
            }),
            step if step < number => Ok(From::Step(step as usize)),
            step => Err(format!(
                "scale {number} takes the result of scale {step} after it"
            )),
        };
        let list = |kind: &str, size: Option<u32>| -> Result<Vec<f64>, String> {
            let size = size
                .or_else(|| p.count(&key(&format!("{kind}_Size"))))
                .ok_or_else(|| missing(&format!("{kind}_Size")))?;
            if size > MOST {
                return Err(format!("{size} numbers in one scale"));
            }
            let one = |i: u32| {
                let name = format!("{kind}[{i}]");
                p.number(&key(&name)).ok_or_else(|| missing(&name))
            };
            (0..size).map(one).collect()
        };
        let Some(kind) = p.text(&key("Scale_Type")) else {
            // The numbers of a part of the converter, under the number of the scale.
            let source = data.iter().position(|(id, _)| *id == number);
            let source = source.or_else(plain).ok_or_else(|| missing("Scale_Type"))?;
            steps.push(Step::Same(From::Stored(source)));
            continue;
        };
        steps.push(match kind.as_str() {
            "Linear" => Step::Linear {
                from: from("Linear_Input_Source")?,
                slope: p.number(&key("Linear_Slope")).ok_or_else(|| missing("Linear_Slope"))?,
                intercept: p
                    .number(&key("Linear_Y_Intercept"))
                    .ok_or_else(|| missing("Linear_Y_Intercept"))?,
            },
            "Polynomial" => {
                let size = p.count(&key("Polynomial_Coefficients_Size")).unwrap_or(4);
                if size > MOST_SCALES {
                    return Err(format!("a polynomial of {size} coefficients"));
                }
                Step::Polynomial {
                    from: from("Polynomial_Input_Source")?,
                    coefficients: list("Polynomial_Coefficients", Some(size))?,
                }
            }
            "Table" => {
                let mut stored = list("Table_Pre_Scaled_Values", None)?;
                let mut scaled = list("Table_Scaled_Values", None)?;
                let rises = |x: &[f64]| x.windows(2).all(|w| w[0] < w[1]);
                if !rises(&stored) {
                    stored.reverse();
                    scaled.reverse();
                }
                if !rises(&stored) || stored.len() != scaled.len() || stored.is_empty() {
                    return Err("its table of scaled values neither rises nor falls".to_owned());
                }
                Step::Table {
                    from: from("Table_Input_Source")?,
                    stored,
                    scaled,
                }
            }
            "Add" => Step::Sum(
                from("Add_Left_Operand_Input_Source")?,
                from("Add_Right_Operand_Input_Source")?,
            ),
            "Subtract" => Step::Difference(
                from("Subtract_Left_Operand_Input_Source")?,
                from("Subtract_Right_Operand_Input_Source")?,
            ),
            "AdvancedAPI" => Step::Same(from("AdvancedAPI_Input_Source")?),
            other => {
                return Err(format!(
                    "its scale of the kind {other} is not applied here; store scaled values, or export the channel"
                ));
            }
        });
    }
    let scaling = Scaling { steps };
    match scaling.holds(data.len()) {
        true => Ok(scaling),
        false => Err("its scales do not follow one another".to_owned()),
    }
}
