//! `fogbank render`, `probe`, `compare`, `backends` and `schema`: the same requests as over HTTP, without a server.

use crate::cli::{Backend, CompareArgs, Output, ProbeArgs, RenderArgs};
use crate::routes::probe::ProbeAnswer;
use fogbank_core::compare::{self, CompareRequest, Side};
use fogbank_core::gpu::{self, Gpu};
use fogbank_core::image::{EncodeError, Format, encode, encode_errors};
use fogbank_core::request::{Options, ProbeRequest, RayRequest, RenderRequest};
use fogbank_core::scene::limits::COUNTS;
use fogbank_core::scene::{self, Code, Environment, Light, Problem, Radiance, ReadError, Scene};
use fogbank_core::sky::RadianceMap;
use fogbank_core::{Interrupted, Progress, Renderer, presets};
use indicatif::{ProgressBar, ProgressStyle};
use schemars::schema_for;
use serde::Serialize;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Why a command failed.
#[derive(Debug)]
pub struct Failure {
    /// One line a reason.
    pub lines: Vec<String>,
    /// What kind of reason.
    pub cause: Cause,
}

/// What a script can tell failures apart by: the exit codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// A file, an address, standard output.
    Other = 1,
    /// The arguments, as clap has it.
    Usage = 2,
    /// The scene, or the value of an option.
    Invalid = 3,
    /// There is no such device.
    Device = 4,
    /// It took too long.
    Deadline = 5,
}

impl Failure {
    /// A single reason.
    pub fn new(what: impl std::fmt::Display, why: impl std::fmt::Display) -> Self {
        Self { lines: vec![format!("{what}: {why}")], cause: Cause::Other }
    }
}

impl From<Interrupted> for Failure {
    fn from(_: Interrupted) -> Self {
        Self { cause: Cause::Deadline, ..Self::new("--deadline-s", "the time is over") }
    }
}

/// Renders a scene into a file.
///
/// # Errors
/// What is wrong with the scene, an option or the file.
pub fn render(args: RenderArgs) -> Result<(), Failure> {
    let output = place(args.out, args.format)?;
    let mut scene = read_scene(&args.scene)?;
    scene.time_s = args.time.unwrap_or(scene.time_s);
    scene.fog.airlight = args.airlight.unwrap_or(scene.fog.airlight);
    let request = RenderRequest {
        scene,
        width: args.width,
        height: args.height,
        quality: args.quality,
        layer: args.layer,
        samples: args.samples,
        exposure_ev: args.exposure_ev,
        tonemap: args.tonemap,
        options: Options {
            lod_error: args.lod_error,
            far_cut: args.far_cut,
            fog_scale: args.fog_scale,
            per_vertex: args.per_vertex,
        },
    };
    let checked = request.check().map_err(|mut problems| {
        if args.airlight.is_some() {
            let of_option = problems.iter_mut().filter(|p| p.pointer == "/scene/fog/airlight");
            of_option.for_each(|problem| problem.pointer = "/airlight".into());
        }
        invalid(&args.scene, problems)
    });
    let (scene, mut view) = checked?;
    view = view.for_format(output.format);
    let renderer = open(args.backend)?;
    let frame = watched(args.deadline_s, |progress| renderer.render(&scene, &view, progress))?;
    write(&output, encode(&frame, &view, output.format))
}

fn open(backend: Backend) -> Result<Renderer, Failure> {
    let failed =
        |failure| Failure { cause: Cause::Device, ..Failure::new("--backend gpu", failure) };
    Renderer::open(backend.into()).map_err(failed)
}

/// Where a picture goes, checked before it is made.
fn place(path: PathBuf, format: Option<Format>) -> Result<Output, Failure> {
    let name = path.display().to_string();
    let output = Output::new(path, format).map_err(|why| Failure {
        cause: Cause::Usage,
        ..Failure::new(format_args!("--out: {name}"), why)
    })?;
    output.check().map_err(|error| Failure::new(&name, error))?;
    Ok(output)
}

fn write(output: &Output, file: Result<Vec<u8>, EncodeError>) -> Result<(), Failure> {
    let name = output.path.display();
    let file = file.map_err(|error| Failure::new(&name, error))?;
    if output.is_standard() {
        return written(io::stdout().lock().write_all(&file));
    }
    std::fs::write(&output.path, file).map_err(|error| Failure::new(&name, error))
}

/// Prints the numbers along one ray, which are always those of the f64 maths.
///
/// # Errors
/// What is wrong with the scene or an option.
pub fn probe(args: ProbeArgs) -> Result<(), Failure> {
    let ray = RayRequest {
        origin: args.origin,
        direction: args.direction,
        max_distance_m: args.max_distance,
    };
    let request = ProbeRequest { scene: read_scene(&args.scene)?, rays: vec![ray] };
    let (scene, rays) = request.check().map_err(|problems| invalid(&args.scene, problems))?;
    let renderer = Renderer::default();
    let rays = watched(None, |progress| renderer.probe(&scene, &rays, progress))?;
    print(&ProbeAnswer { rays })
}

