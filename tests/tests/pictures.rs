//! What a picture shows, and that every field of a scene shows in it.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test stops where it fails, and says what it measured"
)]

use fogbank_core::image::{Format, encode, encode_png16};
use fogbank_core::request::{Layer, Quality, Tonemap, View};
use fogbank_core::scene::{Camera, CheckedScene, Scene, read};
use fogbank_core::{Frame, Interrupted, Progress, Renderer};
use fogbank_tests::fields::{self, Field};
use fogbank_tests::scenes::*;
use serde_json::{Value, json};
use std::path::PathBuf;

/// A scene in which every field of every kind takes part.
fn stage() -> Value {
    json!({
        "camera": { "position": [0.5, 1.5, 7], "target": [0, 0.5, 0], "up": [0, 1, 0],
                    "projection": { "kind": "perspective", "vertical_fov_deg": 45 } },
        "background": [0.05, 0.08, 0.1],
        "surfaces": surfaces(),
        "lights": [
            { "kind": "point", "position": [-1, 2, 2], "intensity": [40, 30, 20], "shadows": false },
            { "kind": "point", "position": [2, 1, 1], "intensity": [5, 10, 20], "shadows": false },
        ],
        "fog": {
            "albedo": [0.9, 0.8, 0.7], "ambient": [0.2, 0.25, 0.3],
            "terms": [
                { "kind": "homogeneous", "extinction": 0.03 },
                { "kind": "gaussians", "blobs": [
                    { "center": [1, 0, 2], "radius": 1.2, "extinction": 0.4 },
                    { "center": [-2, 1, 0], "radius": 0.8, "extinction": 0.6 } ] },
            ],
        },
        "far_m": 60,
    })
}

fn beauty(width: u32, height: u32) -> View {
    view(width, height, Layer::Beauty, Quality::Full)
}

fn picture(json: &Value) -> Vec<f32> {
    render(&scene(json), &beauty(32, 24)).pixels
}

/// Fields that change no picture, and why.
const INERT: [(&str, &str); 13] = [
    ("/$schema", "for editors"),
    ("/surfaces/*/id", "a name"),
    ("/lights/*(point)/id", "a name"),
    ("/lights/*(sun)/id", "a name"),
    ("/lights/*(spot)/id", "a name"),
    ("/lights/*(environment)/id", "a name"),
    ("/fog/terms/*(homogeneous)/id", "a name"),
    ("/fog/terms/*(gaussians)/id", "a name"),
    ("/fog/terms/*(functions)/id", "a name"),
    ("/fog/terms/*(fogmap)/id", "a name"),
    ("/fog/terms/*(emitter)/id", "a name"),
    ("/fog/surface_lighting=auto", "chooses `attenuated`, for want of another"),
    ("/fog/surface_lighting=attenuated", "what `auto` chooses, for want of another"),
];

/// What a morph turns into has these in common with what it comes from: any other value is refused.
const IN_COMMON: [&str; 4] = [
    "/fog/terms/*(functions)/members/*(polynomial)/morph/to/repeat",
    "/fog/terms/*(functions)/members/*(equipotential)/morph/to/object=point",
    "/fog/terms/*(functions)/members/*(equipotential)/morph/to/object=line",
    "/fog/terms/*(functions)/members/*(equipotential)/morph/to/object=sphere",
];

/// Only the command line reads a sky from a file, where its own tests do.
const FILES: [&str; 2] =
    ["/lights/*(environment)/radiance=image", "/lights/*(environment)/radiance(image)/file"];

