//! The shaders, put together from `shaders/`: a pass with the media, the airlight and the surface
//! model that it works with. What is put together names a pipeline; nothing is chosen at run time.

use crate::media::{Field, Media, Shaded};
use crate::request::{Layer, Tonemap};
use glam::DVec3;
use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue,
};
use std::sync::LazyLock;
use wgpu::naga::Module;

macro_rules! sources {
    ($($path:literal),* $(,)?) => {
        [$(($path, include_str!(concat!("../../../shaders/", $path, ".wgsl")))),*]
    };
}

/// The number of the list of numbers that media in closed form share, as `shaders/media/numbers.wgsl` says it;
/// behind those of every pass. Behind it stand their rows, a list a medium.
pub const NUMBERS_BINDING: u32 = 20;

/// The module `fogbank::haze`, which sums up the media that stand in closed form, row by row, as far as a pass is
/// put together with them. Behind each row stands the group of terms that it belongs to.
static HAZE: LazyLock<String> = LazyLock::new(|| {
    let media = Media::default().shaded(DVec3::ZERO, &mut Vec::new());
    let each = |text: &str| {
        let of = |medium: &Shaded| {
            let text = text.replace("STEM", medium.stem);
            format!("#ifdef {}\n{text}#endif\n", medium.define)
        };
        media.iter().map(of).collect::<String>()
    };
    let structs = each("struct Grouped_STEM { row: STEM::Row, group: u32 }\n");
    let sum = |name: &str, parameters: &str, arguments: &str, kind: &str| {
        let is_of_group = parameters.starts_with("group");
        let is_own = if is_of_group { "STEM_rows[i].group == group" } else { "true" };
        let of_row = name.trim_start_matches("group_");
        let loops = each(&format!(
            "    for (var i = 0u; i < arrayLength(&STEM_rows); i++) {{
        if {is_own} {{
            sum += STEM::{of_row}(STEM_rows[i].row{arguments});
        }}
    }}\n"
        ));
        format!(
            "fn {name}({parameters}) -> {kind} {{\n    var sum = {kind}(0.0);\n{loops}    return sum;\n}}\n"
        )
    };
    let bindings = media.iter().zip(NUMBERS_BINDING + 1..).map(|(Shaded { stem, define, .. }, binding)| {
        format!(
            "#ifdef {define}\n@group(0) @binding({binding}) var<storage, read> {stem}_rows: array<Grouped_{stem}>;\n#endif\n"
        )
    });
    [
        "#define_import_path fogbank::haze\n".to_owned(),
        each("#import fogbank::media::STEM\n"),
        structs,
        bindings.collect(),
        sum("extinction", "group: u32, point: vec3<f32>", ", point", "f32"),
        sum("mean", "a: vec3<f32>, b: vec3<f32>", ", a, b", "f32"),
        sum("view_mean", "a: vec3<f32>, b: vec3<f32>", ", a, b", "f32"),
        sum(
            "beyond",
            "point: vec3<f32>, toward: vec3<f32>, path_m: f32",
            ", point, toward, path_m",
            "f32",
        ),
        sum("group_view_mean", "group: u32, a: vec3<f32>, b: vec3<f32>", ", a, b", "f32"),
        sum("bounds", "", "", "vec2<f32>"),
        "fn depth(origin: vec3<f32>, direction: vec3<f32>, length_m: f32) -> f32 {
    return length_m * view_mean(origin, origin + length_m * direction);
}\n"
            .to_owned(),
        "fn span(origin: vec3<f32>, direction: vec3<f32>, length_m: f32) -> vec2<f32> {
    var ends = vec2<f32>(3e38, -3e38);\n"
            .to_owned(),
        each(
            "    for (var i = 0u; i < arrayLength(&STEM_rows); i++) {
        let own = STEM::span(STEM_rows[i].row, origin, direction, length_m);
        ends = vec2<f32>(min(ends.x, own.x), max(ends.y, own.y));
    }\n",
        ),
        "    return ends;\n}\n".to_owned(),
        "fn edge_count() -> u32 {\n    var count = 0u;\n".to_owned(),
        each("    count += STEM::EDGES * arrayLength(&STEM_rows);\n"),
        "    return count;\n}\n".to_owned(),
        "fn edge(which: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {\n    var i = which;\n"
            .to_owned(),
        each(
            "    if i < STEM::EDGES * arrayLength(&STEM_rows) {
        let row = STEM_rows[i / max(STEM::EDGES, 1u)].row;
        return STEM::edge(row, i % max(STEM::EDGES, 1u), origin, direction);
    }
    i -= STEM::EDGES * arrayLength(&STEM_rows);\n",
        ),
        "    return -1.0;\n}\n".to_owned(),
    ]
    .concat()
});

