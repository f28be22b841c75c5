//! What a new certificate says, as texts and rounded numbers: nothing is computed or rounded when it is written.

/// A text in the language of the certificate, or a name that has none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NewText {
    /// In the language of the certificate.
    Said(String),
    /// A name, a number, words of others.
    Name(String),
}

/// A laboratory or a customer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NewContact {
    /// Name.
    pub name: String,
    /// Electronic mail.
    pub email: Option<String>,
    /// Telephone.
    pub phone: Option<String>,
    /// Street and number.
    pub street: Option<String>,
    /// Post code.
    pub post_code: Option<String>,
    /// Town.
    pub town: Option<String>,
    /// Country, two letters.
    pub country: Option<String>,
}

/// The calibrated item.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NewItem {
    /// What it is.
    pub name: String,
    /// Maker.
    pub manufacturer: Option<String>,
    /// Type.
    pub model: Option<String>,
    /// Issuer (`manufacturer`, `customer`), number, and what kind of number it is.
    pub identifications: Vec<(&'static str, String, String)>,
    /// Condition.
    pub condition: Option<String>,
}

/// A statement: its norm with the clause, and what it says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewStatement {
    /// What it is called.
    pub name: NewText,
    /// Norm and clause.
    pub norm: Option<(String, String)>,
    /// What it says.
    pub declaration: NewText,
}

/// A method.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewMethod {
    /// Kind of the method, such as `basic_calibrationMethod`.
    pub ref_type: &'static str,
    /// Name.
    pub name: NewText,
    /// Description.
    pub description: Vec<NewText>,
    /// Norms.
    pub norms: Vec<String>,
}

/// A standard with its certificate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewEquipment {
    /// Name.
    pub name: String,
    /// Number of its certificate, and what that is called.
    pub certificate: (String, String),
    /// Who issued that.
    pub issuer: String,
    /// Issuer and validity of the certificate, in words.
    pub description: Vec<NewText>,
    /// SHA-256 of the certificate, where it was read.
    pub sha256: Option<String>,
}

/// A condition within limits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewRange {
    /// Kind, such as `basic_temperature`.
    pub ref_type: &'static str,
    /// Name.
    pub name: NewText,
    /// Values, with what is put behind the kind for each: `Min` and `Max`, or nothing.
    pub limits: Vec<(&'static str, String)>,
    /// Unit in the notation of D-SI.
    pub unit: String,
}

/// A stated number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewNumber {
    /// Value.
    pub value: String,
    /// Expanded uncertainty.
    pub expanded: String,
    /// Standard uncertainty.
    pub standard: Option<String>,
    /// Coverage factor.
    pub k: Option<String>,
    /// The interval, where it is not symmetric.
    pub interval: Option<[String; 2]>,
}

/// A decision about each number of a quantity.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewConformity {
    /// The rule, in words.
    pub rule: NewText,
    /// Whether each number passes.
    pub passes: Vec<bool>,
}

/// A quantity of a result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewQuantity {
    /// Name.
    pub name: NewText,
    /// Label within D-SI.
    pub label: String,
    /// Kind, such as `vib_phase`.
    pub ref_type: Option<&'static str>,
    /// Unit in the notation of D-SI.
    pub unit: String,
    /// Numbers; those without uncertainty have an empty one.
    pub numbers: Vec<NewNumber>,
    /// Decisions.
    pub conformity: Vec<NewConformity>,
}

/// A complex quantity with the covariance of its two parts, at each frequency.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewComplex {
    /// Name.
    pub name: NewText,
    /// Label within D-SI.
    pub label: String,
    /// Unit of both parts, and of their products, in the notation of D-SI.
    pub units: [String; 2],
    /// Real and imaginary parts.
    pub parts: [Vec<String>; 2],
    /// Variance, covariance, variance.
    pub covariance: [Vec<String>; 3],
    /// Coverage factor of the ellipse.
    pub k: String,
}

/// A result: quantities that belong together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewResult {
    /// Name.
    pub name: NewText,
    /// Kind, such as `basic_beforeAdjustment`.
    pub ref_type: Option<&'static str>,
    /// Whether the numbers of its quantities belong to each other in turn, as over frequency.
    pub is_list: bool,
    /// Quantities.
    pub quantities: Vec<NewQuantity>,
    /// Complex quantities.
    pub complex: Vec<NewComplex>,
}

/// A file inside of the certificate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewAttachment {
    /// Name.
    pub name: String,
    /// Media type.
    pub media_type: String,
    /// What it is.
    pub description: NewText,
    /// Content.
    pub bytes: Vec<u8>,
}

/// A certificate to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewCertificate {
    /// Language of its texts (ISO 639-1).
    pub language: String,
    /// Number, which it has once.
    pub identifier: String,
    /// Order of the customer, and what that is called.
    pub order: Option<(String, String)>,
    /// Days of receipt, begin, end and issue.
    pub received: Option<String>,
    /// First day of the calibration.
    pub begin: String,
    /// Last day of the calibration.
    pub end: String,
    /// Day of issue.
    pub issued: Option<String>,
    /// `laboratory` or `customer`.
    pub place: &'static str,
    /// Number of the certificate that it replaces.
    pub replaces: Option<String>,
    /// The item.
    pub item: NewItem,
    /// Code of the laboratory.
    pub code: Option<String>,
    /// The laboratory.
    pub laboratory: NewContact,
    /// The customer.
    pub customer: NewContact,
    /// Name and role of who authorises, the first one as main signer.
    pub signatories: Vec<(String, String)>,
    /// Statements.
    pub statements: Vec<NewStatement>,
    /// Name of the measurement.
    pub name: NewText,
    /// Methods.
    pub methods: Vec<NewMethod>,
    /// Name and version of the program.
    pub software: (String, String),
    /// Standards.
    pub equipment: Vec<NewEquipment>,
    /// Conditions.
    pub conditions: Vec<NewRange>,
    /// Probability of every interval.
    pub probability: String,
    /// Results.
    pub results: Vec<NewResult>,
    /// What the results were computed from.
    pub attachment: Option<NewAttachment>,
}
