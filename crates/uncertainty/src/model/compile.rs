//! From the tables of a model file to one list of operations.

use super::curve::{Captured, Curve, CurveWeighing};
use super::earlier::Earlier;
use super::entries::{FitEntry, FitScatter, FitWeights, OutputEntry, SolveEntry};
use super::equations::{Block, Equations};
use super::fit::Fit;
use super::solve::Solve;
use super::{InputEntry, UncertaintyModel, UnitRule};
use crate::dimension::Dimension;
use crate::expression::{Op, Program, Scalar, Scope, Value, compile, compile_equation};
use crate::{Expression, Finding, Refusal};
use std::collections::HashSet;

/// A model as one list of operations, with what became of its formulas.
pub(super) struct Compiled {
    pub(crate) program: Program,
    pub(crate) blocks: Vec<Block>,
    pub(crate) formulas: Vec<Formula>,
    /// Outputs, complex and vectors taken apart.
    pub(crate) outputs: Vec<OutputEntry>,
    pub(crate) places: Vec<u32>,
    /// Units of results that are quantities of earlier results.
    pub(crate) stated: Vec<(u32, String)>,
    /// Fits whose residuals are a cause: block, number of points.
    pub(crate) scatter: Vec<(usize, usize)>,
    /// What earlier results were taken to share.
    pub(crate) shared: Vec<Finding>,
}

/// Where the operations of one formula stand.
pub(super) struct Formula {
    pub(crate) name: String,
    /// Unit, for an output.
    pub(crate) unit: Option<String>,
    pub(crate) from: usize,
    pub(crate) results: Vec<u32>,
}

/// A part of the equations that has no unit of its own.
enum Part<'a> {
    Intermediate(&'a super::IntermediateEntry),
    Solve(&'a SolveEntry),
    Fit(&'a FitEntry),
}

impl Part<'_> {
    fn names(&self) -> &[String] {
        match self {
            Self::Intermediate(part) => std::slice::from_ref(&part.name),
            Self::Solve(solve) => &solve.unknown,
            Self::Fit(fit) => &fit.parameters,
        }
    }

    fn speaks_of(&self, names: &HashSet<&str>) -> bool {
        let texts: Vec<&String> = match self {
            Self::Intermediate(part) => vec![&part.expression],
            Self::Solve(solve) => solve.equations.iter().collect(),
            Self::Fit(fit) => [&fit.x, &fit.y].into_iter().chain(&fit.curve).collect(),
        };
        let own = self.names();
        texts.iter().any(|text| {
            words(text).any(|word| names.contains(word) && !own.iter().any(|name| name == word))
        })
    }
}

/// The names in a formula.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_'))
        .filter(|word| word.starts_with(|c: char| c.is_alphabetic() || c == '_'))
}

impl UncertaintyModel {
    /// One entry per number: a vector becomes `x[1]`, `x[2]`, …
    pub(super) fn scalar_inputs(&self) -> Result<Vec<InputEntry>, Refusal> {
        let mut all = Vec::with_capacity(self.input.len());
        for entry in &self.input {
            all.extend(entry.members()?);
        }
        Ok(all)
    }

    /// All formulas as one list of operations.
    pub(super) fn compiled(&self) -> Result<Compiled, Refusal> {
        self.check_names()?;
        let mut compiler = Compiler {
            rule: self.units,
            scope: Scope::new(),
            compiled: Compiled {
                program: Program::default(),
                blocks: Vec::new(),
                formulas: Vec::new(),
                outputs: Vec::new(),
                places: Vec::new(),
                stated: Vec::new(),
                scatter: Vec::new(),
                shared: Vec::new(),
            },
            inputs: 0,
        };
        for entry in &self.input {
            compiler.input(entry)?;
        }
        compiler.earlier(&Earlier::of(&self.earlier, &self.scalar_inputs()?)?)?;
        let mut parts: Vec<Part<'_>> = self
            .intermediate
            .iter()
            .map(Part::Intermediate)
            .chain(self.solve.iter().map(Part::Solve))
            .chain(self.fit.iter().map(Part::Fit))
            .collect();
        // Each part as soon as all it speaks of is there; one that never is gives the refusal.
        while !parts.is_empty() {
            let open: HashSet<&str> = parts
                .iter()
                .flat_map(|part| part.names().iter().map(String::as_str))
                .collect();
            match parts.iter().position(|part| !part.speaks_of(&open)) {
                Some(next) => compiler.part(&parts.remove(next))?,
                None => return Err(circle(&parts)),
            }
        }
        for output in &self.output {
            compiler.output(output)?;
        }
        Ok(compiler.compiled)
    }

