//! Files: what readers of others find in them, and that equal pictures are equal bytes.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test stops where it fails"
)]

use exr::meta::header::Header;
use fogbank_core::Frame;
use fogbank_core::image::{Format, encode, encode_png16};
use fogbank_core::request::{Layer, Quality, Tonemap, View};
use fogbank_core::scene::Camera;
use fogbank_tests::decode;
use fogbank_tests::scenes::view;
use fogbank_tests::server::Server;
use serde_json::json;
use std::io::Cursor;

fn frame(layer: Layer, width: usize, pixels: Vec<f32>) -> Frame {
    Frame {
        channels: layer.channels(1),
        width,
        height: pixels.len() / layer.channels(1) / width,
        layer,
        camera: Camera::default(),
        pixels,
        shown: None,
        timings: vec![],
        backend: "cpu",
    }
}

fn view_of(frame: &Frame) -> View {
    let view = view(frame.width as u32, frame.height as u32, frame.layer, Quality::Full);
    View { tonemap: Tonemap::None, ..view }
}

fn file(frame: &Frame, format: Format) -> Vec<u8> {
    encode(frame, &view_of(frame), format).unwrap()
}

/// The levels of an 8-bit picture, as PNG holds them.
fn levels(frame: &Frame) -> Vec<f64> {
    decode::screen(&file(frame, Format::Png), image::ImageFormat::Png).numbers
}

/// Whoever asks first, and whatever else the server does meanwhile.
#[test]
fn the_same_request_gives_the_same_bytes_under_load() {
    let server = Server::start();
    let scene = json!({
        "surfaces": [{ "shape": { "kind": "sphere", "center": [0, 1, 0], "radius": 1 } }],
        "lights": [{ "kind": "point", "position": [2, 3, 2] }],
        "fog": { "terms": [{ "kind": "homogeneous", "extinction": 0.05 }] },
    });
    // Several blocks, or tiles, for an encoder to get into disorder.
    let body = json!({ "scene": scene, "width": 130, "height": 70 });
    let ask = |format: Format| {
        let answer = server.post_for("/v1/render", &body, format.content_type());
        answer.expect_success().body
    };
    let first = Format::ALL.map(ask);
    std::thread::scope(|scope| {
        for start in 0..4 {
            let (ask, first) = (&ask, &first);
            scope.spawn(move || {
                for n in 0..250 {
                    let place = (start + n) % Format::ALL.len();
                    let format = Format::ALL[place];
                    assert!(ask(format) == first[place], "{format:?}, answer {n}");
                }
            });
        }
    });
}

fn header(file: &[u8]) -> Header {
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(file), true);
    meta.expect("a valid header").headers.remove(0)
}

/// Float32 numbers as they are, under the names of their layers.
#[test]
fn exr_files_name_their_channels() {
    for (layer, names) in [
        (Layer::Beauty, ["B", "G", "R"].as_slice()),
        (Layer::Airlight, &["airlight.B", "airlight.G", "airlight.R"]),
        (Layer::Surface, &["surface.B", "surface.G", "surface.R"]),
        (Layer::Normal, &["normal.X", "normal.Y", "normal.Z"]),
        (Layer::OpticalDepth, &["optical_depth.T"]),
        (Layer::Transmittance, &["transmittance.Y"]),
        (Layer::Depth, &["depth.Z"]),
    ] {
        // Smooth and noisy blocks, the last one not full; a noisy block is stored as it is.
        let noise = |n: usize| f32::from_bits((n as u32).wrapping_mul(0x9e37_79b9) >> 2);
        let number = |n: usize| if n < 1000 { 0.01 * n as f32 } else { noise(n) };
        let pixels: Vec<f32> = (0..23 * 37 * layer.channels(1)).map(number).collect();
        let frame = frame(layer, 23, pixels);
        let file = file(&frame, Format::Exr);
        let header = header(&file);
        let found: Vec<_> = header.channels.list.iter().map(|c| c.name.to_string()).collect();
        assert_eq!(found, names);
        assert_eq!(header.compression, exr::compression::Compression::ZIP16);
        let read = decode::exr(&file);
        assert_eq!((read.width, read.height), (23, 37));
        let numbers = frame.pixels.iter().map(|v| f64::from(*v));
        assert!(read.numbers.into_iter().eq(numbers), "{layer:?}");
        let is_colour = matches!(layer, Layer::Beauty | Layer::Airlight | Layer::Surface);
        let primaries = header.shared_attributes.chromaticities;
        assert_eq!(primaries.map(|c| (c.red.0, c.white.1)), is_colour.then_some((0.64, 0.329)));
    }
}

