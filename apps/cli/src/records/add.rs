//! `proofmass records add`: what is filed.

use crate::{Failure, Outcome, console};
use proofmass::documents::DigitalCertificate;
use proofmass::io::{LARGEST_DOCUMENT, Source};
use proofmass::records::{
    Content, EventKind, FiledCampaign, FiledCertificate, FiledCheck, FiledDevice, FiledEvent,
    FiledRule, FiledUse, Filing, Records as Ledger, Tolerance,
};
use proofmass::statics::static_test::RecalibrationRule;
use std::path::PathBuf;

/// Add a result, a device, a standard, a certificate, a check, an event, a rule
#[derive(clap::Args)]
pub(super) struct Add {
    #[command(subcommand)]
    what: What,
    /// Exit with code 3 when a finding needs a decision
    #[arg(long, global = true)]
    strict: bool,
}

#[derive(clap::Subcommand)]
enum What {
    Result(ResultArguments),
    Device(DeviceArguments),
    Standard(StandardArguments),
    Certificate(CertificateArguments),
    Check(CheckArguments),
    Event(EventArguments),
    Rule(RuleArguments),
    Campaign(CampaignArguments),
    InUse(InUseArguments),
}

/// Add results from their folders
///
/// Files of the folder and the inputs behind it are kept by their digests, so that `records check --recompute` needs nothing else.
/// The same result twice is one.
#[derive(clap::Args)]
struct ResultArguments {
    /// Folders of results, or result.json
    #[arg(required = true)]
    results: Vec<PathBuf>,
    #[command(flatten)]
    filing: Filing,
}

/// Add a device
#[derive(clap::Args)]
struct DeviceArguments {
    #[command(flatten)]
    device: FiledDevice,
}

/// Add a reference standard
#[derive(clap::Args)]
struct StandardArguments {
    #[command(flatten)]
    device: FiledDevice,
}

/// Add the certificate of a standard
///
/// With --file the table or digital calibration certificate (DCC, .xml) that campaigns name as their reference: a result that read it is then known to rest on this standard.
#[derive(clap::Args)]
struct CertificateArguments {
    /// The standard: serial number, owner's number, or number here (#12)
    standard: String,
    /// Number of the certificate [default: that of the DCC]
    #[arg(long, value_name = "NUMBER")]
    number: Option<String>,
    /// First day on which it is valid [default: the day of calibration in the DCC]
    #[arg(long, value_name = "DATE")]
    valid_from: Option<String>,
    /// Last day on which it is valid
    #[arg(long, value_name = "DATE")]
    valid_until: Option<String>,
    /// Laboratory that issued it
    #[arg(long, value_name = "NAME")]
    laboratory: Option<String>,
    /// Relative expanded uncertainty of the sensitivity (k = 2), in percent
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true, value_parser = crate::number_arguments::positive)]
    expanded_relative: Option<f64>,
    /// Its table or page
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
}

/// Add a check measurement of a device or standard; it is judged by E_n
#[derive(clap::Args)]
struct CheckArguments {
    /// The device: serial number, owner's number, or number here (#12)
    device: String,
    /// Measured value
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    value: f64,
    /// Its standard uncertainty
    #[arg(long, value_name = "U", allow_negative_numbers = true, value_parser = crate::number_arguments::positive)]
    u: f64,
    /// Known value
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    reference: f64,
    /// Its standard uncertainty
    #[arg(long, value_name = "U", allow_negative_numbers = true, value_parser = crate::number_arguments::positive)]
    u_reference: f64,
    /// Unit of all numbers
    #[arg(long, value_name = "UNIT")]
    unit: String,
    /// What was measured
    #[arg(long, value_name = "NAME", default_value = "S.modulus")]
    quantity: String,
    /// Day [default: today]
    #[arg(long, value_name = "DATE")]
    date: Option<String>,
}

/// Add what happened to a device: repair, adjustment, drop, withdrawal
#[derive(clap::Args)]
struct EventArguments {
    /// The device: serial number, owner's number, or number here (#12)
    device: String,
    /// What happened
    event: EventKind,
    /// In words
    #[arg(long, value_name = "TEXT", default_value = "")]
    text: String,
    /// Day [default: today]
    #[arg(long, value_name = "DATE")]
    date: Option<String>,
}

