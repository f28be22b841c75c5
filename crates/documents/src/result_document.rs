//! `result.json`: everything a calculation found, in a form that machines can rely on.

use crate::Device;
use proofmass_io::{Error, ErrorKind, Input, RESULT_SCHEMA, Result, Schema, Software};
use proofmass_uncertainty::{Covariance, DegreesOfFreedom, Estimate, Finding, Quantity};
use serde::{Deserialize, Serialize};

/// What to do about a result that contradicts itself.
const CHANGED: &str =
    "the file was changed: evaluate the result again, or fetch it from where it was computed";
/// Version of the form.
pub const RESULT_VERSION: u32 = 2;

/// The frequency in the name of a quantity, Hz, and the name without it.
///
/// ```
/// let found = proofmass_documents::at_frequency("S.xy.modulus[frequency=160]");
/// assert_eq!(found, Some(("S.xy.modulus".to_owned(), 160.0)));
/// assert_eq!(proofmass_documents::at_frequency("bias.x"), None);
/// ```
pub fn at_frequency(name: &str) -> Option<(String, f64)> {
    let (before, rest) = name.split_once("[frequency=")?;
    let (number, after) = rest.split_once(']')?;
    Some((format!("{before}{after}"), number.parse().ok()?))
}

/// A quantity as stated in a result.
///
/// k and U stand in a file only where the interval is value ± k u.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(from = "Written", into = "Written")]
pub struct StatedQuantity {
    /// Stable dotted name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Estimate.
    pub value: f64,
    /// Standard uncertainty; absent where the distribution has none.
    pub u: Option<f64>,
    /// Expanded uncertainty k u; of an interval that is not symmetric about the value, its longer side.
    pub expanded: f64,
    /// Coverage factor.
    pub k: Option<f64>,
    /// Effective degrees of freedom, where the interval rests on them.
    pub nu_eff: Option<DegreesOfFreedom>,
    /// Probability of the interval.
    pub probability: f64,
    /// The interval, where it is not value ± U.
    pub interval: Option<[f64; 2]>,
    /// Method that states it, where the kind of result has several.
    pub method: Option<String>,
}

/// A stated quantity as a file has it.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Written {
    /// Stable dotted name.
    name: String,
    /// Unit.
    unit: String,
    /// Estimate.
    value: f64,
    /// Standard uncertainty; absent where the distribution has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    u: Option<f64>,
    /// Expanded uncertainty k u, where the interval is value ± U.
    #[serde(rename = "U", default, skip_serializing_if = "Option::is_none")]
    expanded: Option<f64>,
    /// Coverage factor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    k: Option<f64>,
    /// Effective degrees of freedom, where the interval rests on them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    nu_eff: Option<DegreesOfFreedom>,
    /// Coverage probability of the interval.
    probability: f64,
    /// The interval, where it is not value ± U.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    interval: Option<[f64; 2]>,
    /// Method that states it, where the kind of result has several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    method: Option<String>,
}

impl From<StatedQuantity> for Written {
    fn from(q: StatedQuantity) -> Self {
        Self {
            expanded: q.symmetric(),
            k: q.k.filter(|_| q.interval.is_none()),
            name: q.name,
            unit: q.unit,
            value: q.value,
            u: q.u,
            nu_eff: q.nu_eff,
            probability: q.probability,
            interval: q.interval,
            method: q.method,
        }
    }
}

impl From<Written> for StatedQuantity {
    fn from(q: Written) -> Self {
        let longer = |[low, high]: [f64; 2]| (high - q.value).max(q.value - low);
        Self {
            expanded: q.expanded.or(q.interval.map(longer)).unwrap_or(0.0),
            name: q.name,
            unit: q.unit,
            value: q.value,
            u: q.u,
            k: q.k,
            nu_eff: q.nu_eff,
            probability: q.probability,
            interval: q.interval,
            method: q.method,
        }
    }
}

impl StatedQuantity {
    /// States a quantity with the interval of a probability.
    pub fn new(quantity: &Quantity, probability: f64) -> Self {
        Self {
            name: quantity.name.clone(),
            unit: quantity.unit.clone(),
            value: quantity.value,
            u: Some(quantity.standard_uncertainty),
            expanded: quantity.expanded(probability),
            k: Some(quantity.coverage_factor(probability)),
            nu_eff: Some(quantity.dof),
            probability,
            interval: None,
            method: None,
        }
    }

    /// U, where the interval is value ± U.
    pub fn symmetric(&self) -> Option<f64> {
        self.interval.is_none().then_some(self.expanded)
    }

    /// States quantities with their intervals of one probability.
    pub fn list<'a>(
        quantities: impl IntoIterator<Item = &'a Quantity>,
        probability: f64,
    ) -> Vec<Self> {
        let quantities = quantities.into_iter();
        quantities.map(|q| Self::new(q, probability)).collect()
    }
}

