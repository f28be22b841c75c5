//! The digital certificate: the same words and numbers as on the sheet, as a DCC.

use super::CertificateJob;
use super::conformity::DecidedEntry;
use super::content::Content;
use super::laboratory::{CalibrationPlace, Contact};
use super::results::{StatedColumn, StatedNumber, StatedResults, StatedTable};
use super::standards;
use super::texts::{Language, Text};
use crate::trouble::{Result, Trouble};
use crate::{StoredResult, frequency_response};
use proofmass_documents::{
    AnyCalibration, NewAttachment, NewCertificate, NewComplex, NewConformity, NewContact,
    NewEquipment, NewItem, NewMethod, NewNumber, NewQuantity, NewRange, NewResult, NewStatement,
    NewText, dsi_squared, dsi_text,
};
use proofmass_report::number::{plain, rounded_up};
use proofmass_uncertainty::chi_squared_quantile;

/// The certificate to be written; `bytes` are those of the result.
pub(super) fn certificate(
    job: &CertificateJob,
    content: &Content,
    result: &StoredResult,
    bytes: &[u8],
) -> Result<NewCertificate> {
    let language = job.language;
    let said = |text: Text| NewText::Said(text.of(language).to_owned());
    let file = &content.file;
    let laboratory = file.laboratory.clone().unwrap_or_default();
    let customer = file.customer.clone().unwrap_or_default();
    let item = file.item.clone().unwrap_or_default();
    let calibration = file.calibration.clone().unwrap_or_default();
    let begin = calibration
        .begin
        .clone()
        .unwrap_or_else(|| "1970-01-01".to_owned());
    let mut identifications = Vec::new();
    for (issuer, value, text) in [
        ("manufacturer", &item.serial, Text::Serial),
        ("customer", &item.customer_id, Text::CustomerId),
    ] {
        if let Some(value) = value {
            identifications.push((issuer, value.clone(), text.of(language).to_owned()));
        }
    }
    if identifications.is_empty() {
        identifications.push((
            "other",
            "–".to_owned(),
            Text::Serial.of(language).to_owned(),
        ));
    }
    let mut statements = vec![NewStatement {
        name: said(Text::Remarks),
        norm: Some(("ISO/IEC 17025:2017".to_owned(), "7.8.2.1".to_owned())),
        declaration: said(Text::Validity),
    }];
    let sentences: Vec<String> = content
        .traceability()
        .iter()
        .map(|(text, numbers)| {
            let words: Vec<(&str, &str)> = numbers.iter().map(|(n, w)| (*n, w.as_str())).collect();
            text.with(language, &words)
        })
        .collect();
    statements.push(NewStatement {
        name: said(Text::Traceability),
        norm: Some(("ISO/IEC 17025:2017".to_owned(), "7.8.4.1".to_owned())),
        declaration: NewText::Said(sentences.join(" ")),
    });
    if job.number.is_none() {
        statements.push(NewStatement {
            name: said(Text::Draft),
            norm: None,
            declaration: said(Text::DraftNotice),
        });
    }
    if let Some(replaced) = &job.replaces {
        let words = [
            ("number", replaced.number.as_str()),
            ("reason", replaced.reason.as_str()),
        ];
        statements.push(NewStatement {
            name: said(Text::Remarks),
            norm: None,
            declaration: NewText::Said(Text::Replaces.with(language, &words)),
        });
    }
    let further = match &calibration.conditions {
        None => &content.conditions,
        said => said,
    };
    for (text, words) in [
        (Text::Accreditation, &laboratory.accreditation),
        (Text::Mounting, &calibration.mounting),
        (Text::Conditions, further),
        (Text::Due, &calibration.due),
        (Text::Remarks, &calibration.remarks),
    ] {
        statements.extend(words.as_ref().map(|words| NewStatement {
            name: said(text),
            norm: None,
            declaration: NewText::Said(words.clone()),
        }));
    }
    let mut description = vec![said(content.method)];
    if let Some(procedure) = &calibration.procedure {
        description.push(NewText::Said(format!(
            "{}: {procedure}.",
            Text::Procedure.of(language)
        )));
    }
    if let Some(deviations) = &calibration.deviations {
        description.push(NewText::Said(format!(
            "{}: {deviations}.",
            Text::Deviations.of(language)
        )));
    }
    let uncertainty = content
        .uncertainty_statement(language, &content.results.per_cent())
        .into_iter()
        .map(NewText::Said);
    let methods = vec![
        NewMethod {
            ref_type: "basic_calibrationMethod",
            name: said(content.method),
            description,
            norms: content.norms.clone(),
        },
        NewMethod {
            ref_type: "basic_methodMeasurementUncertainty",
            name: said(Text::UncertaintyTitle),
            description: uncertainty.collect(),
            norms: vec!["JCGM 100:2008".to_owned()],
        },
    ];
    let equipment = file.standards.iter().map(|s| NewEquipment {
        name: s.name.clone(),
        certificate: (
            s.certificate.clone(),
            Text::CertificateOfStandard.of(language).to_owned(),
        ),
        issuer: s.issuer.clone(),
        description: [
            (Text::IssuedBy, Some(&s.issuer)),
            (Text::ValidUntil, s.valid_until.as_ref()),
        ]
        .into_iter()
        .filter_map(|(text, words)| {
            Some(NewText::Said(format!("{}: {}.", text.of(language), words?)))
        })
        .collect(),
        sha256: s
            .input
            .as_deref()
            .and_then(|stated| standards::digest_of(stated, result)),
    });
    let mut conditions = Vec::new();
    for span in content.environment().into_iter().chain(content.within()) {
        let places: &[&str] = match span.ends.len() {
            1 => &[""],
            _ => &["Min", "Max"],
        };
        conditions.push(NewRange {
            ref_type: span.ref_type,
            name: said(span.text),
            limits: places.iter().copied().zip(span.ends).collect(),
            unit: dsi(span.unit)?,
        });
    }
    let mut results = Vec::new();
    if let Some(found) = &content.as_found {
        results.extend(all_results(job, Adjusted::Before, found, &[], None)?);
    }
    let about = match content.as_found {
        Some(_) => Adjusted::After,
        None => Adjusted::Never,
    };
    results.extend(all_results(
        job,
        about,
        &content.results,
        &content.decisions,
        Some(result),
    )?);
    Ok(NewCertificate {
        language: language.code().to_owned(),
        identifier: job
            .number
            .clone()
            .unwrap_or_else(|| Text::Draft.of(language).to_owned()),
        order: customer
            .order
            .clone()
            .map(|o| (o, Text::Order.of(language).to_owned())),
        received: calibration.received.clone(),
        end: calibration.end.clone().unwrap_or_else(|| begin.clone()),
        begin,
        issued: content.issued.clone(),
        place: match calibration.place {
            CalibrationPlace::Laboratory => "laboratory",
            CalibrationPlace::Customer => "customer",
        },
        replaces: job.replaces.as_ref().map(|r| r.number.clone()),
        item: NewItem {
            name: item
                .name
                .clone()
                .unwrap_or_else(|| Text::Accelerometer.of(language).to_owned()),
            manufacturer: item.manufacturer.clone(),
            model: item.model.clone(),
            identifications,
            condition: item
                .condition
                .as_ref()
                .map(|c| format!("{}: {c}", Text::Condition.of(language))),
        },
        code: laboratory.code.clone(),
        laboratory: contact(&laboratory),
        customer: contact(&customer),
        signatories: match file.signatories.is_empty() {
            true => vec![("–".to_owned(), "–".to_owned())],
            false => file
                .signatories
                .iter()
                .map(|s| (s.name.clone(), s.role.clone()))
                .collect(),
        },
        statements,
        name: said(Text::Results),
        methods,
        software: (
            result.record().software.name().to_owned(),
            result.record().software.version().to_owned(),
        ),
        equipment: equipment.collect(),
        conditions,
        probability: content.results.probability.clone(),
        results,
        attachment: Some(NewAttachment {
            name: crate::RESULT.to_owned(),
            media_type: "application/json".to_owned(),
            description: said(Text::Evidence),
            bytes: bytes.to_vec(),
        }),
    })
}