/// Prints how far one airlight estimator is from another, and writes an image of the errors if asked.
///
/// # Errors
/// What is wrong with the scene, an option or the file.
pub fn compare(args: CompareArgs) -> Result<(), Failure> {
    let CompareArgs { width, height, out, deadline_s, .. } = args;
    let output = out.map(|path| place(path, None)).transpose()?;
    let request = CompareRequest {
        scene: read_scene(&args.scene)?,
        width,
        height,
        a: Side { airlight: args.a, steps: args.a_steps },
        b: Side { airlight: args.b, steps: args.b_steps },
    };
    let (scene, pair) = request.check().map_err(|problems| invalid(&args.scene, problems))?;
    let renderer = open(args.backend)?;
    let compared =
        watched(deadline_s, |progress| compare::run(&renderer, &scene, &pair, progress))?;
    if let Some(output) = output {
        write(&output, encode_errors(&compared.errors, output.format))?;
    }
    print(&compared.comparison)
}

/// Prints every backend of this machine: its differences from the f64 maths, model by model, and from
/// the CPU's pictures, layer by layer; and what a preset takes on it.
///
/// # Errors
/// When they cannot be written.
pub fn backends() -> Result<(), Failure> {
    let mut reports = watched(None, |progress| Renderer::default().selftest(progress))?;
    for adapter in gpu::device::adapters() {
        let Ok(renderer) = Renderer::on(move || Gpu::of(&adapter)) else { continue };
        reports.extend(watched(None, |progress| renderer.selftest(progress))?.pop());
    }
    print(&reports)
}

/// Prints the JSON schema of a scene.
///
/// # Errors
/// When it cannot be written.
pub fn schema() -> Result<(), Failure> {
    print(&schema_for!(Scene))
}

/// Writes a value as JSON to standard output.
///
/// # Errors
/// When it cannot be written.
pub fn print(value: &impl Serialize) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    let json = serde_json::to_writer_pretty(&mut out, value).map_err(io::Error::from);
    written(json.and_then(|()| writeln!(out)))
}

/// What came of writing to standard output.
///
/// # Errors
/// Why it failed, but for a reader who has had enough.
pub fn written(result: io::Result<()>) -> Result<(), Failure> {
    match result {
        // Whoever read it, `head` perhaps, has had enough.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => result.map_err(|error| Failure::new("standard output", error)),
    }
}

/// A scene by the name of a file, `-` for standard input, or `preset:NAME`.
///
/// # Errors
/// What is wrong with the file.
pub fn read_scene(name: &str) -> Result<Scene, Failure> {
    if let Some(preset) = name.strip_prefix("preset:") {
        let mut all = presets::all();
        if let Some(i) = all.iter().position(|known| known.name == preset) {
            return Ok(all.swap_remove(i).scene);
        }
        let names: Vec<_> = all.iter().map(|known| known.name).collect();
        return Err(Failure::new(name, format!("the presets are {}", names.join(", "))));
    }
    let mut json = Vec::new();
    let read = match name {
        "-" => io::stdin().lock().read_to_end(&mut json).map(drop),
        file => std::fs::read(file).map(|bytes| json = bytes),
    };
    read.map_err(|error| {
        let is_preset = presets::all().iter().any(|preset| preset.name == name);
        let hint = if is_preset { format!("; the preset is preset:{name}") } else { String::new() };
        Failure::new(name, format_args!("{error}{hint}"))
    })?;
    let mut scene: Scene = scene::read(&json).map_err(|error| match error {
        ReadError::NotJson(_) => Failure { cause: Cause::Invalid, ..Failure::new(name, error) },
        ReadError::Invalid(problems) => invalid_scene(name, problems),
    })?;
    let beside = Path::new(name).parent().unwrap_or(Path::new(""));
    read_skies(&mut scene, beside).map_err(|problem| invalid_scene(name, vec![problem]))?;
    Ok(scene)
}

/// Reads the pictures of skies, which a scene names relative to its own file.
fn read_skies(scene: &mut Scene, beside: &Path) -> Result<(), Problem> {
    for (i, light) in scene.lights.iter_mut().enumerate() {
        let Light::Environment(Environment { radiance: Radiance::ImageSky(sky), .. }) = light
        else {
            continue;
        };
        let file = beside.join(&sky.file);
        let read = sky_file(&file).and_then(|bytes| RadianceMap::read(&bytes));
        sky.show(read.map_err(|why| {
            let detail = format!("{}: {why}", file.display());
            let pointer = format!("/lights/{i}/radiance/file");
            Problem { code: Code::Conflict, pointer, detail }
        })?);
    }
    Ok(())
}