/// A joint covariance with the names of its rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct NamedCovariance {
    /// Names of rows and columns.
    pub names: Vec<String>,
    /// Units of the quantities; an element has the product of two.
    pub units: Vec<String>,
    /// Rows.
    pub matrix: Covariance,
}

impl NamedCovariance {
    /// That of all components of an estimate.
    pub fn of(estimate: &Estimate) -> Self {
        let components = estimate.components();
        Self {
            names: components.iter().map(|c| c.name.clone()).collect(),
            units: components.iter().map(|c| c.unit.clone()).collect(),
            matrix: estimate.covariance().clone(),
        }
    }
}

/// A result in the making; written with [`ResultDocument::to_json`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ResultDocument {
    /// Form and version.
    pub schema: Schema,
    /// Program that wrote it.
    pub software: Software,
    /// Kind of campaign or calculation.
    pub kind: String,
    /// Title of the campaign.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// The device.
    pub device: Device,
    /// Name of the fitted model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
    /// Files it was computed from.
    pub inputs: Vec<Input>,
    /// What to doubt.
    pub findings: Vec<Finding>,
    /// Every quantity with its interval.
    pub quantities: Vec<StatedQuantity>,
    /// Joint covariance of the quantities of the estimate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<NamedCovariance>,
    /// The estimate with the causes of its uncertainty; read through [`ResultDocument::stated`] alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    estimate: Option<Estimate>,
    /// What only this kind has: residuals, settings, tests.
    pub extra: serde_json::Map<String, serde_json::Value>,
}

impl ResultDocument {
    /// An empty result of a kind.
    pub fn new(kind: impl Into<String>) -> Self {
        Self {
            schema: Schema::new(RESULT_SCHEMA, RESULT_VERSION),
            software: Software::default(),
            kind: kind.into(),
            title: None,
            device: Device::default(),
            model: None,
            inputs: Vec::new(),
            findings: Vec::new(),
            quantities: Vec::new(),
            covariance: None,
            estimate: None,
            extra: serde_json::Map::new(),
        }
    }