fn contact(contact: &Contact) -> NewContact {
    NewContact {
        name: contact.name.clone().unwrap_or_default(),
        email: contact.email.clone(),
        phone: contact.phone.clone(),
        street: contact.street.clone(),
        post_code: contact.post_code.clone(),
        town: contact.town.clone(),
        country: contact.country.clone(),
    }
}

fn dsi(unit: &str) -> Result<String> {
    dsi_text(unit).ok_or_else(|| {
        Trouble::data(format!(
            "the unit {unit:?} has no form in a digital certificate"
        ))
        .with_hint("state the result in units of the SI")
    })
}

fn new_number(number: &StatedNumber) -> NewNumber {
    NewNumber {
        value: number.value.clone(),
        expanded: number.expanded.clone(),
        standard: number.u.clone(),
        k: number.k.clone(),
        interval: number.interval.clone(),
    }
}

/// When a result was measured, beside an adjustment of the item.
#[derive(Clone, Copy)]
enum Adjusted {
    Before,
    After,
    Never,
}

impl Adjusted {
    /// What its names begin with, and its kind.
    fn told(self, language: Language) -> (String, Option<&'static str>) {
        let (text, kind) = match self {
            Self::Before => (Text::AsFound, "basic_beforeAdjustment"),
            Self::After => (Text::AsLeft, "basic_afterAdjustment"),
            Self::Never => return (String::new(), None),
        };
        (format!("{}: ", text.of(language)), Some(kind))
    }
}

