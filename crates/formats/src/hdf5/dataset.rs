//! A dataset as channels.

mod in_chunks;

use super::datatype::{Element, Part, element};
use super::file::{File, Found, Trouble, UNDEFINED};
use super::header::{Header, kind};
use super::layout::{self, Layout, Space};
use crate::arrays::{Arrays, MOST_COLUMNS};
use crate::raw::{Raw, numbers};
use crate::stream::{Column, Remark, Source};

/// What is known of a dataset before its data are looked for.
struct Dataset<'a> {
    name: &'a str,
    unit: Option<String>,
    sides: [u64; 2],
    /// Side along which time goes.
    time: usize,
    /// Whether its sides are named the other way round, as MATLAB does.
    turned: bool,
    parts: Vec<Part>,
    /// Bytes of an element.
    element: u64,
}

impl Dataset<'_> {
    /// What a signal is called, by its number across time.
    fn signal(&self, which: u64, part: &Part) -> String {
        let place = match (self.sides[1 - self.time], (self.time == 0) != self.turned) {
            (1, _) => String::new(),
            (_, true) => format!("(:,{})", which + 1),
            (_, false) => format!("({},:)", which + 1),
        };
        format!("{}{place}{}", self.name, part.name)
    }

    /// Makes a channel of every number of every signal.
    fn channels(
        &self,
        signals: u64,
        rows: u64,
        arrays: &mut Arrays,
        source: impl Fn(u64, &Part) -> Source,
    ) {
        for which in 0..signals {
            for part in &self.parts {
                let column = Column::of(source(which, part));
                arrays.column(self.signal(which, part), self.unit.clone(), rows, column);
            }
        }
    }
}

impl File<'_> {
    /// Takes in a dataset; what is not read of it is remarked.
    pub(super) fn dataset(
        &mut self,
        header: &Header,
        name: &str,
        turned: bool,
        arrays: &mut Arrays,
    ) -> Found<()> {
        let space = self.message(header, kind::DATASPACE)?;
        let space = space.and_then(|s| self.space(&s));
        let space = space.ok_or_else(|| damaged_part("list of sides"))?;
        let Some(dataset) = self.described(header, name, turned, &space, arrays)? else {
            return Ok(());
        };
        let layout = self.message(header, kind::LAYOUT)?;
        let layout = layout.ok_or_else(|| damaged_part("layout"))?;
        match self.layout(&layout)? {
            Layout::Compact(bytes) => compact(&dataset, &bytes, arrays),
            Layout::Contiguous(UNDEFINED) => {
                Err(Trouble::Foreign("which was never written".to_owned()))
            }
            Layout::Contiguous(at) => self.contiguous(&dataset, at, arrays),
            Layout::Chunked(grid) => {
                let filters = self.message(header, kind::FILTERS)?;
                let filters = filters.map_or(Ok(Vec::new()), |f| layout::filters(&f))?;
                self.chunked(&dataset, &space, &grid, filters, arrays)
            }
        }
    }

    /// What a dataset with signals of numbers is; nothing where there are none.
    fn described<'n>(
        &mut self,
        header: &Header,
        name: &'n str,
        turned: bool,
        space: &Space,
        arrays: &mut Arrays,
    ) -> Found<Option<Dataset<'n>>> {
        let foreign = |what: String| Err(Trouble::Foreign(what));
        let sides = match space.sides[..] {
            [] => [1, 1],
            [n] => [n, 1],
            [rows, columns] => [rows, columns],
            _ => return foreign(format!("an array of {} dimensions", space.sides.len())),
        };
        let time = match turned {
            true => usize::from(sides[1] >= sides[0] && space.sides.len() == 2),
            false => usize::from(sides[1] > sides[0]),
        };
        // A single number is no signal.
        if sides[time] < 2 || sides[1 - time] == 0 {
            return Ok(None);
        }
        let form = self.message(header, kind::DATATYPE)?;
        let form = form.and_then(|f| element(&f));
        let Element {
            bytes,
            parts,
            others,
        } = form.ok_or_else(|| damaged_part("datatype"))?;
        let others = others.into_iter();
        arrays
            .remarks
            .extend(others.map(|other| Remark::passed_over(format!("{name}{other}"))));
        if parts.is_empty() {
            return Ok(None);
        }
        if sides[1 - time].saturating_mul(parts.len() as u64) > MOST_COLUMNS as u64 {
            return foreign(format!(
                "a matrix of {} times {} numbers",
                sides[0], sides[1]
            ));
        }
        if header.has(kind::EXTERNAL) {
            return foreign("whose numbers stand in another file".to_owned());
        }
        let unit = self.text_of(header, &["unit", "units"])?;
        Ok(Some(Dataset {
            name,
            unit: unit.filter(|u| !u.is_empty()),
            sides,
            time,
            turned,
            parts,
            element: bytes,
        }))
    }

    fn contiguous(&mut self, dataset: &Dataset<'_>, at: u64, arrays: &mut Arrays) -> Found<()> {
        let (sides, element) = (dataset.sides, dataset.element);
        let place = self.place(at);
        let there = self.size.saturating_sub(place);
        let all = sides[0].saturating_mul(sides[1]).saturating_mul(element);
        if all > there {
            let (n, of) = (there / element, all / element);
            arrays.remarks.push(Remark::cut(format!(
                "{n} of {of} elements of {} are there",
                dataset.name
            )));
        }
        // What is whole along the side that goes slower.
        let line = sides[1].saturating_mul(element);
        let lines = sides[0].min(there / line);
        if !self.claim(lines * line) {
            return Err(Trouble::Damaged(
                "its data overlap another dataset".to_owned(),
            ));
        }
        let (signals, rows, stride, step) = match dataset.time {
            0 => (sides[1], lines, line, element),
            _ => (lines, sides[1], element, line),
        };
        dataset.channels(signals, rows, arrays, |which, part| {
            let at = place + which * step + part.at;
            Source::Raw(Raw::at(part.kind, part.order, at, stride, rows))
        });
        Ok(())
    }
}

fn damaged_part(what: &str) -> Trouble {
    Trouble::Damaged(format!("its {what} is damaged"))
}

fn compact(dataset: &Dataset<'_>, bytes: &[u8], arrays: &mut Arrays) -> Found<()> {
    let [rows, columns] = dataset.sides;
    let element = dataset.element;
    let all = rows
        .checked_mul(columns)
        .and_then(|n| n.checked_mul(element));
    if all.is_none_or(|all| all > bytes.len() as u64) {
        return Err(damaged_part("piece in the header"));
    }
    let line = columns * element;
    let (signals, rows, stride, step) = match dataset.time {
        0 => (columns, rows, line, element),
        _ => (rows, columns, element, line),
    };
    dataset.channels(signals, rows, arrays, |which, part| {
        let from = (which * step + part.at) as usize;
        let to = from + ((rows - 1) * stride + part.kind.size()) as usize;
        let mut values = Vec::new();
        numbers(
            part.kind,
            part.order,
            &bytes[from..to],
            stride as usize,
            &mut values,
        );
        Source::held(values)
    });
    Ok(())
}
