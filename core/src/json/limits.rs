//! Every bound that a scene and a request must respect, in one place: the checks, the JSON schema
//! and `GET /v1/limits` all read these constants.

use schemars::JsonSchema;
use serde::Serialize;

/// A closed interval of accepted numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Range {
    /// Smallest accepted value.
    pub min: f64,
    /// Largest accepted value.
    pub max: f64,
}

impl Range {
    const fn new(min: f64, max: f64) -> Self {
        Self { min, max }
    }

    /// Whether `value` lies in the interval; NaN never does.
    pub fn contains(&self, value: f64) -> bool {
        self.min <= value && value <= self.max
    }
}

/// World coordinates and components of directions [m].
pub const COORDINATE: Range = Range::new(-1e9, 1e9);
/// Distances [m] that may be zero.
pub const DISTANCE: Range = Range::new(0.0, 1e9);
/// Where a ray that meets nothing ends [m].
pub const FAR: Range = Range::new(1e-3, 1e9);
/// Radii, and sizes that must not vanish [m].
pub const RADIUS: Range = Range::new(1e-4, 1e8);
/// Distance of a brush's dabs, in its radii.
pub const SPACING: Range = Range::new(0.01, 100.0);
/// Speeds [m/s].
pub const SPEED: Range = Range::new(0.0, 1e6);
/// How fast particles spread [m²/s].
pub const DIFFUSION: Range = Range::new(0.0, 1e9);
/// Width of a picture as a share of its height.
pub const ASPECT: Range = Range::new(1e-2, 1e2);
/// Extinction [1/m].
pub const EXTINCTION: Range = Range::new(0.0, 1e6);
/// Meteorological visibility [m].
pub const VISIBILITY: Range = Range::new(1e-5, 1e9);
/// Radiant intensity [W/sr], irradiance [W/m²] and radiance [W/(m² sr)].
pub const INTENSITY: Range = Range::new(0.0, 1e12);
/// Factors of a sky's spherical harmonics [W/(m² sr)].
pub const HARMONIC: Range = Range::new(-1e12, 1e12);
/// Extinction that a member of a family adds or takes away [1/m].
pub const SIGNED_EXTINCTION: Range = Range::new(-1e6, 1e6);
/// Components of a wave vector [rad/m].
pub const WAVE_VECTOR: Range = Range::new(-1e5, 1e5);
/// Phases of waves [rad].
pub const PHASE: Range = Range::new(-1e6, 1e6);
/// What an equipotential is divided by at its object.
pub const DIVISOR: Range = Range::new(1e-6, 1e6);
/// By how much that grows with the square of the distance [1/m²].
pub const DIVISOR_GROWTH: Range = Range::new(0.0, 1e6);
/// Time in which something comes back to where it was [s].
pub const PERIOD: Range = Range::new(1e-3, 1e9);
/// Particles born a second [Hz].
pub const RATE: Range = Range::new(0.0, 1e6);
/// Angles by which a direction is turned [degrees].
pub const SPREAD: Range = Range::new(0.0, 180.0);
/// Half angles of a cone of light [degrees].
pub const CONE: Range = Range::new(0.0, 89.999);
/// Octaves of light that was scattered several times.
pub const OCTAVES: Range = Range::new(0.0, 8.0);
/// Extinction of an octave as a share of that before.
pub const THINNING: Range = Range::new(0.1, 1.0);
/// Growth of a radius as a share of itself.
pub const GROWTH: Range = Range::new(0.0, 1e3);
/// By how much noise shifts a blob, in its radii.
pub const NOISE_STRENGTH: Range = Range::new(0.0, 10.0);
/// Relative error of the mean optical depth.
pub const LOD_ERROR: Range = Range::new(0.0, 1.0);
/// Fraction of a picture that fog is computed for.
pub const FOG_SCALE: Range = Range::new(1e-3, 1.0);
/// Transmittance below which a ray ends.
pub const FAR_CUT: Range = Range::new(0.0, 0.1);
/// Powers of a monomial, together.
pub const POWER: Range = Range::new(0.0, 15.0);
/// Sides of a map's cells, and periods of noise [m].
pub const CELL: Range = Range::new(1e-3, 1e6);
/// A fraction per channel: albedos.
pub const FRACTION: Range = Range::new(0.0, 1.0);
/// Mean cosine g of a phase function.
pub const ANISOTROPY: Range = Range::new(-0.99, 0.99);
/// Exponent of the Phong lobe.
pub const SHININESS: Range = Range::new(0.0, 1e5);
/// Vertical field of view [degrees].
pub const FIELD_OF_VIEW: Range = Range::new(0.1, 179.0);
/// Components of velocities [m/s] and accelerations [m/s²].
pub const VELOCITY: Range = Range::new(-1e6, 1e6);
/// Scene time [s].
pub const TIME: Range = Range::new(-1e9, 1e9);
/// Exposure of a picture [stops].
pub const EXPOSURE: Range = Range::new(-64.0, 64.0);

