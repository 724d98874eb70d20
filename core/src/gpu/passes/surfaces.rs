//! First hits: triangles and shapes, the nearest wins.

use crate::gpu::compose::Pass;
use crate::gpu::device::Failure;
use crate::gpu::frame::{Recorder, all, attachment, draw};
use wgpu::{LoadOp, StoreOp};

impl Recorder<'_> {
    /// First hits.
    pub fn surfaces(&mut self) -> Result<(), Failure> {
        let (triangles, shapes) =
            (self.pipeline(Pass::Triangles, &[])?, self.pipeline(Pass::Shapes, &[])?);
        let (lists, targets) = (self.lists, &self.targets);
        let of_triangles = [
            all(0, &self.view),
            all(1, &lists.anchor),
            all(2, &self.triangles.corners),
            all(3, &self.triangles.normals),
        ];
        let of_shapes = [all(0, &self.view), all(1, &lists.shapes.list)];
        let device = &self.gpu.device;
        let binds = [triangles.bind(device, &of_triangles), shapes.bind(device, &of_shapes)];
        let nothing = wgpu::Color { r: f64::from(u32::MAX), ..wgpu::Color::TRANSPARENT };
        let far = wgpu::Color { a: f64::from(self.context.far_m), ..wgpu::Color::TRANSPARENT };
        let mut pass = self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[
                attachment(&targets.hits, LoadOp::Clear(far)),
                attachment(&targets.surfaces, LoadOp::Clear(nothing)),
            ],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depth.view,
                depth_ops: Some(wgpu::Operations {
                    load: LoadOp::Clear(0.0),
                    store: StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: self.timer.render("surfaces"),
            ..Default::default()
        });
        if self.triangles.count > 0 {
            draw(&mut pass, &triangles, &binds[0], (3 * self.triangles.count, 1));
        }
        if lists.shapes.count > 0 {
            draw(&mut pass, &shapes, &binds[1], (4, lists.shapes.count));
        }
        Ok(())
    }
}
