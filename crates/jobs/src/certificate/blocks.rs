//! The document of a certificate in its language: what stands where.

use super::content::Content;
use super::figure;
use super::results::{Meaning, StatedNumber, StatedResults, StatedTable};
use super::sheet::{
    Run, Sheet, SheetAlign, SheetBlock, SheetColumn, SheetIssuer, SheetRunning, SheetSignature,
};
use super::texts::{Language, Piece, Text, persian_digits};
use super::{CertificateJob, laboratory::CalibrationPlace};
use crate::trouble::Result;
use proofmass_report::KeyFigure;
use proofmass_report::number::{minus, plain};

/// Writes numbers and texts in the language of the certificate.
pub(super) struct Words {
    pub(super) language: Language,
    pub(super) persian: bool,
}

impl Words {
    /// A text; the numbers of standards in it keep their digits.
    pub(super) fn of(&self, text: Text) -> String {
        text.of(self.language).to_owned()
    }

    fn with(&self, text: Text, words: &[(&str, &str)]) -> String {
        text.with(self.language, words)
    }

    /// A number or a day of ours with its digits; names and numbers of others keep theirs.
    fn digits(&self, text: &str) -> String {
        match self.persian {
            true => persian_digits(text),
            false => text.to_owned(),
        }
    }

    /// A number as it is printed.
    fn number(&self, text: &str) -> String {
        self.digits(&minus(text))
    }

    /// `Table 3`.
    fn label(&self, text: Text, n: usize) -> String {
        self.with(text, &[("n", &self.digits(&n.to_string()))])
    }

    fn run(&self, text: &str) -> Vec<Run> {
        vec![Run::Number(self.number(text))]
    }

    /// One number, or the ends of a range, with the unit.
    fn span(&self, ends: &[String], unit: &str) -> Vec<Run> {
        match ends {
            [low, high] if low != high => {
                let [low, high] = [low, high].map(|v| minus(v));
                match self.language {
                    Language::Persian => self.between(&low, &format!("{high} {unit}")),
                    _ => self.run(&format!("({low} … {high}) {unit}")),
                }
            }
            ends => {
                let one = ends.first().map_or("", String::as_str);
                self.run(&format!("{} {unit}", minus(one)))
            }
        }
    }

    /// From one number or day to another: in Persian from right to left, with the word between them.
    fn between(&self, first: &str, last: &str) -> Vec<Run> {
        match self.language {
            Language::Persian => vec![
                Run::Number(self.number(first)),
                Run::Text(" تا ".to_owned()),
                Run::Number(self.number(last)),
            ],
            _ => self.run(&format!("{first} … {last}")),
        }
    }
}

type Row = (String, Vec<Run>);

/// Rows of what is known.
struct Rows<'a> {
    words: &'a Words,
    rows: Vec<Row>,
}

impl Rows<'_> {
    fn text(&mut self, label: Text, value: Option<&str>) {
        if let Some(value) = value.filter(|v| !v.trim().is_empty()) {
            let value = one_line(value);
            self.rows.push((self.words.of(label), Run::text(value)));
        }
    }

    fn number(&mut self, label: Text, value: Option<&str>) {
        if let Some(value) = value {
            self.rows
                .push((self.words.of(label), self.words.run(value)));
        }
    }

    fn block(self) -> SheetBlock {
        SheetBlock::Fields { rows: self.rows }
    }

    /// The rows under a heading, where there are any.
    fn section(self, text: Text, blocks: &mut Vec<SheetBlock>) {
        if !self.rows.is_empty() {
            blocks.push(heading(self.words, text));
            blocks.push(self.block());
        }
    }
}

/// A text without the ends of lines that it may have had in a file.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A sentence of ours with symbols and a number in it, which is printed from left to right.
fn with_number(sentence: &str, number: &str, printed: String) -> Vec<Run> {
    let Some((before, after)) = sentence.split_once(number) else {
        return with_symbols(sentence);
    };
    let mut runs = with_symbols(before);
    runs.push(Run::Number(printed));
    runs.extend(with_symbols(after));
    runs
}

/// A sentence of ours with the symbols U and k in it.
fn with_symbols(sentence: &str) -> Vec<Run> {
    let symbol = |word: &str| {
        let inner = word.trim_matches(|c: char| !c.is_alphanumeric());
        matches!(inner, "U" | "k").then(|| inner.to_owned())
    };
    let mut runs = Vec::new();
    let mut text = String::new();
    for word in sentence.split_inclusive(' ') {
        let Some(symbol) = symbol(word) else {
            text.push_str(word);
            continue;
        };
        let (before, after) = word.split_once(&symbol).unwrap_or_default();
        text.push_str(before);
        if !text.is_empty() {
            runs.push(Run::Text(std::mem::take(&mut text)));
        }
        runs.push(Run::Math(symbol));
        text.push_str(after);
    }
    if !text.is_empty() {
        runs.push(Run::Text(text));
    }
    runs
}

