//! A new certificate as XML, DCC 3.3.0 with D-SI 2.2.1.

use super::new::{
    NewAttachment, NewCertificate, NewComplex, NewConformity, NewContact, NewNumber, NewQuantity,
    NewResult, NewText,
};
use crate::base64::base64;
use crate::xml::XmlWriter;

const VERSION: &str = "3.3.0";
/// What the elements of lists end in.
const LIST: &str = "XMLList";

impl NewCertificate {
    /// The bytes of the file: the same for the same certificate.
    pub fn to_xml(&self) -> String {
        let mut xml = XmlWriter::new();
        xml.begin(
            "dcc:digitalCalibrationCertificate",
            &[
                ("xmlns:dcc", "https://ptb.de/dcc"),
                ("xmlns:si", "https://ptb.de/si"),
                ("xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance"),
                (
                    "xsi:schemaLocation",
                    "https://ptb.de/dcc https://ptb.de/dcc/v3.3.0/dcc.xsd",
                ),
                ("schemaVersion", VERSION),
            ],
        );
        let mut w = Writing {
            xml,
            language: &self.language,
            probability: &self.probability,
        };
        w.within("dcc:administrativeData", |w| self.administrative(w));
        w.within("dcc:measurementResults", |w| {
            w.within("dcc:measurementResult", |w| self.measurement(w));
        });
        if let Some(attachment) = &self.attachment {
            w.attachment(attachment);
        }
        w.xml.finish()
    }

    fn administrative(&self, w: &mut Writing) {
        w.within("dcc:dccSoftware", |w| self.program(w));
        w.within("dcc:coreData", |w| {
            let country = self.laboratory.country.as_deref().unwrap_or("XX");
            w.leaf("dcc:countryCodeISO3166_1", country);
            w.leaf("dcc:usedLangCodeISO639_1", &self.language);
            w.leaf("dcc:mandatoryLangCodeISO639_1", &self.language);
            w.leaf("dcc:uniqueIdentifier", &self.identifier);
            if let Some((order, name)) = &self.order {
                w.within("dcc:identifications", |w| {
                    w.identification("customer", order, name);
                });
            }
            w.optional("dcc:receiptDate", self.received.as_deref());
            w.leaf("dcc:beginPerformanceDate", &self.begin);
            w.leaf("dcc:endPerformanceDate", &self.end);
            w.leaf("dcc:performanceLocation", self.place);
            w.optional("dcc:issueDate", self.issued.as_deref());
            if let Some(number) = &self.replaces {
                w.within("dcc:reportAmendedSubstituted", |w| {
                    w.leaf("dcc:typeOfChange", "substituted");
                    w.leaf("dcc:replacedUniqueIdentifier", number);
                });
            }
        });
        w.within("dcc:items", |w| {
            w.within("dcc:item", |w| {
                let item = &self.item;
                w.name("dcc:name", &NewText::Said(item.name.clone()));
                if let Some(condition) = &item.condition {
                    w.name("dcc:description", &NewText::Said(condition.clone()));
                }
                if let Some(maker) = &item.manufacturer {
                    w.within("dcc:manufacturer", |w| {
                        w.name("dcc:name", &NewText::Name(maker.clone()))
                    });
                }
                w.optional("dcc:model", item.model.as_deref());
                w.within("dcc:identifications", |w| {
                    for (issuer, value, name) in &item.identifications {
                        w.identification(issuer, value, name);
                    }
                });
            });
        });
        w.within("dcc:calibrationLaboratory", |w| {
            w.optional("dcc:calibrationLaboratoryCode", self.code.as_deref());
            w.within("dcc:contact", |w| w.contact(&self.laboratory));
        });
        w.within("dcc:respPersons", |w| {
            for (i, (name, role)) in self.signatories.iter().enumerate() {
                w.within("dcc:respPerson", |w| {
                    w.within("dcc:person", |w| {
                        w.name("dcc:name", &NewText::Name(name.clone()))
                    });
                    w.leaf("dcc:role", role);
                    if i == 0 {
                        w.leaf("dcc:mainSigner", "true");
                    }
                });
            }
        });
        w.within("dcc:customer", |w| w.contact(&self.customer));
        if !self.statements.is_empty() {
            w.within("dcc:statements", |w| {
                for statement in &self.statements {
                    w.within("dcc:statement", |w| {
                        w.name("dcc:name", &statement.name);
                        if let Some((norm, clause)) = &statement.norm {
                            w.leaf("dcc:norm", norm);
                            w.leaf("dcc:reference", clause);
                        }
                        w.name("dcc:declaration", &statement.declaration);
                    });
                }
            });
        }
    }