/// Add the rule by which a device, or all, are due; and what is tolerated
///
/// What is not said stays as it was: the interval where neither --rule nor --months is given, and every tolerance that is not named.
///
/// `fixed`: always after --months. `drift`: until the drift with its uncertainty may have used up a tolerance, at most --months.
/// `staircase`: after ILAC-G24, --months at first, a quarter longer after each change within 80 % of the tolerance, half after one
/// beyond it, at most --longest.
#[derive(clap::Args)]
struct RuleArguments {
    /// The device: serial number, owner's number, or number here (#12) [default: all without a rule of their own]
    device: Option<String>,
    /// How the time to the next calibration is found [default: as before, or fixed]
    #[arg(long, value_name = "RULE", value_parser = ["fixed", "drift", "staircase"])]
    rule: Option<String>,
    /// Months [default: as before, or 12]
    #[arg(long, value_name = "MONTHS", allow_negative_numbers = true, value_parser = crate::number_arguments::positive)]
    months: Option<f64>,
    /// Longest interval of the staircase, in months [default: as before, or 36]
    #[arg(long, value_name = "MONTHS", allow_negative_numbers = true, value_parser = crate::number_arguments::positive)]
    longest: Option<f64>,
    /// Quantity that is not tolerated by this rule any more; may be repeated
    #[arg(long, value_name = "NAME")]
    without: Vec<String>,
    /// Largest tolerated change of a quantity in its unit, such as bias.x=0.01; may be repeated
    #[arg(long, value_name = "NAME=VALUE", value_parser = change)]
    change: Vec<(String, f64)>,
    /// Limits of a quantity in its unit, such as bias.x=-0.1,0.1; may be repeated
    #[arg(long, value_name = "NAME=LOW,HIGH", value_parser = limits)]
    limits: Vec<(String, [f64; 2])>,
}

/// Add a campaign, which results may name
#[derive(clap::Args)]
struct CampaignArguments {
    /// Its title
    title: String,
    /// Anything else worth filing
    #[arg(long, value_name = "TEXT")]
    description: Option<String>,
}

/// State which calibration a device is used with from a day on
#[derive(clap::Args)]
struct InUseArguments {
    /// The device: serial number, owner's number, or number here (#12)
    device: String,
    /// Number of the result
    result: i64,
    /// Day [default: today]
    #[arg(long, value_name = "DATE")]
    date: Option<String>,
}

fn change(text: &str) -> Result<(String, f64), String> {
    let refused = || "a name and a positive number are needed, such as bias.x=0.01".to_owned();
    // The name of a quantity over frequency has an = of its own.
    let (name, value) = text.rsplit_once('=').ok_or_else(refused)?;
    match value.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok((name.to_owned(), value)),
        _ => Err(refused()),
    }
}

fn limits(text: &str) -> Result<(String, [f64; 2]), String> {
    let refused = || {
        "a name and two numbers are needed, the second larger, such as bias.x=-0.1,0.1".to_owned()
    };
    let (name, values) = text.rsplit_once('=').ok_or_else(refused)?;
    let (low, high) = values.split_once(',').ok_or_else(refused)?;
    match (low.trim().parse::<f64>(), high.trim().parse::<f64>()) {
        (Ok(low), Ok(high)) if low < high && low.is_finite() && high.is_finite() => {
            Ok((name.to_owned(), [low, high]))
        }
        _ => Err(refused()),
    }
}

impl Add {
    pub(super) fn run(self, place: &str, today: &str) -> Result<Outcome, Failure> {
        super::made(place, |records| self.add_to(records, today))
    }

