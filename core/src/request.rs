//! What a client asks of a scene: a picture, an optical-depth map, a probe.

use crate::airlight::Method;
pub use crate::options::Options;
use crate::scene::limits::{self, COUNTS};
use crate::scene::{Camera, CheckedScene, Checker, Code, Fog, Octave, Problem, Scene, Vec3};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Asks for a picture of a scene.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RenderRequest {
    /// What to render.
    pub scene: Scene,
    /// Pixels along a row.
    #[schemars(range(min = 1, max = COUNTS.picture_side))]
    pub width: u32,
    /// Rows of pixels.
    #[schemars(range(min = 1, max = COUNTS.picture_side))]
    pub height: u32,
    /// `draft` for a moving hand, `full` for every pixel.
    #[serde(default)]
    pub quality: Quality,
    /// Which image of the frame.
    #[serde(default)]
    pub layer: Layer,
    /// Samples per pixel along edges; 1 in float formats and drafts, 4 in 8-bit `full` pictures.
    #[serde(default)]
    #[schemars(range(min = 1, max = COUNTS.samples))]
    pub samples: Option<u32>,
    /// Exposure of 8-bit pictures [stops].
    #[serde(default)]
    #[schemars(range(min = limits::EXPOSURE.min, max = limits::EXPOSURE.max))]
    #[schemars(extend("x-usual" = limits::USUAL_EXPOSURE))]
    pub exposure_ev: f64,
    /// How the radiance of 8-bit pictures is brought onto a screen.
    #[serde(default)]
    pub tonemap: Tonemap,
    /// What the frame may lose for speed.
    #[serde(default)]
    pub options: Options,
}

/// How much work a frame may cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Quality {
    /// For a moving hand: fog at a lower resolution, depth edges respected.
    Draft,
    /// Every pixel.
    #[default]
    Full,
}

/// One image of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Layer {
    /// The picture: surfaces through the fog, airlight and veil.
    #[default]
    Beauty,
    /// Light of the lamps scattered into the view rays.
    Airlight,
    /// Radiance of the surfaces before the fog in front of them.
    Surface,
    /// Optical depth of the view rays.
    OpticalDepth,
    /// exp(−optical depth).
    Transmittance,
    /// Distance along the ray [m]; `far_m` where nothing is hit.
    Depth,
    /// Normals of the surfaces, towards the eye; zero where nothing is hit.
    Normal,
}

impl Layer {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Beauty,
        Self::Airlight,
        Self::Surface,
        Self::Normal,
        Self::OpticalDepth,
        Self::Transmittance,
        Self::Depth,
    ];

    /// Numbers a pixel has where the fog has so many bands: 1 if it is grey, else 3.
    pub fn channels(self, bands: usize) -> usize {
        match self {
            Self::Beauty | Self::Airlight | Self::Surface | Self::Normal => 3,
            Self::OpticalDepth | Self::Transmittance => bands,
            Self::Depth => 1,
        }
    }
}

/// How radiance is brought onto a screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Tonemap {
    /// AgX: bright colours desaturate gently.
    #[default]
    Agx,
    /// Reinhard: L / (1 + L) per channel.
    Reinhard,
    /// Clipped at 1.
    None,
}

/// A checked picture request without its scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Pixels along a row.
    pub width: u32,
    /// Rows of pixels.
    pub height: u32,
    /// How much work the frame may cost.
    pub quality: Quality,
    /// Which image of the frame.
    pub layer: Layer,
    /// Samples per pixel along edges, if asked for.
    pub samples: Option<u32>,
    /// Exposure of 8-bit pictures [stops].
    pub exposure_ev: f64,
    /// Tone map of 8-bit pictures.
    pub tonemap: Tonemap,
    /// Whether it becomes an 8-bit picture.
    pub for_screen: bool,
    /// Whether a draft of it must be made faster than a draft is: it may be coarser.
    pub is_hasty: bool,
    /// The airlight estimator, if not the scene's own.
    pub estimator: Option<Method>,
    /// What it may lose for speed.
    pub options: Options,
}

impl View {
    /// The octaves of a fog's light that the layer shows.
    pub fn octaves(&self, fog: &Fog) -> Vec<Octave> {
        match self.layer {
            Layer::Beauty | Layer::Airlight => fog.octaves(),
            _ => vec![Octave::FIRST],
        }
    }

