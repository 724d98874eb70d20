//! What outlives a frame on either backend: geometry, extinction field, and what stands around lights. Each
//! is found by all that it depends on: surfaces and fog by value, once a frame, and what is made from
//! them by their address.

use super::context::{Context, Lamp};
use super::light_table::{self, LightTable};
use super::shafts::{self, Shafts};
use super::sky_table::SkyTable;
use super::viewpoint::Grid;
use crate::airlight::fogshop2007::{CenterDepths, outlook};
use crate::geometry::Origin;
use crate::kept::{Kept, Most, Same};
use crate::light::Source;
use crate::media::{Bands, Field, Moment, Term};
use crate::progress::{Interrupted, Progress};
use crate::request::View;
use crate::scene::{Blob, Camera, CheckedScene, Octave, Shape, Surface, Vec3};
use crate::shapes::Geometry;
use crate::sky::{Fineness, Radiance};
use glam::DVec3;
use std::sync::Arc;

/// Geometries, and fields: those of a few scenes that clients go to and fro between.
const SCENES: Most = Most { entries: 8, bytes: 256 << 20 };

/// Moments of each of their fogs, and octaves of their light.
const MOMENTS: Most = Most { entries: 12, bytes: SCENES.bytes / SCENES.entries };

/// Depths and tables around lights, each: those of a few scenes with the most lights. A dragged lamp
/// leaves some behind at every place.
const AROUND_LIGHTS: Most = Most { entries: 256, bytes: 128 << 20 };

/// Skies over a few fogs.
const SKIES: Most = Most { entries: 32, bytes: 128 << 20 };

/// What hides lamps from a picture or two with the most lights.
const SHAFTS: Most = Most { entries: 96, bytes: 128 << 20 };

/// A fog, and where light comes from in it.
type Lit = (Same<Field>, Source);

/// Geometry, field, and what stands around lights, of the scenes that were used last.
#[derive(Debug)]
pub struct Cache {
    geometry: Kept<Vec<Surface>, Geometry>,
    bands: Kept<Vec<Term>, Kept<Moment, Bands>>,
    pruned: Kept<(Same<Bands>, DVec3, f64), Bands>,
    to_light: Kept<Lit, Vec<f64>>,
    exact_to_light: Kept<Lit, CenterDepths>,
    tables: Kept<(Lit, light_table::Fineness), Option<LightTable>>,
    shafts: Kept<Shaded, Shafts>,
    skies: Kept<Under, Option<SkyTable>>,
}

/// A sky over a fog: how bright it is, how far fog that has no end towards it counts, its channels that differ; by how
/// many parts and bands of harmonics it is summed up, and in how many places.
type Under = (Same<Field>, (Radiance, f64, Vec<usize>), (Fineness, usize, usize));

/// What hides a lamp from a picture: surfaces, where it is, the camera and the picture.
#[derive(Clone, Debug, PartialEq)]
struct Shaded {
    geometry: Same<Geometry>,
    light: Origin,
    camera: Camera,
    grid: Grid,
    fineness: shafts::Fineness,
}

impl Default for Cache {
    fn default() -> Self {
        Self {
            geometry: Kept::new(SCENES, |surfaces, geometry| {
                surfaces.iter().map(bytes_of_surface).sum::<usize>() + geometry.bytes()
            }),
            bands: Kept::new(SCENES, |terms, _| terms.iter().map(bytes_of_term).sum()),
            pruned: Kept::new(MOMENTS, |_, bands| bands.bytes()),
            to_light: Kept::new(AROUND_LIGHTS, |_, depths| size_of_val(depths.as_slice())),
            exact_to_light: Kept::new(AROUND_LIGHTS, |_, depths| depths.bytes()),
            tables: Kept::new(AROUND_LIGHTS, |_, table| {
                table.as_ref().map_or(0, LightTable::bytes)
            }),
            shafts: Kept::new(SHAFTS, |_, shafts| shafts.bytes()),
            skies: Kept::new(SKIES, |_, table| table.as_ref().map_or(0, SkyTable::bytes)),
        }
    }
}

impl Cache {
    /// The scene's geometry.
    ///
    /// # Errors
    /// [`Interrupted`] when `progress` says so.
    pub fn geometry(
        &self,
        scene: &CheckedScene,
        progress: &Progress,
    ) -> Result<Arc<Geometry>, Interrupted> {
        let make = || Geometry::build(&scene.surfaces, progress);
        self.geometry.get(scene.surfaces.as_slice(), progress, make)
    }

    /// The scene's extinction at its time, band by band.
    ///
    /// # Errors
    /// [`Interrupted`] when `progress` says so.
    pub fn bands(
        &self,
        scene: &CheckedScene,
        progress: &Progress,
    ) -> Result<Arc<Bands>, Interrupted> {
        self.bands_of(scene, Octave::FIRST, progress)
    }