/// The document.
/// `digest` is that of the result.
pub(super) fn sheet(job: &CertificateJob, content: &Content, digest: String) -> Result<Sheet> {
    let words = Words {
        language: job.language,
        persian: job.persian_digits && job.language == Language::Persian,
    };
    let laboratory = content.file.laboratory.clone().unwrap_or_default();
    // A draft may lack what nothing is typeset without.
    let lacking = || format!("{} …", words.of(Text::Laboratory));
    let name = laboratory.name.as_deref().map(one_line);
    let name = name.filter(|n| !n.is_empty()).unwrap_or_else(lacking);
    let number = match &job.number {
        Some(number) => number.clone(),
        None => words.of(Text::NoNumber),
    };
    let mut blocks = Vec::new();
    if job.number.is_none() {
        blocks.push(paragraph(words.of(Text::DraftNotice)));
    }
    head(&words, job, content, &number, &mut blocks);
    traceability(&words, content, &mut blocks);
    results(&words, content, &mut blocks)?;
    conformity(&words, content, &mut blocks);
    uncertainty(&words, content, &mut blocks);
    remarks(&words, &digest, content, &mut blocks);
    let issued = content.issued.clone().unwrap_or_default();
    let signatures: Vec<SheetSignature> = content
        .file
        .signatories
        .iter()
        .map(|s| SheetSignature {
            name: one_line(&s.name),
            role: one_line(&s.role),
            date: words.digits(&issued),
        })
        .collect();
    if !signatures.is_empty() {
        blocks.push(heading(&words, Text::Authorised));
        blocks.push(SheetBlock::Signatures { rows: signatures });
    }
    blocks.push(SheetBlock::End {
        text: words.of(Text::End),
    });
    let accreditation = laboratory.accreditation.clone().unwrap_or_default();
    let issuer = SheetIssuer {
        name: name.clone(),
        lines: laboratory.lines().iter().map(|l| one_line(l)).collect(),
        logo_svg: None,
        marks: accreditation
            .lines()
            .map(one_line)
            .filter(|l| !l.is_empty())
            .collect(),
    };
    let running = SheetRunning {
        head: [name, number.clone()],
        foot: [words.of(Text::Title), words.digits(&issued)],
    };
    let mut sheet = Sheet::new(words.of(Text::Title), running, issuer, blocks);
    job.language.code().clone_into(&mut sheet.language);
    job.language.direction().clone_into(&mut sheet.direction);
    sheet.digits = if words.persian { "persian" } else { "latin" }.to_owned();
    // A file has a date: of a draft without one the last day that is known.
    let days = content.file.calibration.iter();
    let mut days = days.flat_map(|c| [&c.end, &c.begin, &c.received]).flatten();
    let issued = content.issued.as_ref().or_else(|| days.next());
    sheet.issued = issued.cloned().unwrap_or_default();
    sheet.number = number;
    sheet.page_of = words.of(Text::PageOf);
    sheet.watermark = job.number.is_none().then(|| words.of(Text::Draft));
    Ok(sheet)
}

fn heading(words: &Words, text: Text) -> SheetBlock {
    SheetBlock::Heading {
        level: 1,
        text: words.of(text),
    }
}

fn paragraph(text: impl Into<String>) -> SheetBlock {
    SheetBlock::Paragraph {
        text: Run::text(text),
    }
}

