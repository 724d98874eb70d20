//! Walls with rows of recessed windows.

use super::MeshBuilder;
use glam::DVec3;

/// An upright wall with a grid of windows.
#[derive(Clone, Copy, Debug)]
pub struct Facade {
    /// Its lower corner, left as seen from outside [m].
    pub corner: DVec3,
    /// From left to right as seen from outside; horizontal, of unit length.
    pub right: DVec3,
    /// Width [m].
    pub width: f64,
    /// Height [m].
    pub height: f64,
    /// Windows in a row.
    pub columns: usize,
    /// Rows of windows.
    pub rows: usize,
    /// Share of a bay's width and height that the window takes.
    pub opening: [f64; 2],
    /// How deep the panes lie behind the wall [m].
    pub recess: f64,
}

impl Facade {
    /// Adds the wall and its reveals, and answers the four corners of each pane, rows from the
    /// ground up.
    pub fn build(&self, wall: &mut MeshBuilder) -> Vec<[DVec3; 4]> {
        let bay = [self.width / self.columns as f64, self.height / self.rows as f64];
        let margin = [0, 1].map(|k| bay[k] * (1.0 - self.opening[k]) / 2.0);
        let mut panes = Vec::with_capacity(self.columns * self.rows);
        for row in 0..self.rows {
            for column in 0..self.columns {
                let (x, y) = (column as f64 * bay[0], row as f64 * bay[1]);
                let outer = self.rectangle([x, y], [x + bay[0], y + bay[1]], 0.0);
                let low = [x + margin[0], y + margin[1]];
                let high = [x + bay[0] - margin[0], y + bay[1] - margin[1]];
                let opening = self.rectangle(low, high, 0.0);
                let pane = self.rectangle(low, high, -self.recess);
                let rings = [outer, opening, pane].map(|ring| ring.map(|p| wall.vertex(p)));
                for pair in rings.windows(2) {
                    for k in 0..4 {
                        let next = (k + 1) % 4;
                        wall.quad([pair[0][k], pair[0][next], pair[1][next], pair[1][k]]);
                    }
                }
                panes.push(pane);
            }
        }
        panes
    }

    /// Which way the wall looks.
    pub fn outward(&self) -> DVec3 {
        self.right.cross(DVec3::Y)
    }

    /// A point of the wall: metres to the right, up and out of it.
    pub fn point(&self, right: f64, up: f64, out: f64) -> DVec3 {
        self.corner + self.right * right + DVec3::Y * up + self.outward() * out
    }

    fn rectangle(&self, low: [f64; 2], high: [f64; 2], out: f64) -> [DVec3; 4] {
        [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]
            .map(|[right, up]| self.point(right, up, out))
    }
}
