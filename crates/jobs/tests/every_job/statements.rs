//! How numbers are stated on every page: U with k or its probability, no degrees of freedom beyond 9999, many digits only beside U.

use proofmass_jobs::StoredResult;
use serde_json::Value;

/// Largest number of degrees of freedom that is printed.
const LARGEST: f64 = 9999.0;
/// Digits of a number from which on it must say how well it is known.
const MANY: usize = 6;

pub fn law_numbers_say_how_well_they_are_known(kind: &str, result: &StoredResult) {
    let report = serde_json::to_value(result.report()).expect("JSON");
    let mut wrong = Vec::new();
    walk(&report, &mut wrong);
    assert!(wrong.is_empty(), "{kind}:\n{}", wrong.join("\n"));
}

/// Every number that a reader came for and every table of a page, wherever it stands.
fn walk(value: &Value, wrong: &mut Vec<String>) {
    match value {
        Value::Object(map) => {
            // Nobody reads what only a file has.
            if map.get("place").is_some_and(|place| place == "file") {
                return;
            }
            if map.contains_key("value") && map.contains_key("label") {
                figure(value, wrong);
            } else if map.contains_key("columns") && map.contains_key("rows") {
                table(value, wrong);
            }
            map.values().for_each(|v| walk(v, wrong));
        }
        Value::Array(list) => list.iter().for_each(|v| walk(v, wrong)),
        _ => {}
    }
}

fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_default()
}

/// Whether words say with which factor or probability a U is meant.
fn says_k(words: &str) -> bool {
    words.contains("k = ") || words.contains('%')
}

fn figure(figure: &Value, wrong: &mut Vec<String>) {
    let (label, value, note) = (
        text(figure, "label"),
        text(figure, "value"),
        text(figure, "note"),
    );
    if value.contains('±') && !says_k(note) && !says_k(label) {
        wrong.push(format!("{label}: U of {value} without k: {note:?}"));
    }
    let known = ['±', '('].iter().any(|sign| value.contains(*sign));
    if !known && digits(value) >= MANY {
        wrong.push(format!("{label}: {value} says not how well it is known"));
    }
}

/// Significant digits of a number with decimals; a whole number is a count.
fn digits(text: &str) -> usize {
    let number = text.split(['×', ' ']).next().unwrap_or_default();
    let decimal = number.contains('.') && number.chars().all(|c| "0123456789.-−".contains(c));
    match decimal {
        true => number
            .trim_start_matches(|c: char| "0.-−".contains(c))
            .chars()
            .filter(char::is_ascii_digit)
            .count(),
        false => 0,
    }
}

fn table(table: &Value, wrong: &mut Vec<String>) {
    let columns = table["columns"].as_array().expect("columns");
    let headings: Vec<&str> = columns.iter().map(|c| text(c, "heading")).collect();
    let caption = text(table, "caption");
    let notes = table["notes"].to_string();
    let has = |wanted: &[&str]| headings.iter().any(|h| wanted.contains(h));
    // U, U (95 %), U of the modulus: not a word that begins with it.
    let ratio = |h: &str| h.contains(" over ");
    let expanded =
        |h: &&&str| !ratio(h) && (**h == "U" || h.starts_with("U ") || h.starts_with("U("));
    for heading in headings.iter().filter(expanded) {
        let told = says_k(heading) || says_k(caption) || says_k(&notes) || has(&["k"]);
        if !told {
            wrong.push(format!("{caption:?}: {heading} without k"));
        }
    }
    let rows = table["rows"].as_array().expect("rows");
    for (at, heading) in headings.iter().enumerate() {
        let rounded = columns[at]["rounding"] == "freedom";
        if rounded || !matches!(*heading, "ν" | "degrees of freedom" | "dof") {
            continue;
        }
        for row in rows {
            let cell = &row[at];
            let shown = cell["number"]
                .as_str()
                .or(cell.as_str())
                .or(cell["text"].as_str());
            let number = cell.as_f64().or(shown.and_then(|s| s.parse().ok()));
            if number.is_some_and(|nu| nu > LARGEST) {
                wrong.push(format!("{caption:?}: {heading} = {cell}"));
            }
        }
    }
    // Beside a U, or within the bounds that are told of a column.
    let beside = headings.iter().any(|h| {
        let word = h.split([' ', '(', '/']).next().unwrap_or_default();
        matches!(word, "U" | "u" | "±" | "from" | "lower" | "interval") || h.contains('%')
    });
    // What is typed into firmware has the digits of its number format; U of the same quantities stands beside them.
    let copied = [
        "Coefficients of the filter",
        "Sensitivity matrix K",
        "K⁻¹ of",
    ];
    let copied = copied.iter().any(|c| caption.starts_with(c));
    for row in rows.iter().filter(|_| !copied) {
        let cells = row.as_array().expect("a row");
        // A place on the time axis is read off it, not measured.
        if cells[0]
            .as_str()
            .is_some_and(|name| name.starts_with("instant"))
        {
            continue;
        }
        for (cell, column) in cells.iter().zip(columns) {
            let printed = cell["number"].as_str().unwrap_or_default();
            let decimals = column["rounding"]["decimals"].as_u64();
            let rounded = cell.as_f64().zip(decimals).map(|(value, decimals)| {
                let value = value * column["scale"].as_f64().unwrap_or(1.0);
                format!("{value:.*}", decimals as usize)
            });
            let printed = rounded.as_deref().unwrap_or(printed);
            if !text(column, "heading").is_empty() && !beside && digits(printed) >= MANY {
                let heading = text(column, "heading");
                wrong.push(format!("{caption:?}: {heading} = {printed} without U"));
            }
        }
    }
}
