//! What the shaders read, as they read it: structs, places relative to the
//! camera. `shaders/` documents each field; a test holds the two against each other.

use encase::ShaderType;
use encase::internal::WriteInto;
use encase::{StorageBuffer, UniformBuffer};
use glam::{UVec3, Vec2, Vec3, Vec4};

/// A struct, its twin in WGSL, and the names of its fields.
macro_rules! rows {
    ($($(#[$doc:meta])* $name:ident in $module:literal { $($field:ident: $row:ty),* })*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug, Default, PartialEq, ShaderType)]
            pub struct $name { $(pub $field: $row),* }
        )*

        /// Name, module or pass of its twin, names and offsets of its fields, size.
        #[cfg(test)]
        fn structs() -> Vec<(&'static str, &'static str, Vec<(&'static str, u64)>, u64)> {
            vec![$((
                stringify!($name),
                $module,
                [$(stringify!($field)),*]
                    .into_iter()
                    .zip($name::METADATA.extra.offsets)
                    .collect(),
                $name::min_size().get(),
            )),*]
        }
    };
}

rows! {
    /// The camera, the picture and the fog's own numbers.
    View in "fogbank::view" {
        forward: Vec3, far_m: f32, right: Vec3, sample_x: f32, up: Vec3, sample_y: f32,
        size: Vec2, targets: Vec2, ambient: Vec3, cut_off_m: f32, weighing: f32, exposure: f32,
        parallel: u32, step: u32, blobs: u32, scatters: u32, opaque: f32, soft: u32
    }
    /// A part of a list that one dispatch works on.
    Span in "fogbank::view" { first: u32, end: u32, lamp: u32, slot: u32 }
    /// A light.
    Lamp in "fogbank::lamp" {
        position: Vec3, distance_m: f32, strength: Vec3, path_m: f32, toward: Vec3, inner: f32,
        axis: Vec3, outer: f32, is_shaded: u32, sky: u32, channel: u32, sky_g: f32, log_most: f32
    }
    /// What a group of terms scatters of a lamp.
    Scatter in "fogbank::lamp" { colour: Vec3, g: f32, lamp: u32, group: u32, share: f32 }
    /// A Gaussian.
    Blob in "fogbank::media::gaussians" {
        place: Vec3, a: f32, half_depth: f32, reach_m: f32, group: u32, is_slab: u32
    }
    /// What noise does to view rays.
    Bend in "bend" { moved: Vec3, rate: f32, strength: f32, reach: f32 }
    /// What a surface is made of.
    Material in "fogbank::surface::attenuated" {
        diffuse: Vec3, shininess: f32, specular: Vec3, emission: Vec3
    }
    /// A triangle, relative to the anchor.
    Triangle in "triangles" { a: Vec3, surface: u32, b: Vec3, normals: u32, c: Vec3 }
    /// Normals at a triangle's corners.
    Smooth in "triangles" { a: Vec3, b: Vec3, c: Vec3 }
    /// Where triangles are relative to.
    Anchor in "triangles" { shift: Vec3 }
    /// The work of a dispatch of cells of the grid.
    Task in "grid" { side: u32, alone: u32, at_edges: u32 }
    /// How fine the grid is.
    Fineness in "fogbank::grid::block" {
        near: f32, glow: f32, hidden: f32, wide: f32, rough: f32, unseen: f32, knots: u32,
        groups: u32
    }
    /// What a light's table covers.
    Extent in "fogbank::grid::light_table" {
        across: Vec3, reach: f32, down: Vec3, first: f32, toward: Vec3, density: f32, side: f32,
        shells: f32, begin: u32, parallel: u32
    }
    /// How much throws shadows.
    Counts in "fogbank::casters" { shift: Vec3, planes: u32, nodes: u32 }
    /// The rows of heights of a lamp.
    Shaft in "fogbank::grid::shafts" {
        origin: Vec3, ends: u32, axis: Vec3, far: f32, right: Vec3, middle: f32, up: Vec3,
        first: f32, density: f32, begin: f32, scale: f32, slices: u32, bins: u32, place: u32
    }
    /// What the table of a sky covers.
    Table in "fogbank::sky::table" {
        origin: Vec3, begin: u32, size: UVec3, order: u32, colours: [Vec4; 3], channels: u32
    }
    /// How bright a sky is.
    Backdrop in "fogbank::sky::backdrop" { kind: u32, begin: u32, count: u32, width: u32 }
    /// A plane, a sphere or a box.
    Shape in "shapes" { first: Vec4, second: Vec4, kind: u32, surface: u32 }
}

/// A list as a shader's `array` reads it; one empty element stands for none.
pub fn list<T: ShaderType + Default + Clone>(values: Vec<T>) -> Vec<u8>
where
    Vec<T>: ShaderType + WriteInto,
{
    let values = if values.is_empty() { vec![T::default()] } else { values };
    let mut bytes = StorageBuffer::new(Vec::new());
    // Only a fixed-size target can be too small.
    let _ = bytes.write(&values);
    bytes.into_inner()
}

/// A struct as a `uniform` reads it.
pub fn one<T: ShaderType + WriteInto>(value: &T) -> Vec<u8> {
    let mut bytes = UniformBuffer::new(Vec::new());
    let _ = bytes.write(value);
    bytes.into_inner()
}

#[cfg(test)]
mod tests {
    use super::structs;
    use crate::gpu::compose::{Pass, compositions, module};
    use crate::gpu::passes::BLOCK_BYTES;
    use naga_oil::compose::Composer;
    use wgpu::naga::{Module, TypeInner};

    /// Name and offset of every member, and the size, of a struct of a module.
    fn layout(module: &Module, name: &str) -> Option<(Vec<(String, u64)>, u64)> {
        module.types.iter().find_map(|(_, ty)| match &ty.inner {
            TypeInner::Struct { members, span } if ty.name.as_deref() == Some(name) => {
                let member = |m: &wgpu::naga::StructMember| {
                    (m.name.clone().unwrap_or_default(), u64::from(m.offset))
                };
                Some((members.iter().map(member).collect(), u64::from(*span)))
            }
            _ => None,
        })
    }

    /// A buffer written on one side and read on the other means the same on both.
    #[test]
    fn structs_lie_in_memory_as_the_shaders_read_them() {
        let modules: Vec<_> =
            compositions().iter().map(|key| (key.pass, module(key).unwrap())).collect();
        for (name, place, fields, size) in structs() {
            let decorated = Composer::decorated_name(Some(place), name);
            let found = modules.iter().find_map(|(pass, module)| {
                let own = pass.stem() == place;
                layout(module, if own { name } else { &decorated })
            });
            let (members, span) = found.unwrap_or_else(|| panic!("{place} reads no {name}"));
            let fields: Vec<_> = fields.into_iter().map(|(f, at)| (f.to_owned(), at)).collect();
            assert_eq!((members, span), (fields, size), "{name} of {place}");
        }
    }

    /// Blocks are written and read on the device alone, which is told how much room they take.
    #[test]
    fn blocks_take_as_much_room_as_the_shaders_say() {
        let key = compositions().into_iter().find(|key| key.pass == Pass::Knots).unwrap();
        let name = Composer::decorated_name(Some("fogbank::grid::block"), "Block");
        let (_, span) = layout(&module(&key).unwrap(), &name).unwrap();
        assert_eq!(span, BLOCK_BYTES);
    }
}