    fn add_to(self, records: &mut Ledger, today: &str) -> Result<Outcome, Failure> {
        let on = |date: Option<String>| date.unwrap_or_else(|| today.to_owned());
        let mut all = Vec::new();
        let content = match self.what {
            What::Result(results) => {
                for place in &results.results {
                    let filed = records
                        .add_result(place, &results.filing, today)
                        .map_err(|trouble| trouble.detail(place.display().to_string()))?;
                    filed.findings.iter().for_each(console::finding);
                    let said = &results.filing;
                    let more = !said.standard.is_empty()
                        || said.number.is_some()
                        || said.device.is_some()
                        || said.date.is_some()
                        || said.supersedes.is_some();
                    if filed.known && more {
                        return Err(Failure::new(format!(
                            "{} is here already as result {}, and nothing is changed",
                            place.display(),
                            filed.number
                        ))
                        .hint(format!(
                            "to file it anew with what you say now: --supersedes {} --reason \"…\"",
                            filed.number
                        )));
                    }
                    if let Some(device) = filed.new_device {
                        let name = records.filed_device(device)?.line();
                        console::note(format!("new device #{device}: {name}"));
                    }
                    let how = if filed.known {
                        "is here already as"
                    } else {
                        "is"
                    };
                    console::print(&format!(
                        "{} {how} result {}\n",
                        place.display(),
                        filed.number
                    ))?;
                    all.extend(filed.findings);
                }
                return Ok(Outcome::of(self.strict, &all));
            }
            What::Device(d) => Content::Device(named(records, d.device)?),
            What::Standard(s) => Content::Device(FiledDevice {
                standard: true,
                ..named(records, s.device)?
            }),
            What::Certificate(c) => {
                let standard = records.device(&c.standard)?;
                let device = records.filed_device(standard)?;
                if !device.standard {
                    return Err(Failure::new(format!(
                        "{} is a device, not a standard",
                        c.standard
                    ))
                    .hint("add it with `records add standard`"));
                }
                let filed = FiledCertificate {
                    standard,
                    number: c.number.unwrap_or_default(),
                    laboratory: c.laboratory,
                    valid_from: c.valid_from.unwrap_or_default(),
                    valid_until: c.valid_until,
                    u_relative: c.expanded_relative.map(|percent| percent / 200.0),
                    ..FiledCertificate::default()
                };
                let digital = c
                    .file
                    .as_ref()
                    .is_some_and(|f| DigitalCertificate::is_named(f));
                if !digital && (filed.number.is_empty() || filed.valid_from.is_empty()) {
                    return Err(Failure::new("a certificate needs its number and its first day")
                        .hint("give --number and --valid-from; a digital calibration certificate (--file ….xml) says both"));
                }
                Content::Certificate(match &c.file {
                    Some(file) => {
                        let name = file.display().to_string();
                        let (bytes, _) = Source::open(file)?.into_bytes(LARGEST_DOCUMENT)?;
                        let (mut filed, doubts) = filed.reading(&name, &bytes, &device)?;
                        doubts.iter().for_each(console::finding);
                        filed.file = Some(records.keep_file(&name, &bytes)?);
                        filed
                    }
                    None => filed,
                })
            }
            What::Check(c) => Content::Check(FiledCheck::measured(
                records.device(&c.device)?,
                on(c.date),
                (c.quantity, c.unit),
                [c.value, c.u],
                [c.reference, c.u_reference],
            )?),
            What::Event(e) => Content::Event(FiledEvent {
                device: records.device(&e.device)?,
                date: on(e.date),
                event: e.event,
                text: e.text,
            }),
            What::Rule(rule) => Content::Rule(rule.filed(records)?),
            What::Campaign(c) => Content::Campaign(FiledCampaign {
                title: c.title,
                description: c.description,
            }),
            What::InUse(u) => Content::InUse(FiledUse {
                device: records.device(&u.device)?,
                result: u.result,
                date: on(u.date),
            }),
        };
        let filed = records.file_content(today, None, content.clone())?;
        match &content {
            Content::Rule(rule) => console::note(rule.words()),
            Content::Certificate(_) => {
                let behind = records.results_behind(filed.number)?;
                if !behind.is_empty() {
                    let numbers: Vec<String> = behind.iter().map(i64::to_string).collect();
                    console::note(format!(
                        "it stands behind the results {}",
                        numbers.join(", ")
                    ));
                }
            }
            _ => {}
        }
        filed.findings.iter().for_each(console::finding);
        console::print(&format!("#{}\n", filed.number))?;
        Ok(Outcome::of(self.strict, &filed.findings))
    }
}