/// Where a quantity usually lies, and how one moves through it: the hint `x-usual` of the JSON
/// schema, for sliders. Everything within its [`Range`] is accepted all the same.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Usual {
    /// The low end; above 0 on a logarithmic scale.
    pub min: f64,
    /// The high end.
    pub max: f64,
    /// What equal steps do.
    pub scale: Scale,
}

/// What equal steps through a range do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// They add.
    Linear,
    /// They multiply.
    Log,
}

impl Usual {
    const fn linear(min: f64, max: f64) -> Self {
        Self { min, max, scale: Scale::Linear }
    }

    const fn log(min: f64, max: f64) -> Self {
        Self { min, max, scale: Scale::Log }
    }
}

/// From air that hides a ridge 30 km away to smoke that hides an arm's length.
pub const USUAL_EXTINCTION: Usual = Usual::log(1e-4, 10.0);
/// The same as a visibility [m].
pub const USUAL_VISIBILITY: Usual = Usual::log(0.3, 3e4);
/// From a candle to a floodlight [W/sr].
pub const USUAL_INTENSITY: Usual = Usual::log(0.1, 1e5);
/// From a full moon to the midday sun, if a lamp's W/sr are taken as they usually are [W/m²].
pub const USUAL_IRRADIANCE: Usual = Usual::log(1e-3, 1e3);
/// From a moonless sky to a lamp's globe [W/(m² sr)].
pub const USUAL_RADIANCE: Usual = Usual::log(1e-3, 1e2);
/// Stops.
pub const USUAL_EXPOSURE: Usual = Usual::linear(-8.0, 8.0);

/// How many of each thing a scene or a request may hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Counts {
    /// Surfaces of a scene.
    pub surfaces: usize,
    /// Triangles of all meshes and heightfields together.
    pub triangles: usize,
    /// Vertices of all meshes together.
    pub vertices: usize,
    /// Lights of a scene.
    pub lights: usize,
    /// Fog terms of a scene.
    pub terms: usize,
    /// Gaussians of all terms together.
    pub blobs: usize,
    /// Members of a term of functions.
    pub members: usize,
    /// Monomials of a polynomial.
    pub monomials: usize,
    /// Periods of a polynomial of several variables along a ray.
    pub periods: usize,
    /// Rows or columns of a map.
    pub map_side: usize,
    /// Frames of a simulation.
    pub frames: usize,
    /// Keys of a wind.
    pub keys: usize,
    /// Operations of a JSON patch.
    pub operations: usize,
    /// Edits of a request.
    pub edits: usize,
    /// Points of a stroke.
    pub stroke_points: usize,
    /// Steps that the particles of an edit take together.
    pub particle_steps: usize,
    /// Characters of an id.
    pub id_chars: usize,
    /// Spherical harmonics of a sky.
    pub harmonics: usize,
    /// Pixels of a sky's picture.
    pub sky_pixels: usize,
    /// Pixels along one side of a picture.
    pub picture_side: usize,
    /// Pixels of a picture.
    pub picture_pixels: usize,
    /// Pixels along one side of a light's cube face.
    pub cube_side: usize,
    /// Samples per pixel along edges.
    pub samples: usize,
    /// Rays of a probe.
    pub rays: usize,
    /// Pixels of a comparison.
    pub compare_pixels: usize,
    /// Steps of ray marching, in a comparison.
    pub march_steps: usize,
}

/// The counts that this program accepts.
pub const COUNTS: Counts = Counts {
    surfaces: 10_000,
    triangles: 1_000_000,
    vertices: 1_000_000,
    lights: 64,
    terms: 256,
    blobs: 200_000,
    members: 256,
    monomials: 64,
    periods: 100_000,
    map_side: 1024,
    frames: 4096,
    keys: 4096,
    operations: 10_000,
    edits: 256,
    stroke_points: 1000,
    particle_steps: 2_000_000,
    id_chars: 64,
    harmonics: 256,
    sky_pixels: 8_388_608,
    picture_side: 8192,
    picture_pixels: 8_388_608,
    cube_side: 1024,
    samples: 16,
    rays: 65_536,
    compare_pixels: 2_097_152,
    march_steps: 4096,
};

/// Rows or columns of a heightfield's grid, whose cells are two triangles each.
pub const GRID_SIDE: usize = COUNTS.triangles / 2 + 1;

/// Rows of all heightfields together: each has at least one cell a row, but for its last row.
pub const GRID_ROWS: usize = COUNTS.triangles / 2 + COUNTS.surfaces;