    fn check_names(&self) -> Result<(), Refusal> {
        let parts = self.intermediate.iter().map(|i| &i.name);
        let parts = parts
            .chain(self.solve.iter().flat_map(|s| &s.unknown))
            .chain(self.fit.iter().flat_map(|f| &f.parameters));
        let outputs = self
            .output
            .iter()
            .map(|o| (&o.name, o.expression.is_empty()));
        let mut known = HashSet::new();
        let earlier = self.earlier.iter().flat_map(|e| e.quantities.keys());
        let all = self
            .input
            .iter()
            .map(|i| &i.name)
            .chain(earlier)
            .chain(parts);
        for (name, again) in all.map(|name| (name, false)).chain(outputs) {
            Expression::check_name(name)?;
            if !known.insert(name) && !again {
                return Err(Refusal::Duplicate { name: name.clone() });
            }
        }
        let mut stated = HashSet::new();
        match self.output.iter().find(|o| !stated.insert(&o.name)) {
            Some(twice) => Err(Refusal::Duplicate {
                name: twice.name.clone(),
            }),
            None => Ok(()),
        }
    }
}

/// Says which of these parts need each other: every one of them needs another.
fn circle(parts: &[Part<'_>]) -> Refusal {
    let needed = |place: usize| {
        parts.iter().position(|other| {
            let names: HashSet<&str> = other.names().iter().map(String::as_str).collect();
            parts[place].speaks_of(&names)
        })
    };
    let mut way = vec![0];
    let around = loop {
        let Some(next) = needed(way[way.len() - 1]) else {
            break 0;
        };
        if let Some(from) = way.iter().position(|place| *place == next) {
            break from;
        }
        way.push(next);
    };
    let names: Vec<&str> = way[around..]
        .iter()
        .filter_map(|&place| parts[place].names().first().map(String::as_str))
        .collect();
    Refusal::Equation {
        name: names[0].to_owned(),
        what: format!(
            "its formula needs itself, by way of {}; equations that hold together are stated in [[solve]]",
            names[1..].join(", ")
        ),
    }
}

/// Outputs at most, the members of vectors counted: each has its column of trials, its budget and its covariances.
const MOST_OUTPUTS: usize = 400;

struct Compiler {
    rule: UnitRule,
    scope: Scope,
    compiled: Compiled,
    /// Variables so far.
    inputs: usize,
}

impl Compiler {
    fn program(&mut self) -> &mut Program {
        &mut self.compiled.program
    }

    fn variable(&mut self) -> u32 {
        self.inputs += 1;
        let place = Op::Input(self.inputs - 1);
        self.program().push(place)
    }

    fn input(&mut self, entry: &InputEntry) -> Result<(), Refusal> {
        let factor = self.factor(&entry.unit, &entry.name)?;
        let one = |compiler: &mut Self| {
            let place = compiler.variable();
            compiler.scaled(place, factor, false)
        };
        let value = match entry.length() {
            None => Value::real(one(self)),
            Some(n) => Value::Many((0..n).map(|_| Scalar::Real(one(self))).collect()),
        };
        self.scope.insert(entry.name.clone(), value);
        Ok(())
    }

    /// Value and causes of the quantities of earlier results.
    fn earlier(&mut self, earlier: &Earlier) -> Result<(), Refusal> {
        self.compiled.shared = earlier.findings();
        let variables: Vec<u32> = earlier.inputs.iter().map(|_| self.variable()).collect();
        for quantity in &earlier.quantities {
            let mut sum = self.program().push(Op::Constant(quantity.value));
            for &(variable, factor, estimate) in &quantity.terms {
                let estimate = self.program().push(Op::Constant(estimate));
                let factor = self.program().push(Op::Constant(factor));
                let from = Op::Subtract(variables[variable], estimate);
                let from = self.program().push(from);
                let term = self.program().push(Op::Multiply(from, factor));
                sum = self.program().push(Op::Add(sum, term));
            }
            let factor = self.factor(&quantity.unit, &quantity.name)?;
            let place = self.scaled(sum, factor, false);
            self.compiled.stated.push((place, quantity.unit.clone()));
            self.scope.insert(quantity.name.clone(), Value::real(place));
        }
        Ok(())
    }

    fn factor(&self, unit: &str, name: &str) -> Result<f64, Refusal> {
        factor(self.rule, unit, name)
    }

    fn scaled(&mut self, place: u32, factor: f64, back: bool) -> u32 {
        if factor == 1.0 {
            return place;
        }
        let by = self.program().push(Op::Constant(factor));
        self.program().push(if back {
            Op::Divide(place, by)
        } else {
            Op::Multiply(place, by)
        })
    }

    /// Reads a formula; what it is called is for its units.
    fn formula(&mut self, name: &str, text: &str, unit: Option<&str>) -> Result<Value, Refusal> {
        let (from, labels) = (
            self.compiled.program.ops.len(),
            self.compiled.program.labels.len(),
        );
        let value = compile(text, &self.scope, &mut self.compiled.program)?;
        convert_labels(self.rule, &mut self.compiled.program, labels, name)?;
        self.compiled.formulas.push(Formula {
            name: name.to_owned(),
            unit: unit.map(str::to_owned),
            from,
            results: value.scalars().into_iter().flat_map(parts).collect(),
        });
        Ok(value)
    }

    fn part(&mut self, part: &Part<'_>) -> Result<(), Refusal> {
        match part {
            Part::Intermediate(part) => {
                let value = self.formula(&part.name, &part.expression, None)?;
                self.scope.insert(part.name.clone(), value);
                Ok(())
            }
            Part::Solve(solve) => self.solve(solve),
            Part::Fit(fit) => self.fit(fit),
        }
    }

    /// A block whose results have these names.
    fn block(&mut self, block: Block, names: &[String]) {
        self.compiled.blocks.push(block);
        let number = self.compiled.blocks.len() - 1;
        for (k, name) in names.iter().enumerate() {
            let place = self.program().push(if k == 0 {
                Op::Block(number)
            } else {
                Op::Further
            });
            self.scope.insert(name.clone(), Value::real(place));
        }
    }

    fn solve(&mut self, entry: &SolveEntry) -> Result<(), Refusal> {
        let m = entry.unknown.len();
        let refuse = |what: String| Refusal::Equation {
            name: entry.unknown.join(", "),
            what,
        };
        if m == 0 {
            return Err(Refusal::Equation {
                name: "solve".to_owned(),
                what: "at least one name is needed in `unknown`".to_owned(),
            });
        }
        if entry.start.len() != m || entry.start.iter().any(|s| !s.is_finite()) {
            return Err(refuse(format!(
                "`start` needs one finite number per unknown, {m}"
            )));
        }
        // Inside, every name stands for a variable of the equations: the unknowns first.
        let mut inner = Program::default();
        let mut scope = Scope::new();
        let mut captured = Vec::new();
        for (i, name) in entry.unknown.iter().enumerate() {
            let place = inner.push(Op::Input(i));
            scope.insert(name.clone(), Value::real(place));
        }
        let spoken: HashSet<&str> = entry.equations.iter().flat_map(|e| words(e)).collect();
        let mut outer: Vec<(&String, &Value)> = self
            .scope
            .iter()
            .filter(|(name, _)| spoken.contains(name.as_str()))
            .collect();
        outer.sort_by_key(|(name, _)| *name);
        for (name, value) in outer {
            if scope.contains_key(name) {
                continue;
            }
            let mut inside = |k: u32| {
                captured.push(k);
                inner.push(Op::Input(m + captured.len() - 1))
            };
            let mut scalar = |s: &Scalar| match *s {
                Scalar::Real(k) => Scalar::Real(inside(k)),
                Scalar::Complex(re, im) => Scalar::Complex(inside(re), inside(im)),
            };
            let value = match value {
                Value::One(one) => Value::One(scalar(one)),
                Value::Many(many) => Value::Many(many.iter().map(scalar).collect()),
            };
            scope.insert(name.clone(), value);
        }
        let mut residuals = Vec::new();
        for text in &entry.equations {
            let labels = inner.labels.len();
            let (left, right) = compile_equation(text, &scope, &mut inner)?;
            convert_labels(self.rule, &mut inner, labels, &entry.unknown.join(", "))?;
            let mut sides = left.scalars();
            if let Some(right) = right {
                let right = right.scalars();
                if right.len() != sides.len() {
                    return Err(refuse(format!(
                        "the sides of `{text}` have different lengths"
                    )));
                }
                for (left, right) in sides.iter_mut().zip(right) {
                    *left = inner.difference(*left, right);
                }
            }
            residuals.extend(sides.into_iter().flat_map(parts));
        }
        if residuals.len() != m {
            return Err(refuse(format!(
                "there are {} equations for {m} unknowns (a complex one counts twice)",
                residuals.len()
            )));
        }
        let block = Block::Solve(Box::new(Solve {
            unknown: entry.unknown.clone(),
            start: entry.start.clone(),
            program: inner,
            residuals,
            captured,
            branch: None,
        }));
        self.block(block, &entry.unknown);
        Ok(())
    }

    fn fit(&mut self, entry: &FitEntry) -> Result<(), Refusal> {
        let refuse = |what: String| Refusal::Equation {
            name: entry.name.clone(),
            what,
        };
        let vector = |value: Value, which: &str| -> Result<Vec<u32>, Refusal> {
            let Value::Many(members) = value else {
                return Err(refuse(format!(
                    "`{which}` is a vector, one member per point"
                )));
            };
            let real = |s: &Scalar| match s {
                Scalar::Real(k) => Ok(*k),
                Scalar::Complex(..) => Err(refuse(format!("`{which}` is real"))),
            };
            members.iter().map(real).collect()
        };
        let parameters = entry.parameters.len();
        if parameters == 0
            || entry
                .degree
                .is_some_and(|d| d.checked_add(1) != Some(parameters))
            || parameters > 12
        {
            return Err(refuse(
                "`parameters` needs one name per parameter, the constant first: degree + 1 of them, 12 at most".to_owned(),
            ));
        }
        let x = vector(self.formula(&entry.name, &entry.x, None)?, "x")?;
        let mut y = vector(self.formula(&entry.name, &entry.y, None)?, "y")?;
        if x.len() != y.len() {
            return Err(refuse(format!(
                "`x` has {} members and `y` {}",
                x.len(),
                y.len()
            )));
        }
        let curve = entry.curve.as_ref();
        let curve = curve.map(|text| self.curve(entry, text, &x, &y));
        let curve = curve.transpose()?;
        if entry.start.is_some() && curve.is_none() {
            return Err(refuse(
                "`start` belongs to the parameters of a `curve`".to_owned(),
            ));
        }
        if entry.weights == FitWeights::Both && curve.is_none() && parameters != 2 {
            return Err(refuse(
                "weights = \"both\" of a polynomial is for straight lines, with two parameters; more are a `curve`".to_owned(),
            ));
        }
        if entry.scatter == FitScatter::Residuals {
            if entry.weights != FitWeights::Equal {
                return Err(refuse(
                    "scatter = \"residuals\" goes with equal weights: other weights say what the scatter is".to_owned(),
                ));
            }
            if y.len() <= parameters {
                return Err(refuse(format!(
                    "scatter = \"residuals\" needs more points than parameters, {} are there",
                    y.len()
                )));
            }
            self.compiled
                .scatter
                .push((self.compiled.blocks.len(), y.len()));
            for y in &mut y {
                let scatter = self.variable();
                *y = self.program().push(Op::Add(*y, scatter));
            }
        } else if y.len() < parameters {
            return Err(refuse(format!(
                "{parameters} parameters need as many points, {} are there",
                y.len()
            )));
        }
        let mut fit = Fit::new(entry, x, y, parameters - 1);
        // Its ordinates scatter.
        fit.curve = curve.map(|curve| Curve {
            y: fit.y.clone(),
            ..curve
        });
        self.block(Block::Fit(Box::new(fit)), &entry.parameters);
        Ok(())
    }

    /// The curve of a fit, as a program of its own: the parameters first, then the abscissa.
    fn curve(&self, entry: &FitEntry, text: &str, x: &[u32], y: &[u32]) -> Result<Curve, Refusal> {
        let refuse = |what: String| Refusal::Equation {
            name: entry.name.clone(),
            what,
        };
        let m = entry.parameters.len();
        let start = entry.start.clone().unwrap_or_default();
        if start.len() != m || start.iter().any(|s| !s.is_finite()) {
            return Err(refuse(format!(
                "a `curve` needs its `start`: one finite number per parameter, {m}"
            )));
        }
        if entry.degree.is_some() {
            return Err(refuse("a `curve` has no `degree`".to_owned()));
        }
        let abscissa = entry.x.trim();
        let abscissa = if words(abscissa).eq([abscissa]) {
            abscissa
        } else {
            "x"
        };
        let mut inner = Program::default();
        let mut scope = Scope::new();
        for (i, name) in entry.parameters.iter().map(String::as_str).enumerate() {
            if name == abscissa {
                return Err(refuse(format!(
                    "`{name}` is the abscissa in `curve`, so no parameter may be called so"
                )));
            }
            let place = inner.push(Op::Input(i));
            scope.insert(name.to_owned(), Value::real(place));
        }
        let place = inner.push(Op::Input(m));
        scope.insert(abscissa.to_owned(), Value::real(place));
        if !words(text).any(|word| word == abscissa) && entry.weights == FitWeights::Both {
            return Err(refuse(format!(
                "weights = \"both\" needs a `curve` that speaks of its abscissa, `{abscissa}`"
            )));
        }
        let mut captured = Vec::new();
        let mut spoken: Vec<&str> = words(text).collect();
        spoken.sort_unstable();
        spoken.dedup();
        for name in spoken {
            if scope.contains_key(name) {
                continue;
            }
            captured.push(match self.scope.get(name) {
                None => continue,
                Some(Value::One(Scalar::Real(k))) => Captured::One(*k),
                Some(Value::Many(members)) if members.len() == x.len() => {
                    let each = members.iter().map(|member| match member {
                        Scalar::Real(k) => Some(*k),
                        Scalar::Complex(..) => None,
                    });
                    let each: Option<Vec<u32>> = each.collect();
                    Captured::Each(each.ok_or_else(|| refuse(format!("`{name}` is complex")))?)
                }
                Some(_) => {
                    return Err(refuse(format!(
                        "`{name}` in `curve` is neither one real quantity nor a vector with a member per point, {}",
                        x.len()
                    )));
                }
            });
            let place = inner.push(Op::Input(m + captured.len()));
            scope.insert(name.to_owned(), Value::real(place));
        }
        let labels = inner.labels.len();
        let value = compile(text, &scope, &mut inner)?;
        convert_labels(self.rule, &mut inner, labels, &entry.name)?;
        let Value::One(Scalar::Real(result)) = value else {
            return Err(refuse("`curve` is one real quantity".to_owned()));
        };
        Ok(Curve {
            x: x.to_vec(),
            y: y.to_vec(),
            program: inner,
            result,
            captured,
            start,
            weighing: CurveWeighing::Equal,
            scattered: Vec::new(),
        })
    }

    fn output(&mut self, entry: &OutputEntry) -> Result<(), Refusal> {
        let text = if entry.expression.is_empty() {
            &entry.name
        } else {
            &entry.expression
        };
        let value = self.formula(&entry.name, text, Some(&entry.unit))?;
        let factor = self.factor(&entry.unit, &entry.name)?;
        let named = |name: String| OutputEntry {
            name,
            unit: entry.unit.clone(),
            expression: text.clone(),
        };
        let state = |compiler: &mut Self, name: &str, scalar: Scalar| {
            let list = match scalar {
                Scalar::Real(k) => vec![(name.to_owned(), k)],
                Scalar::Complex(re, im) => {
                    vec![(format!("re({name})"), re), (format!("im({name})"), im)]
                }
            };
            for (name, k) in list {
                let k = compiler.scaled(k, factor, true);
                compiler.compiled.places.push(k);
                compiler.compiled.outputs.push(named(name));
            }
        };
        if self.compiled.outputs.len() + 2 * value.scalars().len() > MOST_OUTPUTS {
            return Err(Refusal::Equation {
                name: entry.name.clone(),
                what: format!(
                    "there would be more than {MOST_OUTPUTS} outputs; state fewer members, or a sum of them"
                ),
            });
        }
        match &value {
            Value::One(one) => state(self, &entry.name, *one),
            Value::Many(many) => {
                for (k, one) in many.iter().enumerate() {
                    state(self, &format!("{}[{}]", entry.name, k + 1), *one);
                }
            }
        }
        self.scope.insert(entry.name.clone(), value);
        Ok(())
    }
}

/// Factor to the coherent unit of the SI, where the model asks for conversion.
fn factor(rule: UnitRule, unit: &str, name: &str) -> Result<f64, Refusal> {
    if rule != UnitRule::Convert {
        return Ok(1.0);
    }
    let known = Dimension::parse(unit).and_then(|d| d.factor);
    known.ok_or_else(|| Refusal::Equation {
        name: name.to_owned(),
        what: format!(
            "{unit:?} is no unit this program knows, so that it cannot be converted; state another, or leave out \
             units = \"convert\""
        ),
    })
}

/// Converts the numbers with a unit that were read into a program since it had so many of them.
fn convert_labels(
    rule: UnitRule,
    program: &mut Program,
    since: usize,
    name: &str,
) -> Result<(), Refusal> {
    for (place, label) in &program.labels[since..] {
        let factor = factor(rule, label, name)?;
        if let Op::Constant(c) = &mut program.ops[*place as usize] {
            *c *= factor;
        }
    }
    Ok(())
}

fn parts(scalar: Scalar) -> Vec<u32> {
    match scalar {
        Scalar::Real(k) => vec![k],
        Scalar::Complex(re, im) => vec![re, im],
    }
}

impl Compiled {
    pub fn equations(self) -> Equations {
        let outputs = self.outputs.into_iter().map(|o| (o.name, o.unit));
        Equations::new(outputs.collect(), self.places, self.program, self.blocks)
    }
}
