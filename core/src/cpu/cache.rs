//! What outlives a frame: geometry, first hits and extinction field, kept while their part of the
//! scene stays the same. Keyed by content: the parts are compared value by value, so that a stale entry cannot
//! answer.

use super::batch::Hits;
use super::mapped::LightTable;
use super::viewpoint::Grid;
use crate::geometry::Geometry;
use crate::media::Field;
use crate::scene::{Camera, CheckedScene};
use glam::DVec3;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// Entries that a cache keeps; the size of one is bounded by the scene's limits.
const KEPT: usize = 3;

/// The newest values made from scenes, by a part of the scene that they depend on.
#[derive(Debug)]
struct Newest<T>(Mutex<VecDeque<(CheckedScene, Arc<T>)>>);

impl<T> Default for Newest<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T> Newest<T> {
    /// The value of a scene with the `same` part, else a new one.
    fn get(
        &self,
        scene: &CheckedScene,
        same: impl Fn(&CheckedScene) -> bool,
        make: impl FnOnce() -> T,
    ) -> Arc<T> {
        let mut entries = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = entries.iter().position(|(key, _)| same(key));
        let entry = match found.and_then(|at| entries.remove(at)) {
            Some(entry) => entry,
            None => (scene.clone(), Arc::new(make())),
        };
        let value = Arc::clone(&entry.1);
        entries.push_front(entry);
        entries.truncate(KEPT);
        value
    }
}

/// Pictures whose first hits are kept.
const KEPT_PICTURES: usize = 2;

/// Tiles of the largest picture whose first hits are kept: 2 million pixels, 42 MB.
const KEPT_TILES: usize = 1 << 13;

/// Bytes of depths and of tables around lights that are kept, each: a dragged lamp leaves one behind
/// at every place.
const KEPT_BYTES: usize = 128 << 20;

/// First hits of all tiles, and what they depend on.
#[derive(Debug)]
struct Traced {
    /// Found by its surfaces, so that the same address means the same content.
    geometry: Arc<Geometry>,
    camera: Camera,
    grid: Grid,
    far_m: f64,
    hits: Arc<Vec<Hits>>,
}

/// What a scene's fog does around lights: the newest values, by fog and place of the light.
#[derive(Debug)]
struct AroundLights<T>(Mutex<VecDeque<(CheckedScene, DVec3, Arc<T>)>>);

impl<T> Default for AroundLights<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T> AroundLights<T> {
    /// The value of a light, else a new one; all together take no more than [`KEPT_BYTES`], as
    /// `bytes` counts them, but for the newest.
    fn get(
        &self,
        scene: &CheckedScene,
        light: DVec3,
        make: impl FnOnce() -> T,
        bytes: impl Fn(&T) -> usize,
    ) -> Arc<T> {
        let same = |key: &CheckedScene, at: DVec3| at == light && key.fog.terms == scene.fog.terms;
        let mut entries = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, _, value)) = entries.iter().find(|(key, at, _)| same(key, *at)) {
            return Arc::clone(value);
        }
        let value = Arc::new(make());
        let mut sum = bytes(&value);
        entries.retain(|(_, _, old)| {
            sum += bytes(old);
            sum <= KEPT_BYTES
        });
        entries.push_front((scene.clone(), light, Arc::clone(&value)));
        value
    }
}

/// Geometry, field, first hits and light tables of the newest scenes.
#[derive(Debug, Default)]
pub struct Cache {
    geometry: Newest<Geometry>,
    field: Newest<Field>,
    traced: Mutex<VecDeque<Traced>>,
    to_light: AroundLights<Vec<f64>>,
    tables: AroundLights<Option<LightTable>>,
}

impl Cache {
    /// The scene's geometry.
    pub fn geometry(&self, scene: &CheckedScene) -> Arc<Geometry> {
        let same = |key: &CheckedScene| key.surfaces == scene.surfaces;
        self.geometry.get(scene, same, || Geometry::build(&scene.surfaces))
    }

    /// The scene's extinction.
    pub fn field(&self, scene: &CheckedScene) -> Arc<Field> {
        let same = |key: &CheckedScene| key.fog.terms == scene.fog.terms;
        self.field.get(scene, same, || Field::new(&scene.fog))
    }

    /// First hits of all pixel centres, which no change of fog or lights moves.
    pub fn first_hits(
        &self,
        scene: &CheckedScene,
        geometry: &Arc<Geometry>,
        grid: Grid,
        make: impl FnOnce() -> Vec<Hits>,
    ) -> Arc<Vec<Hits>> {
        if grid.count() > KEPT_TILES {
            return Arc::new(make());
        }
        let same = |old: &Traced| {
            Arc::ptr_eq(&old.geometry, geometry)
                && (old.grid, old.far_m) == (grid, scene.far_m)
                && old.camera == scene.camera
        };
        let mut entries = self.traced.lock().unwrap_or_else(PoisonError::into_inner);
        let found = entries.iter().position(same);
        let entry = found.and_then(|at| entries.remove(at)).unwrap_or_else(|| Traced {
            geometry: Arc::clone(geometry),
            camera: scene.camera.clone(),
            grid,
            far_m: scene.far_m,
            hits: Arc::new(make()),
        });
        let hits = Arc::clone(&entry.hits);
        entries.push_front(entry);
        entries.truncate(KEPT_PICTURES);
        hits
    }

    /// The blobs' depths from a light, which no move of the camera changes.
    pub fn to_light(
        &self,
        scene: &CheckedScene,
        light: DVec3,
        make: impl FnOnce() -> Vec<f64>,
    ) -> Arc<Vec<f64>> {
        self.to_light.get(scene, light, make, |depths| size_of_val(depths.as_slice()))
    }

    /// The table around a light, which no move of the camera changes.
    pub fn light_table(
        &self,
        scene: &CheckedScene,
        light: DVec3,
        make: impl FnOnce() -> Option<LightTable>,
    ) -> Arc<Option<LightTable>> {
        self.tables.get(scene, light, make, |table| table.as_ref().map_or(0, LightTable::bytes))
    }
}