    fn program(&self, w: &mut Writing) {
        w.within("dcc:software", |w| {
            w.name("dcc:name", &NewText::Name(self.software.0.clone()));
            // A letter first, which is how the rules for certificates want it.
            w.leaf("dcc:release", &format!("v{}", self.software.1));
            w.leaf("dcc:type", "application");
        });
    }

    fn measurement(&self, w: &mut Writing) {
        w.name("dcc:name", &self.name);
        w.within("dcc:usedMethods", |w| {
            for method in &self.methods {
                w.with("dcc:usedMethod", &[("refType", method.ref_type)], |w| {
                    w.name("dcc:name", &method.name);
                    w.texts("dcc:description", &method.description);
                    for norm in &method.norms {
                        w.leaf("dcc:norm", norm);
                    }
                });
            }
        });
        w.within("dcc:usedSoftware", |w| self.program(w));
        if !self.equipment.is_empty() {
            w.within("dcc:measuringEquipments", |w| {
                for standard in &self.equipment {
                    w.with(
                        "dcc:measuringEquipment",
                        &[("refType", "basic_normalUsed")],
                        |w| {
                            w.name("dcc:name", &NewText::Name(standard.name.clone()));
                            w.texts("dcc:description", &standard.description);
                            if let Some(digest) = &standard.sha256 {
                                w.within("dcc:certificate", |w| {
                                    w.name("dcc:referral", &NewText::Name(standard.issuer.clone()));
                                    w.leaf("dcc:referralID", &standard.certificate.0);
                                    w.leaf("dcc:procedure", "SHA-256");
                                    w.leaf("dcc:value", digest);
                                });
                            }
                            w.within("dcc:identifications", |w| {
                                w.identification(
                                    "other",
                                    &standard.certificate.0,
                                    &standard.certificate.1,
                                );
                            });
                        },
                    );
                }
            });
        }
        if !self.conditions.is_empty() {
            w.within("dcc:influenceConditions", |w| {
                for condition in &self.conditions {
                    w.with(
                        "dcc:influenceCondition",
                        &[("refType", condition.ref_type)],
                        |w| {
                            w.name("dcc:name", &condition.name);
                            w.within("dcc:data", |w| {
                                for (end, value) in &condition.limits {
                                    let kind = format!("{}{end}", condition.ref_type);
                                    w.with("dcc:quantity", &[("refType", &kind)], |w| {
                                        w.within("si:real", |w| {
                                            w.leaf("si:value", value);
                                            w.leaf("si:unit", &condition.unit);
                                        });
                                    });
                                }
                            });
                        },
                    );
                }
            });
        }
        w.within("dcc:results", |w| {
            for result in &self.results {
                let kind: Vec<(&str, &str)> = result
                    .ref_type
                    .map(|t| ("refType", t))
                    .into_iter()
                    .collect();
                w.with("dcc:result", &kind, |w| w.result(result));
            }
        });
    }
}

/// The document with what all of its parts need.
struct Writing<'a> {
    xml: XmlWriter,
    language: &'a str,
    probability: &'a str,
}

/// Text without blanks at its ends or in a row, which the schema refuses; a dash where nothing is left.
fn filled(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    match words.is_empty() {
        true => "–".to_owned(),
        false => words.join(" "),
    }
}

