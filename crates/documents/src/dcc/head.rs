//! A certificate: who calibrated what for whom, and the quantities it states.

use super::quantity::{self, DccQuantity};
use crate::Device;
use crate::findings;
use crate::xml::{Element, Namespace, XmlTree};
use proofmass_io::{Error, ErrorKind, Input, LARGEST_DOCUMENT, Result, Source};
use proofmass_uncertainty::Finding;
use std::path::{Path, PathBuf};

/// Versions of the form that are read: the first and the last, as whole and first part.
const VERSIONS: [(u32, u32); 2] = [(2, 3), (3, 3)];
/// Characters of a text of the head that are kept.
const LONGEST: usize = 400;

/// A digital calibration certificate.
///
/// ```
/// use proofmass_documents::DigitalCertificate;
/// use proofmass_io::Source;
/// let text = r#"<c:digitalCalibrationCertificate xmlns:c="https://ptb.de/dcc" xmlns:si="https://ptb.de/si" schemaVersion="3.3.0">
///   <c:measurementResults><c:measurementResult><c:results><c:result><c:data><c:quantity>
///     <c:name><c:content>mass</c:content></c:name>
///     <si:real><si:value>1.0002</si:value><si:unit>\kilogram</si:unit>
///       <si:expandedUnc><si:uncertainty>0.0002</si:uncertainty><si:coverageFactor>2</si:coverageFactor>
///         <si:coverageProbability>0.95</si:coverageProbability></si:expandedUnc></si:real>
///   </c:quantity></c:data></c:result></c:results></c:measurementResult></c:measurementResults>
/// </c:digitalCalibrationCertificate>"#;
/// let source = Source::from_bytes("certificate.xml", text)?;
/// let certificate = DigitalCertificate::from_source(source)?;
/// let mass = &certificate.quantities[0];
/// assert_eq!((mass.name.as_str(), mass.values[0], mass.unit.symbol().as_str()), ("mass", 1.0002, "kg"));
/// assert_eq!(mass.uncertainty.as_ref().unwrap().standard(0), 0.0001);
/// # Ok::<(), proofmass_io::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DigitalCertificate {
    /// Path and digest.
    pub input: Input,
    /// Version of the form; `None` for quantities without a certificate around them.
    pub version: Option<String>,
    /// The number that it has once.
    pub identifier: Option<String>,
    /// Who calibrated.
    pub laboratory: Option<String>,
    /// For whom.
    pub customer: Option<String>,
    /// What was calibrated.
    pub item: Device,
    /// First and last day of the calibration (ISO 8601).
    pub performed: Option<[String; 2]>,
    /// Day of issue (ISO 8601).
    pub issued: Option<String>,
    /// Languages of its texts.
    pub languages: Vec<String>,
    /// Lines of XML signatures, none of which is checked.
    pub signatures: Vec<u64>,
    /// What the results state, in their order.
    pub quantities: Vec<DccQuantity>,
    pub(super) path: PathBuf,
}

impl DigitalCertificate {
    /// Whether a file is one by its name, which ends in .xml.
    pub fn is_named(path: &Path) -> bool {
        path.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("xml"))
    }

    /// Reads a certificate.
    ///
    /// # Errors
    /// No XML or no certificate, another version, entities or a document type; a list of another length than its values, a number that
    /// is not finite, a negative uncertainty, k or a probability that contradict each other: with element and line.
    pub fn from_source(source: Source) -> Result<Self> {
        let path = source.name().to_path_buf();
        let (bytes, input) = source.into_bytes(LARGEST_DOCUMENT)?;
        Self::read(&bytes, input, path.clone()).map_err(|e| e.at(&path))
    }

    fn read(bytes: &[u8], input: Input, path: PathBuf) -> Result<Self> {
        let tree = XmlTree::read(bytes)?;
        let root = tree.root();
        let certificate = root.is(Namespace::Dcc, "digitalCalibrationCertificate");
        let has_quantities = || root.descendants().any(|e| e.namespace() == Namespace::Si);
        let is_foreign = !certificate && root.name() == "digitalCalibrationCertificate";
        if is_foreign || (!certificate && !has_quantities()) {
            return Err(Error::new(
                ErrorKind::Format,
                match is_foreign {
                    true => "is no digital calibration certificate: its first element belongs to another form than https://ptb.de/dcc".to_owned(),
                    false => format!("is no digital calibration certificate: it begins with {}", root.name()),
                },
            )
            .line(root.line())
            .with_hint("name a DCC (XML): its first element is digitalCalibrationCertificate of https://ptb.de/dcc"));
        }
        let version = match certificate {
            true => Some(version(root)?),
            false => None,
        };
        let core = root.at(Namespace::Dcc, &["administrativeData", "coreData"]);
        let day = |name: &str| core?.child(Namespace::Dcc, name).map(text);
        let contact = |names: &[&str]| {
            let name = root.at(Namespace::Dcc, names)?;
            content(name)
        };
        // Whatever calls itself a signature is one that is not checked.
        let signed = root.descendants().filter(|e| {
            e.name() == "Signature" && !matches!(e.namespace(), Namespace::Dcc | Namespace::Si)
        });
        Ok(Self {
            version,
            identifier: day("uniqueIdentifier"),
            laboratory: contact(&[
                "administrativeData",
                "calibrationLaboratory",
                "contact",
                "name",
            ]),
            customer: contact(&["administrativeData", "customer", "name"]),
            item: item(root),
            performed: day("beginPerformanceDate")
                .zip(day("endPerformanceDate"))
                .map(<[_; 2]>::from),
            issued: day("issueDate"),
            languages: core
                .into_iter()
                .flat_map(Element::children)
                .filter(|e| e.is(Namespace::Dcc, "usedLangCodeISO639_1"))
                .map(text)
                .collect(),
            signatures: signed.map(Element::line).collect(),
            quantities: quantity::of(root)?,
            input,
            path,
        })
    }
}

