//! What outlives a frame: geometry and extinction field, kept while their part of the scene stays
//! the same. Keyed by content: the parts are compared value by value, so that a stale entry cannot
//! answer.

use super::mapped::LightTable;
use crate::geometry::Geometry;
use crate::media::Field;
use crate::scene::CheckedScene;
use crate::scene::limits::COUNTS;
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

/// The depths of a scene's blobs from a light.
type LightDepths = (CheckedScene, DVec3, Arc<Vec<f64>>);

/// The table around a light, if it has one.
type LightTables = (CheckedScene, DVec3, Option<Arc<LightTable>>);

/// Geometry and field of the newest scenes.
#[derive(Debug, Default)]
pub struct Cache {
    geometry: Newest<Geometry>,
    field: Newest<Field>,
    to_light: Mutex<VecDeque<LightDepths>>,
    tables: Mutex<VecDeque<LightTables>>,
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

    /// The blobs' depths from a light, which no move of the camera changes.
    pub fn to_light(
        &self,
        scene: &CheckedScene,
        light: DVec3,
        make: impl FnOnce() -> Vec<f64>,
    ) -> Arc<Vec<f64>> {
        let same = |(key, at, _): &LightDepths| *at == light && key.fog.terms == scene.fog.terms;
        let mut entries = self.to_light.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, _, depths)) = entries.iter().find(|entry| same(entry)) {
            return Arc::clone(depths);
        }
        let depths = Arc::new(make());
        entries.push_front((scene.clone(), light, Arc::clone(&depths)));
        entries.truncate(2 * COUNTS.lights);
        depths
    }

    /// The table around a light, which no move of the camera changes.
    pub fn light_table(
        &self,
        scene: &CheckedScene,
        light: DVec3,
        make: impl FnOnce() -> Option<LightTable>,
    ) -> Option<Arc<LightTable>> {
        let same = |(key, at, _): &LightTables| *at == light && key.fog.terms == scene.fog.terms;
        let mut entries = self.tables.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, _, table)) = entries.iter().find(|entry| same(entry)) {
            return table.clone();
        }
        let table = make().map(Arc::new);
        entries.push_front((scene.clone(), light, table.clone()));
        entries.truncate(COUNTS.lights);
        table
    }
}
