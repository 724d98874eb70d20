//! What a request will cost, before anything is computed for it: which lane it takes, and how many
//! bytes its answer has at most.

use crate::queue::Lane;
use fogbank_core::image::Format;
use fogbank_core::request::View;
use fogbank_core::scene::{Airlight, CheckedScene, Light};
use fogbank_core::sky::Fineness;

/// Pairs of a pixel and a blob, or what else a ray sums up, in a picture that looks short. Two processors take about two
/// seconds for so many.
const SHORT_PAIRS: u64 = 4_000_000_000;

/// Triples of a ray, a light and a blob in a probe that looks short: single rays in f64 take some
/// hundred times as long as pixels, which share most of their work.
const SHORT_TRIPLES: u64 = 10_000_000;

/// Places at which what is left of a sky is summed up.
const SKY_PLACES: u64 = 1 << 16;

/// The lane of a picture.
pub fn lane_of_picture(scene: &CheckedScene, view: &View) -> Lane {
    let pixels = u64::from(view.width) * u64::from(view.height);
    // Parts of skies at the places of a table, or at about as many of the picture.
    let skies = scene.skies().count() as u64 * Fineness::FAST.parts() as u64 * SKY_PLACES;
    let pairs = pixels.saturating_add(skies).saturating_mul(1 + terms(scene));
    lane(scene, pairs.saturating_mul(integrals(scene)) <= SHORT_PAIRS)
}

/// The lane of a probe.
pub fn lane_of_probe(scene: &CheckedScene, rays: usize) -> Lane {
    // A sky is summed up as so many suns.
    let suns =
        |light: &Light| if light.sky().is_some() { Fineness::FAST.parts() as u64 } else { 1 };
    let lights = 1 + scene.lights.iter().map(suns).sum::<u64>();
    let pairs = (rays as u64).saturating_mul(lights).saturating_mul(1 + terms(scene));
    let triples = pairs.saturating_mul(integrals(scene));
    lane(scene, triples <= SHORT_TRIPLES)
}

fn lane(scene: &CheckedScene, is_small: bool) -> Lane {
    let is_short = is_small && scene.fog.airlight != Airlight::Reference;
    if is_short { Lane::Short } else { Lane::Long }
}

/// Airlights of each light: one a band of colour, an octave, and a group of terms that scatter alike.
fn integrals(scene: &CheckedScene) -> u64 {
    let octaves = scene.fog.octaves().len();
    (scene.fog.bands() * scene.fog.scatterings().len().max(1) * octaves) as u64
}

/// Blobs, cells, waves and monomials that a ray may sum up.
fn terms(scene: &CheckedScene) -> u64 {
    let enabled = scene.fog.terms.iter().filter(|term| term.common().enabled);
    enabled.map(|term| term.cost(scene.far_m) as u64).sum()
}

/// The most bytes of a picture's file; its head, and what an 8-bit format may add where nothing can
/// be compressed, are small beside it.
pub fn picture_bytes(width: u32, height: u32, channels: usize, format: Format) -> usize {
    let pixel = if format.is_float() { channels * size_of::<f32>() } else { channels.max(3) };
    width as usize * height as usize * pixel
}

/// The most bytes of a probe's JSON: every number takes up to 24 characters and a comma.
pub fn probe_bytes(scene: &CheckedScene, rays: usize) -> usize {
    const NUMBER: usize = 25;
    /// Names, braces and an id.
    const WORDS: usize = 512;
    const NUMBERS: usize = 25;
    rays * (WORDS + NUMBER * (NUMBERS + 3 * scene.lights.len()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fogbank_core::request::{ProbeRequest, RenderRequest};
    use fogbank_core::scene;

    fn lane(json: &str) -> Lane {
        let request: RenderRequest = scene::read(json.as_bytes()).unwrap();
        let (scene, view) = request.check().unwrap();
        lane_of_picture(&scene, &view)
    }

    #[test]
    fn the_reference_and_huge_pictures_look_long() {
        assert_eq!(lane(r#"{"scene": {}, "width": 8, "height": 8}"#), Lane::Short);
        assert_eq!(lane(r#"{"scene": {}, "width": 8192, "height": 1024}"#), Lane::Short);
        let reference = r#"{"scene": {"fog": {"airlight": "reference"}}, "width": 8, "height": 8}"#;
        assert_eq!(lane(reference), Lane::Long);
        let blobs = vec!["{}"; 1000].join(",");
        let term = format!(r#"{{"kind": "gaussians", "blobs": [{blobs}]}}"#);
        let huge = format!(
            r#"{{"scene": {{"fog": {{"terms": [{term}]}}}}, "width": 8192, "height": 1024}}"#
        );
        assert_eq!(lane(&huge), Lane::Long);
    }

    /// Three bands and two groups are six times the work.
    #[test]
    fn colour_and_groups_count() {
        let picture = |extinction: &str| {
            let blobs = vec![format!(r#"{{"extinction": {extinction}}}"#); 100].join(",");
            let own = r#"{"kind": "homogeneous", "albedo": [1, 0.5, 0.2]}"#;
            let terms = format!(r#"[{own}, {{"kind": "gaussians", "blobs": [{blobs}]}}]"#);
            format!(
                r#"{{"scene": {{"fog": {{"terms": {terms}}}}}, "width": 4000, "height": 2000}}"#
            )
        };
        assert_eq!(lane(&picture("1")), Lane::Short);
        assert_eq!(lane(&picture("[1, 2, 3]")), Lane::Long);
    }

    #[test]
    fn rays_times_lights_times_blobs_say_how_long_a_probe_looks() {
        let lights = [r#"{"kind": "point"}"#; 8].join(",");
        let json = format!(r#"{{"scene": {{"lights": [{lights}]}}, "rays": []}}"#);
        let request: ProbeRequest = scene::read(json.as_bytes()).unwrap();
        let (scene, _) = request.check().unwrap();
        assert_eq!(lane_of_probe(&scene, 1000), Lane::Short);
        assert_eq!(lane_of_probe(&scene, 10_000_000), Lane::Long);
        assert_eq!(probe_bytes(&scene, 1), 512 + 25 * (25 + 24));
    }

    #[test]
    fn a_sky_is_as_many_suns_as_it_has_parts() {
        let lane = |light: &str, rays: usize| {
            let json = format!(r#"{{"scene": {{"lights": [{light}]}}, "rays": []}}"#);
            let request: ProbeRequest = scene::read(json.as_bytes()).unwrap();
            lane_of_probe(&request.check().unwrap().0, rays)
        };
        assert_eq!(lane(r#"{"kind": "sun"}"#, 200_000), Lane::Short);
        assert_eq!(lane(r#"{"kind": "environment"}"#, 200_000), Lane::Long);
    }

    #[test]
    fn a_float_picture_is_as_large_as_its_numbers() {
        assert_eq!(picture_bytes(8, 4, 3, Format::Npy), 8 * 4 * 12);
        assert_eq!(picture_bytes(8, 4, 1, Format::Exr), 8 * 4 * 4);
        assert_eq!(picture_bytes(8, 4, 1, Format::Png), 8 * 4 * 3);
    }
}