    /// Sets the title.
    #[must_use]
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = Some(title.into());
        self
    }

    /// Sets the device.
    #[must_use]
    pub fn device(mut self, device: &Device) -> Self {
        self.device = device.clone();
        self
    }

    /// Sets the name of the model.
    #[must_use]
    pub fn model(mut self, model: impl Into<String>) -> Self {
        self.model = Some(model.into());
        self
    }

    /// Adds an input.
    #[must_use]
    pub fn input(mut self, input: Input) -> Self {
        self.inputs.push(input);
        self
    }

    /// Adds findings.
    #[must_use]
    pub fn findings<'a>(mut self, findings: impl IntoIterator<Item = &'a Finding>) -> Self {
        self.findings.extend(findings.into_iter().cloned());
        self
    }

    /// States every component of the estimate with its interval and adds the joint covariance.
    #[must_use]
    pub fn estimate(mut self, estimate: &Estimate, probability: f64) -> Self {
        self.quantities.extend(
            estimate
                .quantities()
                .iter()
                .map(|q| StatedQuantity::new(q, probability)),
        );
        self.covariance = Some(NamedCovariance::of(estimate));
        self.estimate = Some(estimate.clone());
        self
    }

    /// Adds an estimate of quantities that are stated already, and the joint covariance.
    #[must_use]
    pub fn joint(mut self, estimate: &Estimate) -> Self {
        self.covariance = Some(NamedCovariance::of(estimate));
        self.estimate = Some(estimate.clone());
        self
    }

    /// The estimate behind the quantities: the one way to it, which refuses an estimate that says otherwise than the quantities.
    ///
    /// # Errors
    /// A value, u, unit or covariance of the estimate that is not the stated one, or a stated U that is not k u.
    pub fn stated(&self) -> Result<Option<&Estimate>> {
        let Some(estimate) = &self.estimate else {
            return Ok(None);
        };
        for (i, component) in estimate.components().iter().enumerate() {
            let Some(q) = self.quantities.iter().find(|q| q.name == component.name) else {
                continue;
            };
            let u = estimate.covariance().standard_uncertainty(i);
            let near = |a: f64, b: f64| {
                (a - b).abs() <= 1e-6 * u.max(q.u.unwrap_or(0.0)) + 1e-12 * a.abs()
            };
            if !(near(q.value, component.value) && q.u.is_none_or(|stated| near(stated, u)))
                || q.unit != component.unit
            {
                return Err(Error::new(
                    ErrorKind::Format,
                    format!(
                        "states {} as {} {} with u = {}, but its estimate has {} {} with u = {u}",
                        q.name,
                        q.value,
                        q.unit,
                        q.u.map_or_else(|| "none".to_owned(), |u| u.to_string()),
                        component.value,
                        component.unit,
                    ),
                )
                .column(&q.name)
                .with_hint(
                    "an earlier version kept the linear result beside the stated one: evaluate it again with this one",
                ));
            }
            let product = q.k.zip(q.u).map(|(k, u)| k * u);
            if let Some(product) = product.filter(|_| q.interval.is_none())
                && (q.expanded - product).abs() > 1e-6 * product
            {
                return Err(Error::new(
                    ErrorKind::Format,
                    format!(
                        "states {} with U = {}, but k u is {product}",
                        q.name, q.expanded
                    ),
                )
                .column(&q.name)
                .with_hint(CHANGED));
            }
        }
        self.covariance_is_of(estimate)?;
        Ok(Some(estimate))
    }

    /// That the joint covariance, where one is stated, is that of the estimate.
    fn covariance_is_of(&self, estimate: &Estimate) -> Result<()> {
        let Some(stated) = &self.covariance else {
            return Ok(());
        };
        let all = estimate.covariance();
        let places: Vec<Option<usize>> =
            stated.names.iter().map(|n| estimate.index_of(n)).collect();
        for (i, a) in places.iter().enumerate() {
            for (j, b) in places.iter().enumerate().take(i + 1) {
                let (Some(a), Some(b)) = (*a, *b) else {
                    continue;
                };
                let product = all.standard_uncertainty(a) * all.standard_uncertainty(b);
                if (stated.matrix[(i, j)] - all[(a, b)]).abs() > 1e-6 * product {
                    return Err(Error::new(
                        ErrorKind::Format,
                        format!(
                            "states the covariance of {} and {} as {}, but its estimate has {}",
                            stated.names[i],
                            stated.names[j],
                            stated.matrix[(i, j)],
                            all[(a, b)]
                        ),
                    )
                    .column(&stated.names[i])
                    .with_hint(CHANGED));
                }
            }
        }
        Ok(())
    }

    /// States a quantity outside the estimate, such as local gravity.
    #[must_use]
    pub fn quantity(mut self, quantity: &Quantity, probability: f64) -> Self {
        self.quantities
            .push(StatedQuantity::new(quantity, probability));
        self
    }

    /// Adds a section that only this kind has.
    ///
    /// # Errors
    /// The value holds a number that is not finite, or the name is taken.
    pub fn section(mut self, name: &str, value: &impl Serialize) -> Result<Self> {
        if self.extra.contains_key(name) {
            return Err(Error::new(ErrorKind::Output, "the section is there already").column(name));
        }
        let value = proofmass_io::finite::to_value(value).map_err(|e| match e.field() {
            Some(field) => {
                let field = format!("{name}{field}");
                e.column(field)
            }
            None => e.column(name),
        })?;
        self.extra.insert(name.to_string(), value);
        Ok(self)
    }

    /// The bytes of the file. Numbers are written with as many digits as bring back the same double.
    ///
    /// # Errors
    /// A number that is not finite, or two quantities of one name.
    pub fn to_json(&self) -> Result<Vec<u8>> {
        for (i, q) in self.quantities.iter().enumerate() {
            if self.quantities[..i].iter().any(|p| p.name == q.name) {
                return Err(
                    Error::new(ErrorKind::Output, "two quantities have this name").column(&q.name),
                );
            }
        }
        proofmass_io::finite::to_json_with_rows(self)
    }

    /// Reads a result of this version of the form or an earlier one.
    ///
    /// Version 1 has the state of its calculation (`extra.outcome`) in place of the page.
    ///
    /// # Errors
    /// Another form or a later version, or a damaged file.
    pub fn from_json(bytes: &[u8]) -> Result<Self> {
        let document: Self = serde_json::from_slice(bytes).map_err(|e| {
            Error::new(
                ErrorKind::Format,
                "the file is not a result.json of proofmass, or it is damaged or incomplete",
            )
            .line(e.line() as u64)
            .with_hint("name a result.json that proofmass wrote")
            .because(e)
        })?;
        let known = 1..=RESULT_VERSION;
        if document.schema.name() != RESULT_SCHEMA || !known.contains(&document.schema.version) {
            return Err(Error::new(
                ErrorKind::Format,
                format!(
                    "is {} version {}; this program reads {RESULT_SCHEMA} up to version {RESULT_VERSION}",
                    document.schema.name(), document.schema.version
                ),
            )
            .with_hint("use the version of proofmass that wrote it; it stands under `software`"));
        }
        Ok(document)
    }
}

/// Whether these bytes are a result of this program, of whatever version and kind.
pub fn is_result(bytes: &[u8]) -> bool {
    #[derive(Deserialize)]
    struct Begin {
        schema: Schema,
    }
    serde_json::from_slice::<Begin>(bytes).is_ok_and(|begin| begin.schema.name() == RESULT_SCHEMA)
}