/// Scenes that together hold every field of every kind, written out.
fn stages() -> Vec<Value> {
    let mut near = stage();
    for list in ["/surfaces", "/lights", "/fog/terms"] {
        near.pointer_mut(list).unwrap()[0]["id"] = json!("name");
    }
    near["fog"]["terms"].as_array_mut().unwrap().extend([
        json!({ "kind": "homogeneous", "visibility_m": 500, "id": "haze" }),
        json!({ "kind": "gaussians", "id": "nothing" }),
    ]);
    let mut parallel = stage();
    // Of an upright vector another height would be but another length.
    parallel["camera"]["up"] = json!([0.2, 1, 0.1]);
    parallel["camera"]["projection"] = json!({ "kind": "orthographic", "height_m": 6 });
    parallel["fog"]["phase"] = json!({ "kind": "henyey_greenstein", "g": 0.4 });
    let mut even = edited(&stage(), "/fog/terms/1", &json!({ "kind": "homogeneous" }));
    even["fog"]["airlight"] = json!("none");
    even["fog"]["surface_lighting"] = json!("attenuated");
    let (mut slab, mut thinning) = (stage(), stage());
    for term in 0..2 {
        slab["fog"]["terms"][term]["phase"] = json!({ "kind": "isotropic" });
    }
    slab["fog"]["terms"][0]["vertical"] = json!({ "kind": "slab", "min_m": -0.5, "max_m": 1.5 });
    thinning["fog"]["terms"][0]["vertical"] = json!({ "kind": "exponential", "base_m": 0.5 });
    let own = |g: f64| json!({ "kind": "henyey_greenstein", "g": g });
    let mut smoke = stage();
    for (term, albedo) in [(0, [0.9, 0.5, 0.2]), (1, [0.3, 0.5, 0.8])] {
        smoke["fog"]["terms"][term]["albedo"] = json!(albedo);
        smoke["fog"]["terms"][term]["phase"] = own(0.5);
    }
    smoke["fog"]["terms"][0]["extinction"] = json!([0.02, 0.03, 0.05]);
    smoke["fog"]["terms"][1]["blobs"][0]["extinction"] = json!([0.3, 0.4, 0.6]);
    let complete = |scene: Value| {
        let scene: Scene = read(scene.to_string().as_bytes()).expect("a scene");
        serde_json::to_value(scene).unwrap()
    };
    let mut keyed = moving();
    keyed["fog"]["wind"] = json!({ "keys": [
        { "time_s": 0.5, "velocity": [0.2, 0.1, 0.3] }, { "time_s": 2.5, "velocity": [-0.3, 0.2, 0.1] } ] });
    keyed["fog"]["terms"][2]["deconstruct"] = json!(false);
    let mut plain = stage();
    let isotropic = json!({ "kind": "isotropic" });
    plain["fog"]["terms"] = json!([
        { "kind": "functions", "id": "veil", "scale": 0.2, "phase": isotropic, "members": [
            { "kind": "cosine", "amplitude": 0.3, "wave_vector": [0, 0, 0] } ] },
        { "kind": "fogmap", "id": "map", "scale": 0.3, "phase": isotropic },
        { "kind": "emitter", "id": "plume", "rate_hz": 2, "extinction": 0.4, "phase": isotropic },
    ]);
    // Most of what moves shows in the veil already, which takes no time.
    keyed["fog"]["airlight"] = json!("none");
    let mut stages = vec![
        near,
        parallel,
        even,
        slab,
        thinning,
        smoke,
        plain,
        keyed,
        sunny(),
        moving(),
        spotted(),
    ];
    stages.extend(skies());
    stages.into_iter().map(complete).collect()
}

/// Under a sky of each kind.
fn skies() -> [Value; 3] {
    [
        json!({ "kind": "uniform" }),
        json!({ "kind": "gradient" }),
        json!({ "kind": "spherical_harmonics", "coefficients": [
            [3, 3, 3], [0.3, 0.2, 0.1], [0.1, 0.2, 0.3], [0.2, 0.1, 0.2]] }),
    ]
    .map(|radiance| {
        let mut scene = stage();
        scene["lights"] = json!([{ "kind": "environment", "id": "sky", "radiance": radiance }]);
        scene["fog"]["airlight"] = json!("none");
        scene
    })
}

