//! The catalogue of findings: every kind is declared once, as data.

use crate::Severity;

/// A kind of finding: what is the same each time it is found. The sentences hold the names of their numbers in braces.
///
/// Declared with [`findings!`](macro@crate::findings).
#[derive(Clone, Copy, Debug)]
pub struct FindingKind {
    /// Stable kebab-case name, declared once in the whole project.
    pub code: &'static str,
    /// What it means, in a line or two of prose.
    pub meaning: &'static str,
    /// The severities it may have; the first is the usual one.
    pub severities: &'static [Severity],
    /// What is doubtful, in one sentence.
    pub what: &'static str,
    /// The numbers that speak for it; empty when the sentence carries them.
    pub evidence: &'static str,
    /// What to do next; empty when nothing is to be done.
    pub advice: &'static str,
    /// Names of the numbers and words that a finding of this kind carries.
    pub evidence_fields: &'static [&'static str],
    /// How often it is found in healthy data, where that was measured.
    pub false_alarms: Option<&'static str>,
}

impl FindingKind {
    /// The severity it has unless a finding says otherwise.
    pub fn usual_severity(&self) -> Severity {
        self.severities[0]
    }

    /// The meaning as one line of prose.
    pub fn meaning_line(&self) -> String {
        self.meaning
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ")
    }

    /// What is doubtful, for a page: numbers are shown by their names, `⟨like this⟩`.
    pub fn what_line(&self) -> String {
        without_numbers(self.what)
    }

    /// The evidence, for a page.
    pub fn evidence_line(&self) -> String {
        without_numbers(self.evidence)
    }

    /// What to do next, for a page.
    pub fn advice_line(&self) -> String {
        without_numbers(self.advice)
    }
}

/// `{sample_rate:.1} Hz` becomes `⟨sample rate⟩ Hz`; doubled braces become single ones.
fn without_numbers(template: &str) -> String {
    let mut line = String::with_capacity(template.len());
    let mut rest = template.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '{' | '}' if rest.next_if_eq(&c).is_some() => line.push(c),
            '{' => {
                let field: String = rest.by_ref().take_while(|c| *c != '}').collect();
                let name = field.split(':').next().unwrap_or_default();
                line.push('⟨');
                line.push_str(&name.replace('_', " "));
                line.push('⟩');
            }
            _ => line.push(c),
        }
    }
    line
}

/// Declares the kinds of findings of a room, and for each a function that makes one from its numbers.
///
/// The sentences are format strings over the arguments of the function; evidence, advice and the rate of false alarms
/// may be left out. The first severity is the usual one, another is chosen with [`Finding::at`](crate::Finding::at).
/// The arguments are numbers, texts or [`Figure`](crate::Figure)s; each also stands in the finding as machine-readable
/// evidence. The functions are as public as the module that holds the declaration.
///
/// ```
/// use proofmass_uncertainty::{Severity, findings};
///
/// findings! {
///     /// What a fit may find.
///     pub CATALOGUE;
///
///     /// The scatter about the fit is larger than the stated noise.
///     excess_residuals(chi_squared: f64, dof: usize, factor: f64) =
///         "excess-residuals", [Warning, Decision],
///         what "the residuals exceed the noise of the means",
///         evidence "χ² = {chi_squared:.1} with {dof} degrees of freedom",
///         advice "check that the sensor stood still; the covariance was scaled by {factor:.2}",
///         false_alarms "1 % of healthy records, by the level of the test";
///
///     /// Nothing was recorded.
///     empty_channel() = "empty-channel", [Note], what "the channel is empty";
/// }
///
/// let finding = excess_residuals(311.24, 105, 2.964);
/// assert_eq!(
///     finding.to_string(),
///     "warning: the residuals exceed the noise of the means (χ² = 311.2 with 105 degrees of freedom); \
///      check that the sensor stood still; the covariance was scaled by 2.96"
/// );
/// assert_eq!(finding.evidence_fields()["dof"], 105usize.into());
/// assert_eq!(finding.at(Severity::Decision).severity(), Severity::Decision);
/// assert_eq!(CATALOGUE[0].evidence_line(), "χ² = ⟨chi squared⟩ with ⟨dof⟩ degrees of freedom");
/// assert_eq!(empty_channel().code(), CATALOGUE[1].code);
/// ```
#[macro_export]
macro_rules! findings {
    (
        $(#[$about:meta])*
        $visibility:vis $catalogue:ident;
        $(
            $(#[doc = $meaning:literal])+
            $kind:ident($($argument:ident: $type:ty),* $(,)?) =
                $code:literal, [$($severity:ident),+ $(,)?],
                what $what:literal
                $(, evidence $evidence:literal)?
                $(, advice $advice:literal)?
                $(, false_alarms $false_alarms:literal)?
                $(,)?;
        )+
    ) => {
        $(#[$about])*
        $visibility static $catalogue: &[$crate::FindingKind] = &[$($kind::KIND),+];

        $(
            mod $kind {
                pub(super) const KIND: $crate::FindingKind = $crate::FindingKind {
                    code: $code,
                    meaning: concat!($($meaning),+),
                    severities: &[$($crate::Severity::$severity),+],
                    what: $what,
                    evidence: concat!($($evidence)?),
                    advice: concat!($($advice)?),
                    evidence_fields: &[$(stringify!($argument)),*],
                    false_alarms: $crate::findings!(@optional $($false_alarms)?),
                };
            }

            $(#[doc = $meaning])+
            #[allow(clippy::too_many_arguments, reason = "one argument for each number of the sentences")]
            pub fn $kind($($argument: $type),*) -> $crate::Finding {
                let sentences = [
                    ::std::fmt::format(::std::format_args!($what)),
                    $crate::findings!(@sentence $($evidence)?),
                    $crate::findings!(@sentence $($advice)?),
                ];
                $crate::Finding::of(&$kind::KIND, sentences, [$($crate::EvidenceValue::from($argument)),*])
            }
        )+
    };
    (@optional) => { ::core::option::Option::None };
    (@optional $given:literal) => { ::core::option::Option::Some($given) };
    (@sentence) => { ::std::string::String::new() };
    (@sentence $given:literal) => { ::std::fmt::format(::std::format_args!($given)) };
}
