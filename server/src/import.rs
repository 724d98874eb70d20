//! `fogbank import` and `fogbank fogmap`: files of other programs as terms of a scene, and a map back.

use crate::cli::{FogmapArgs, ImportArgs};
use crate::commands::{Cause, Failure, print, read_scene, written};
use fogbank_core::image::map;
use fogbank_core::media::fogmap::Fogmap;
use fogbank_core::media::gaussians::BlobFrame;
use fogbank_core::scene::limits::COUNTS;
use fogbank_core::scene::{Blob, Gaussians, Scene, Spectrum, Term, Vec3};
use serde::Deserialize;
use std::io::{self, Write};
use std::path::Path;

/// Prints the scene that a file says.
///
/// # Errors
/// What is wrong with the file.
pub fn import(args: ImportArgs) -> Result<(), Failure> {
    let name = args.file.display().to_string();
    let ending = args.file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if ending != "csv" {
        let why = "only .csv files are taken: time, x, y, z, radius, extinction";
        return Err(Failure { cause: Cause::Usage, ..Failure::new(name, why) });
    }
    let bytes = std::fs::read(&args.file).map_err(|error| Failure::new(&name, error))?;
    let mut scene = Scene::default();
    scene.fog.terms = vec![Term::Gaussians(simulation(&bytes).map_err(|why| bad(&name, why))?)];
    checked(&name, &scene)?;
    print(&scene)
}

fn bad(name: &str, why: String) -> Failure {
    Failure { cause: Cause::Invalid, ..Failure::new(name, why) }
}

/// What is printed is a scene that the program takes.
fn checked(name: &str, scene: &Scene) -> Result<(), Failure> {
    let problems = scene.clone().check().err().unwrap_or_default();
    match problems.first() {
        None => Ok(()),
        Some(problem) => Err(bad(name, format!("{}: {}", problem.pointer, problem.detail))),
    }
}

/// A line of a simulation.
#[derive(Deserialize)]
struct Line {
    time: f64,
    x: f64,
    y: f64,
    z: f64,
    radius: f64,
    extinction: f64,
}

/// Blobs, frame by frame in the order of time. Where a frame has fewer than others its last ones have faded.
fn simulation(bytes: &[u8]) -> Result<Gaussians, String> {
    let mut frames: Vec<BlobFrame> = Vec::new();
    for line in csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes).deserialize() {
        let Line { time, x, y, z, radius, extinction } = line.map_err(|error| error.to_string())?;
        let extinction = Spectrum::Grey(extinction);
        let blob = Blob { center: Vec3([x, y, z]), radius, extinction };
        match frames.iter_mut().find(|frame| frame.time_s == time) {
            Some(frame) => frame.blobs.push(blob),
            None => frames.push(BlobFrame { time_s: time, blobs: vec![blob].into() }),
        }
        if frames.len() > COUNTS.frames {
            return Err(format!("more than {} times", COUNTS.frames));
        }
    }
    frames.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    let most = frames.iter().map(|frame| frame.blobs.len()).max().unwrap_or(0);
    if most.saturating_mul(frames.len()) > COUNTS.blobs {
        return Err(format!(
            "{most} blobs at {} times are more than {}",
            frames.len(),
            COUNTS.blobs
        ));
    }
    let mut faded: Vec<Blob> = Vec::new();
    for frame in &mut frames {
        let count = frame.blobs.len();
        let place = |i: usize| faded.get(i).copied().unwrap_or_default();
        frame
            .blobs
            .extend((count..most).map(|i| Blob { extinction: Spectrum::Grey(0.0), ..place(i) }));
        faded.clone_from(&frame.blobs);
    }
    match frames.len() {
        0 => Err("there is no line but the names".into()),
        1 => Ok(Gaussians { blobs: frames.remove(0).blobs, ..Gaussians::default() }),
        _ => Ok(Gaussians { frames: Some(frames), ..Gaussians::default() }),
    }
}

/// Prints an image as a fogmap, or writes a fogmap of a scene as an image.
///
/// # Errors
/// What is wrong with a file.
pub fn fogmap(args: FogmapArgs) -> Result<(), Failure> {
    match (args.image, args.export) {
        (Some(image), _) => print_map(&image),
        (None, Some(of)) => {
            let out = args.out.ok_or_else(|| Failure::new("--out", "a file is needed"))?;
            export_map(&of, &out)
        }
        (None, None) => {
            Err(Failure { cause: Cause::Usage, ..Failure::new("fogmap", "an image or --export") })
        }
    }
}

fn print_map(image: &Path) -> Result<(), Failure> {
    let name = image.display().to_string();
    let bytes = std::fs::read(image).map_err(|error| Failure::new(&name, error))?;
    let coefficients = map::read(&bytes, COUNTS.map_side).map_err(|why| bad(&name, why))?;
    print(&Term::Fogmap(Fogmap { coefficients: coefficients.into(), ..Fogmap::default() }))
}

/// `of`: a scene, and a term by its id or its place.
fn export_map(of: &[String], out: &Path) -> Result<(), Failure> {
    let [scene, term] = of else { return Err(Failure::new("--export", "a scene and a term")) };
    let terms = read_scene(scene)?.fog.terms;
    let by_id = terms.iter().find(|own| own.common().id == Some(term.as_str()));
    let found = by_id.or_else(|| terms.get(term.parse::<usize>().ok()?));
    let Some(Term::Fogmap(found)) = found else {
        return Err(bad(scene, format!("{term} is no fogmap of it")));
    };
    let file = map::write(&found.coefficients).map_err(|why| bad(scene, why))?;
    if out == Path::new("-") {
        return written(io::stdout().lock().write_all(&file));
    }
    std::fs::write(out, file).map_err(|error| Failure::new(out.display(), error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simulation_is_read_frame_by_frame() {
        let text = "time,x,y,z,radius,extinction\n1, 0,2,0, 0.6,0.3\n0, 0,1,0, 0.5,0.4\n0, 3,1,0, 0.5,0.4\n";
        let read = simulation(text.as_bytes()).unwrap();
        let frames = read.frames.unwrap();
        assert_eq!(frames.iter().map(|frame| frame.time_s).collect::<Vec<_>>(), [0.0, 1.0]);
        assert_eq!(frames[1].blobs.len(), 2);
        assert_eq!(frames[1].blobs[1].extinction, Spectrum::Grey(0.0));
        assert_eq!(frames[1].blobs[1].center, Vec3([3.0, 1.0, 0.0]), "it fades where it was");
    }

    #[test]
    fn one_time_is_no_simulation_and_nonsense_is_said() {
        let one = "time,x,y,z,radius,extinction\n0,0,1,0,0.5,0.4\n";
        assert_eq!(simulation(one.as_bytes()).unwrap().blobs.len(), 1);
        assert!(simulation(b"time,x,y,z,radius,extinction\n").is_err());
        assert!(simulation(b"time,x,y,z,radius,extinction\n0,0,1,0,half,0.4\n").is_err());
        assert!(simulation(b"x,y\n0,1\n").is_err());
    }
}