/// By daylight, in fog that is made irregular.
fn sunny() -> Value {
    let mut scene = stage();
    scene["time_s"] = json!(0.7);
    scene["lights"] = json!([{ "kind": "sun", "id": "sun", "direction": [0.5, -1, -0.3], "irradiance": [3, 2.8, 2.5] }]);
    scene["fog"]["noise"] =
        json!({ "strength": 0.6, "scale_m": 3, "drift": [0.4, 0.2, 0.3], "seed": 5 });
    scene
}

/// A cone of light that is scattered more than once.
fn spotted() -> Value {
    let mut scene = stage();
    scene["lights"] = json!([{ "kind": "spot", "id": "beam", "position": [1, 2.5, 2], "direction": [-0.3, -1, -0.4],
        "inner_angle_deg": 15, "outer_angle_deg": 50, "intensity": [40, 30, 20] }]);
    scene["fog"]["phase"] = json!({ "kind": "henyey_greenstein", "g": 0.5 });
    scene["fog"]["multiple_scattering"] =
        json!({ "octaves": 2, "attenuation": 0.5, "contribution": 0.4, "phase": 0.6 });
    scene
}

/// Everything that changes with time, in a wind.
fn moving() -> Value {
    let mut scene = stage();
    scene["time_s"] = json!(1.7);
    scene["fog"]["wind"] = json!({ "velocity": [0.3, 0.1, 0.2] });
    let own = json!({ "kind": "henyey_greenstein", "g": 0.3 });
    let object = |kind: &str, place: &str, at: [f64; 3]| {
        let mut object = json!({ "kind": kind });
        object[place] = json!(at);
        match kind {
            "line" => object["direction"] = json!([1, 0.2, 0.3]),
            "sphere" => object["radius"] = json!(0.7),
            _ => {}
        }
        object
    };
    let around = |kind: &str, place: &str| {
        json!({ "kind": "equipotential", "object": object(kind, place, [0.5, 1.0, 0.3]), "strength": 0.3,
            "morph": { "period_s": 5, "to": { "strength": 0.5, "c": 1.2, "d": 3,
                "object": object(kind, place, [1.0, 0.6, 0.0]) } } })
    };
    let polynomial = |repeat: bool| {
        let monomials = |c: f64| json!([{ "powers": [1, 2, 1], "coefficient": c }, { "powers": [0, 1, 0], "coefficient": 0.2 }]);
        json!({ "kind": "polynomial", "repeat": repeat, "period_m": [3, 2, 4], "monomials": monomials(0.6),
            "morph": { "period_s": 7, "to": { "repeat": repeat, "period_m": [4, 3, 3], "monomials": monomials(0.3) } } })
    };
    let members = json!([
        { "kind": "cosine", "amplitude": 0.5, "wave_vector": [0, 0, 0] },
        { "kind": "cosine", "amplitude": 0.1, "wave_vector": [0.5, 2, 1], "phase_rad": 0.3,
          "morph": { "period_s": 6, "to": { "amplitude": 0.2, "wave_vector": [1, 1, 0.4], "phase_rad": 1 } } },
        polynomial(true), polynomial(false),
        around("point", "position"), around("line", "position"), around("sphere", "center"),
        // What morphs must stay of one kind; these need not.
        { "kind": "polynomial", "repeat": false, "period_m": [3, null, null], "monomials": [{ "powers": [1, 0, 0], "coefficient": 0.2 }] },
        { "kind": "equipotential", "strength": 0.2, "object": object("point", "position", [0.2, 0.7, 0.9]) },
        { "kind": "equipotential", "strength": 0.1, "object": object("sphere", "center", [0.4, 0.5, 0.9]) },
    ]);
    let slab = json!({ "kind": "slab", "min_m": -0.5, "max_m": 1.5 });
    scene["fog"]["terms"] = json!([
        { "kind": "homogeneous", "extinction": 0.05, "vertical": slab },
        { "kind": "functions", "scale": [0.2, 0.25, 0.3], "members": members, "albedo": [0.9, 0.8, 0.5], "phase": own },
        { "kind": "fogmap", "degree": 1, "origin": [-3, -3], "cell_m": 1.2, "scale": 0.4, "levels": 2, "mu": 0.6,
          "coefficients": [[0.2, 0.9, 0.4], [0.7, 0.1, 0.6], [0.3, 0.8, 0.5]], "albedo": [0.5, 0.8, 0.9], "phase": own,
          "vertical": { "kind": "exponential", "base_m": 0.3, "falloff_per_m": 0.6 } },
        { "kind": "fogmap", "degree": 2, "origin": [-3, -3], "cell_m": 1.5, "scale": [0.2, 0.3, 0.4],
          "coefficients": [[0.2, 0.9], [0.7, 0.1]], "vertical": slab },
        { "kind": "gaussians", "wind_response": 0.8, "draw": "slab", "blobs": [
            { "center": [1, 0, 2], "radius": 1.2, "extinction": 0.4 } ] },
        { "kind": "gaussians", "frames": [
            { "time_s": 0.4, "blobs": [{ "center": [0, 1, 2], "radius": 0.8, "extinction": [0.4, 0.5, 0.6] }] },
            { "time_s": 3.1, "blobs": [{ "center": [1, 1.5, 1], "radius": 1, "extinction": 0.3 }] } ] },
        { "kind": "emitter", "position": [-1, 0, 1], "rate_hz": 3, "velocity": [0.2, 0.7, 0.1], "spread_deg": 20,
          "acceleration": [0.1, 0.2, 0], "lifetime_s": 2, "radius": 0.5, "growth": 0.8, "extinction": [0.5, 0.6, 0.7],
          "wind_response": 0.7, "albedo": [0.4, 0.6, 0.8], "phase": own, "draw": "slab" },
    ]);
    scene
}