fn head(
    words: &Words,
    job: &CertificateJob,
    content: &Content,
    number: &str,
    blocks: &mut Vec<SheetBlock>,
) {
    let file = &content.file;
    let mut rows = Rows {
        words,
        rows: Vec::new(),
    };
    rows.text(Text::Number, Some(number));
    let customer = file.customer.clone().unwrap_or_default();
    rows.text(Text::Customer, customer.name.as_deref());
    rows.text(Text::Address, Some(&customer.lines().join(", ")));
    rows.text(Text::Order, customer.order.as_deref());
    let calibration = file.calibration.clone().unwrap_or_default();
    let place = match calibration.place {
        CalibrationPlace::Laboratory => Text::AtLaboratory,
        CalibrationPlace::Customer => Text::AtCustomer,
    };
    rows.text(Text::Place, Some(&words.of(place)));
    rows.number(Text::Received, calibration.received.as_deref());
    if let Some(begin) = &calibration.begin {
        let period = match &calibration.end {
            Some(end) if end != begin => words.between(begin, end),
            _ => words.run(begin),
        };
        rows.rows.push((words.of(Text::Calibrated), period));
    }
    rows.number(Text::Issued, content.issued.as_deref());
    rows.number(Text::Due, calibration.due.as_deref());
    blocks.push(rows.block());
    if let Some(replaced) = &job.replaces {
        let told = [
            ("number", replaced.number.as_str()),
            ("reason", &one_line(&replaced.reason)),
        ];
        // Number and reason are words of the laboratory, and keep their digits.
        blocks.push(paragraph(Text::Replaces.with(words.language, &told)));
    }

    blocks.push(heading(words, Text::Item));
    let item = file.item.clone().unwrap_or_default();
    let mut rows = Rows {
        words,
        rows: Vec::new(),
    };
    let name = item
        .name
        .clone()
        .unwrap_or_else(|| words.of(Text::Accelerometer));
    rows.text(Text::Object, Some(&name));
    rows.text(Text::Manufacturer, item.manufacturer.as_deref());
    rows.text(Text::Model, item.model.as_deref());
    rows.text(Text::Serial, item.serial.as_deref());
    rows.text(Text::CustomerId, item.customer_id.as_deref());
    rows.text(Text::Condition, item.condition.as_deref());
    blocks.push(rows.block());

    blocks.push(heading(words, Text::Method));
    let mut rows = Rows {
        words,
        rows: Vec::new(),
    };
    // Numbers of standards keep their digits in every language.
    rows.text(Text::Method, Some(content.method.of(words.language)));
    rows.text(Text::Procedure, calibration.procedure.as_deref());
    rows.text(Text::Mounting, calibration.mounting.as_deref());
    for span in content.within() {
        rows.rows
            .push((words.of(span.text), words.span(&span.ends, span.unit)));
    }
    rows.text(Text::Deviations, calibration.deviations.as_deref());
    blocks.push(rows.block());

    let mut rows = Rows {
        words,
        rows: Vec::new(),
    };
    for span in content.environment() {
        rows.rows
            .push((words.of(span.text), words.span(&span.ends, span.unit)));
    }
    let conditions = calibration
        .conditions
        .as_deref()
        .or(content.conditions.as_deref());
    rows.text(Text::Conditions, conditions);
    rows.section(Text::Environment, blocks);
}

fn traceability(words: &Words, content: &Content, blocks: &mut Vec<SheetBlock>) {
    let statement = content.traceability();
    if statement.is_empty() {
        return;
    }
    blocks.push(heading(words, Text::Traceability));
    blocks.extend(statement.into_iter().map(|(text, numbers)| {
        let pieces = text.pieces(words.language).map(|piece| match piece {
            Piece::Text(text) => Run::Text(text.to_owned()),
            Piece::Word(name) => {
                let number = numbers.iter().find(|n| n.0 == name);
                Run::Number(words.digits(number.map_or("", |n| &n.1)))
            }
        });
        let text = pieces.filter(|run| !run.words().is_empty()).collect();
        SheetBlock::Paragraph { text }
    }));
    if content.file.standards.is_empty() {
        return;
    }
    let column = |text: Text| SheetColumn {
        heading: Run::text(words.of(text)),
        unit: String::new(),
        align: SheetAlign::Text,
    };
    let rows = content.file.standards.iter();
    let rows: Vec<Vec<String>> = rows
        .map(|s| {
            let until = s.valid_until.as_deref().unwrap_or("–");
            vec![
                one_line(&s.name),
                one_line(&s.certificate),
                one_line(&s.issuer),
                words.digits(until),
            ]
        })
        .collect();
    blocks.push(SheetBlock::Table {
        caption: Vec::new(),
        label: String::new(),
        columns: vec![
            column(Text::Standard),
            column(Text::CertificateOfStandard),
            column(Text::IssuedBy),
            column(Text::ValidUntil),
        ],
        rows,
        notes: Vec::new(),
    });
}

fn results(words: &Words, content: &Content, blocks: &mut Vec<SheetBlock>) -> Result<()> {
    blocks.push(heading(words, Text::Results));
    let mut n = 0;
    if let Some(found) = &content.as_found {
        blocks.push(SheetBlock::Heading {
            level: 2,
            text: words.of(Text::AsFound),
        });
        tables(words, found, &mut n, blocks);
        blocks.push(SheetBlock::Heading {
            level: 2,
            text: words.of(Text::AsLeft),
        });
    }
    tables(words, &content.results, &mut n, blocks);
    let is_transverse = content
        .results
        .tables
        .iter()
        .any(StatedTable::is_transverse);
    let what = match is_transverse {
        true => Text::TransverseOverFrequency,
        false => Text::SensitivityOverFrequency,
    };
    let caption = words.with(Text::PlotCaption, &[("what", &words.of(what))]);
    if let Some(svg) = figure::drawing(&content.results, &caption, |t| words.digits(t))? {
        blocks.push(SheetBlock::Figure {
            caption: Run::text(caption.clone()),
            label: words.label(Text::FigureLabel, 1),
            svg,
            alternative: caption,
        });
    }
    Ok(())
}