/// The bytes of such a file, of which no more than any sky has are read.
fn sky_file(file: &Path) -> Result<Vec<u8>, String> {
    /// Four floats a pixel.
    const MOST: u64 = 16 * COUNTS.sky_pixels as u64 + (1 << 20);
    let mut bytes = Vec::new();
    let read = File::open(file).and_then(|file| file.take(MOST).read_to_end(&mut bytes));
    read.map_err(|error| error.to_string())?;
    Ok(bytes)
}

fn invalid_scene(name: &str, problems: Vec<Problem>) -> Failure {
    let lines =
        problems.into_iter().map(|Problem { pointer, detail, .. }| match pointer.as_str() {
            "" => format!("{name}: {detail}"),
            _ => format!("{name}: {pointer}: {detail}"),
        });
    Failure { lines: lines.collect(), cause: Cause::Invalid }
}

/// What a check of the whole request found: pointers into the file, or the option at fault.
fn invalid(name: &str, problems: Vec<Problem>) -> Failure {
    let line = |Problem { pointer, detail, .. }: Problem| {
        if pointer.is_empty() {
            return format!("{name}: {detail}");
        }
        if let Some(pointer) = pointer.strip_prefix("/scene") {
            return format!("{name}: {pointer}: {detail}");
        }
        // An option is named as its member, but for the parts of a ray and of a comparison's sides.
        let member = pointer.trim_start_matches("/rays/0").trim_start_matches('/');
        let member = match member.split_once('/') {
            Some((side, "steps")) => format!("{side}_steps"),
            Some((first, _)) => first.to_owned(),
            None => member.trim_end_matches("_m").to_owned(),
        };
        format!("--{}: {detail}", member.replace('_', "-"))
    };
    Failure { lines: problems.into_iter().map(line).collect(), cause: Cause::Invalid }
}

/// Runs `work`, with a progress bar on a terminal's standard error when it takes long.
fn watched<T: Send>(
    deadline_s: Option<f64>,
    work: impl FnOnce(&Progress) -> Result<T, Interrupted> + Send,
) -> Result<T, Interrupted> {
    const PATIENCE: Duration = Duration::from_secs(1);
    const TICK: Duration = Duration::from_millis(100);
    const STEPS: f64 = 1000.0;
    let deadline = deadline_s.map(|seconds| Instant::now() + Duration::from_secs_f64(seconds));
    let progress = deadline.map(Progress::until).unwrap_or_default();
    std::thread::scope(|scope| {
        let (finished, end) = std::sync::mpsc::channel::<()>();
        scope.spawn({
            let progress = &progress;
            move || {
                if end.recv_timeout(PATIENCE) != Err(std::sync::mpsc::RecvTimeoutError::Timeout) {
                    return;
                }
                let bar = ProgressBar::new(STEPS as u64).with_style(style());
                while end.recv_timeout(TICK) == Err(std::sync::mpsc::RecvTimeoutError::Timeout) {
                    bar.set_position((progress.fraction() * STEPS) as u64);
                }
                bar.finish_and_clear();
            }
        });
        let result = work(&progress);
        drop(finished);
        result
    })
}

fn style() -> ProgressStyle {
    let template = "{wide_bar} {percent:>3} % {elapsed} ({eta} left)";
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

#[cfg(test)]
mod tests {
    use super::*;
    use fogbank_core::scene::Code;

    fn lines(pointer: &str) -> Vec<String> {
        let (pointer, code) = (pointer.into(), Code::OutOfRange);
        let problem = Problem { pointer, code, detail: "no".into() };
        invalid("a.json", vec![problem]).lines
    }

    #[test]
    fn a_failure_names_the_place_in_the_file_or_the_option() {
        assert_eq!(lines("/scene/lights/0/id"), ["a.json: /lights/0/id: no"]);
        assert_eq!(lines(""), ["a.json: no"]);
        assert_eq!(lines("/width"), ["--width: no"]);
        assert_eq!(lines("/exposure_ev"), ["--exposure-ev: no"]);
        assert_eq!(lines("/rays/0/direction/1"), ["--direction: no"]);
        assert_eq!(lines("/rays/0/max_distance_m"), ["--max-distance: no"]);
        assert_eq!(lines("/a/airlight"), ["--a: no"]);
        assert_eq!(lines("/b/steps"), ["--b-steps: no"]);
    }

    #[test]
    fn an_unknown_preset_lists_the_known_ones() {
        let failure = read_scene("preset:nothing").unwrap_err();
        assert!(failure.lines[0].starts_with("preset:nothing: the presets are "));
    }
}