/// The matrix moves the eye to the origin and what it looks at in front of it; right is right.
#[test]
fn exr_files_hold_the_camera() {
    let frame = frame(Layer::Depth, 4, vec![1.0; 8]);
    let about = header(&file(&frame, Format::Exr)).own_attributes;
    assert!(about.software_name.unwrap().to_string().starts_with("Fogbank "));
    // Twice as wide as high, and 45 degrees high.
    let width = 4.0 * 22.5f32.to_radians().tan();
    assert!((about.screen_window_width - width).abs() < 1e-6);
    let matrix = about.world_to_camera.unwrap();
    let moved = |[x, y, z]: [f32; 3]| {
        let row = [x, y, z, 1.0];
        [0, 1, 2].map(|k| (0..4).map(|i| row[i] * matrix[4 * i + k]).sum::<f32>())
    };
    let distance = (8.0f32 * 8.0 + 0.7 * 0.7).sqrt();
    for (point, expected) in [
        ([0.0, 1.7, 8.0], [0.0, 0.0, 0.0]),
        ([0.0, 1.0, 0.0], [0.0, 0.0, distance]),
        ([1.0, 1.7, 8.0], [1.0, 0.0, 0.0]),
    ] {
        let moved = moved(point);
        let off = moved.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 1e-5, "{moved:?} instead of {expected:?}");
    }
}

/// Pictures say that they are sRGB; a map of numbers has no colours.
#[test]
fn png_files_name_their_colour_space() {
    let about = |file: &[u8]| {
        let reader = png::Decoder::new(Cursor::new(file)).read_info().unwrap();
        let info = reader.info();
        let gamma = info.gama_chunk.map(png::ScaledFloat::into_scaled);
        (info.srgb, gamma, info.chrm_chunk.map(|chrm| chrm.red.0.into_scaled()))
    };
    let srgb = (Some(png::SrgbRenderingIntent::Perceptual), Some(45_455), Some(64_000));
    let picture = frame(Layer::Beauty, 2, vec![0.5; 12]);
    let map = frame(Layer::OpticalDepth, 2, vec![0.5; 4]);
    assert_eq!(about(&file(&picture, Format::Png)), srgb);
    assert_eq!(about(&file(&map, Format::Png)), srgb);
    assert_eq!(about(&encode_png16(&map).unwrap().0), (None, None, None));
}

/// Linear light of a level between 0 and 255 (IEC 61966-2-1).
fn light(level: f64) -> f32 {
    let v = level / 255.0;
    let linear = if v < 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
    linear as f32
}

const WIDTH: usize = 1600;
const ROWS: usize = 16;

/// The same in all rows, as many times as the layer has channels.
fn ramp(layer: Layer, value: impl Fn(usize) -> f32) -> Frame {
    let row = (0..WIDTH).flat_map(|x| vec![value(x); layer.channels(1)]);
    frame(layer, WIDTH, row.collect::<Vec<_>>().repeat(ROWS))
}

/// The most columns in a row that show one level and nothing else.
fn widest_band(levels: &[f64], channel: usize) -> usize {
    let level = |x: usize, y: usize| levels[(y * WIDTH + x) * 3 + channel];
    let (mut widest, mut begun) = (0, 0);
    for x in 0..WIDTH {
        if (0..ROWS).any(|y| level(x, y) != level(begun, 0)) {
            begun = x + 1;
        }
        widest = widest.max((x + 1).saturating_sub(begun));
    }
    widest
}

