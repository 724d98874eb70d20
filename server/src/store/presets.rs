//! Presets as scenes: everybody may look at them and take copies, and nobody changes them.

use super::record::Head;
use fogbank_core::presets;
use serde::Serialize;
use std::sync::{Arc, LazyLock};

/// A preset, ready to be shown; as JSON without its scene, which `/v1/scenes/{name}` has.
#[derive(Serialize)]
pub struct Kept {
    /// What it is called.
    pub name: &'static str,
    /// A heading.
    pub title: &'static str,
    /// What it shows.
    pub description: &'static str,
    /// The scene at revision 0, which is before that of any write.
    #[serde(skip)]
    pub head: Arc<Head>,
}

/// All of them, the demo scene first. Made when somebody asks for the first time, which takes some tenths of a second.
pub fn all() -> &'static [Kept] {
    static ALL: LazyLock<Vec<Kept>> = LazyLock::new(make);
    &ALL
}

/// The preset of that name.
pub fn head(name: &str) -> Option<Arc<Head>> {
    let kept = all().iter().find(|kept| kept.name == name)?;
    Some(Arc::clone(&kept.head))
}

fn make() -> Vec<Kept> {
    let kept = |preset: presets::Preset| {
        let presets::Preset { name, title, description, mut scene } = preset;
        scene.name_all();
        match scene.check() {
            Ok(scene) => {
                Some(Kept { name, title, description, head: Arc::new(Head { revision: 0, scene }) })
            }
            Err(problems) => {
                tracing::error!("the preset {name} is not valid: {problems:?}");
                None
            }
        }
    };
    presets::all().into_iter().filter_map(kept).collect()
}