impl DigitalCertificate {
    /// What to doubt: a signature that nobody checked, a coverage factor that is very large, a value outside of its interval.
    pub fn findings(&self) -> Vec<Finding> {
        let signed = self.signatures.first().map(|line| {
            let name = self.input.path.as_str();
            findings::signature_not_checked(name, self.signatures.len(), *line)
        });
        let few = self.quantities.iter().filter_map(|q| {
            let (k, p, degrees) = q.uncertainty.as_ref()?.of_few_degrees()?;
            let name = q.label.as_deref().unwrap_or(&q.name);
            Some((name, q.line, k, p, degrees))
        });
        // Of several the one with the largest.
        let few = few.max_by(|a, b| a.2.total_cmp(&b.2));
        let few = few.map(|(name, line, k, p, degrees)| {
            findings::coverage_factor_large(name, line, k, p, degrees)
        });
        let outside = self.quantities.iter().find_map(|q| {
            let outside = q.uncertainty.as_ref()?.outside?;
            let name = q.label.as_deref().unwrap_or(&q.name);
            let [low, high] = outside.interval;
            Some(findings::value_outside_interval(
                name,
                q.line,
                outside.value,
                low,
                high,
            ))
        });
        signed.into_iter().chain(few).chain(outside).collect()
    }
}

/// The version, where it is one that is read.
fn version(root: Element) -> Result<String> {
    let stated = root.attribute("schemaVersion").unwrap_or_default();
    let mut parts = stated.split('.').map(|p| p.parse::<u32>().ok());
    let read = match (parts.next().flatten(), parts.next().flatten()) {
        (Some(whole), Some(part)) => (VERSIONS[0]..=VERSIONS[1]).contains(&(whole, part)),
        _ => false,
    };
    if read {
        return Ok(stated.to_owned());
    }
    let what = match stated {
        "" => "the certificate does not say of which version it is (schemaVersion)".to_owned(),
        other => format!("version \"{}\" of the form is not read", short(other)),
    };
    Err(root
        .refuse(what)
        .with_hint("versions 2.3 to 3.3 are read: ask the laboratory for one of these"))
}

fn item(root: Element) -> Device {
    let Some(item) = root.at(Namespace::Dcc, &["administrativeData", "items", "item"]) else {
        return Device::default();
    };
    let of = |names: &[&str]| item.at(Namespace::Dcc, names);
    let all = of(&["identifications"]);
    let mut identifications = all.into_iter().flat_map(Element::children);
    let by_maker = identifications.find(|e| {
        let issuer = e.child(Namespace::Dcc, "issuer").map(Element::text);
        issuer == Some("manufacturer")
    });
    Device {
        manufacturer: of(&["manufacturer", "name"]).and_then(content),
        model: of(&["model"]).map(text),
        serial: by_maker
            .and_then(|e| e.child(Namespace::Dcc, "value"))
            .map(text),
        description: of(&["name"]).and_then(content),
    }
}

/// The text in English where there is one, else the first.
pub(super) fn content(name: Element) -> Option<String> {
    let all = || name.children().filter(|e| e.is(Namespace::Dcc, "content"));
    let english = all().find(|e| e.attribute("lang") == Some("en"));
    english.or_else(|| all().next()).map(text)
}

fn text(element: Element) -> String {
    short(element.text())
}

pub(super) fn short(text: &str) -> String {
    text.chars().take(LONGEST).collect()
}