/// `n` counts the tables.
fn tables(words: &Words, stated: &StatedResults, n: &mut usize, blocks: &mut Vec<SheetBlock>) {
    let mut label = || {
        *n += 1;
        words.label(Text::TableLabel, *n)
    };
    for table in &stated.tables {
        blocks.push(over_frequency(words, table, label()));
    }
    if !stated.singles.is_empty() {
        blocks.push(singles(words, stated, label()));
    }
}

impl StatedTable {
    fn is_transverse(&self) -> bool {
        self.columns
            .iter()
            .any(|c| c.meaning == Meaning::Transverse)
    }
}

/// Numbers under a word.
fn numbers(heading: impl Into<String>, unit: &str) -> SheetColumn {
    under(Run::text(heading), unit)
}

/// Numbers under the symbol of a quantity.
fn symbol(symbol: &str, unit: &str) -> SheetColumn {
    under(vec![Run::Math(symbol.to_owned())], unit)
}

fn under(heading: Vec<Run>, unit: &str) -> SheetColumn {
    SheetColumn {
        heading,
        unit: unit.to_owned(),
        align: SheetAlign::Number,
    }
}

/// The first numbers of the certificate as its page opens with them, with the digits of its tables.
pub(super) fn key_figures(content: &Content, language: Language) -> Vec<KeyFigure> {
    let words = Words {
        language,
        persian: false,
    };
    let note = |number: &StatedNumber| {
        let probability = content.results.per_cent();
        match &number.k {
            Some(k) => format!("k = {k}, {probability}"),
            None => probability,
        }
    };
    let figure = |label: String, number: &StatedNumber, unit: &str| {
        let value = match number.interval {
            None => format!("{} ± {}", minus(&number.value), number.expanded),
            Some(_) => format!("{} ({})", minus(&number.value), spread(&words, number)),
        };
        KeyFigure::new(label, value, unit).note(note(number))
    };
    let mut figures = Vec::new();
    for table in &content.results.tables {
        for (i, frequency) in table.frequency.iter().enumerate() {
            for column in &table.columns {
                let which = table.element.as_deref().unwrap_or_default();
                let label = format!("{} {which} {frequency} Hz", words.of(column.meaning.text()));
                let label: Vec<&str> = label.split_whitespace().collect();
                figures.extend(
                    column
                        .numbers
                        .get(i)
                        .map(|n| figure(label.join(" "), n, &column.unit)),
                );
            }
        }
    }
    let singles = content.results.singles.iter();
    figures.extend(singles.map(|s| figure(s.words(language), &s.number, &s.unit)));
    figures.truncate(6);
    figures
}

/// U of a number, or its interval.
fn spread(words: &Words, number: &StatedNumber) -> String {
    match &number.interval {
        None => words.number(&number.expanded),
        Some([low, high]) => format!("{} … {}", words.number(low), words.number(high)),
    }
}

fn over_frequency(words: &Words, table: &StatedTable, label: String) -> SheetBlock {
    let mut columns = vec![numbers(words.of(Text::Frequency), "Hz")];
    let mut rows: Vec<Vec<String>> = table
        .frequency
        .iter()
        .map(|f| vec![words.number(f)])
        .collect();
    for column in &table.columns {
        columns.push(numbers(words.of(column.meaning.text()), &column.unit));
        columns.push(symbol("U", &column.unit));
        columns.push(symbol("k", ""));
        for (row, number) in rows.iter_mut().zip(&column.numbers) {
            let k = number
                .k
                .as_deref()
                .map_or_else(|| "–".to_owned(), |k| words.number(k));
            row.extend([words.number(&number.value), spread(words, number), k]);
        }
    }
    let caption = match &table.element {
        // S.xy: acceleration along x, output along y.
        Some(element) => {
            let mut letters = element.chars().map(|c| c.to_string());
            let (axis, output) = (
                letters.next().unwrap_or_default(),
                letters.next().unwrap_or_default(),
            );
            words.with(
                Text::SensitivityElement,
                &[("element", element), ("output", &output), ("axis", &axis)],
            )
        }
        None if table.is_transverse() => words.of(Text::TransverseOverFrequency),
        None => words.of(Text::SensitivityOverFrequency),
    };
    SheetBlock::Table {
        caption: Run::text(caption),
        label,
        columns,
        rows,
        notes: Vec::new(),
    }
}

