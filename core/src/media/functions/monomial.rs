//! Products of powers, and sums of them.

use crate::json::bounded;
use crate::json::limits::{self, COUNTS};
use crate::media::toward::Toward;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A product of powers: coefficient · u^p v^q w^r.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Monomial {
    /// The powers of the three variables, together at most 15.
    #[schemars(inner(range(min = 0, max = 15)))]
    pub powers: [u8; 3],
    /// What the product is multiplied by [1/m].
    #[schemars(range(min = limits::SIGNED_EXTINCTION.min, max = limits::SIGNED_EXTINCTION.max))]
    pub coefficient: f64,
}

impl Default for Monomial {
    fn default() -> Self {
        Self { powers: [0; 3], coefficient: 0.1 }
    }
}

impl Monomial {
    /// Its mean over a period.
    pub fn average(&self) -> f64 {
        let parts = self.powers.map(|power| f64::from(power) + 1.0);
        self.coefficient / parts.iter().product::<f64>()
    }
}

/// A sum of products of powers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct Monomials(
    #[serde(deserialize_with = "bounded::list::<{ COUNTS.monomials }, _, _>")]
    #[schemars(length(max = COUNTS.monomials))]
    pub Vec<Monomial>,
);

impl Toward for Monomials {
    fn toward(&self, other: &Self, share: f64) -> Self {
        let scaled = |list: &Self, by: f64| {
            let of = move |one: &Monomial| Monomial { coefficient: by * one.coefficient, ..*one };
            list.0.iter().map(of).collect::<Vec<_>>()
        };
        Self([scaled(self, 1.0 - share), scaled(other, share)].concat())
    }
}