/// A device that can be found again, and is not here yet.
fn named(records: &mut Ledger, mut device: FiledDevice) -> Result<FiledDevice, Failure> {
    for number in [&mut device.serial, &mut device.owner_number] {
        *number = number.take().map(|n| n.trim().to_owned());
    }
    let number = |text: &Option<String>| text.as_ref().is_some_and(|t| !t.trim().is_empty());
    if !number(&device.serial) && !number(&device.owner_number) {
        return Err(Failure::new("a device needs a number by which it is found")
            .hint("give --serial or --owner-number"));
    }
    if let Some(known) = records.same_device(&device)? {
        return Err(
            Failure::new(format!("{} is here already as #{known}", device.line()))
                .hint("`proofmass records show` has what is known of it"),
        );
    }
    Ok(device)
}

impl RuleArguments {
    fn filed(self, records: &mut Ledger) -> Result<FiledRule, Failure> {
        let device = self
            .device
            .as_deref()
            .map(|called| records.device(called))
            .transpose()?;
        let before = records.own_rule(device)?;
        let (kind, months, longest) = match before.as_ref().map(|b| b.rule) {
            Some(RecalibrationRule::Drift { longest }) => ("drift", longest, 36.0),
            Some(RecalibrationRule::Staircase { first, longest }) => ("staircase", first, longest),
            Some(RecalibrationRule::Fixed { months }) => ("fixed", months, 36.0),
            _ => ("fixed", 12.0, 36.0),
        };
        let kind = self.rule.as_deref().unwrap_or(kind);
        let months = self.months.unwrap_or(months);
        if self.longest.is_some() && kind != "staircase" {
            return Err(Failure::new("--longest belongs to the staircase")
                .hint("the longest interval of `drift` is --months"));
        }
        let longest = self.longest.unwrap_or(longest);
        if kind == "staircase" && months > longest {
            return Err(Failure::new(format!(
                "the first interval of {months} months is longer than the longest of {longest}"
            ))
            .hint("make --longest at least --months"));
        }
        if months > 600.0 {
            return Err(Failure::new(format!(
                "an interval of {months} months is out of range: 600 months at most"
            ))
            .hint("give --months in months"));
        }
        let rule = match kind {
            "drift" => RecalibrationRule::Drift { longest: months },
            "staircase" => RecalibrationRule::Staircase {
                first: months,
                longest,
            },
            _ => RecalibrationRule::Fixed { months },
        };
        let mut tolerances = before.map(|b| b.tolerances).unwrap_or_default();
        for name in &self.without {
            let Some(at) = tolerances.iter().position(|t| t.quantity == *name) else {
                return Err(Failure::new(format!("the rule tolerates no {name:?}"))
                    .hint("`proofmass records show DEVICE` has the rule"));
            };
            tolerances.remove(at);
        }
        for (quantity, change) in self.change {
            of(&mut tolerances, quantity).change = Some(change);
        }
        for (quantity, limits) in self.limits {
            of(&mut tolerances, quantity).limits = Some(limits);
        }
        if kind != "fixed" && tolerances.iter().all(|t| t.change.is_none()) {
            return Err(Failure::new(format!("the rule `{kind}` needs a tolerance"))
                .hint("say what may change, such as --change S.modulus=0.0001, which is that of every frequency"));
        }
        Ok(FiledRule {
            device,
            rule,
            tolerances,
        })
    }
}

/// The tolerance of a quantity, a new one where there is none.
fn of(tolerances: &mut Vec<Tolerance>, quantity: String) -> &mut Tolerance {
    let at = tolerances.iter().position(|t| t.quantity == quantity);
    let at = at.unwrap_or_else(|| {
        tolerances.push(Tolerance {
            quantity,
            change: None,
            limits: None,
        });
        tolerances.len() - 1
    });
    &mut tolerances[at]
}