    fn check(&self, check: &mut Checker) {
        check_size(check, self.width, self.height, COUNTS.picture_pixels);
        if let Some(samples) = self.samples {
            let range = limits::Range { min: 1.0, max: COUNTS.samples as f64 };
            check.number(f64::from(samples), range, || "/samples".into());
        }
        check.number(self.exposure_ev, limits::EXPOSURE, || "/exposure_ev".into());
        self.options.check(check);
    }
}

impl RenderRequest {
    /// Checks everything.
    ///
    /// # Errors
    /// What is wrong, with pointers into this request.
    pub fn check(self) -> Result<(CheckedScene, View), Vec<Problem>> {
        let mut check = Checker::default();
        let view = View {
            width: self.width,
            height: self.height,
            quality: self.quality,
            layer: self.layer,
            samples: self.samples,
            exposure_ev: self.exposure_ev,
            tonemap: self.tonemap,
            for_screen: false,
            is_hasty: false,
            estimator: None,
            options: self.options,
        };
        view.check(&mut check);
        Ok((check_scene(check, self.scene)?, view))
    }
}

/// Asks for a picture of a scene that the server has.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrameRequest {
    /// Pixels along a row.
    #[serde(default = "width")]
    #[schemars(range(min = 1, max = COUNTS.picture_side))]
    pub width: u32,
    /// Rows of pixels.
    #[serde(default = "height")]
    #[schemars(range(min = 1, max = COUNTS.picture_side))]
    pub height: u32,
    /// `draft` for a moving hand, `full` for every pixel.
    #[serde(default)]
    pub quality: Quality,
    /// Which image of the frame.
    #[serde(default)]
    pub layer: Layer,
    /// From where; the scene's own camera where nothing is said. In an address it is JSON.
    #[serde(default)]
    pub camera: Option<Camera>,
    /// Samples per pixel along edges; 1 in float formats and drafts, 4 in 8-bit `full` pictures.
    #[serde(default)]
    #[schemars(range(min = 1, max = COUNTS.samples))]
    pub samples: Option<u32>,
    /// Time of the picture [s]; the scene's own where nothing is said.
    #[serde(default)]
    #[schemars(range(min = limits::TIME.min, max = limits::TIME.max))]
    pub time_s: Option<f64>,
    /// Exposure of 8-bit pictures [stops].
    #[serde(default)]
    #[schemars(range(min = limits::EXPOSURE.min, max = limits::EXPOSURE.max))]
    pub exposure_ev: f64,
    /// How the radiance of 8-bit pictures is brought onto a screen.
    #[serde(default)]
    pub tonemap: Tonemap,
    /// What may be left out to be faster. In an address it is JSON.
    #[serde(default)]
    pub options: Options,
}

fn width() -> u32 {
    800
}

fn height() -> u32 {
    600
}

impl FrameRequest {
    /// Checks everything.
    ///
    /// # Errors
    /// What is wrong, with pointers into this request.
    pub fn check(self) -> Result<(View, Eye), Vec<Problem>> {
        let mut check = Checker::default();
        let eye = Eye { camera: self.camera, time_s: self.time_s };
        eye.check(&mut check);
        let view = View {
            width: self.width,
            height: self.height,
            quality: self.quality,
            layer: self.layer,
            samples: self.samples,
            exposure_ev: self.exposure_ev,
            tonemap: self.tonemap,
            for_screen: false,
            is_hasty: false,
            estimator: None,
            options: self.options,
        };
        view.check(&mut check);
        check.finish((view, eye))
    }
}

/// From where and when a scene is looked at, if not as it says itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Eye {
    /// From where.
    pub camera: Option<Camera>,
    /// When [s].
    pub time_s: Option<f64>,
}

impl Eye {
    pub(crate) fn check(&self, check: &mut Checker) {
        if let Some(camera) = &self.camera {
            camera.check(check);
        }
        if let Some(time_s) = self.time_s {
            check.number(time_s, limits::TIME, || "/time_s".into());
        }
    }

    /// The scene as it is seen so.
    ///
    /// # Errors
    /// What is wrong with it then.
    pub fn on(&self, scene: &CheckedScene) -> Result<CheckedScene, Vec<Problem>> {
        match self {
            Self { camera: None, time_s: None } => Ok(scene.clone()),
            Self { camera, time_s } => scene.seen(camera.clone(), *time_s),
        }
    }
}