/// A gradient of 200 pixels a level has no bands, and every small area has the mean of the exact one.
#[test]
fn slow_gradients_have_no_bands() {
    let exact = |x: usize| 100.0 + x as f64 / 200.0;
    let frame = ramp(Layer::Beauty, |x| light(exact(x)));
    let levels = levels(&frame);
    let widest = widest_band(&levels, 0);
    assert!(widest <= 20, "a band is {widest} pixels wide");
    for start in (0..WIDTH).step_by(16) {
        let columns = start..start + 16;
        let places = (0..ROWS).flat_map(|y| columns.clone().map(move |x| 3 * (y * WIDTH + x)));
        let mean = places.map(|at| levels[at]).sum::<f64>() / 256.0;
        let right = columns.clone().map(exact).sum::<f64>() / 16.0;
        assert!((mean - right).abs() < 0.05, "{mean} instead of {right} at {start}");
    }
    // Colour maps as well: five levels of green here.
    let map = ramp(Layer::Transmittance, |x| 0.30 + 0.02 * x as f32 / WIDTH as f32);
    let widest = widest_band(&self::levels(&map), 1);
    assert!(widest <= 30, "a band of the colour map is {widest} pixels wide");
    // Lossless files show the same; greys stay grey.
    let webp = decode::screen(&file(&frame, Format::WebP), image::ImageFormat::WebP);
    assert_eq!(webp.numbers, levels);
    assert!(levels.chunks(3).all(|rgb| rgb[0] == rgb[1] && rgb[1] == rgb[2]));
}

/// What is a level already stays it in every pixel: no speckles in black, in white, or between.
#[test]
fn exact_levels_stay() {
    for level in 0..=255 {
        let shown = levels(&frame(Layer::Beauty, 16, vec![light(f64::from(level)); 16 * 16 * 3]));
        assert!(shown.iter().all(|v| *v == f64::from(level)), "{level}");
    }
    for (light, level) in [(0.0, 0.0), (1e30, 255.0)] {
        let frame = frame(Layer::Beauty, 16, vec![light; 16 * 16 * 3]);
        let view = View { tonemap: Tonemap::Agx, ..view_of(&frame) };
        let file = encode(&frame, &view, Format::Png).unwrap();
        let shown = decode::screen(&file, image::ImageFormat::Png).numbers;
        assert!(shown.iter().all(|v| *v == level), "AgX of {light}");
    }
}

/// JPEG of any height shows in every line what PNG does: strips that are coded apart follow one another, also when
/// their restart markers have counted round. A ramp is coded to a few levels at quality 90 and 80; a strip
/// that is lost or begun wrongly is off by tens.
#[test]
fn strips_of_a_jpeg_join_without_a_seam() {
    let ramp = |x: usize, y: usize| [x as f32 / 71.0, ((y * 3) % 400) as f32 / 400.0, 0.5];
    for (width, height) in [(1, 1), (17, 32), (70, 33), (71, 700)] {
        let pixels = (0..height).flat_map(|y| (0..width).flat_map(move |x| ramp(x, y))).collect();
        let frame = frame(Layer::Beauty, width, pixels);
        let expected = levels(&frame);
        for quality in [Quality::Full, Quality::Draft] {
            let view = View { quality, ..view_of(&frame) };
            let file = encode(&frame, &view, Format::Jpeg).unwrap();
            let picture = decode::screen(&file, image::ImageFormat::Jpeg);
            assert_eq!((picture.width, picture.height), (width, height));
            let line = |y: usize| {
                let range = y * width * 3..(y + 1) * width * 3;
                let pairs = picture.numbers[range.clone()].iter().zip(&expected[range]);
                pairs.map(|(a, b)| (a - b).abs()).sum::<f64>() / (3 * width) as f64
            };
            // But where the ramp falls back from white to black.
            let lines = (0..height).filter(|y| (y * 3) % 400 >= 24 && (y * 3) % 400 < 376);
            let worst = lines.map(line).fold(0.0, f64::max);
            assert!(worst < 4.0, "{width}x{height} {quality:?}: {worst}");
        }
    }
}