impl Writing<'_> {
    fn within(&mut self, name: &str, inner: impl FnOnce(&mut Self)) {
        self.with(name, &[], inner);
    }

    fn with(&mut self, name: &str, attributes: &[(&str, &str)], inner: impl FnOnce(&mut Self)) {
        self.xml.begin(name, attributes);
        inner(self);
        self.xml.end();
    }

    fn leaf(&mut self, name: &str, text: &str) {
        self.xml.leaf(name, &filled(text));
    }

    fn optional(&mut self, name: &str, text: Option<&str>) {
        if let Some(text) = text {
            self.leaf(name, text);
        }
    }

    fn name(&mut self, element: &str, text: &NewText) {
        self.texts(element, std::slice::from_ref(text));
    }

    /// Texts in one element: those of a language as one content, since each language stands once.
    fn texts(&mut self, element: &str, texts: &[NewText]) {
        if texts.is_empty() {
            return;
        }
        let language = self.language.to_owned();
        self.within(element, |w| {
            let said: Vec<&str> = texts
                .iter()
                .map(|text| match text {
                    NewText::Said(text) | NewText::Name(text) => text.as_str(),
                })
                .collect();
            let all = filled(&said.join(" "));
            match texts.iter().any(|t| matches!(t, NewText::Said(_))) {
                true => w.xml.leaf_with("dcc:content", &[("lang", &language)], &all),
                false => w.xml.leaf("dcc:content", &all),
            }
        });
    }

    fn identification(&mut self, issuer: &str, value: &str, name: &str) {
        self.within("dcc:identification", |w| {
            w.leaf("dcc:issuer", issuer);
            w.leaf("dcc:value", value);
            w.name("dcc:name", &NewText::Said(name.to_owned()));
        });
    }

    fn contact(&mut self, contact: &NewContact) {
        self.name("dcc:name", &NewText::Name(contact.name.clone()));
        self.optional("dcc:eMail", contact.email.as_deref());
        self.optional("dcc:phone", contact.phone.as_deref());
        self.within("dcc:location", |w| {
            let town = contact.town.as_deref();
            let country = contact.country.as_deref();
            // The schema wants one of them at least.
            if town.is_none() && country.is_none() {
                w.leaf("dcc:city", "");
            }
            w.optional("dcc:city", town);
            w.optional("dcc:countryCode", country);
            w.optional("dcc:postCode", contact.post_code.as_deref());
            w.optional("dcc:street", contact.street.as_deref());
        });
    }

    fn result(&mut self, result: &NewResult) {
        self.name("dcc:name", &result.name);
        self.within("dcc:data", |w| {
            if result.is_list {
                w.within("dcc:list", |w| w.quantities(result));
            } else {
                w.quantities(result);
            }
        });
    }

    fn quantities(&mut self, result: &NewResult) {
        for quantity in &result.quantities {
            let kind: Vec<(&str, &str)> = quantity
                .ref_type
                .map(|t| ("refType", t))
                .into_iter()
                .collect();
            self.with("dcc:quantity", &kind, |w| {
                w.name("dcc:name", &quantity.name);
                match (result.is_list, &quantity.numbers[..]) {
                    (false, [one]) => w.single(quantity, one),
                    _ => w.list(quantity),
                }
                w.conformity(&quantity.conformity);
            });
        }
        for complex in &result.complex {
            self.within("dcc:quantity", |w| {
                w.name("dcc:name", &complex.name);
                w.complex(complex);
            });
        }
    }

    /// U with its k; elements of lists have an ending.
    fn expanded(&mut self, ending: &str, expanded: &str, k: &str, probability: &str) {
        let of = |name: &str| format!("si:{name}{ending}");
        self.within(&of("measurementUncertaintyUnivariate"), |w| {
            w.within(&of("expandedMU"), |w| {
                w.leaf(&of("valueExpandedMU"), expanded);
                w.leaf(&of("coverageFactor"), k);
                w.leaf(&of("coverageProbability"), probability);
            });
        });
    }

    /// An interval that is not symmetric, with its u.
    fn interval(&mut self, ending: &str, u: &str, [low, high]: &[String; 2], probability: &str) {
        let of = |name: &str| format!("si:{name}{ending}");
        self.within(&of("measurementUncertaintyUnivariate"), |w| {
            w.within(&of("coverageIntervalMU"), |w| {
                w.leaf(&of("valueStandardMU"), u);
                w.leaf(&of("intervalMin"), low);
                w.leaf(&of("intervalMax"), high);
                w.leaf(&of("coverageProbability"), probability);
            });
        });
    }

    fn single(&mut self, quantity: &NewQuantity, number: &NewNumber) {
        let probability = self.probability.to_owned();
        self.within("si:real", |w| {
            w.leaf("si:label", &quantity.label);
            w.leaf("si:value", &number.value);
            w.leaf("si:unit", &quantity.unit);
            match (&number.interval, &number.k, &number.standard) {
                (Some(ends), _, Some(u)) => w.interval("", u, ends, &probability),
                (None, Some(k), _) => w.expanded("", &number.expanded, k, &probability),
                _ => {}
            }
        });
    }

    fn list(&mut self, quantity: &NewQuantity) {
        let probability = self.probability.to_owned();
        let numbers = &quantity.numbers;
        let all = |of: &dyn Fn(&NewNumber) -> Option<String>| -> Option<String> {
            let words: Option<Vec<String>> = numbers.iter().map(of).collect();
            words.map(|w| w.join(" "))
        };
        let values = all(&|n| Some(n.value.clone())).unwrap_or_default();
        let ks = all(&|n| n.k.clone()).map(|words| same(&words));
        let expanded = all(&|n| Some(n.expanded.clone()).filter(|e| !e.is_empty()));
        let standard = all(&|n| n.standard.clone());
        // In a list with one interval that is not symmetric every number has its ends; of the others they are value ± U.
        let end = |n: &NewNumber, k: usize, sign: f64| match &n.interval {
            Some(ends) => ends[k].clone(),
            None => moved(&n.value, &n.expanded, sign),
        };
        let low = all(&|n| Some(end(n, 0, -1.0)));
        let high = all(&|n| Some(end(n, 1, 1.0)));
        self.within("si:realListXMLList", |w| {
            w.leaf("si:labelXMLList", &quantity.label);
            w.leaf("si:valueXMLList", &values);
            w.leaf("si:unitXMLList", &quantity.unit);
            if let (Some(expanded), Some(ks)) = (&expanded, &ks) {
                w.expanded(LIST, expanded, ks, &probability);
            } else if let (Some(_), Some(standard), Some(low), Some(high)) =
                (&expanded, &standard, low, high)
            {
                w.interval(LIST, standard, &[low, high], &probability);
            }
        });
    }

    fn complex(&mut self, complex: &NewComplex) {
        let probability = self.probability.to_owned();
        let [unit, product] = &complex.units;
        let [rr, ri, ii] = &complex.covariance;
        self.within("si:complexListXMLList", |w| {
            w.leaf("si:labelXMLList", &complex.label);
            w.leaf("si:valueRealXMLList", &complex.parts[0].join(" "));
            w.leaf("si:valueImagXMLList", &complex.parts[1].join(" "));
            w.leaf("si:unitXMLList", unit);
            w.within("si:measurementUncertaintyBivariateXMLList", |w| {
                w.within("si:ellipsoidalRegionMUXMLList", |w| {
                    w.within("si:covarianceMatrixXMLList", |w| {
                        for column in [[rr, ri], [ri, ii]] {
                            w.within("si:columnXMLList", |w| {
                                for cell in column {
                                    w.within("si:covarianceXMLList", |w| {
                                        w.leaf("si:valueXMLList", &cell.join(" "));
                                        w.leaf("si:unitXMLList", product);
                                    });
                                }
                            });
                        }
                    });
                    w.leaf("si:coverageFactorXMLList", &complex.k);
                    w.leaf("si:coverageProbabilityXMLList", &probability);
                });
            });
        });
    }

    fn conformity(&mut self, decided: &[NewConformity]) {
        let word = |pass: &bool| if *pass { "pass" } else { "fail" };
        if decided.is_empty() {
            return;
        }
        self.within("dcc:measurementMetaData", |w| {
            for conformity in decided {
                w.with("dcc:metaData", &[("refType", "basic_conformity")], |w| {
                    w.name("dcc:declaration", &conformity.rule);
                    match &conformity.passes[..] {
                        [one] => w.leaf("dcc:conformity", word(one)),
                        several => {
                            let words: Vec<&str> = several.iter().map(word).collect();
                            w.leaf("dcc:conformityXMLList", &words.join(" "));
                        }
                    }
                });
            }
        });
    }

    fn attachment(&mut self, attachment: &NewAttachment) {
        self.within("dcc:document", |w| {
            w.name("dcc:description", &attachment.description);
            w.leaf("dcc:fileName", &attachment.name);
            w.leaf("dcc:mimeType", &attachment.media_type);
            w.leaf("dcc:dataBase64", &base64(&attachment.bytes));
        });
    }
}

/// Value ± U, with as many decimals as both have.
fn moved(value: &str, expanded: &str, sign: f64) -> String {
    let decimals = value.split_once('.').map_or(0, |(_, d)| d.len());
    let number = |t: &str| t.parse::<f64>().unwrap_or(0.0);
    format!("{:.decimals$}", number(value) + sign * number(expanded))
}

/// A list of words of which all are the same is one word, which holds for all values.
fn same(words: &str) -> String {
    let mut each = words.split(' ');
    let first = each.next().unwrap_or_default();
    match each.all(|w| w == first) {
        true => first.to_owned(),
        false => words.to_owned(),
    }
}
