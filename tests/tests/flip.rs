//! FLIP against nv-flip, the code of its authors.

use fogbank_core::Progress;
use fogbank_core::image::flip::{PIXELS_PER_DEGREE, map, mean};
use fogbank_tests::decode;

struct Picture {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
}

impl Picture {
    fn new((width, height): (u32, u32), mut rgb: impl FnMut(u32, u32) -> [f64; 3]) -> Self {
        let mut bytes = Vec::new();
        for y in 0..height {
            for x in 0..width {
                bytes.extend(rgb(x, y).map(|value| (255.0 * value).round() as u8));
            }
        }
        Self { width, height, rgb: bytes }
    }

    fn golden(name: &str) -> Self {
        let path = format!("{}/golden/{name}.png", env!("CARGO_MANIFEST_DIR"));
        let file = std::fs::read(path).unwrap();
        let picture = decode::screen(&file, image::ImageFormat::Png);
        let rgb = picture.numbers.iter().map(|byte| *byte as u8).collect();
        Self { width: picture.width as u32, height: picture.height as u32, rgb }
    }

    fn nv(&self) -> nv_flip::FlipImageRgb8 {
        nv_flip::FlipImageRgb8::with_data(self.width, self.height, &self.rgb)
    }
}

/// The same numbers in [0, 1) in every run (Knuth's MMIX generator).
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1u32 << 31)
    }
}

fn noise(size: (u32, u32), seed: u64) -> Picture {
    let mut random = random(seed);
    Picture::new(size, |_, _| [random(), random(), random()])
}

/// All colours flow into each other; a little brighter by `shift`.
fn gradient(size: (u32, u32), shift: f64) -> Picture {
    let (width, height) = (f64::from(size.0), f64::from(size.1));
    Picture::new(size, |x, y| {
        let (x, y) = (f64::from(x) / width, f64::from(y) / height);
        [x, y, 1.0 - 0.5 * (x + y)].map(|value| shift + (1.0 - shift) * value)
    })
}

/// Lines one pixel wide and edges, in colours.
fn drawing(size: (u32, u32), shift: u32) -> Picture {
    Picture::new(size, |x, y| match ((x + shift) % 16, y % 24) {
        (3, _) | (_, 5) => [1.0, 1.0, 1.0],
        (8..16, 12..24) => [0.9, 0.1, 0.0],
        (0..8, 12..24) => [0.0, 0.2, 0.8],
        _ => [0.0, 0.0, 0.0],
    })
}

/// How far mean and map may be from theirs: single precision, and powers that steepen towards 0.
fn agree(name: &str, reference: &Picture, test: &Picture) {
    let theirs = nv_flip::flip(reference.nv(), test.nv(), PIXELS_PER_DEGREE as f32).to_vec();
    let (progress, width) = (Progress::default(), reference.width as usize);
    let ours = map(&reference.rgb, &test.rgb, width, &progress).unwrap();
    assert_eq!(ours.len(), theirs.len(), "{name}");
    let largest = ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let expected = theirs.iter().map(|error| f64::from(*error)).sum::<f64>() / theirs.len() as f64;
    let found = mean(&reference.rgb, &test.rgb, width, &progress).unwrap();
    println!("{name}: mean {found}, off by {:e}, by {largest:e} at most", found - expected);
    assert!((found - expected).abs() < 1e-4, "{name}: {found} instead of {expected}");
    assert!(largest < 1e-3, "{name}: {largest}");
    assert!(ours.iter().all(|error| (0.0..=1.0).contains(error)), "{name}");
    let same = mean(&test.rgb, &test.rgb, width, &progress);
    assert_eq!(same, Ok(0.0), "{name}");
}

#[test]
fn flip_is_that_of_its_authors() {
    let size = (97, 61);
    agree("noise", &noise(size, 1), &noise(size, 2));
    agree("noise on a gradient", &gradient(size, 0.0), &noise(size, 3));
    agree("gradients", &gradient(size, 0.0), &gradient(size, 0.02));
    agree("drawings", &drawing(size, 0), &drawing(size, 1));
    agree("a drawing on a gradient", &gradient(size, 0.1), &drawing(size, 0));
    let even = |rgb| Picture::new(size, |_, _| rgb);
    agree("black and white", &even([0.0; 3]), &even([1.0; 3]));
    agree("green and blue", &even([0.0, 1.0, 0.0]), &even([0.0, 0.0, 1.0]));
    agree("dark greys", &even([0.02; 3]), &even([0.03; 3]));
}

#[test]
fn flip_is_that_of_its_authors_on_small_pictures() {
    for size in [(1, 1), (3, 2), (1, 40), (40, 1), (9, 8)] {
        agree(&format!("{size:?}"), &noise(size, 4), &noise(size, 5));
        agree(&format!("{size:?}, drawn"), &drawing(size, 0), &gradient(size, 0.3));
    }
}

#[test]
fn flip_is_that_of_its_authors_on_our_pictures() {
    agree("surface", &Picture::golden("beauty"), &Picture::golden("surface"));
    agree("airlight", &Picture::golden("beauty"), &Picture::golden("airlight"));
}