fn all_results(
    job: &CertificateJob,
    adjusted: Adjusted,
    stated: &StatedResults,
    decisions: &[DecidedEntry],
    result: Option<&StoredResult>,
) -> Result<Vec<NewResult>> {
    let language = job.language;
    let (about, ref_type) = adjusted.told(language);
    let decided = |name: &str, n: usize| -> Vec<NewConformity> {
        let entries = decisions.iter();
        let entries = entries.filter(|d| d.entry.quantity == name && d.decisions.len() == n);
        let of = |entry: &DecidedEntry| NewConformity {
            rule: NewText::Said(entry.declaration(language)),
            passes: entry.decisions.iter().map(|d| d.pass).collect(),
        };
        entries.map(of).collect()
    };
    let mut results = Vec::new();
    for table in &stated.tables {
        let frequency = NewQuantity {
            name: NewText::Said(Text::Frequency.of(language).to_owned()),
            label: "frequency".to_owned(),
            ref_type: Some("vib_frequency"),
            unit: dsi("Hz")?,
            numbers: table
                .frequency
                .iter()
                .map(|f| NewNumber {
                    value: f.clone(),
                    expanded: String::new(),
                    standard: None,
                    k: None,
                    interval: None,
                })
                .collect(),
            conformity: Vec::new(),
        };
        let mut quantities = vec![frequency];
        for column in &table.columns {
            quantities.push(NewQuantity {
                name: NewText::Said(column.meaning.text().of(language).to_owned()),
                label: column.meaning.label().to_owned(),
                ref_type: column.meaning.ref_type(),
                unit: dsi(&column.unit)?,
                numbers: column.numbers.iter().map(new_number).collect(),
                conformity: decided(&column.name, column.numbers.len()),
            });
        }
        // Of phases against another zero there is no complex sensitivity.
        let complex = match (result, stated.about_phases()) {
            (Some(result), None) => complex(job, table, result)?,
            _ => None,
        };
        let name = match &table.element {
            Some(element) => format!("{about}S.{element}"),
            None => format!("{about}{}", table.columns[0].meaning.text().of(language)),
        };
        results.push(NewResult {
            name: NewText::Said(name),
            ref_type,
            is_list: true,
            quantities,
            complex: complex.into_iter().collect(),
        });
    }
    if !stated.singles.is_empty() {
        let quantities: Result<Vec<NewQuantity>> = stated
            .singles
            .iter()
            .map(|s| {
                Ok(NewQuantity {
                    name: NewText::Said(s.words(language)),
                    label: s.name.clone(),
                    ref_type: None,
                    unit: dsi(&s.unit)?,
                    numbers: vec![new_number(&s.number)],
                    conformity: decided(&s.name, 1),
                })
            })
            .collect();
        results.push(NewResult {
            name: NewText::Said(format!("{about}{}", Text::Parameters.of(language))),
            ref_type,
            is_list: false,
            quantities: quantities?,
            complex: Vec::new(),
        });
    }
    Ok(results)
}

/// Real and imaginary parts of a sensitivity with the covariance of both, where the result holds them.
fn complex(
    job: &CertificateJob,
    table: &StatedTable,
    result: &StoredResult,
) -> Result<Option<NewComplex>> {
    let Some(AnyCalibration::FrequencyResponse(file)) = result.calibration() else {
        return Ok(None);
    };
    let is_modulus = |c: &&StatedColumn| c.name.ends_with(".modulus");
    let Some(modulus) = table.columns.iter().find(is_modulus) else {
        return Ok(None);
    };
    let response = frequency_response::of_file(file)?;
    let place = |names: &[String], wanted: Option<char>| match wanted {
        Some(letter) => names.iter().position(|n| n.chars().eq([letter])),
        None => (names.len() == 1).then_some(0),
    };
    // S.xy: acceleration along x, output along y.
    let mut letters = table.element.as_deref().unwrap_or_default().chars();
    let (axis, output) = (letters.next(), letters.next());
    let (Some(output), Some(axis)) = (place(&file.outputs, output), place(&file.axes, axis)) else {
        return Ok(None);
    };
    let re = response.real_part(output, axis)?;
    let factor = modulus.factor;
    let mut parts = [Vec::new(), Vec::new()];
    let mut covariance = [Vec::new(), Vec::new(), Vec::new()];
    for frequency in &table.frequency {
        let points = response.series().points();
        let Some(point) = points.iter().find(|p| plain(p.at) == *frequency) else {
            return Ok(None);
        };
        let (values, matrix) = (point.estimate.components(), point.estimate.covariance());
        for k in 0..2 {
            let u = factor * matrix.standard_uncertainty(re + k);
            parts[k].push(rounded_up(factor * values[re + k].value, 2.0 * u).0);
        }
        let products = [(re, re), (re, re + 1), (re + 1, re + 1)];
        for (list, place) in covariance.iter_mut().zip(products) {
            list.push(format!("{:.6e}", factor * factor * matrix[place]));
        }
    }
    let unit = dsi(&modulus.unit)?;
    let Some(square) = dsi_squared(&unit) else {
        return Ok(None);
    };
    let probability = result.quantities().first().map_or(0.95, |q| q.probability);
    Ok(Some(NewComplex {
        name: NewText::Said(Text::Modulus.of(job.language).to_owned()),
        label: "sensitivity".to_owned(),
        units: [unit, square],
        parts,
        covariance,
        k: format!("{:.2}", chi_squared_quantile(probability, 2.0).sqrt()),
    }))
}