fn singles(words: &Words, stated: &StatedResults, label: String) -> SheetBlock {
    let text = |text: Text| SheetColumn {
        heading: Run::text(words.of(text)),
        unit: String::new(),
        align: SheetAlign::Text,
    };
    let rows = stated.singles.iter().map(|s| {
        let k = s
            .number
            .k
            .as_deref()
            .map_or_else(|| "–".to_owned(), |k| words.number(k));
        vec![
            s.words(words.language),
            words.number(&s.number.value),
            spread(words, &s.number),
            k,
            s.unit.clone(),
        ]
    });
    SheetBlock::Table {
        caption: Run::text(words.of(Text::Parameters)),
        label,
        columns: vec![
            text(Text::Quantity),
            numbers(words.of(Text::Value), ""),
            symbol("U", ""),
            symbol("k", ""),
            text(Text::Unit),
        ],
        rows: rows.collect(),
        notes: Vec::new(),
    }
}

fn conformity(words: &Words, content: &Content, blocks: &mut Vec<SheetBlock>) {
    if content.decisions.is_empty() {
        return;
    }
    blocks.push(heading(words, Text::Conformity));
    for entry in &content.decisions {
        let mut rows = Rows {
            words,
            rows: Vec::new(),
        };
        let rule = entry.rule(words.language, |r| words.digits(r));
        let rule = with_number(&rule, "50 %", words.digits("50 %"));
        rows.rows.push((words.of(Text::Rule), rule));
        let space = if entry.unit == "°" { "" } else { " " };
        let limit =
            |l: Option<f64>| l.map(|l| format!("{}{space}{}", minus(&l.to_string()), entry.unit));
        rows.number(Text::LowerLimit, limit(entry.entry.lower).as_deref());
        rows.number(Text::UpperLimit, limit(entry.entry.upper).as_deref());
        rows.text(Text::LimitsFrom, entry.entry.source.as_deref());
        blocks.push(rows.block());
        let text = |text: Text| SheetColumn {
            heading: Run::text(words.of(text)),
            unit: String::new(),
            align: SheetAlign::Text,
        };
        let frequency = |name: &str| proofmass_documents::at_frequency(name).map(|(_, f)| plain(f));
        let has_frequencies = entry
            .decisions
            .iter()
            .any(|d| frequency(&d.quantity).is_some());
        let quantity = content
            .results
            .name_of(&entry.entry.quantity, words.language);
        let rows = entry.decisions.iter().map(|d| {
            let word = if d.pass { Text::Pass } else { Text::Fail };
            let mut row = vec![quantity.clone()];
            row.extend(frequency(&d.quantity).map(|f| words.number(&f)));
            row.extend([words.of(word), words.digits(&d.risk)]);
            row
        });
        let mut columns = vec![text(Text::Quantity)];
        columns.extend(has_frequencies.then(|| numbers(words.of(Text::Frequency), "Hz")));
        columns.extend([text(Text::Decision), text(Text::Risk)]);
        blocks.push(SheetBlock::Table {
            caption: Vec::new(),
            label: String::new(),
            columns,
            rows: rows.collect(),
            notes: Vec::new(),
        });
    }
}

fn uncertainty(words: &Words, content: &Content, blocks: &mut Vec<SheetBlock>) {
    blocks.push(heading(words, Text::UncertaintyTitle));
    let probability = words.digits(&content.results.per_cent());
    for text in content.uncertainty_statement(words.language, &probability) {
        blocks.push(SheetBlock::Paragraph {
            text: with_number(&text, &probability, probability.clone()),
        });
    }
}

fn remarks(words: &Words, digest: &str, content: &Content, blocks: &mut Vec<SheetBlock>) {
    blocks.push(heading(words, Text::Remarks));
    let own = content
        .file
        .calibration
        .as_ref()
        .and_then(|c| c.remarks.clone());
    let lines = own.iter().flat_map(|remarks| remarks.lines());
    blocks.extend(lines.map(one_line).filter(|l| !l.is_empty()).map(paragraph));
    blocks.push(paragraph(words.of(Text::Validity)));
    let evidence = format!("{}: ", words.of(Text::Evidence));
    blocks.push(SheetBlock::Paragraph {
        text: vec![
            Run::Text(evidence),
            Run::Number("result.json, SHA-256".to_owned()),
            Run::Text(" ".to_owned()),
            Run::Number(digest.to_owned()),
        ],
    });
}
