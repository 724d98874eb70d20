//! Scenes to begin with: the papers' own figures with the papers' own counts, built from a few
//! lines each.

mod alps;
mod city;
mod countryside;
mod geometry;
mod gorge;
mod inscatter;
mod lighthouse;
mod nave;
mod room;
mod stage;
mod street;
mod terrain;
#[cfg(test)]
mod tests;
mod vehicle;
mod vessel;
mod village;

use crate::scene::Scene;
use schemars::JsonSchema;
use serde::Serialize;

/// A scene to begin with.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Preset {
    /// How the command line and the page name it.
    pub name: &'static str,
    /// A heading.
    pub title: &'static str,
    /// What it shows, in a sentence or two.
    pub description: &'static str,
    /// The scene itself.
    pub scene: Scene,
}

/// All presets; the first one is the demo scene.
pub fn all() -> Vec<Preset> {
    let mut presets = Vec::from(street::presets());
    presets.push(vessel::preset());
    presets.extend(terrain::presets());
    presets.extend(city::presets());
    presets.extend(vehicle::presets());
    presets.push(room::preset());
    presets.extend(countryside::presets());
    presets.push(gorge::preset());
    presets.extend(alps::presets());
    presets.extend([inscatter::preset(), nave::preset(), lighthouse::preset()]);
    presets
}