/// Asks for the optical depth of every view ray, or of what a light first meets in all directions.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OpticalDepthRequest {
    /// What to look at.
    pub scene: Scene,
    /// Pixels along a row; of view rays.
    #[serde(default)]
    #[schemars(with = "u32", range(min = 1, max = COUNTS.picture_side))]
    pub width: Option<u32>,
    /// Rows of pixels; of view rays.
    #[serde(default)]
    #[schemars(with = "u32", range(min = 1, max = COUNTS.picture_side))]
    pub height: Option<u32>,
    /// A light, by its id or its place among the lights, in place of the view rays.
    #[serde(default)]
    #[schemars(with = "LightName")]
    pub light: Option<LightName>,
    /// Pixels along the sides of the light's pictures. Of a lamp these are the faces of a cube, +X −X +Y −Y +Z −Z from top to
    /// bottom, as cube maps have them: to the right in them is −Z, +Z, +X, +X, +X, −X, downwards −Y, −Y, +Z, −Z, −Y, −Y.
    /// Of the sun it is one square across its way around all that has an end, up in it is +Y.
    #[serde(default)]
    #[schemars(with = "u32", range(min = 1, max = COUNTS.cube_side))]
    pub size: Option<u32>,
}

/// Names a light.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum LightName {
    /// By its place in the list.
    Index(usize),
    /// By the id that the scene gives it.
    Id(String),
}

/// What a map of optical depths is of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DepthsOf {
    /// View rays.
    View(View),
    /// The light in this place of the scene's list; so many pixels across.
    Light(usize, u32),
}

impl OpticalDepthRequest {
    /// What this asks for.
    ///
    /// # Errors
    /// What is wrong, with pointers into this request.
    pub fn check(self) -> Result<(CheckedScene, DepthsOf), Vec<Problem>> {
        if self.light.is_some() || self.size.is_some() {
            return self.check_light();
        }
        let mut check = Checker::default();
        for (name, value) in [("width", self.width), ("height", self.height)] {
            if value.is_none() {
                let pointer = || format!("/{name}");
                check.refuse(
                    Code::Missing,
                    pointer,
                    format!("`{name}` is missing; or give `light` and `size`"),
                );
            }
        }
        let (Some(width), Some(height)) = (self.width, self.height) else {
            return Err(check_scene(check, self.scene).err().unwrap_or_default());
        };
        let view = RenderRequest {
            scene: self.scene,
            width,
            height,
            quality: Quality::Full,
            layer: Layer::OpticalDepth,
            samples: Some(1),
            exposure_ev: 0.0,
            tonemap: Tonemap::None,
            options: Options::default(),
        };
        let (scene, view) = view.check()?;
        Ok((scene, DepthsOf::View(view)))
    }

    fn check_light(self) -> Result<(CheckedScene, DepthsOf), Vec<Problem>> {
        let mut check = Checker::default();
        for (name, value) in [("width", self.width), ("height", self.height)] {
            if value.is_some() {
                let why = "a map of a light has a `size`";
                check.refuse(Code::Conflict, || format!("/{name}"), why);
            }
        }
        let range = limits::Range { min: 1.0, max: COUNTS.cube_side as f64 };
        match self.size {
            Some(size) => check.number(f64::from(size), range, || "/size".into()),
            None => check.refuse(Code::Missing, || "/size".into(), "`size` is missing"),
        }
        let lights = &self.scene.lights;
        let light = match &self.light {
            Some(LightName::Index(index)) => Some(*index).filter(|index| *index < lights.len()),
            Some(LightName::Id(id)) => lights.iter().position(|own| own.id() == Some(id)),
            None => {
                check.refuse(Code::Missing, || "/light".into(), "`light` is missing");
                Some(0)
            }
        };
        match light.map(|light| lights.get(light)) {
            None => {
                check.refuse(Code::UnknownWord, || "/light".into(), "the scene has no such light");
            }
            Some(Some(light)) if light.sky().is_some() => {
                let why = "a sky shines from everywhere: it has no map";
                check.refuse(Code::Conflict, || "/light".into(), why);
            }
            Some(_) => {}
        }
        let of = DepthsOf::Light(light.unwrap_or(0), self.size.unwrap_or(1));
        Ok((check_scene(check, self.scene)?, of))
    }
}

/// Asks for the numbers along rays.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProbeRequest {
    /// What to look at.
    pub scene: Scene,
    /// The rays.
    #[serde(deserialize_with = "crate::json::bounded::list::<{ COUNTS.rays }, _, _>")]
    #[schemars(length(max = COUNTS.rays))]
    pub rays: Vec<RayRequest>,
}

