//! The shaders, put together from `shaders/`: a pass with the media, the airlight and the surface
//! model that it works with. What is put together names a pipeline; nothing is chosen at run time.

use crate::request::{Layer, Tonemap};
use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue,
};
use wgpu::naga::Module;

macro_rules! sources {
    ($($path:literal),* $(,)?) => {
        [$(($path, include_str!(concat!("../../../shaders/", $path, ".wgsl")))),*]
    };
}

/// What passes import, each behind what it imports itself.
const MODULES: &[(&str, &str)] = &sources![
    "num",
    "phase",
    "view",
    "lamp",
    "surfaces",
    "screen",
    "sparse",
    "bundle",
    "media/homogeneous",
    "media/gaussians",
    "tile",
    "airlight/sun2005",
    "airlight/fogshop2007",
    "surface/attenuated",
    "airlight/mapped",
    "mapped/pilot",
    "mapped/pixels",
    "mapped/around",
    "mapped/batch",
    "mapped/patch",
    "mapped/light_table",
];

macro_rules! passes {
    ($($(#[$doc:meta])* $name:ident = $stem:literal),* $(,)?) => {
        /// A pass over the picture.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Pass { $($(#[$doc])* $name),* }

        impl Pass {
            /// All passes.
            const ALL: [Self; [$($stem),*].len()] = [$(Self::$name),*];

            /// The name of its file in `shaders/passes/`.
            pub fn stem(self) -> &'static str {
                match self { $(Self::$name => $stem),* }
            }

            fn text(self) -> &'static str {
                match self {
                    $(Self::$name => {
                        include_str!(concat!("../../../shaders/passes/", $stem, ".wgsl"))
                    })*
                }
            }
        }
    };
}

passes! {
    /// First hits of triangles.
    Triangles = "triangles",
    /// First hits of planes, spheres and boxes.
    Shapes = "shapes",
    /// Homogeneous fog along view rays.
    Homogeneous = "homogeneous",
    /// Blobs along view rays, as quads that add up.
    BlobQuads = "blob_quads",
    /// Blobs along view rays, tile by tile.
    BlobTiles = "blob_tiles",
    /// Airlight by the mapped rule, patch by patch.
    Mapped = "mapped",
    /// What lies between a light and the surfaces.
    LightDepth = "light_depth",
    /// Light from the surfaces.
    Surface = "surface",
    /// What a layer shows.
    Composite = "composite",
    /// The mean of the samples, as it is or for a screen.
    Tonemap = "tonemap",
}

/// A pass and what it is put together with.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Composition {
    /// The pass.
    pub pass: Pass,
    /// Names that its text asks for.
    pub defines: Vec<&'static str>,
}

impl Composition {
    /// Of a pass, with the names of all lists.
    pub fn new(pass: Pass, defines: &[&[&'static str]]) -> Self {
        Self { pass, defines: defines.concat() }
    }
}

/// The name by which [`Pass::Composite`] knows a layer.
pub fn of_layer(layer: Layer) -> &'static [&'static str] {
    match layer {
        Layer::Beauty => &["LAYER_BEAUTY"],
        Layer::Airlight => &["LAYER_AIRLIGHT"],
        Layer::Surface => &["LAYER_SURFACE"],
        Layer::Normal => &["LAYER_NORMAL"],
        Layer::OpticalDepth => &["LAYER_OPTICAL_DEPTH"],
        Layer::Transmittance => &["LAYER_TRANSMITTANCE"],
        Layer::Depth => &[],
    }
}

/// The names by which [`Pass::Tonemap`] knows a tone map.
pub fn of_tonemap(tonemap: Tonemap) -> &'static [&'static str] {
    match tonemap {
        Tonemap::Agx => &["SCREEN", "AGX"],
        Tonemap::Reinhard => &["SCREEN", "REINHARD"],
        Tonemap::None => &["SCREEN"],
    }
}

/// What a pass may be put together with: one choice of every list.
fn choices(pass: Pass) -> Vec<Vec<&'static [&'static str]>> {
    match pass {
        Pass::Triangles | Pass::Shapes => vec![],
        Pass::LightDepth => vec![vec![&[], &["MISSING"]]],
        Pass::Homogeneous => vec![vec![&[], &["AIRLIGHT_SUN2005"]]],
        Pass::BlobQuads => vec![vec![&[], &["AIRLIGHT_FOGSHOP2007"]]],
        Pass::BlobTiles => {
            vec![vec![&[], &["AIRLIGHT_FOGSHOP2007"]], vec![&[], &["MISSING"]]]
        }
        Pass::Mapped => vec![vec![&[], &["LIGHT_TABLE"]]],
        Pass::Surface => vec![vec![&[], &["BLOBS"], &["BLOBS", "LOW"]]],
        Pass::Composite => vec![
            Layer::ALL.map(of_layer).to_vec(),
            vec![&[], &["FOG_BUFFER"]],
            vec![&[], &["FOG_LOW"]],
            vec![&[], &["MARK_EDGES"], &["AT_EDGES"]],
        ],
        Pass::Tonemap => {
            let shown = [Tonemap::Agx, Tonemap::Reinhard, Tonemap::None].map(of_tonemap);
            vec![[&[][..]].into_iter().chain(shown).collect()]
        }
    }
}

/// Every composition that a frame may need.
pub fn compositions() -> Vec<Composition> {
    let all = |pass: Pass| {
        let mut keys = vec![Composition::new(pass, &[])];
        for choice in choices(pass) {
            let with = |key: &Composition| {
                let key = key.clone();
                choice.iter().map(move |names| Composition::new(pass, &[&key.defines, names]))
            };
            keys = keys.iter().flat_map(with).collect();
        }
        keys
    };
    Pass::ALL.into_iter().flat_map(all).collect()
}

/// The composition as naga reads it.
///
/// # Errors
/// What is wrong with the text, and where.
pub fn module(key: &Composition) -> Result<Module, String> {
    let mut composer = Composer::default();
    for (path, source) in MODULES {
        let descriptor =
            ComposableModuleDescriptor { source, file_path: path, ..Default::default() };
        let added = composer.add_composable_module(descriptor).map(drop);
        added.map_err(|error| error.emit_to_string(&composer))?;
    }
    let defines = key.defines.iter().map(|name| ((*name).to_owned(), ShaderDefValue::Bool(true)));
    let made = composer.make_naga_module(NagaModuleDescriptor {
        source: key.pass.text(),
        file_path: key.pass.stem(),
        shader_defs: defines.collect(),
        ..Default::default()
    });
    made.map_err(|error| error.emit_to_string(&composer))
}

#[cfg(test)]
mod tests {
    use super::{compositions, module};
    use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};

    /// Every shader that a frame may ask for is valid, whether or not there is a GPU.
    #[test]
    fn every_composition_is_valid() {
        for key in compositions() {
            let module = module(&key).unwrap_or_else(|error| panic!("{key:?}: {error}"));
            let mut validator = Validator::new(ValidationFlags::all(), Capabilities::default());
            validator.validate(&module).unwrap_or_else(|error| panic!("{key:?}: {error:?}"));
            assert!(!module.entry_points.is_empty(), "{key:?} has no entry point");
        }
    }
}
