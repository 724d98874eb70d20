//! The shaders, put together from `shaders/`: a pass with the media, the airlight and the surface
//! model that it works with. What is put together names a pipeline; nothing is chosen at run time.

use crate::request::Layer;
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
}

/// A pass and what it is put together with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Composition {
    /// The pass.
    pub pass: Pass,
    /// Names that its text asks for.
    pub defines: &'static [&'static str],
}

/// Every composition that a frame may need.
pub fn compositions() -> Vec<Composition> {
    let with = |pass, defines: &[&'static [&'static str]]| {
        defines.iter().map(move |defines| Composition { pass, defines }).collect::<Vec<_>>()
    };
    [
        with(Pass::Triangles, &[&[]]),
        with(Pass::Shapes, &[&[]]),
        with(Pass::Homogeneous, &[&[], &["AIRLIGHT_SUN2005"]]),
        with(Pass::BlobQuads, &[&[], &["AIRLIGHT_FOGSHOP2007"]]),
        with(Pass::BlobTiles, &[&[], &["AIRLIGHT_FOGSHOP2007"]]),
        with(Pass::Mapped, &[&[], &["LIGHT_TABLE"]]),
        with(Pass::LightDepth, &[&[]]),
        with(Pass::Surface, &[&[], &["BLOBS"]]),
        Layer::ALL
            .into_iter()
            .flat_map(|layer| {
                let all = [(false, false), (false, true), (true, false), (true, true)];
                all.map(|(computed, edges)| composite(layer, computed, edges))
            })
            .collect(),
    ]
    .concat()
}

/// The pass that puts a layer together, with fog from passes that draw and, maybe, compute; and
/// that finds edges, if asked to.
pub fn composite(layer: Layer, computed: bool, edges: bool) -> Composition {
    macro_rules! with {
        ($($define:literal),*) => {
            match (computed, edges) {
                (false, false) => &[$($define,)* "FOG_TEXTURE"],
                (false, true) => &[$($define,)* "FOG_TEXTURE", "EDGES"],
                (true, false) => &[$($define,)* "FOG_TEXTURE", "FOG_BUFFER"],
                (true, true) => &[$($define,)* "FOG_TEXTURE", "FOG_BUFFER", "EDGES"],
            }
        };
    }
    let defines: &[&str] = match layer {
        Layer::Beauty => with!("LAYER_BEAUTY"),
        Layer::Airlight => with!("LAYER_AIRLIGHT"),
        Layer::Surface => with!("LAYER_SURFACE"),
        Layer::Normal => with!("LAYER_NORMAL"),
        Layer::OpticalDepth => with!("LAYER_OPTICAL_DEPTH"),
        Layer::Transmittance => with!("LAYER_TRANSMITTANCE"),
        Layer::Depth => with!(),
    };
    Composition { pass: Pass::Composite, defines }
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