/// Sets what a pointer names, making the last member where there is none.
fn edited(scene: &Value, pointer: &str, value: &Value) -> Value {
    let mut scene = scene.clone();
    let (parent, name) = pointer.rsplit_once('/').unwrap();
    let parent = scene.pointer_mut(parent).unwrap_or_else(|| panic!("nothing at {pointer}"));
    match name.parse::<usize>() {
        Ok(place) if parent.is_array() => parent[place] = value.clone(),
        _ => parent[name] = value.clone(),
    }
    scene
}

/// The picture of a scene after the change, where that is valid.
fn picture_of(scene: &Value) -> Option<Vec<f32>> {
    let scene: Scene = read(scene.to_string().as_bytes()).ok()?;
    Some(render(&scene.check().ok()?, &beauty(32, 24)).pixels)
}

/// Whether some change of the field, somewhere in the stages, changes the picture.
fn shows(field: &Field, stages: &[(Value, Vec<f32>)]) -> bool {
    if IN_COMMON.iter().chain(&FILES).any(|name| *name == field.name()) {
        return true;
    }
    let mut tried = 0;
    for (stage, before) in stages {
        for place in field.places(stage) {
            for value in field.others(stage.pointer(&place).unwrap()) {
                let Some(after) = picture_of(&edited(stage, &place, &value)) else { continue };
                tried += 1;
                if after != *before {
                    return true;
                }
            }
        }
    }
    assert!(tried > 0 || field.name() == "/$schema", "no stage can change {}", field.name());
    false
}

/// A field that changed nothing would be a lie in the documentation: every leaf of the schema, every
/// word and every kind changes the picture somewhere, but for those that say why not.
#[test]
fn every_field_changes_the_picture() {
    let stages: Vec<_> = stages().into_iter().map(|s| (s.clone(), picture(&s))).collect();
    let fields = fields::all();
    assert!(fields.len() > 100, "{} fields", fields.len());
    let is_inert = |field: &&Field| INERT.iter().any(|(name, _)| *name == field.name());
    let (inert, shown): (Vec<_>, Vec<_>) = fields.iter().partition(is_inert);
    let mute: Vec<_> = shown.iter().filter(|f| !shows(f, &stages)).map(|f| f.name()).collect();
    assert!(mute.is_empty(), "these change nothing: {mute:?}");
    let lively: Vec<_> = inert.iter().filter(|f| shows(f, &stages)).map(|f| f.name()).collect();
    assert!(lively.is_empty(), "these are listed as changing nothing: {lively:?}");
}

