//! The vectors of a scene: positions, colours and albedos.

use super::limits;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

macro_rules! triple {
    ($(#[$doc:meta])* $name:ident, $range:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(transparent)]
        pub struct $name(
            #[schemars(inner(range(min = $range.min, max = $range.max)))] pub [f64; 3],
        );

        impl $name {
            /// The same value in all three components.
            pub const fn splat(value: f64) -> Self {
                Self([value; 3])
            }

            /// The components as a vector of the maths; −0 becomes 0, which it equals as a key but not
            /// in its sign.
            pub fn vector(self) -> DVec3 {
                DVec3::from_array(self.0) + DVec3::ZERO
            }
        }

        impl From<[f64; 3]> for $name {
            fn from(components: [f64; 3]) -> Self {
                Self(components)
            }
        }
    };
}

triple!(
    /// A position or direction `[x, y, z]` in world space, metres, +Y up.
    Vec3,
    limits::COORDINATE
);
triple!(
    /// A colour `[r, g, b]`, linear Rec. 709, in the unit of its field.
    Rgb,
    limits::INTENSITY
);
triple!(
    /// A share per channel `[r, g, b]` between 0 (all absorbed) and 1 (nothing absorbed).
    Albedo,
    limits::FRACTION
);

#[cfg(test)]
mod tests {
    use super::*;

    /// Kept values are found by numbers that compare equal; what is made from them must be the same.
    #[test]
    fn no_vector_has_a_negative_zero() {
        let vector = Vec3([-0.0, 0.0, -1.0]).vector();
        assert_eq!(vector.to_array().map(f64::to_bits), [0.0, 0.0, -1.0].map(f64::to_bits));
    }
}
