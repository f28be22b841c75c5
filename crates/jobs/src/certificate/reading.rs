//! What a digital calibration certificate says, as a page and as data.

use proofmass_documents::{DccQuantity, DccSensitivity, DigitalCertificate};
use proofmass_report::number::minus;
use proofmass_report::{Cell, Column, Field, Report, Rounding, Section, Table};
use serde::Serialize;

/// A certificate that was read, as JSON has it. Numbers of the table are in SI, those of quantities in their unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct CertificateRead {
    version: Option<String>,
    identifier: Option<String>,
    laboratory: Option<String>,
    customer: Option<String>,
    item: proofmass_documents::Device,
    performed: Option<[String; 2]>,
    issued: Option<String>,
    sha256: String,
    /// Lines of XML signatures, none of which was checked.
    unchecked_signatures: Vec<u64>,
    quantities: Vec<QuantityRead>,
    /// Sensitivity over frequency, where it states one that can be a standard.
    #[serde(skip_serializing_if = "Option::is_none")]
    sensitivity: Option<Vec<PointRead>>,
    /// Why it can be no standard, where it cannot.
    #[serde(skip_serializing_if = "Option::is_none")]
    no_standard: Option<String>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct QuantityRead {
    name: String,
    label: Option<String>,
    line: u64,
    unit: String,
    values: Vec<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    u: Option<Vec<f64>>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct PointRead {
    #[serde(rename = "frequency_Hz")]
    frequency: f64,
    sensitivity: f64,
    u_sensitivity: f64,
    phase_rad: Option<f64>,
    u_phase_rad: Option<f64>,
}

/// The table of a sensitivity, or why there is none.
fn table_of(certificate: &DigitalCertificate) -> Result<DccSensitivity, String> {
    certificate.sensitivity(None).map_err(|e| match e.hint() {
        Some(hint) => format!("{e}; {hint}"),
        None => e.to_string(),
    })
}

/// The certificate as data.
pub fn data(certificate: &DigitalCertificate) -> CertificateRead {
    let table = table_of(certificate);
    let points = table.as_ref().ok().map(|t| {
        let point = |r: &proofmass_documents::SensitivityRow| PointRead {
            frequency: r.frequency,
            sensitivity: r.sensitivity,
            u_sensitivity: r.sensitivity_uncertainty,
            phase_rad: r.phase.map(|p| p[0]),
            u_phase_rad: r.phase.map(|p| p[1]),
        };
        t.rows.iter().map(point).collect()
    });
    let quantity = |q: &DccQuantity| QuantityRead {
        name: q.name.clone(),
        label: q.label.clone(),
        line: q.line,
        unit: q.unit.symbol(),
        values: q.values.clone(),
        u: q.uncertainty
            .as_ref()
            .map(|u| (0..q.values.len()).map(|i| u.standard(i)).collect()),
    };
    CertificateRead {
        version: certificate.version.clone(),
        identifier: certificate.identifier.clone(),
        laboratory: certificate.laboratory.clone(),
        customer: certificate.customer.clone(),
        item: certificate.item.clone(),
        performed: certificate.performed.clone(),
        issued: certificate.issued.clone(),
        sha256: certificate.input.sha256.clone(),
        unchecked_signatures: certificate.signatures.clone(),
        quantities: certificate.quantities.iter().map(quantity).collect(),
        sensitivity: points,
        no_standard: table.err(),
    }
}

/// The certificate as a page: its head, the table that makes it a standard, and every quantity.
pub fn page(certificate: &DigitalCertificate) -> Report {
    let number = certificate.identifier.as_deref();
    let title = match (number, &certificate.version) {
        (Some(number), _) => format!("Calibration certificate {number}"),
        (None, Some(_)) => "Calibration certificate without a number".to_owned(),
        (None, None) => "Quantities without a certificate".to_owned(),
    };
    let mut report = Report::new(title);
    let performed = certificate.performed.as_ref().map(|[a, b]| match a == b {
        true => a.clone(),
        false => format!("{a} to {b}"),
    });
    let item = certificate.item.line();
    let signed = match certificate.signatures.len() {
        0 => "by no XML signature".to_owned(),
        n => format!("XML signatures: {n}, not checked"),
    };
    for (label, value) in [
        ("Laboratory", certificate.laboratory.clone()),
        ("Customer", certificate.customer.clone()),
        ("Item", certificate.item.description.clone()),
        ("Device", (!item.is_empty()).then_some(item)),
        ("Calibrated", performed),
        ("Issued", certificate.issued.clone()),
        (
            "Form",
            certificate.version.as_ref().map(|v| format!("DCC {v}")),
        ),
        ("Signed", Some(signed)),
    ] {
        if let Some(value) = value {
            report = report.meta(label, value);
        }
    }
    let mut findings = certificate.findings();
    match table_of(certificate) {
        Ok(table) => {
            findings.extend(table.findings.iter().cloned());
            let unit = format!("{}/(m/s²)", table.output);
            report = report.section(
                Section::new("Sensitivity")
                    .summarised()
                    .table(sensitivity(&table, &unit)),
            );
        }
        Err(why) => {
            report = report.section(
                Section::new("Sensitivity")
                    .summarised()
                    .paragraph(format!("It cannot be the standard of a campaign: {why}.")),
            );
        }
    }
    report
        .section(
            Section::new("Quantities")
                .summarised()
                .table(quantities(certificate)),
        )
        .findings(findings)
}

fn sensitivity(table: &DccSensitivity, unit: &str) -> Table {
    type Row = proofmass_documents::SensitivityRow;
    let fields = [
        Field::shown("f", "Hz", |r: &Row| r.frequency.into()).rounded(Rounding::Plain),
        Field::shown("sensitivity", unit, |r: &Row| {
            Cell::Estimate(r.sensitivity, r.sensitivity_uncertainty)
        }),
        Field::shown("u relative", "%", |r: &Row| {
            (100.0 * r.sensitivity_uncertainty / r.sensitivity).into()
        })
        .rounded(Rounding::TwoDigits),
        Field::shown("phase", "°", |r: &Row| {
            r.phase
                .map(|[p, u]| Cell::Estimate(p.to_degrees(), u.to_degrees()))
                .into()
        }),
    ];
    Table::of("Standard uncertainties in parentheses", fields, &table.rows)
}

fn quantities(certificate: &DigitalCertificate) -> Table {
    let columns = [
        Column::text("quantity"),
        Column::text("values"),
        Column::text("unit"),
        Column::text("uncertainty as stated"),
        Column::text("k"),
        Column::text("line"),
    ];
    let table = Table::new("", columns);
    certificate.quantities.iter().fold(table, |table, q| {
        let name = q
            .label
            .clone()
            .filter(|l| !l.is_empty())
            .unwrap_or_else(|| q.name.clone());
        let values = match &q.values[..] {
            [first, .., last] => {
                format!("{} … {} ({})", exact(*first), exact(*last), q.values.len())
            }
            one => one.first().copied().map(exact).unwrap_or_default(),
        };
        let stated = q.uncertainty.as_ref().map(|u| spread(&u.stated));
        let k = q.uncertainty.as_ref().map(|u| match &u.k[..] {
            [] => "standard".to_owned(),
            k => spread(k),
        });
        table.row([
            Cell::text(name),
            Cell::text(values),
            Cell::text(q.unit.symbol()),
            stated.into(),
            k.into(),
            Cell::text(q.line.to_string()),
        ])
    })
}

/// The smallest and the largest of some numbers.
fn spread(numbers: &[f64]) -> String {
    let low = numbers.iter().copied().fold(f64::INFINITY, f64::min);
    let high = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    match low == high {
        true => exact(low),
        false => format!("{} … {}", exact(low), exact(high)),
    }
}

/// A number with every digit that it has, and none that it does not have.
fn exact(value: f64) -> String {
    let size = value.abs();
    minus(&match size == 0.0 || (1e-4..1e7).contains(&size) {
        true => format!("{value}"),
        false => format!("{value:e}"),
    })
}
