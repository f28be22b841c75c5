//! What an entry has to be before it is filed, since nothing is changed afterwards. Entries that are here already are not judged again.

use crate::day::day_of;
use crate::engine::Engine;
use crate::entry::{
    Content, Entry, FiledCertificate, FiledCheck, FiledDevice, FiledResult, FiledRule,
    FiledSupersession, Tolerance,
};
use crate::ledger::read_entry;
use crate::rests::{device_of, superseded};
use proofmass_io::spelling::nearest;
use proofmass_jobs::{Result, Trouble};

/// Refuses an entry that could not be read again, that contradicts itself or what it names, or with whose numbers nothing can be
/// computed.
pub(crate) fn check(engine: &mut dyn Engine, entry: &Entry, body: &str) -> Result<()> {
    // JSON has no place for numbers that are not finite.
    if serde_json::from_str::<Entry>(body).is_err() {
        return refuse_number("a number is not finite".to_owned());
    }
    match &entry.content {
        Content::Result(r) => {
            not_ahead(&r.date, &entry.filed)?;
            numbers(r)?;
            campaign(engine, r)
        }
        Content::Certificate(c) => {
            not_ahead(&c.valid_from, &entry.filed)?;
            certificate(engine, c)
        }
        Content::Check(c) => {
            not_ahead(&c.date, &entry.filed)?;
            unit(engine, c)
        }
        Content::Event(e) => not_ahead(&e.date, &entry.filed),
        Content::InUse(u) => {
            not_ahead(&u.date, &entry.filed)?;
            match device_of(engine, u.result)? {
                Some(device) if device != u.device => Err(Trouble::request(format!(
                    "result {} is of another device, #{device}",
                    u.result
                ))
                .with_hint("`proofmass records show DEVICE` lists the results of a device")),
                _ => counts(engine, u.result),
            }
        }
        Content::Supersession(s) => supersession(engine, s),
        Content::Rule(rule) => names(engine, rule),
        Content::Device(d) => device(engine, d),
        Content::Campaign(c) => {
            match c.title.trim() {
                "" => Err(Trouble::request("a campaign needs its title")
                    .with_hint("say it in a few words")),
                _ => Ok(()),
            }
        }
    }
}

fn refuse_number(what: String) -> Result<()> {
    Err(Trouble::data(what).with_hint("correct the number: what is filed once is never changed"))
}

/// What is filed has happened.
fn not_ahead(date: &str, filed: &str) -> Result<()> {
    match day_of(date)? > day_of(filed)? {
        true => Err(
            Trouble::request(format!("{date} lies ahead: it is filed on {filed}"))
                .with_hint("correct the date, or the clock of this computer"),
        ),
        false => Ok(()),
    }
}

/// A device whose numbers can be typed, and are not those of another.
fn device(engine: &mut dyn Engine, d: &FiledDevice) -> Result<()> {
    for number in [&d.serial, &d.owner_number].into_iter().flatten() {
        if number.starts_with('#') || number.starts_with("result:") || number.chars().count() > 200
        {
            let few: String = number.chars().take(20).collect();
            return Err(
                Trouble::request(format!("{few:?} cannot be the number of a device")).with_hint(
                    "#12 and result:17 are numbers of these records; at most 200 characters",
                ),
            );
        }
    }
    let Some(number) = &d.owner_number else {
        return Ok(());
    };
    let others = engine.rows(
        "SELECT entry FROM device WHERE owner_number = ?1",
        &[number.into()],
    )?;
    match others.first().and_then(|row| row[0].integer()) {
        Some(other) => Err(Trouble::request(format!(
            "the owner's number {number} is that of the device #{other}"
        ))
        .with_hint("an owner's number is given once")),
        None => Ok(()),
    }
}

/// A result that was not superseded.
fn counts(engine: &mut dyn Engine, result: i64) -> Result<()> {
    match superseded(engine, result)?.is_none() {
        true => Ok(()),
        false => Err(
            Trouble::request(format!("result {result} no longer counts"))
                .with_hint("name the one that counts in its place"),
        ),
    }
}

fn numbers(result: &FiledResult) -> Result<()> {
    let mut names = std::collections::BTreeSet::new();
    for q in &result.quantities {
        if !names.insert(&q.name) {
            return refuse_number(format!("{} stands twice in the result", q.name));
        }
        if let (Some(u), Some(expanded), Some(k)) = (q.u, q.expanded, q.k)
            && (k * u - expanded).abs() > 0.05 * expanded.abs()
        {
            return refuse_number(format!(
                "{}: u = {u} and U = {expanded} contradict each other with k = {k}",
                q.name
            ));
        }
        let uncertain = [
            ("u", q.u),
            ("U", q.expanded),
            ("u of the standard", q.u_standard),
        ];
        for (name, value) in uncertain {
            // Its square has to be a number.
            if let Some(v) = value.filter(|v| *v != 0.0 && !(1e-150..1e150).contains(v)) {
                return refuse_number(format!("{name} of {} is {v}", q.name));
            }
        }
        if let Some(k) = q.k.filter(|k| !(*k > 0.0)) {
            return refuse_number(format!("the coverage factor of {} is {k}", q.name));
        }
    }
    Ok(())
}