/// What passes import, each behind what it imports itself.
const MODULES: &[(&str, &str)] = &sources![
    "num",
    "phase",
    "view",
    "lamp",
    "beam",
    "casters",
    "surfaces",
    "screen",
    "sparse",
    "bundle",
    "sky/harmonics",
    "sky/table",
    "sky/backdrop",
    "media/vertical",
    "media/numbers",
    "media/homogeneous",
    "media/functions",
    "media/fogmap",
    "media/gaussians",
    "tile",
    "airlight/sun2005",
    "airlight/macklin2010",
    "airlight/fogshop2007",
    "surface/attenuated",
    "grid/around",
    "grid/cell",
    "grid/crossing",
    "grid/glow",
    "grid/light_table",
    "grid/rule",
    "grid/shafts",
];

/// What passes import that itself imports `fogbank::haze`.
const MODULES_WITH_HAZE: &[(&str, &str)] = &sources!["grid/block"];

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

            /// Whether its text asks what stands in closed form.
            pub fn sees_haze(self) -> bool {
                self.text().contains("haze::") || self.text().contains("import fogbank::grid::block")
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
    /// What stands in closed form along view rays.
    Haze = "haze",
    /// Blobs along view rays, tile by tile.
    BlobTiles = "blob_tiles",
    /// Where the rays of a grid are tabulated.
    Knots = "knots",
    /// Airlight on a grid of rays.
    Grid = "grid",
    /// What noise makes of the fog.
    Bend = "bend",
    /// What lies between a light and the surfaces.
    LightDepth = "light_depth",
    /// Which lamps the surfaces see.
    Lit = "lit",
    /// Light from the surfaces.
    Surface = "surface",
    /// Light of skies from the surfaces, and behind everything.
    Skies = "skies",
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

    /// How many media in closed form it is put together with.
    pub fn media(&self) -> usize {
        self.defines.iter().filter(|name| name.starts_with("MEDIUM_")).count()
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

/// The names by which passes know the media in closed form that are there; the even haze always is.
pub fn of_media(field: &Field) -> Vec<&'static str> {
    let mut names = MEDIA[0].clone();
    for (name, _) in field.groups().iter().flat_map(Media::in_shaders).filter(|(_, there)| *there) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    // The same media are the same pipeline, whatever group they are in.
    names.sort_unstable();
    names
}

/// What a pass may be put together with: one choice of every list.
fn choices(pass: Pass) -> Vec<Vec<&'static [&'static str]>> {
    let mut all = of_its_own(pass);
    if pass.sees_haze() {
        all.push(MEDIA.iter().map(Vec::as_slice).collect());
    }
    all
}

fn of_its_own(pass: Pass) -> Vec<Vec<&'static [&'static str]>> {
    match pass {
        Pass::Triangles | Pass::Shapes | Pass::Knots | Pass::Bend | Pass::Lit | Pass::Skies => {
            vec![]
        }
        Pass::LightDepth => vec![vec![&[], &["MISSING"]]],
        Pass::Haze => {
            let lit: &[&[&str]] = &[
                &[],
                &["AIRLIGHT_SUN2005"],
                &["AIRLIGHT_MACKLIN2010"],
                &["AIRLIGHT_SUN2005", "SHADOWS"],
                &["AIRLIGHT_MACKLIN2010", "SHADOWS"],
            ];
            vec![lit.to_vec()]
        }
        Pass::BlobTiles => {
            let lit: &[&[&str]] = &[
                &[],
                &["AIRLIGHT_FOGSHOP2007"],
                &["AIRLIGHT_MACKLIN2010"],
                &["AIRLIGHT_FOGSHOP2007", "SHADOWS"],
                &["AIRLIGHT_MACKLIN2010", "SHADOWS"],
            ];
            vec![lit.to_vec(), vec![&[], &["MISSING"]]]
        }
        Pass::Grid => vec![vec![&[], &["EDGES"]]],
        Pass::Surface => {
            let depths: &[&[&str]] = &[&[], &["BLOBS"], &["BLOBS", "LOW"], &["TABLES"], &["CLEAR"]];
            vec![depths.to_vec(), vec![&[], &["SHADOWS"]]]
        }
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

/// All sets of media in closed form, the even haze in each.
static MEDIA: LazyLock<Vec<Vec<&'static str>>> = LazyLock::new(|| {
    let names: Vec<_> = Media::default().in_shaders().map(|(name, _)| name).collect();
    let more = names.len() - 1;
    let set = |bits: usize| {
        let is_in = |i: &usize| *i == 0 || bits >> (i - 1) & 1 == 1;
        let mut set: Vec<_> = (0..names.len()).filter(is_in).map(|i| names[i]).collect();
        set.sort_unstable();
        set
    };
    (0..1 << more).map(set).collect()
});

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
    // The media stand in front of the sum of them, and behind it what sees them as one.
    let haze = [("haze", HAZE.as_str())];
    for (path, source) in [MODULES, &haze, MODULES_WITH_HAZE].concat() {
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
