//! How bright a sky is, by direction.

use super::harmonics::{self, bands};
use super::map::RadianceMap;
use super::parts::Fineness;
use crate::json::bounded;
use crate::json::limits::{self, COUNTS};
use crate::json::tagged::tagged;
use crate::json::{Checker, Code, Rgb};
use crate::shared::Shared;
use glam::{DVec3, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::sync::LazyLock;

tagged!(
    /// How bright a sky is, by direction.
    Radiance {
        /// The same everywhere.
        UniformSky = "uniform",
        /// From the zenith over the horizon to the ground.
        GradientSky = "gradient",
        /// A sum of spherical harmonics.
        HarmonicSky = "spherical_harmonics",
        /// A picture of all directions.
        ImageSky = "image",
    }
);

/// The same everywhere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct UniformSky {
    /// Its radiance [W/(m² sr)].
    #[schemars(extend("x-usual" = limits::USUAL_RADIANCE))]
    pub rgb: Rgb,
}

impl Default for UniformSky {
    fn default() -> Self {
        Self { rgb: Rgb([0.3, 0.4, 0.5]) }
    }
}

/// From the zenith over the horizon to the ground, linear in the sine of the elevation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GradientSky {
    /// Radiance straight above [W/(m² sr)].
    #[schemars(extend("x-usual" = limits::USUAL_RADIANCE))]
    pub zenith: Rgb,
    /// Radiance at the horizon [W/(m² sr)].
    #[schemars(extend("x-usual" = limits::USUAL_RADIANCE))]
    pub horizon: Rgb,
    /// Radiance straight below: what the ground sends up, which surfaces do not hide from fog [W/(m² sr)].
    #[schemars(extend("x-usual" = limits::USUAL_RADIANCE))]
    pub ground: Rgb,
}

impl Default for GradientSky {
    fn default() -> Self {
        Self {
            zenith: Rgb([0.15, 0.25, 0.45]),
            horizon: Rgb([0.5, 0.55, 0.6]),
            ground: Rgb([0.1, 0.09, 0.08]),
        }
    }
}

/// A sum of spherical harmonics: real, orthonormal, polar axis +Z, no Condon–Shortley sign. Where it is negative there
/// is no light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct HarmonicSky {
    /// One factor for each function, at index l² + l + m [W/(m² sr)]; whole bands: 1, 4, 9 and so on.
    #[serde(deserialize_with = "bounded::shared::<{ COUNTS.harmonics }, _, _>")]
    #[schemars(
        with = "Vec<[f64; 3]>",
        length(min = 1, max = COUNTS.harmonics),
        inner(inner(range(min = limits::HARMONIC.min, max = limits::HARMONIC.max)))
    )]
    pub coefficients: Shared<Vec<Rgb>>,
}

impl Default for HarmonicSky {
    fn default() -> Self {
        Self { coefficients: vec![Rgb([1.0, 1.3, 1.6])].into() }
    }
}

/// A picture of all directions: its middle column is −Z, right of it lies +X, its top is +Y. Only the command line reads
/// files.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ImageSky {
    /// An EXR or HDR file, relative to the scene's own.
    #[schemars(length(min = 1, max = 4096))]
    pub file: String,
    /// What stands in it, once somebody has read it.
    #[serde(skip)]
    read: Option<Shared<RadianceMap>>,
}

impl ImageSky {
    /// Takes what stands in its file.
    pub fn show(&mut self, map: RadianceMap) {
        self.read = Some(map.into());
    }

    /// The picture.
    pub(super) fn map(&self) -> &RadianceMap {
        static BLACK: LazyLock<RadianceMap> = LazyLock::new(RadianceMap::default);
        self.read.as_deref().unwrap_or(&BLACK)
    }
}

impl Default for Radiance {
    fn default() -> Self {
        Self::UniformSky(UniformSky::default())
    }
}