fn campaign(engine: &mut dyn Engine, result: &FiledResult) -> Result<()> {
    let Some(number) = result.campaign else {
        return Ok(());
    };
    match read_entry(engine, number).map(|entry| entry.content) {
        Ok(Content::Campaign(_)) => Ok(()),
        _ => Err(Trouble::request(format!("entry {number} is no campaign"))
            .with_hint("`records add campaign TITLE` adds one and prints its number")),
    }
}

fn certificate(engine: &mut dyn Engine, c: &FiledCertificate) -> Result<()> {
    let from = day_of(&c.valid_from)?;
    if let Some(until) = &c.valid_until
        && day_of(until)? < from
    {
        return Err(Trouble::request(format!(
            "the certificate {} ends on {until}, before it begins on {}",
            c.number, c.valid_from
        ))
        .with_hint("correct the two dates"));
    }
    if c.number.trim().is_empty() {
        return Err(Trouble::request("a certificate needs its number")
            .with_hint("give the one that is printed on it"));
    }
    let Some(file) = &c.file else {
        return Ok(());
    };
    let others = engine.rows(
        "SELECT standard, number FROM certificate WHERE digest = ?1 AND standard <> ?2 LIMIT 1",
        &[(&file.sha256).into(), c.standard.into()],
    )?;
    match others.first() {
        Some(row) => Err(Trouble::request(format!(
            "{} is the file of the certificate {} of another standard",
            file.name,
            row[1].words()
        ))
        .with_hint("a result that reads a table rests on the standard whose table it is: each standard needs its own")),
        None => Ok(()),
    }
}

fn supersession(engine: &mut dyn Engine, s: &FiledSupersession) -> Result<()> {
    if s.reason.trim().is_empty() {
        return Err(Trouble::request("a result is superseded for a reason")
            .with_hint("say it in a few words"));
    }
    if matches!(
        read_entry(engine, s.old)?.content,
        Content::Device(_) | Content::Campaign(_)
    ) {
        return Err(
            Trouble::request(format!("entry {} is a device or a campaign", s.old)).with_hint(
                "a device that is out of use is withdrawn: `records add event DEVICE withdrawal`",
            ),
        );
    }
    let Some(new) = s.new else {
        return Ok(());
    };
    if device_of(engine, s.old)?.is_none() {
        return Err(Trouble::request(format!("entry {} is no result", s.old))
            .with_hint("only a result has another in its place"));
    }
    counts(engine, new)
}

/// A check is in the unit in which the quantity of this device is known.
fn unit(engine: &mut dyn Engine, c: &FiledCheck) -> Result<()> {
    if c.quantity.trim().is_empty() {
        return Err(Trouble::request("the check does not say what was measured")
            .with_hint("give --quantity, such as S.modulus"));
    }
    let rows = engine.rows(
        "SELECT quantity.unit FROM quantity JOIN result ON result.entry = quantity.result WHERE device = ?1 AND (name = ?2 OR name LIKE ?2 || '[%')
         UNION SELECT unit FROM checked WHERE device = ?1 AND quantity = ?2",
        &[c.device.into(), (&c.quantity).into()],
    )?;
    let known: Vec<&str> = rows.iter().filter_map(|row| row[0].text()).collect();
    match known.is_empty() || known.contains(&c.unit.as_str()) {
        true => Ok(()),
        false => Err(Trouble::request(format!(
            "{} of this device is known in {}, not in {}",
            c.quantity, known[0], c.unit
        ))
        .with_hint("give the numbers in that unit, or the quantity its own name")),
    }
}

/// The quantities of tolerances are those of a result, where there is one to compare with.
fn names(engine: &mut dyn Engine, rule: &FiledRule) -> Result<()> {
    let rows = match rule.device {
        Some(device) => engine.rows(
            "SELECT DISTINCT name FROM quantity WHERE result IN (SELECT entry FROM result WHERE device = ?1)",
            &[device.into()],
        )?,
        None => engine.rows("SELECT DISTINCT name FROM quantity", &[])?,
    };
    let known: Vec<&str> = rows.iter().filter_map(|row| row[0].text()).collect();
    let is_known = |t: &Tolerance| known.iter().any(|name| t.is_of(name));
    let unknown = rule.tolerances.iter().find(|t| !is_known(t));
    let Some(unknown) = unknown.filter(|_| !known.is_empty()) else {
        return Ok(());
    };
    Err(
        Trouble::request(format!("no result has a quantity {:?}", unknown.quantity)).with_hint(
            match nearest(&unknown.quantity, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("results have {}", known[..known.len().min(5)].join(", ")),
            },
        ),
    )
}