    /// The same of an octave of its light.
    ///
    /// # Errors
    /// [`Interrupted`] when `progress` says so.
    pub fn bands_of(
        &self,
        scene: &CheckedScene,
        octave: Octave,
        progress: &Progress,
    ) -> Result<Arc<Bands>, Interrupted> {
        let terms = &scene.fog.terms;
        let moment = Moment { density: octave.density, ..scene.fog.moment(scene.time_s) };
        let moments = || Ok::<_, Interrupted>(Kept::new(MOMENTS, |_, bands: &Bands| bands.bytes()));
        let moments = self.bands.get(terms.as_slice(), progress, moments)?;
        moments.get(&moment, progress, || Ok(Bands::new(terms, &moment)))
    }

    /// The same as a view may see it, of an octave: with fewer blobs far away, if it may be off by as much.
    ///
    /// # Errors
    /// [`Interrupted`] when `progress` says so.
    pub fn seen_bands(
        &self,
        scene: &CheckedScene,
        octave: Octave,
        view: &View,
        progress: &Progress,
    ) -> Result<Arc<Bands>, Interrupted> {
        let bands = self.bands_of(scene, octave, progress)?;
        let (eye, error) = (scene.camera.position.vector(), view.options.lod_error);
        if error == 0.0 {
            return Ok(bands);
        }
        let key = (Same::new(&bands), eye, error);
        self.pruned.get(&key, progress, || Ok(bands.pruned(eye, error)))
    }

    /// The blobs' depths from a light as pictures take them, which no move of the camera changes.
    ///
    /// # Errors
    /// What `make` fails with.
    pub fn to_light(
        &self,
        field: &Arc<Field>,
        light: Source,
        progress: &Progress,
        make: impl FnOnce() -> Result<Vec<f64>, Interrupted>,
    ) -> Result<Arc<Vec<f64>>, Interrupted> {
        self.to_light.get(&(Same::new(field), light), progress, make)
    }

    /// The same in f64, for probes.
    ///
    /// # Errors
    /// [`Interrupted`] when `progress` says so.
    pub fn exact_to_light(
        &self,
        field: &Arc<Field>,
        light: Source,
        progress: &Progress,
    ) -> Result<Arc<CenterDepths>, Interrupted> {
        let make = || Ok(CenterDepths::new(field, outlook(field, light)));
        self.exact_to_light.get(&(Same::new(field), light), progress, make)
    }

    /// The table around a light, which no move of the camera changes; `make` is given one of the same light in another
    /// fog, if there is one.
    ///
    /// # Errors
    /// What `make` fails with.
    pub fn light_table(
        &self,
        field: &Arc<Field>,
        light: Source,
        fineness: light_table::Fineness,
        progress: &Progress,
        make: impl FnOnce(Option<&LightTable>) -> Result<Option<LightTable>, Interrupted>,
    ) -> Result<Arc<Option<LightTable>>, Interrupted> {
        let key = ((Same::new(field), light), fineness);
        self.tables.get(&key, progress, || {
            let like = |((_, other), size): &(Lit, light_table::Fineness)| {
                *other == light && *size == fineness
            };
            let known = self.tables.newest(like);
            make(known.as_ref().and_then(|table| table.as_ref().as_ref()))
        })
    }
}

impl Cache {
    /// What surfaces hide of a lamp from a picture.
    ///
    /// # Errors
    /// [`Interrupted`] when the job's progress says so.
    pub fn shafts(
        &self,
        context: &Context,
        lamp: &Lamp,
        fineness: shafts::Fineness,
        make: impl FnOnce() -> Result<Shafts, Interrupted>,
    ) -> Result<Arc<Shafts>, Interrupted> {
        let key = Shaded {
            geometry: Same::new(context.geometry),
            light: lamp.source.origin(),
            camera: context.camera.clone(),
            grid: context.grid,
            fineness,
        };
        self.shafts.get(&key, context.job.progress, make)
    }
}

impl Cache {
    /// What is left of a sky in a fog, which no move of the camera changes.
    ///
    /// # Errors
    /// What `make` fails with.
    pub fn sky_table(
        &self,
        field: &Arc<Field>,
        sky: (Radiance, f64, Vec<usize>),
        detail: (Fineness, usize, usize),
        progress: &Progress,
        make: impl FnOnce() -> Result<Option<SkyTable>, Interrupted>,
    ) -> Result<Arc<Option<SkyTable>>, Interrupted> {
        self.skies.get(&(Same::new(field), sky, detail), progress, make)
    }
}

/// Near enough.
fn bytes_of_surface(surface: &Surface) -> usize {
    let parts = match &surface.shape {
        Shape::Plane(_) | Shape::Sphere(_) | Shape::Box(_) => 0,
        Shape::Mesh(mesh) => {
            let vertices =
                mesh.positions.len() + mesh.normals.as_ref().map_or(0, |list| list.len());
            vertices * size_of::<Vec3>() + size_of_val(mesh.indices.as_slice())
        }
        Shape::Heightfield(field) => {
            field.heights.iter().map(|row| size_of_val(row.as_slice())).sum()
        }
    };
    size_of::<Surface>() + parts
}

/// Near enough.
fn bytes_of_term(term: &Term) -> usize {
    size_of::<Term>() + term.blobs() * size_of::<Blob>()
}