/// Without blobs `auto` is `sun2005`.
#[test]
fn auto_is_sun_in_homogeneous_fog() {
    let no_blobs = edited(&stage(), "/fog/terms/1/enabled", &json!(false));
    let published = edited(&no_blobs, "/fog/airlight", &json!("sun2005"));
    assert_eq!(picture(&published), picture(&no_blobs));
}

/// `enabled: false` hides a thing as if it were not there.
#[test]
fn disabled_is_absent() {
    let stage = stage();
    let shorter = |list: &str, place: usize| {
        let mut scene = stage.clone();
        scene.pointer_mut(list).unwrap().as_array_mut().unwrap().remove(place);
        scene
    };
    for (list, count) in [("/surfaces", 5), ("/lights", 2), ("/fog/terms", 2)] {
        for place in 0..count {
            let hidden = edited(&stage, &format!("{list}/{place}/enabled"), &json!(false));
            assert_eq!(picture(&hidden), picture(&shorter(list, place)), "{list}/{place}");
        }
    }
}

fn png(frame: &Frame, view: &View) -> Vec<u8> {
    encode(frame, view, Format::Png).expect("a picture")
}

struct Decoded {
    width: u32,
    height: u32,
    bytes: Vec<u8>,
    depth: png::BitDepth,
    color: png::ColorType,
}

fn decode(file: &[u8]) -> Decoded {
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut bytes).expect("pixels");
    let (width, height, depth, color) = (info.width, info.height, info.bit_depth, info.color_type);
    Decoded { width, height, bytes, depth, color }
}