impl Radiance {
    /// Looks at all of its numbers; `at` names its members.
    pub fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        let mut colour = |name: &str, rgb: Rgb| check.triple(rgb.0, limits::INTENSITY, || at(name));
        match self {
            Self::UniformSky(sky) => colour("rgb", sky.rgb),
            Self::GradientSky(sky) => {
                colour("zenith", sky.zenith);
                colour("horizon", sky.horizon);
                colour("ground", sky.ground);
            }
            Self::HarmonicSky(sky) => check_harmonics(check, sky, at),
            Self::ImageSky(sky) if sky.read.is_none() => {
                let detail = "only the command line reads files; a request has no place for images";
                check.refuse(Code::Conflict, || at("file"), detail);
            }
            Self::ImageSky(_) => {}
        }
    }

    /// L(ω) towards a unit vector [W/(m² sr)].
    pub fn toward(&self, d: DVec3) -> DVec3 {
        match self {
            Self::UniformSky(sky) => sky.rgb.vector(),
            Self::GradientSky(sky) => {
                let (horizon, sine) = (sky.horizon.vector(), d.y.clamp(-1.0, 1.0));
                let end = if sine > 0.0 { sky.zenith } else { sky.ground };
                horizon + (end.vector() - horizon) * sine.abs()
            }
            Self::HarmonicSky(sky) => {
                let values = harmonics::all(sky.coefficients.len().isqrt(), d);
                let terms = sky.coefficients.iter().zip(values);
                let sum: DVec3 = terms.map(|(factor, value)| factor.vector() * value).sum();
                sum.max(DVec3::ZERO)
            }
            Self::ImageSky(sky) => sky.map().toward(d),
        }
    }

    /// Colours by which a shader draws it: for each kind its number and how many bands or pixels a row has
    /// (`shaders/sky/backdrop.wgsl`).
    pub fn drawn(&self) -> (u32, usize, Vec<Vec3>) {
        let colour = |rgb: &Rgb| rgb.vector().as_vec3();
        match self {
            Self::UniformSky(sky) => (0, 1, vec![colour(&sky.rgb)]),
            Self::GradientSky(sky) => {
                (1, 1, [sky.zenith, sky.horizon, sky.ground].iter().map(colour).collect())
            }
            Self::HarmonicSky(sky) => {
                let factors = sky.coefficients.iter().map(colour);
                (2, sky.coefficients.len().isqrt(), factors.collect())
            }
            Self::ImageSky(sky) => {
                let (width, pixels) = sky.map().rows();
                (3, width, pixels.iter().map(|pixel| Vec3::from(*pixel)).collect())
            }
        }
    }

    /// Its mean over all directions [W/(m² sr)].
    pub fn mean(&self) -> DVec3 {
        let whole: DVec3 = self.all_parts(Fineness::FAST).iter().map(|part| part.weight).sum();
        whole / (4.0 * PI)
    }

    /// Its spherical harmonics below `order`.
    pub fn harmonics(&self, order: usize) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; order * order];
        for part in self.all_parts(Fineness::REFERENCE) {
            let values = harmonics::all(order, part.toward);
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += part.weight * value);
        }
        sums
    }

    /// The sky blurred by a function of the angle alone, given by its factor in each band.
    pub fn blurred(&self, factors: &[f64]) -> Vec<DVec3> {
        let order = factors.len();
        let mut all = self.harmonics(order);
        all.iter_mut().zip(bands(order)).for_each(|(value, l)| *value *= factors[l]);
        all
    }
}

fn check_harmonics(check: &mut Checker, sky: &HarmonicSky, at: &dyn Fn(&str) -> String) {
    let list = &sky.coefficients;
    check.count(list.len(), COUNTS.harmonics, "coefficients", || at("coefficients"));
    if list.is_empty() || list.len().isqrt().pow(2) != list.len() {
        let detail =
            format!("{} coefficients are no whole bands: 1, 4, 9, 16 and so on", list.len());
        check.refuse(Code::WrongLength, || at("coefficients"), detail);
    }
    for (i, factor) in list.iter().enumerate().take(COUNTS.harmonics) {
        check.triple(factor.0, limits::HARMONIC, || at(&format!("coefficients/{i}")));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn sky(json: &str) -> Radiance {
        serde_json::from_str(json).unwrap()
    }

    /// All kinds say the same of the same sky: 2 above the horizon on the mean, by its first harmonic.
    #[test]
    fn kinds_agree() {
        let sqrt = PI.sqrt();
        let uniform = sky(r#"{"kind": "uniform", "rgb": [1, 2, 3]}"#);
        let first = DVec3::new(1.0, 2.0, 3.0) * 2.0 * sqrt;
        assert!(uniform.harmonics(2)[0].distance(first) < 1e-12);
        assert!(uniform.harmonics(2)[1].length() < 1e-12);
        let json = format!(
            r#"{{"kind": "spherical_harmonics", "coefficients": [{:?}]}}"#,
            first.to_array()
        );
        assert!(sky(&json).toward(DVec3::Z).distance(DVec3::new(1.0, 2.0, 3.0)) < 1e-12);
        let gradient = r#"{"kind": "gradient", "zenith": [4, 4, 4], "horizon": [2, 2, 2], "ground": [0, 0, 0]}"#;
        let gradient = sky(gradient);
        assert_eq!(gradient.toward(DVec3::new(0.8, 0.6, 0.0)), DVec3::splat(3.2));
        assert_eq!(gradient.toward(DVec3::new(0.8, -0.6, 0.0)), DVec3::splat(0.8));
        // It is linear in y: two bands are all of it.
        let json = gradient.harmonics(2).iter().map(|v| v.to_array()).collect::<Vec<_>>();
        let json = format!(r#"{{"kind": "spherical_harmonics", "coefficients": {json:?}}}"#);
        let d = DVec3::new(0.48, 0.6, -0.64);
        assert!(sky(&json).toward(d).distance(gradient.toward(d)) < 1e-10);
    }
}
