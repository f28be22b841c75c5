//! The named error models: which elements of the sensitivity matrix are free.

use crate::Triple;
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// Which elements of ã = K a + b a fit is free to choose.
///
/// Without attitudes, ‖a‖ = g leaves any rotation of the sensor open: of the nine elements of K six can be
/// found. Which six is a convention, and two are in use: upper-triangular (the sensor frame takes its z axis
/// from the z element, its y–z plane from the y element) and symmetric (the frame lies evenly among the three
/// elements).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// Three biases; the scale factor is nominal.
    Bias,
    /// Three biases, three scale factors.
    BiasScale,
    /// Three biases, three scale factors, three misalignments: K upper-triangular.
    Triangular,
    /// Three biases and a symmetric K: an ellipsoid, its frame unrotated.
    Symmetric,
    /// Three biases and all nine elements of K; needs known attitudes.
    Full,
}

/// Names of the bias components.
pub(crate) const BIAS: [&str; 3] = ["bias.x", "bias.y", "bias.z"];
/// Names of the elements of K as quantities of the estimate.
pub(crate) const ELEMENT: [[&str; 3]; 3] = [
    ["scale.x", "misalignment.xy", "misalignment.xz"],
    ["misalignment.yx", "scale.y", "misalignment.yz"],
    ["misalignment.zx", "misalignment.zy", "scale.z"],
];

impl Model {
    /// All models, smallest first.
    pub const ALL: [Self; 5] = [
        Self::Bias,
        Self::BiasScale,
        Self::Triangular,
        Self::Symmetric,
        Self::Full,
    ];

    /// Name as written in a campaign.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bias => "bias",
            Self::BiasScale => "bias-scale",
            Self::Triangular => "triangular",
            Self::Symmetric => "symmetric",
            Self::Full => "full",
        }
    }

    /// The free elements (row, column) of K; the symmetric model names the upper one of each pair.
    pub fn free_elements(self) -> &'static [(usize, usize)] {
        const DIAGONAL: [(usize, usize); 3] = [(0, 0), (1, 1), (2, 2)];
        const UPPER: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        const ALL: [(usize, usize); 9] = [
            (0, 0),
            (1, 1),
            (2, 2),
            (0, 1),
            (0, 2),
            (1, 2),
            (1, 0),
            (2, 0),
            (2, 1),
        ];
        match self {
            Self::Bias => &[],
            Self::BiasScale => &DIAGONAL,
            Self::Triangular | Self::Symmetric => &UPPER,
            Self::Full => &ALL,
        }
    }

    /// The elements of K that can differ from the nominal matrix, in the order they are reported.
    pub(crate) fn reported_elements(self) -> &'static [(usize, usize)] {
        match self {
            Self::Symmetric => Self::Full.free_elements(),
            other => other.free_elements(),
        }
    }

    /// Number of free parameters.
    pub fn parameters(self) -> usize {
        3 + self.free_elements().len()
    }

    /// Name of one free parameter, in the order bias x, y, z, then the free elements.
    pub fn parameter_name(self, index: usize) -> &'static str {
        if index < 3 {
            BIAS[index]
        } else {
            let (i, j) = self.free_elements()[index - 3];
            ELEMENT[i][j]
        }
    }

    /// K from the parameters (natural units, where the nominal matrix is the identity).
    pub(crate) fn matrix(self, parameters: &[f64]) -> [Triple; 3] {
        let mut k = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for (&(i, j), &value) in self.free_elements().iter().zip(&parameters[3..]) {
            k[i][j] = value;
            if self == Self::Symmetric {
                k[j][i] = value;
            }
        }
        k
    }

    /// Adds wᵀ (∂K/∂θ) a and wᵀ ∂b/∂θ to one row of a Jacobian, times `sign`.
    pub(crate) fn derivative(self, w: Triple, a: Triple, sign: f64, row: &mut [f64]) {
        for axis in 0..3 {
            row[axis] = sign * w[axis];
        }
        for (&(i, j), element) in self.free_elements().iter().zip(&mut row[3..]) {
            *element = sign * w[i] * a[j];
            if self == Self::Symmetric && i != j {
                *element += sign * w[j] * a[i];
            }
        }
    }

    /// A model with fewer parameters, to name in a hint.
    pub fn smaller(self) -> Option<Self> {
        match self {
            Self::Bias => None,
            Self::BiasScale => Some(Self::Bias),
            Self::Triangular | Self::Symmetric => Some(Self::BiasScale),
            Self::Full => Some(Self::Triangular),
        }
    }

    /// The next model with more parameters; `known`: whether attitudes are given.
    pub fn larger(self, known: bool) -> Option<Self> {
        match self {
            Self::Bias => Some(Self::BiasScale),
            Self::BiasScale => Some(Self::Triangular),
            Self::Triangular | Self::Symmetric if known => Some(Self::Full),
            Self::Triangular | Self::Symmetric | Self::Full => None,
        }
    }

    /// Refuses fewer equations than parameters.
    pub(crate) fn check_count(
        self,
        equations: usize,
        each: usize,
        more: usize,
    ) -> Result<(), Error> {
        let needed = (self.parameters() + more).div_ceil(each);
        if equations < needed {
            return Err(Error::TooFew {
                name: "standstills",
                needed,
                got: equations,
            });
        }
        Ok(())
    }
}

impl std::fmt::Display for Model {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
