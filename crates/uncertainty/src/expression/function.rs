//! The functions and relations that a formula may use.

use crate::Number;

/// A comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Relation {
    Less,
    LessOrEqual,
    More,
    MoreOrEqual,
}

/// Signs, the longer ones first.
pub(super) const RELATIONS: [(&str, Relation); 6] = [
    ("<=", Relation::LessOrEqual),
    ("≤", Relation::LessOrEqual),
    (">=", Relation::MoreOrEqual),
    ("≥", Relation::MoreOrEqual),
    ("<", Relation::Less),
    (">", Relation::More),
];

/// A function of one number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Function {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Exp,
    Ln,
    Log10,
    Log2,
    Sqrt,
    Cbrt,
    Abs,
    Degrees,
    Radians,
}

/// By name.
pub(super) const FUNCTIONS: [(&str, Function); 20] = [
    ("sin", Function::Sin),
    ("cos", Function::Cos),
    ("tan", Function::Tan),
    ("asin", Function::Asin),
    ("acos", Function::Acos),
    ("atan", Function::Atan),
    ("sinh", Function::Sinh),
    ("cosh", Function::Cosh),
    ("tanh", Function::Tanh),
    ("exp", Function::Exp),
    ("ln", Function::Ln),
    ("log10", Function::Log10),
    ("log2", Function::Log2),
    ("sqrt", Function::Sqrt),
    ("cbrt", Function::Cbrt),
    ("abs", Function::Abs),
    ("degrees", Function::Degrees),
    ("deg", Function::Degrees),
    ("radians", Function::Radians),
    ("rad", Function::Radians),
];

/// √(a² + b²) without overflow; at the origin its derivative is that of |a|.
pub(super) fn hypotenuse<T: Number>(a: T, b: T) -> T {
    let (large, small) = if a.value().abs() >= b.value().abs() {
        (a.abs(), b)
    } else {
        (b.abs(), a)
    };
    if large.value() == 0.0 {
        return large;
    }
    let ratio = small / large;
    large * (T::from(1.0) + ratio * ratio).sqrt()
}

impl Relation {
    pub(super) fn holds(self, a: f64, b: f64) -> bool {
        match self {
            Self::Less => a < b,
            Self::LessOrEqual => a <= b,
            Self::More => a > b,
            Self::MoreOrEqual => a >= b,
        }
    }
}

impl Function {
    pub(super) fn apply<T: Number>(self, x: T) -> T {
        match self {
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Asin => x.asin(),
            Self::Acos => x.acos(),
            Self::Atan => x.atan(),
            Self::Sinh => x.sinh(),
            Self::Cosh => x.cosh(),
            Self::Tanh => x.tanh(),
            Self::Exp => x.exp(),
            Self::Ln => x.ln(),
            Self::Log10 => x.log10(),
            Self::Log2 => x.ln() / T::from(std::f64::consts::LN_2),
            Self::Sqrt => x.sqrt(),
            Self::Cbrt if x.value() < 0.0 => -(-x).powf(T::from(1.0 / 3.0)),
            Self::Cbrt => x.powf(T::from(1.0 / 3.0)),
            Self::Abs => x.abs(),
            Self::Degrees => x * T::from(180.0 / std::f64::consts::PI),
            Self::Radians => x * T::from(std::f64::consts::PI / 180.0),
        }
    }
}
