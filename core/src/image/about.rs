//! What an EXR file says of a frame besides its numbers: the channels' names, their colours, the
//! camera. Attributes are OpenEXR's standard ones where it has one.

use crate::frame::Frame;
use crate::frame::viewpoint::Viewpoint;
use crate::request::Layer;

/// An entry of an EXR file's header: name, type and bytes.
pub struct Attribute(pub &'static str, pub &'static str, pub Vec<u8>);

impl Attribute {
    /// A text.
    pub fn text(name: &'static str, text: &str) -> Self {
        Self(name, "string", text.as_bytes().to_vec())
    }

    /// Numbers of a type that is made of floats: `float`, `v2f`, `m44f`, `chromaticities`.
    pub fn floats(name: &'static str, kind: &'static str, numbers: &[f32]) -> Self {
        Self(name, kind, numbers.iter().flat_map(|v| v.to_le_bytes()).collect())
    }

    /// Whole numbers.
    pub fn words(name: &'static str, kind: &'static str, numbers: [i32; 4]) -> Self {
        Self(name, kind, numbers.iter().flat_map(|v| v.to_le_bytes()).collect())
    }

    /// Appends it to a file.
    pub fn write(&self, file: &mut Vec<u8>) {
        let Self(name, kind, bytes) = self;
        file.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat());
        file.extend((bytes.len() as u32).to_le_bytes());
        file.extend(bytes);
    }
}

/// Names and attributes of an image.
pub struct Caption {
    /// The names of its channels.
    pub channels: Vec<String>,
    /// Attributes in their order.
    pub attributes: Vec<Attribute>,
}

impl Caption {
    /// Of a frame.
    pub fn of(frame: &Frame) -> Self {
        let mut attributes = vec![software()];
        attributes.extend(camera(frame));
        if matches!(frame.layer, Layer::Beauty | Layer::Airlight | Layer::Surface) {
            attributes.push(rec_709());
        }
        Self { channels: channels(frame), attributes }
    }

    /// Of a comparison's errors.
    pub fn of_errors() -> Self {
        Self { channels: vec!["error.Y".into()], attributes: vec![software(), window(1.0)] }
    }
}

/// The picture's own channels have plain names. `Y` is what OpenEXR calls grey, `Z` a depth.
fn channels(frame: &Frame) -> Vec<String> {
    let is_coloured = frame.channels == 3;
    let (stem, names): (_, &[&str]) = match frame.layer {
        Layer::OpticalDepth if is_coloured => ("optical_depth.", &["R", "G", "B"]),
        Layer::Transmittance if is_coloured => ("transmittance.", &["R", "G", "B"]),
        Layer::Beauty => ("", &["R", "G", "B"]),
        Layer::Airlight => ("airlight.", &["R", "G", "B"]),
        Layer::Surface => ("surface.", &["R", "G", "B"]),
        Layer::Normal => ("normal.", &["X", "Y", "Z"]),
        Layer::OpticalDepth => ("optical_depth.", &["T"]),
        Layer::Transmittance => ("transmittance.", &["Y"]),
        Layer::Depth => ("depth.", &["Z"]),
    };
    names.iter().map(|name| format!("{stem}{name}")).collect()
}

fn software() -> Attribute {
    Attribute::text("software", concat!("Fogbank ", env!("CARGO_PKG_VERSION")))
}

fn camera(frame: &Frame) -> [Attribute; 3] {
    let viewpoint = Viewpoint::new(&frame.camera, frame.width, frame.height);
    let projection = if viewpoint.parallel { "orthographic" } else { "perspective" };
    let (right, _) = viewpoint.half_axes();
    [
        window(2.0 * right.length() as f32),
        Attribute::floats("worldToCamera", "m44f", &camera_from_world(&viewpoint)),
        Attribute::text("projection", projection),
    ]
}

/// The picture's width: at a distance of one metre, or anywhere where rays are parallel [m].
fn window(width: f32) -> Attribute {
    Attribute::floats("screenWindowWidth", "float", &[width])
}

/// Red, green, blue and white of linear Rec. 709.
fn rec_709() -> Attribute {
    let points = [0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329];
    Attribute::floats("chromaticities", "chromaticities", &points)
}

/// OpenEXR's camera space has x to the right, y up and z forwards; points are rows, so the last row
/// moves.
fn camera_from_world(viewpoint: &Viewpoint) -> [f32; 16] {
    let (right, up) = viewpoint.half_axes();
    let axes = [right.normalize(), up.normalize(), viewpoint.forward];
    let [x, y, z] = [0, 1, 2].map(|row| axes.map(|axis| axis[row]));
    let moved = axes.map(|axis| -axis.dot(viewpoint.position));
    let rows = [(x, 0.0), (y, 0.0), (z, 0.0), (moved, 1.0)];
    let mut matrix = [0.0; 16];
    for (out, ([a, b, c], d)) in matrix.chunks_exact_mut(4).zip(rows) {
        out.copy_from_slice(&[a as f32, b as f32, c as f32, d]);
    }
    matrix
}
