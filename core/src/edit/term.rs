//! Which term of a fog an edit means.

use super::Refused;
use crate::json::limits::COUNTS;
use crate::media::Term;
use crate::media::emitter::Emitter;
use crate::media::fogmap::Fogmap;
use crate::scene::{Blob, Gaussians, Scene};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Names an item of a list.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Name {
    /// By its id.
    Id(#[schemars(length(min = 1, max = COUNTS.id_chars))] String),
    /// By its place in the list.
    Place(u32),
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Id(id) => write!(f, "`{id}`"),
            Self::Place(place) => write!(f, "at place {place}"),
        }
    }
}

/// The term of that name, and its place.
fn find<'a>(scene: &'a mut Scene, name: &Name) -> Result<(usize, &'a mut Term), Refused> {
    let terms = &scene.fog.terms;
    let place = match name {
        Name::Id(id) => terms.iter().position(|term| term.common().id == Some(id)),
        Name::Place(place) => Some(*place as usize).filter(|place| *place < terms.len()),
    };
    let none = || Refused::conflict("term", format!("the fog has no term {name}"));
    let place = place.ok_or_else(none)?;
    Ok((place, &mut scene.fog.terms[place]))
}

fn other_kind(name: &Name, found: &Term, needed: &str) -> Refused {
    Refused::conflict("term", format!("the term {name} is {}, not {needed}", found.what()))
}

/// The blobs of that name that may be changed.
pub fn gaussians<'a>(scene: &'a mut Scene, name: &Name) -> Result<&'a mut Gaussians, Refused> {
    match find(scene, name)?.1 {
        Term::Gaussians(Gaussians { frames: Some(_), .. }) => {
            let detail = format!("the term {name} plays a simulation back");
            Err(Refused::conflict("term", detail))
        }
        Term::Gaussians(gaussians) => Ok(gaussians),
        other => Err(other_kind(name, other, "a sum of blobs")),
    }
}

/// The blobs that a brush adds to, and the place of their term: those of that name; without one the last ones,
/// or new ones.
pub fn painted<'a>(
    scene: &'a mut Scene,
    name: Option<&Name>,
) -> Result<(u32, &'a mut Gaussians), Refused> {
    let is_open = |term: &Term| matches!(term, Term::Gaussians(Gaussians { frames: None, .. }));
    let place = match name {
        Some(name) => find(scene, name)?.0,
        None => scene.fog.terms.iter().rposition(is_open).unwrap_or_else(|| {
            scene.fog.terms.push(Term::Gaussians(Gaussians::default()));
            scene.fog.terms.len() - 1
        }),
    };
    let place = place as u32;
    Ok((place, gaussians(scene, &Name::Place(place))?))
}

/// All blobs that may be changed, or those of that name.
pub fn all_gaussians<'a>(
    scene: &'a mut Scene,
    name: Option<&Name>,
) -> Result<Vec<&'a mut Gaussians>, Refused> {
    if let Some(name) = name {
        return Ok(vec![gaussians(scene, name)?]);
    }
    let open = scene.fog.terms.iter_mut().filter_map(|term| match term {
        Term::Gaussians(gaussians) if gaussians.frames.is_none() => Some(gaussians),
        _ => None,
    });
    Ok(open.collect())
}

/// The emitter of that name, and its place.
pub fn emitter<'a>(scene: &'a mut Scene, name: &Name) -> Result<(usize, &'a mut Emitter), Refused> {
    match find(scene, name)? {
        (place, Term::Emitter(emitter)) => Ok((place, emitter)),
        (_, other) => Err(other_kind(name, other, "an emitter")),
    }
}

/// The fogmap of that name.
pub fn fogmap<'a>(scene: &'a mut Scene, name: &Name) -> Result<&'a mut Fogmap, Refused> {
    match find(scene, name)?.1 {
        Term::Fogmap(map) => Ok(map),
        other => Err(other_kind(name, other, "a fogmap")),
    }
}

/// A term's blobs, and places among them, each once and in order.
pub fn picked<'a>(
    scene: &'a mut Scene,
    name: &Name,
    blobs: &[u32],
) -> Result<(&'a mut Vec<Blob>, Vec<usize>), Refused> {
    let all = &mut *gaussians(scene, name)?.blobs;
    let mut places: Vec<_> = blobs.iter().map(|place| *place as usize).collect();
    places.sort_unstable();
    places.dedup();
    match places.last() {
        Some(last) if *last >= all.len() => {
            let detail = format!("there is no blob {last}: there are {}", all.len());
            Err(Refused::conflict("blobs", detail))
        }
        _ => Ok((all, places)),
    }
}