/// Asks for the numbers along rays in a scene that the server has.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RaysRequest {
    /// The rays.
    #[serde(deserialize_with = "crate::json::bounded::list::<{ COUNTS.rays }, _, _>")]
    #[schemars(length(max = COUNTS.rays))]
    pub rays: Vec<RayRequest>,
    /// When [s]; at the scene's own time where nothing is said.
    #[serde(default)]
    #[schemars(range(min = limits::TIME.min, max = limits::TIME.max))]
    pub time_s: Option<f64>,
}

impl RaysRequest {
    /// Checks everything.
    ///
    /// # Errors
    /// What is wrong, with pointers into this request.
    pub fn check(
        &self,
        scene: &CheckedScene,
    ) -> Result<(CheckedScene, Vec<ProbeRay>), Vec<Problem>> {
        let mut check = Checker::default();
        let eye = Eye { camera: None, time_s: self.time_s };
        eye.check(&mut check);
        let rays = check_rays(&mut check, &self.rays, scene.fog.longest_m());
        let rays = check.finish(rays)?;
        Ok((eye.on(scene)?, rays))
    }
}

fn check_rays(check: &mut Checker, rays: &[RayRequest], longest_m: f64) -> Vec<ProbeRay> {
    check.count(rays.len(), COUNTS.rays, "rays", || "/rays".into());
    let each = rays.iter().enumerate().take(COUNTS.rays);
    each.map(|(i, ray)| ray.check(check, i, longest_m)).collect()
}

/// One ray of a probe.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RayRequest {
    /// Where it starts [m].
    pub origin: Vec3,
    /// Where it goes; any length but zero.
    #[schemars(extend("not" = { "const": [0, 0, 0] }))]
    pub direction: Vec3,
    /// Where it ends at the latest [m]; without it, `far_m` of the scene.
    #[serde(default)]
    #[schemars(range(min = limits::DISTANCE.min, max = limits::DISTANCE.max))]
    pub max_distance_m: Option<f64>,
}

/// A checked ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeRay {
    /// Where it starts [m].
    pub origin: DVec3,
    /// Unit vector.
    pub direction: DVec3,
    /// Where it ends at the latest [m], if given.
    pub max_distance_m: Option<f64>,
}

impl ProbeRequest {
    /// Checks everything.
    ///
    /// # Errors
    /// What is wrong, with pointers into this request.
    pub fn check(self) -> Result<(CheckedScene, Vec<ProbeRay>), Vec<Problem>> {
        let mut check = Checker::default();
        let rays = check_rays(&mut check, &self.rays, self.scene.fog.longest_m());
        Ok((check_scene(check, self.scene)?, rays))
    }
}

impl RayRequest {
    fn check(&self, check: &mut Checker, i: usize, longest_m: f64) -> ProbeRay {
        let at = |name: &str| format!("/rays/{i}/{name}");
        check.triple(self.origin.0, limits::COORDINATE, || at("origin"));
        check.direction(self.direction, || at("direction"));
        if let Some(distance_m) = self.max_distance_m {
            check.number(distance_m, limits::DISTANCE, || at("max_distance_m"));
            if distance_m > longest_m {
                let detail = format!(
                    "a polynomial of the fog repeats more than {} times within {distance_m} m",
                    COUNTS.periods
                );
                check.refuse(Code::OutOfRange, || at("max_distance_m"), detail);
            }
        }
        ProbeRay {
            origin: self.origin.vector(),
            direction: self.direction.vector().normalize_or_zero(),
            max_distance_m: self.max_distance_m,
        }
    }
}

pub(crate) fn check_size(check: &mut Checker, width: u32, height: u32, most: usize) {
    let side = limits::Range { min: 1.0, max: COUNTS.picture_side as f64 };
    check.number(f64::from(width), side, || "/width".into());
    check.number(f64::from(height), side, || "/height".into());
    let pixels = u64::from(width) * u64::from(height);
    if check.is_clean() && pixels > most as u64 {
        let detail = format!("{pixels} pixels are more than the limit of {most}");
        check.refuse(Code::TooMany, || "/height".into(), detail);
    }
}

pub(crate) fn check_scene(mut check: Checker, scene: Scene) -> Result<CheckedScene, Vec<Problem>> {
    check.within("/scene", |check| scene.check_into(check));
    scene.checked(check)
}