/// Mean FLIP difference of two 8-bit pictures.
fn flip(a: &Decoded, b: &Decoded) -> f32 {
    assert_eq!((a.width, a.height), (b.width, b.height), "sizes");
    let image = |d: &Decoded| nv_flip::FlipImageRgb8::with_data(d.width, d.height, &d.bytes);
    let errors = nv_flip::flip(image(a), image(b), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    nv_flip::FlipPool::from_image(&errors).mean()
}

/// A draft is the picture that the full one will be: the eye must not see it jump.
#[test]
fn drafts_look_like_full_pictures() {
    let scene = scene(&stage());
    let full = View { samples: Some(1), ..beauty(192, 144) };
    let draft = View { quality: Quality::Draft, ..full };
    let [full, draft] = [full, draft].map(|view| decode(&png(&render(&scene, &view), &view)));
    let difference = flip(&full, &draft);
    println!("FLIP of a draft: {difference}");
    // FLIP: 0 is the same, 0.97 is black against white; 0.02 cannot be told apart in a moving picture.
    assert!(difference < 0.02, "{difference}");
}

/// No halo: right in front of a foreground edge a draft shows the foreground's fog, not the dense
/// fog behind it.
#[test]
fn drafts_have_no_halo() {
    const SIZE: usize = 96;
    let scene = scene(&json!({
        "camera": { "position": [0, 0, 6], "target": [0, 0, 0] },
        "surfaces": [{ "shape": { "kind": "sphere", "center": [0, 0, 3], "radius": 0.7 } }],
        "lights": [{ "position": [2.5, 2, -2], "kind": "point", "intensity": [50, 50, 50], "shadows": false }],
        "fog": { "terms": [{ "kind": "gaussians", "blobs": [
            { "center": [0, 0, -3], "radius": 3, "extinction": 1 },
            { "center": [0, 0, 4], "radius": 4, "extinction": 0.02 } ] }] },
        "far_m": 40,
    }));
    let frame =
        |quality, layer| render(&scene, &view(SIZE as u32, SIZE as u32, layer, quality)).pixels;
    let depth = frame(Quality::Full, Layer::Depth);
    let hit = |x: usize, y: usize| depth[y * SIZE + x] < 10.0;
    let [full, draft] = [Quality::Full, Quality::Draft].map(|q| frame(q, Layer::Airlight));
    let mut border = 0;
    for y in 1..SIZE - 1 {
        for x in 1..SIZE - 1 {
            let around = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
            if !hit(x, y) || around.iter().all(|(x, y)| hit(*x, *y)) {
                continue;
            }
            border += 1;
            let at = 3 * (y * SIZE + x);
            // Half a pixel's depth on a silhouette changes its fog by some percent.
            let relative = (draft[at] / full[at] - 1.0).abs();
            assert!(relative < 0.1, "{x}, {y}: {} instead of {}", draft[at], full[at]);
        }
    }
    assert!(border > 50, "the sphere has a border of {border} pixels");
}

/// More samples smooth edges and leave everything else as it is: but for what the interpolation of
/// airlight, which edge samples share with pixels, may miss.
#[test]
fn samples_touch_edges_only() {
    const SIZE: (usize, usize) = (64, 48);
    let scene = scene(&stage());
    let view = |layer, samples| View {
        layer,
        samples: Some(samples),
        ..beauty(SIZE.0 as u32, SIZE.1 as u32)
    };
    let frame = |layer, samples| render(&scene, &view(layer, samples)).pixels;
    let (one, four) = (frame(Layer::Beauty, 1), frame(Layer::Beauty, 4));
    let depth = frame(Layer::Depth, 1);
    let normal = frame(Layer::Normal, 1);
    // Alike to the eye of this test: a smaller jump of depth and a smaller bend than any edge has.
    let smooth = |i: usize, j: usize| {
        let bend: f32 = (0..3).map(|k| normal[3 * i + k] * normal[3 * j + k]).sum();
        (depth[i] - depth[j]).abs() < 0.02 * depth[i].min(depth[j])
            && (bend > 0.98 || normal[3 * i..3 * i + 3] == normal[3 * j..3 * j + 3])
    };
    let (mut inside, mut changed) = (0, 0);
    for y in 1..SIZE.1 - 1 {
        for x in 1..SIZE.0 - 1 {
            let at = y * SIZE.0 + x;
            let same = (3 * at..3 * at + 3).all(|k| (one[k] - four[k]).abs() <= 2e-3 * one[k]);
            changed += usize::from(!same);
            if [at - 1, at + 1, at - SIZE.0, at + SIZE.0].iter().all(|next| smooth(at, *next)) {
                inside += 1;
                assert!(same, "pixel {x}, {y} is no edge");
            }
        }
    }
    assert!(inside > 1000 && changed > 100, "{inside} pixels inside, {changed} changed");
}

/// Where nothing has an edge, samples change nothing; and 8-bit full pictures alone take four.
#[test]
fn samples_leave_a_flat_picture() {
    let flat = edited(&stage(), "/surfaces", &json!([]));
    let scene = scene(&flat);
    let frame = |samples| render(&scene, &View { samples: Some(samples), ..beauty(40, 30) }).pixels;
    assert_eq!(frame(1), frame(16));
    let samples = |format, quality| {
        View { samples: None, quality, ..beauty(8, 8) }.for_format(format).samples
    };
    for format in Format::ALL {
        let full = if format.is_float() { 1 } else { 4 };
        assert_eq!(samples(format, Quality::Full), Some(full), "{format:?}");
        assert_eq!(samples(format, Quality::Draft), Some(1), "{format:?}");
    }
}

/// The same request gives the same bytes, whatever was rendered before it.
#[test]
fn frames_do_not_depend_on_earlier_frames() {
    let renderer = Renderer::default();
    let bytes = |json: &Value, quality| {
        let view = View { quality, samples: Some(4), ..beauty(64, 48) };
        let frame = renderer.render(&scene(json), &view, &Progress::default()).unwrap();
        (png(&frame, &view), frame.pixels)
    };
    let a = stage();
    let others = [
        edited(&a, "/fog/terms/1/blobs/0/center/0", &json!(0)),
        edited(&a, "/lights/0/position/0", &json!(1)),
        edited(&a, "/surfaces/1/shape/radius", &json!(0.5)),
        edited(&a, "/camera/position/0", &json!(3)),
    ];
    for quality in [Quality::Full, Quality::Draft] {
        let first = bytes(&a, quality);
        assert!(first == bytes(&a, quality), "{quality:?}: the same request");
        for other in &others {
            bytes(other, quality);
            assert!(first == bytes(&a, quality), "{quality:?}: after another scene");
        }
        let fresh = Renderer::default();
        let view = View { quality, samples: Some(4), ..beauty(64, 48) };
        let alone = fresh.render(&scene(&a), &view, &Progress::default()).unwrap();
        assert!(first.1 == alone.pixels, "{quality:?}: a new renderer");
    }
}

/// Compares a picture with the one that is kept, which `FOGBANK_BLESS=1` writes.
fn golden(name: &str, scene: &CheckedScene, layer: Layer) {
    let view = View { layer, samples: Some(4), for_screen: true, ..beauty(128, 96) };
    let file = png(&render(scene, &view), &view);
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("golden").join(format!("{name}.png"));
    if std::env::var_os("FOGBANK_BLESS").is_some() {
        std::fs::write(&path, &file).expect("a place for the golden picture");
    }
    let kept = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    assert!(kept.len() <= 64 * 1024, "{name}: {} bytes", kept.len());
    let difference = flip(&decode(&kept), &decode(&file));
    // One level of 8 bits everywhere is about 0.004; lanes of another width move fewer pixels.
    assert!(difference < 0.01, "{name}: FLIP {difference}");
}

/// Every kind of fog looks as it did when somebody looked at it.
#[test]
fn fogs_look_as_they_did() {
    let stage = stage();
    for (name, hidden) in [("homogeneous", 1), ("gaussians", 0)] {
        let fog = edited(&stage, &format!("/fog/terms/{hidden}/enabled"), &json!(false));
        golden(name, &scene(&fog), Layer::Beauty);
    }
    for (name, vertical) in [
        ("slab", json!({ "kind": "slab", "min_m": 0, "max_m": 0.9 })),
        ("exponential", json!({ "kind": "exponential", "base_m": 0.3, "falloff_per_m": 2 })),
    ] {
        let layer = json!({ "kind": "homogeneous", "extinction": 0.4, "vertical": vertical });
        golden(name, &scene(&edited(&stage, "/fog/terms", &json!([layer]))), Layer::Beauty);
    }
}

/// So does every kind of shape.
#[test]
fn shapes_look_as_they_did() {
    let stage = stage();
    for (place, name) in ["plane", "sphere", "box", "mesh", "heightfield"].into_iter().enumerate() {
        let one = json!([stage["surfaces"][place]]);
        golden(name, &scene(&edited(&stage, "/surfaces", &one)), Layer::Beauty);
    }
}

/// And every layer.
#[test]
fn layers_look_as_they_did() {
    let scene = scene(&stage());
    for layer in [
        Layer::Beauty,
        Layer::Airlight,
        Layer::Surface,
        Layer::OpticalDepth,
        Layer::Transmittance,
        Layer::Depth,
        Layer::Normal,
    ] {
        let name = serde_json::to_value(layer).unwrap().as_str().unwrap().to_owned();
        golden(&name, &scene, layer);
    }
}

/// What is shown of values, as the mean of an area of each: dithering shows two levels.
fn tonemapped(values: &[f32], tonemap: Tonemap, exposure_ev: f64) -> Vec<f64> {
    const SIDE: usize = 16;
    let row: Vec<f32> = values.iter().flat_map(|v| [*v; 3 * SIDE]).collect();
    let width = values.len() * SIDE;
    let frame = Frame {
        width,
        height: SIDE,
        channels: 3,
        layer: Layer::Beauty,
        camera: Camera::default(),
        pixels: row.repeat(SIDE),
        shown: None,
        timings: vec![],
        backend: "cpu",
    };
    let view = View { tonemap, exposure_ev, ..beauty(width as u32, SIDE as u32) };
    let bytes = decode(&png(&frame, &view)).bytes;
    let mut means = vec![0.0; 3 * values.len()];
    for (place, level) in bytes.into_iter().enumerate() {
        let (column, channel) = (place / 3 % width, place % 3);
        means[column / SIDE * 3 + channel] += f64::from(level) / (SIDE * SIDE) as f64;
    }
    means
}

/// A screen's white is radiance 1 without a tone map, and its curve is sRGB's.
#[test]
fn no_tone_map_is_srgb() {
    let expect = |shown: Vec<f64>, levels: &[f64]| {
        for (rgb, level) in shown.chunks(3).zip(levels) {
            assert!(rgb.iter().all(|v| (v - level).abs() < 0.02), "{rgb:?} instead of {level}");
        }
    };
    let shown = tonemapped(&[0.0, 0.001, 0.214_041_14, 0.5, 1.0, 7.0], Tonemap::None, 0.0);
    // IEC 61966-2-1: 0.001 · 12.92 · 255; 0.2140 is half; (1.055 · 0.5^(1/2.4) − 0.055) · 255.
    expect(shown, &[0.0, 3.295, 127.5, 187.516, 255.0, 255.0]);
    // A stop doubles.
    expect(tonemapped(&[0.5], Tonemap::None, 1.0), &[255.0]);
    // Reinhard halves 1.
    expect(tonemapped(&[1.0], Tonemap::Reinhard, 0.0), &[187.516]);
}

/// More light never looks darker, from black to far beyond white, in any channel.
#[test]
fn tone_maps_rise_with_exposure() {
    for tonemap in [Tonemap::None, Tonemap::Reinhard, Tonemap::Agx] {
        let shown = |ev: i32| {
            let levels = tonemapped(&[0.01, 0.18, 1.0], tonemap, 0.25 * f64::from(ev));
            assert!(levels.chunks(3).all(|rgb| (rgb[0] - rgb[1]).abs() <= 1.0), "grey stays grey");
            levels
        };
        let mut last = shown(-80);
        assert!(last.iter().all(|v| *v < 8.0), "{tonemap:?} is dark at −20 stops: {last:?}");
        for ev in -79..=80 {
            let next = shown(ev);
            assert!(last.iter().zip(&next).all(|(a, b)| a <= b), "{tonemap:?} at {ev}/4 stops");
            last = next;
        }
        assert!(last.iter().all(|v| *v > 247.0), "{tonemap:?} is white at 20 stops: {last:?}");
    }
}

/// A 16-bit optical-depth picture tells every depth to half of one part in 65535 of its largest.
#[test]
fn sixteen_bits_hold_optical_depths() {
    let scene = scene(&stage());
    let frame = render(&scene, &view(40, 30, Layer::OpticalDepth, Quality::Full));
    let (file, scale) = encode_png16(&frame).unwrap();
    let decoded = decode(&file);
    assert_eq!((decoded.width, decoded.height), (40, 30));
    assert_eq!((decoded.depth, decoded.color), (png::BitDepth::Sixteen, png::ColorType::Grayscale));
    for (bytes, depth) in decoded.bytes.chunks(2).zip(&frame.pixels) {
        let level = f64::from(u16::from_be_bytes([bytes[0], bytes[1]]));
        let error = (level / 65535.0 * scale - f64::from(*depth)).abs();
        assert!(error <= 0.5001 / 65535.0 * scale, "{error}");
    }
}

/// Nobody waits for a picture that was called off, or whose time is over.
#[test]
fn cancelled_frames_stop() {
    let scene = scene(&stage());
    let cancelled = Progress::default();
    cancelled.cancel();
    let late = Progress::until(std::time::Instant::now());
    let renderer = Renderer::default();
    for progress in [cancelled, late] {
        assert_eq!(renderer.render(&scene, &beauty(64, 48), &progress).unwrap_err(), Interrupted);
        let rays = pixel_rays(&scene, 4, 3);
        assert_eq!(renderer.probe(&scene, &rays, &progress).unwrap_err(), Interrupted);
    }
}
