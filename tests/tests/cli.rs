//! The command line: the same requests as over HTTP, and words that help when they fail.

use fogbank_tests::decode;
use fogbank_tests::selftest::allowed;
use fogbank_tests::server::{Server, command};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};

fn scene() -> Value {
    json!({
        "surfaces": [{ "shape": { "kind": "sphere", "center": [0, 1, 0], "radius": 1 } }],
        "lights": [{ "kind": "point", "position": [2, 3, 2] }],
        "fog": { "terms": [{ "kind": "homogeneous", "extinction": 0.05 }] },
    })
}

/// A file of this test's own.
fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("cli-{name}"))
}

fn scene_file(name: &str, scene: &Value) -> String {
    let path = file(name);
    std::fs::write(&path, scene.to_string()).unwrap();
    path.to_str().unwrap().to_owned()
}

fn run(arguments: &[&str]) -> Output {
    command(arguments).output().unwrap()
}

#[track_caller]
fn succeed(arguments: &[&str]) -> Vec<u8> {
    let output = run(arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments:?}: {error}");
    assert_eq!(error, "", "{arguments:?}");
    output.stdout
}

/// What it says on standard error, one line a reason, when it fails with this status.
#[track_caller]
fn fail(arguments: &[&str], status: i32) -> String {
    let output = run(arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {error}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    error
}

#[test]
fn render_writes_the_bytes_that_the_server_answers() {
    let server = Server::start();
    let scene_file = scene_file("render.json", &scene());
    for (ending, media_type, magic) in [
        ("png", "image/png", b"\x89PNG".as_slice()),
        ("jpg", "image/jpeg", b"\xff\xd8\xff"),
        ("jpeg", "image/jpeg", b"\xff\xd8\xff"),
        ("webp", "image/webp", b"RIFF"),
        ("exr", "image/x-exr", b"\x76\x2f\x31\x01"),
        ("npy", "application/x-npy", b"\x93NUMPY"),
    ] {
        let out = file(&format!("render.{ending}"));
        let out_name = out.to_str().unwrap();
        succeed(&["render", &scene_file, "-o", out_name, "--width", "24", "--height", "16"]);
        let written = std::fs::read(&out).unwrap();
        assert!(written.starts_with(magic), "{ending}");
        let body = json!({ "scene": scene(), "width": 24, "height": 16 });
        let answer = server.post_for("/v1/render", &body, media_type).expect_success();
        assert_eq!(written, answer.body, "{ending}");
    }
}

#[test]
fn every_option_of_render_is_that_of_the_request() {
    let server = Server::start();
    let scene_file = scene_file("options.json", &scene());
    let out = file("options.png");
    let arguments = [
        "render",
        &scene_file,
        "-o",
        out.to_str().unwrap(),
        "--width=20",
        "--height=12",
        "--quality=draft",
        "--layer=airlight",
        "--time=-2.5",
        "--samples=2",
        "--exposure-ev=-1",
        "--tonemap=reinhard",
    ];
    succeed(&arguments);
    let mut scene = scene();
    scene["time_s"] = json!(-2.5);
    let body = json!({ "scene": scene, "width": 20, "height": 12, "quality": "draft",
        "layer": "airlight", "samples": 2, "exposure_ev": -1, "tonemap": "reinhard" });
    let answer = server.post("/v1/render", &body).expect_success();
    assert_eq!(std::fs::read(&out).unwrap(), answer.body);
}

#[test]
fn compare_prints_what_the_server_answers_and_writes_its_image() {
    let server = Server::start();
    let scene_file = scene_file("compare.json", &scene());
    let out = file("compare.npy");
    let sides = ["--a=march", "--a-steps=7", "--b=sun2005", "--width=24", "--height=16"];
    let image = ["-o", out.to_str().unwrap()];
    let printed = succeed(&[&["compare", scene_file.as_str()][..], &sides, &image].concat());
    let printed: Value = serde_json::from_slice(&printed).unwrap();
    let body = json!({ "scene": scene(), "width": 24, "height": 16,
        "a": { "airlight": "march", "steps": 7 }, "b": { "airlight": "sun2005" } });
    let answered = server.post("/v1/compare", &body).expect_success().json();
    for member in ["a", "b", "bias", "median", "p95", "max", "flip", "mean_b"] {
        assert_eq!(printed[member], answered[member], "{member}");
    }
    let answer = server.post_for("/v1/compare", &body, "application/x-npy").expect_success();
    assert_eq!(std::fs::read(&out).unwrap(), answer.body);
}

#[test]
fn compare_names_the_option_at_fault() {
    let scene_file = scene_file("compare-fault.json", &scene());
    let error = fail(&["compare", &scene_file, "--a", "march"], 3);
    assert!(error.starts_with("fogbank: --a-steps: "), "{error}");
    let error = fail(&["compare", &scene_file, "--b-steps", "3"], 3);
    assert!(error.starts_with("fogbank: --b-steps: "), "{error}");
    fail(&["compare", &scene_file, "--a", "fog"], 2);
}

#[test]
fn without_a_size_a_picture_is_960_by_540_and_a_preset_needs_no_file() {
    let out = file("preset.npy");
    let out_name = out.to_str().unwrap();
    succeed(&["render", "preset:steaming-vessel", "-o", out_name, "--layer", "depth"]);
    let picture = decode::npy(&std::fs::read(&out).unwrap());
    assert_eq!((picture.width, picture.height, picture.channels), (960, 540, 1));
}

#[test]
fn options_come_from_the_environment_as_well() {
    let scene_file = scene_file("environment.json", &scene());
    let out = file("environment.npy");
    let mut command = command(&["render", &scene_file, "-o", out.to_str().unwrap()]);
    command.env("FOGBANK_WIDTH", "7").env("FOGBANK_HEIGHT", "5").env("FOGBANK_LAYER", "depth");
    assert!(command.status().unwrap().success());
    let picture = decode::npy(&std::fs::read(&out).unwrap());
    assert_eq!((picture.width, picture.height, picture.channels), (7, 5, 1));
}

#[test]
fn probe_prints_what_the_server_answers() {
    let server = Server::start();
    let scene_file = scene_file("probe.json", &scene());
    let ray = json!({ "origin": [0.5, 1, 8], "direction": [0, 0, -2] });
    let mut short = ray.clone();
    short["max_distance_m"] = json!(3.5);
    let arguments = ["probe", &scene_file, "--origin", "0.5,1,8", "--direction", "0,0,-2"];
    let with_end = [&arguments[..], &["--max-distance", "3.5"]].concat();
    for (ray, arguments) in [(ray, &arguments[..]), (short, &with_end)] {
        let printed: Value = serde_json::from_slice(&succeed(arguments)).unwrap();
        let body = json!({ "scene": scene(), "rays": [ray] });
        assert_eq!(printed, server.post("/v1/probe", &body).expect_success().json());
    }
}

#[test]
fn a_scene_comes_from_standard_input_as_well() {
    let mut command = command(&["probe", "-", "--origin", "0,1,8", "--direction", "0,0,-1"]);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(scene().to_string().as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let distance = printed["rays"][0]["hit"]["distance_m"].as_f64().unwrap();
    assert!((distance - 7.0).abs() < 1e-12, "{distance}");
}

#[test]
fn the_schema_is_a_json_schema_with_the_ranges() {
    let schema: Value = serde_json::from_slice(&succeed(&["schema"])).unwrap();
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    assert_eq!(schema["title"], "Scene");
    assert_eq!(schema["properties"]["far_m"]["minimum"], 0.001);
    assert_eq!(schema["properties"]["far_m"]["maximum"], 1e9);
    assert_eq!(schema["properties"]["far_m"]["default"], 10_000.0);
    assert_eq!(schema["$defs"]["Blob"]["properties"]["radius"]["minimum"], 1e-4);
    assert_eq!(schema["$defs"]["Vec3"]["items"]["maximum"], 1e9);
    assert_eq!(schema["additionalProperties"], false);
}

#[test]
fn what_is_wrong_with_a_scene_is_told_line_by_line() {
    let out = file("never.png");
    let out_name = out.to_str().unwrap();
    let bad = scene_file("bad.json", &json!({ "far_m": 0, "time_s": 1e12 }));
    let error = fail(&["render", &bad, "-o", out_name, "--width", "0"], 3);
    let lines: Vec<_> = error.lines().collect();
    assert_eq!(lines.len(), 3, "{error}");
    assert!(lines[0].starts_with("fogbank: --width: 0 is not between"), "{error}");
    assert!(lines[1].starts_with(&format!("fogbank: {bad}: /time_s: ")), "{error}");
    assert!(lines[2].starts_with(&format!("fogbank: {bad}: /far_m: ")), "{error}");
    let unknown = scene_file("unknown.json", &json!({ "fog": { "density": 1 } }));
    let error = fail(&["render", &unknown, "-o", out_name], 3);
    assert!(
        error.starts_with(&format!("fogbank: {unknown}: /fog/density: unknown key")),
        "{error}"
    );
    let no_json = file("no.json");
    std::fs::write(&no_json, "{ fog").unwrap();
    let error = fail(&["render", no_json.to_str().unwrap(), "-o", out_name], 3);
    assert!(error.contains("not JSON"), "{error}");
    assert!(!out.exists(), "a failed render leaves no file");
}

#[test]
fn wrong_arguments_are_refused_with_words_that_help() {
    let scene_file = scene_file("arguments.json", &scene());
    let out = file("arguments.png");
    let out_name = out.to_str().unwrap();
    for (arguments, words) in [
        (vec!["render", &scene_file], "--out"),
        (vec!["render", &scene_file, "-o", "fog.gif"], "png, jpg, jpeg, webp, exr, npy"),
        (vec!["render", &scene_file, "-o", out_name, "--layer", "fog"], "optical_depth"),
        (vec!["render", &scene_file, "-o", out_name, "--quality", "best"], "draft"),
        (vec!["render", &scene_file, "-o", out_name, "--width", "-1"], "-1"),
        (vec!["probe", &scene_file, "--origin", "0,0", "--direction", "0,0,1"], "x,y,z"),
        (vec!["render", &scene_file, "-o", "-"], "--format"),
        (vec!["serve", "--queue", "0"], "1 to 1024"),
        (vec!["--queue", "0"], "1 to 1024"),
        (vec!["serve", "--backend", "abacus"], "cpu"),
        (vec!["serve", "--deadline-s", "nan"], "0.001 to 86400"),
        (vec!["fly"], "fly"),
    ] {
        let error = fail(&arguments, 2);
        assert!(error.contains(words), "{arguments:?}: {error}");
    }
    for (arguments, words) in [
        (vec!["render", "/nothing.json", "-o", out_name], "/nothing.json: "),
        (vec!["render", "preset:fog", "-o", out_name], "street-thin"),
        (vec!["render", "street-thin", "-o", out_name], "preset:street-thin"),
        (vec!["serve", "--listen", "127.0.0.1:fog"], "127.0.0.1:fog"),
        (vec!["serve", "--listen", "127.0.0.1:0", "--data-dir", "/proc/fog"], "/proc/fog"),
    ] {
        let error = fail(&arguments, 1);
        assert!(error.starts_with("fogbank: ") && error.contains(words), "{arguments:?}: {error}");
    }
}

/// What would take minutes to render: whatever is refused is refused before that.
const SLOW: [&str; 4] = ["render", "preset:room-3008", "--airlight=reference", "-o"];

#[test]
fn a_file_that_cannot_be_written_is_refused_before_anything_is_rendered() {
    let folder = file("folder.png");
    std::fs::create_dir_all(&folder).unwrap();
    let folder = folder.to_str().unwrap();
    for (out, status) in [(folder, 1), ("/nowhere/fog.png", 1), ("/proc/fog.png", 1), ("f.gif", 2)]
    {
        let error = fail(&[&SLOW[..], &[out]].concat(), status);
        assert!(error.contains(out), "{error}");
    }
    let errors = ["compare", "preset:room-3008", "-o", "/nowhere/fog.npy"];
    assert!(fail(&errors, 1).contains("/nowhere/fog.npy"));
}

/// A scene's faults, a missing device and a deadline are told apart by a script.
#[test]
fn exit_codes_tell_failures_apart() {
    let out = file("codes.png");
    let out_name = out.to_str().unwrap();
    let error = fail(&[&SLOW[..], &[out_name, "--deadline-s=0.05"]].concat(), 5);
    assert!(error.contains("--deadline-s"), "{error}");
    let scene_file = scene_file("codes.json", &scene());
    let error = fail(&["probe", &scene_file, "--origin", "0,0,0", "--direction", "0,0,0"], 3);
    assert!(error.contains("--direction: "), "{error}");
    let mut no_driver = command(&["render", &scene_file, "-o", out_name, "--backend=gpu"]);
    no_driver.env("VK_DRIVER_FILES", "/nowhere.json").env("VK_ICD_FILENAMES", "/nowhere.json");
    let output = no_driver.output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(4), "{error}");
    assert!(error.contains("--backend gpu"), "{error}");
    assert!(!out.exists(), "a failed render leaves no file");
}

#[test]
fn a_failed_render_leaves_an_older_file_as_it_was() {
    let out = file("older.png");
    std::fs::write(&out, "older").unwrap();
    fail(&[&SLOW[..], &[out.to_str().unwrap(), "--deadline-s=0.05"]].concat(), 5);
    assert_eq!(std::fs::read(&out).unwrap(), b"older");
}

#[test]
fn airlight_is_that_of_the_scene_or_of_the_option() {
    let picture = |scene: &Value, arguments: &[&str]| {
        let scene_file = scene_file("airlight.json", scene);
        let size = ["render", &scene_file, "-o", "-", "--format=npy", "--width=9", "--height=7"];
        succeed(&[&size[..], arguments].concat())
    };
    let mut none = scene();
    none["fog"]["airlight"] = json!("none");
    let by_option = picture(&scene(), &["--airlight=none"]);
    assert!(by_option == picture(&none, &[]) && by_option != picture(&scene(), &[]));
    let out = file("airlight.png");
    let blobs = ["render", "preset:room-3008", "--airlight=sun2005", "-o", out.to_str().unwrap()];
    let error = fail(&blobs, 3);
    assert!(error.starts_with("fogbank: --airlight: "), "{error}");
}

#[test]
fn a_picture_goes_to_standard_output_as_well() {
    let scene_file = scene_file("standard.json", &scene());
    let out = file("standard.png");
    let size = ["--width=24", "--height=16"];
    succeed(&[&["render", &scene_file, "-o", out.to_str().unwrap()][..], &size].concat());
    let printed = [&["render", &scene_file, "-o", "-", "--format=png"][..], &size].concat();
    assert_eq!(succeed(&printed), std::fs::read(&out).unwrap());
}

#[test]
fn help_lists_what_a_choice_may_be() {
    for (command, words) in [
        (
            "render",
            ["beauty", "optical_depth", "draft", "reinhard", "fogshop2007", "webp"].as_slice(),
        ),
        ("compare", &["march", "reference", "sun2005"]),
        ("serve", &["auto", "cpu", "gpu"]),
    ] {
        let help = String::from_utf8(succeed(&[command, "--help"])).unwrap();
        let listed =
            |word: &&str| help.contains(&format!("- {word}")) || help.contains(&format!("{word},"));
        let missing: Vec<_> = words.iter().filter(|word| !listed(word)).collect();
        assert!(missing.is_empty(), "{command}: {missing:?} in {help}");
    }
}

/// The environment of a server does not get in the way of a command.
#[test]
fn options_without_a_command_are_those_of_serve() {
    let mut schema = command(&["schema"]);
    let output = schema.env("FOGBANK_LISTEN", "127.0.0.1:0").env("FOGBANK_QUEUE", "2").output();
    assert!(output.unwrap().status.success());
    let mut child = command(&["--listen", "127.0.0.1:0"]).stdout(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(line.starts_with("listening on http://127.0.0.1:"), "{line}");
}

/// A driver in software will do, and its picture looks like the CPU's.
#[test]
fn render_takes_the_backend_it_is_told() {
    let shown = ["cpu", "gpu"].map(|backend| {
        let out = file(&format!("on-{backend}.png"));
        let backend = format!("--backend={backend}");
        let out_name = out.to_str().unwrap();
        let size = ["--width=120", "--height=90", "--quality=draft"];
        let preset = ["render", "preset:street-thin", "-o", out_name, &backend];
        succeed(&[&preset[..], &size].concat());
        image::open(&out).unwrap().to_rgb8()
    });
    let [cpu, gpu] = shown;
    assert_ne!(cpu, gpu, "the same maths in another order differ in some last bits");
    let off = cpu.iter().zip(gpu.iter()).filter(|(a, b)| a.abs_diff(**b) > 8).count();
    assert!(50 * off < cpu.len(), "{off} of {} levels differ", cpu.len());
}

#[test]
fn backends_are_listed_with_their_differences() {
    // Drivers may say what they like on standard error.
    let output = run(&["backends"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let listed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let backends = listed.as_array().unwrap();
    let names: Vec<_> = backends.iter().map(|b| b["backend"].as_str().unwrap()).collect();
    assert!(names.contains(&"cpu") && names.contains(&"gpu"), "{names:?}");
    for backend in backends {
        let preset = &backend["presets"][0];
        assert!(preset["ms"].as_f64().unwrap() > 0.0);
        let layers = preset["layers"].as_array().unwrap();
        assert_eq!(layers.len(), 7, "{preset}");
        for entry in layers.iter().chain(backend["models"].as_array().unwrap()) {
            assert!(entry["largest_difference"].as_f64().unwrap() < allowed(entry), "{entry}");
        }
    }
}

#[test]
fn serve_says_where_it_listens_and_nothing_else() {
    let server = Server::start();
    let port: u16 = server.address.strip_prefix("127.0.0.1:").unwrap().parse().unwrap();
    assert_ne!(port, 0);
    assert_eq!(server.line, format!("listening on http://127.0.0.1:{port}\n"));
    server.expect_healthy();
    server.get("/nothing").expect_problem(404);
    let taken = fail(&["serve", "--listen", &server.address], 1);
    assert!(taken.contains(&server.address), "{taken}");
    assert_eq!(server.stop(), "");
}

/// An HDR file of one colour, 1 W/(m² sr), of so many pixels as it says.
fn hdr(says: &str, pixels: usize) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{says}\n").into_bytes();
    bytes.extend([128, 128, 128, 129].repeat(pixels));
    bytes
}

/// A sky's picture is read beside the scene; what is no picture, or none that fits, is said with its place.
#[test]
fn a_sky_may_be_a_picture_in_a_file() {
    let with = |name: &str, image: &str| {
        let radiance = json!({ "kind": "image", "file": image });
        let scene = json!({ "lights": [{ "kind": "environment", "radiance": radiance }] });
        scene_file(name, &scene)
    };
    std::fs::write(file("sky.hdr"), hdr("-Y 4 +X 8", 32)).unwrap();
    let scene = with("sky.json", "cli-sky.hdr");
    let answer = succeed(&["probe", &scene, "--origin", "0,0,0", "--direction", "0,0.6,0.8"]);
    let answer: Value = serde_json::from_slice(&answer).unwrap();
    assert_eq!(answer["rays"][0]["radiance"], json!([1.0, 1.0, 1.0]), "{answer}");
    std::fs::write(file("huge.hdr"), hdr("-Y 65535 +X 65535", 1)).unwrap();
    std::fs::write(file("short.hdr"), hdr("-Y 4 +X 8", 1)).unwrap();
    for (image, words) in [
        ("cli-huge.hdr", "65535×65535"),
        ("cli-short.hdr", "cli-short.hdr"),
        ("cli-nowhere.exr", "No such file"),
        ("cli-sky.json", "neither an EXR nor an HDR"),
    ] {
        let scene = with("wrong-sky.json", image);
        let error = fail(&["probe", &scene, "--origin", "0,0,0", "--direction", "0,0,1"], 3);
        assert!(error.contains("/lights/0/radiance/file") && error.contains(words), "{error}");
    }
}
