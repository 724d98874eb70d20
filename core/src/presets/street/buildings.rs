//! The colonnade on the left, the houses on the right and the tower at the end of the street.

use super::super::geometry::{Facade, MeshBuilder};
use super::ground::{FAR_Z, KERB, NEAR_Z};
use super::lamp_post::{column, upright};
use crate::random::Random;
use glam::DVec3;

/// The row of columns stands here [m].
pub const COLONNADE_X: f64 = -5.3;
/// The distance between columns [m].
pub const COLUMN_STEP: f64 = 3.2;

/// Columns along the left pavement.
pub fn columns() -> MeshBuilder {
    let one = column();
    let mut row = MeshBuilder::default();
    for k in 0..10 {
        let z = 7.2 - COLUMN_STEP * f64::from(k);
        row.add(&one, upright(DVec3::new(COLONNADE_X, KERB, z), 0.0));
    }
    row
}

/// What the columns carry, and the wall behind them.
pub fn gallery() -> MeshBuilder {
    let mut walls = MeshBuilder::default();
    // Entablature: courses that step out to a cornice, as (half width, low, high).
    let courses = [
        (0.40, 4.0, 4.28),
        (0.43, 4.28, 4.52),
        (0.47, 4.52, 4.6),
        (0.40, 4.6, 5.05),
        (0.52, 5.05, 5.15),
        (0.72, 5.15, 5.32),
        (0.8, 5.32, 5.42),
    ];
    for (half, low, high) in courses {
        let min = DVec3::new(COLONNADE_X - half, KERB + low, FAR_Z);
        walls.block(min, DVec3::new(COLONNADE_X + half, KERB + high, NEAR_Z));
    }
    let mut z = NEAR_Z - 0.4;
    while z > FAR_Z {
        // Dentils under the cornice.
        let min = DVec3::new(COLONNADE_X + 0.4, KERB + 4.9, z - 0.16);
        walls.block(min, DVec3::new(COLONNADE_X + 0.55, KERB + 5.05, z));
        z -= 0.32;
    }
    let floor = DVec3::new(-9.0, -0.05, FAR_Z);
    walls.block(floor, DVec3::new(-4.95, KERB, NEAR_Z));
    let ceiling = DVec3::new(-9.0, KERB + 4.3, FAR_Z);
    walls.block(ceiling, DVec3::new(COLONNADE_X, KERB + 4.5, NEAR_Z));
    let back = Facade {
        corner: DVec3::new(-8.4, KERB, NEAR_Z),
        right: DVec3::NEG_Z,
        width: NEAR_Z - FAR_Z,
        height: 4.3,
        columns: 18,
        rows: 1,
        opening: [0.45, 0.7],
        recess: 0.35,
    };
    for niche in back.build(&mut walls) {
        walls.face(niche);
    }
    upper_storey(&mut walls);
    walls
}

fn upper_storey(walls: &mut MeshBuilder) {
    let wall = Facade {
        corner: DVec3::new(COLONNADE_X + 0.1, KERB + 5.42, NEAR_Z),
        right: DVec3::NEG_Z,
        width: NEAR_Z - FAR_Z,
        height: 3.6,
        columns: 18,
        rows: 1,
        opening: [0.36, 0.62],
        recess: 0.3,
    };
    for pane in wall.build(walls) {
        walls.face(pane);
    }
    let eaves = DVec3::new(COLONNADE_X - 3.0, KERB + 9.02, FAR_Z);
    walls.block(eaves, DVec3::new(COLONNADE_X + 0.5, KERB + 9.3, NEAR_Z));
}

/// The houses on the right: walls, and their panes with and without light behind them.
#[derive(Default)]
pub struct Houses {
    /// Walls, sills, frames and roofs.
    pub walls: MeshBuilder,
    /// Dark panes.
    pub dark: MeshBuilder,
    /// Panes with a lamp behind them.
    pub lit: MeshBuilder,
}

/// A row of houses of different widths and heights.
pub fn houses(random: &mut Random) -> Houses {
    let mut row = Houses::default();
    let mut z = NEAR_Z;
    while z > FAR_Z {
        let columns = 2 + (random.unit() * 3.0) as usize;
        let width = columns as f64 * random.between(1.9, 2.3);
        let rows = 3 + (random.unit() * 2.0) as usize;
        let wall = Facade {
            corner: DVec3::new(5.0 + random.between(0.0, 0.25), KERB, z - width),
            right: DVec3::Z,
            width,
            height: rows as f64 * random.between(2.7, 3.1),
            columns,
            rows,
            opening: [0.48, 0.58],
            recess: 0.16,
        };
        house(&mut row, wall, random);
        z -= width;
    }
    row
}

fn house(row: &mut Houses, wall: Facade, random: &mut Random) {
    for pane in wall.build(&mut row.walls) {
        let glass = if random.chance(0.2) { &mut row.lit } else { &mut row.dark };
        glass.face(pane);
        window_trim(&mut row.walls, pane);
    }
    let mut course = |low: f64, high: f64, out: f64| {
        let (a, b) = (wall.point(0.0, low, out), wall.point(wall.width, high, -0.3));
        row.walls.block(a.min(b), a.max(b));
    };
    course(0.0, 0.45, 0.06);
    course(wall.height - 0.25, wall.height - 0.12, 0.14);
    course(wall.height - 0.12, wall.height, 0.26);
    // The roof's slope, and the gable towards the neighbours.
    let rise = random.between(1.8, 2.6);
    let ridge = |right: f64| wall.point(right, wall.height + rise, -3.0);
    let eave = |right: f64| wall.point(right, wall.height, 0.2);
    row.walls.face([eave(0.0), eave(wall.width), ridge(wall.width), ridge(0.0)]);
    for end in [0.0, wall.width] {
        let foot = [wall.point(end, 0.0, 0.0), wall.point(end, 0.0, -3.0)];
        let top = [wall.point(end, wall.height, 0.0), ridge(end)];
        row.walls.face([foot[1], foot[0], top[0], top[1]]);
    }
}

/// A sill, a lintel and a cross of glazing bars.
fn window_trim(walls: &mut MeshBuilder, [low, _, high, _]: [DVec3; 4]) {
    // The street's houses all look towards −x.
    let (face, pane) = (low.x - 0.16, low.x);
    let (z0, z1) = (low.z.min(high.z), low.z.max(high.z));
    let mut bar = |x: [f64; 2], y: [f64; 2], z: [f64; 2]| {
        walls.block(DVec3::new(x[0], y[0], z[0]), DVec3::new(x[1], y[1], z[1]));
    };
    bar([face - 0.1, pane], [low.y - 0.09, low.y], [z0 - 0.1, z1 + 0.1]);
    bar([face - 0.06, face + 0.02], [high.y, high.y + 0.14], [z0 - 0.08, z1 + 0.08]);
    let (middle, waist) = ((z0 + z1) / 2.0, low.y + 0.62 * (high.y - low.y));
    bar([pane - 0.05, pane], [low.y, high.y], [middle - 0.03, middle + 0.03]);
    bar([pane - 0.045, pane], [waist - 0.03, waist + 0.03], [z0, z1]);
}

/// The tower that closes the street, without its clock.
pub fn tower() -> MeshBuilder {
    let mut tower = MeshBuilder::default();
    let (half, z) = (3.2, FAR_Z - 3.0);
    let wall = Facade {
        corner: DVec3::new(-half, 0.0, z + half),
        right: DVec3::X,
        width: 2.0 * half,
        height: 17.0,
        columns: 2,
        rows: 4,
        opening: [0.3, 0.5],
        recess: 0.4,
    };
    for pane in wall.build(&mut tower) {
        tower.face(pane);
    }
    tower.block(DVec3::new(-half, 0.0, z - half), DVec3::new(half, 17.0, z + half - 0.5));
    for (low, high, out) in [(0.0, 0.8, 0.2), (9.9, 10.3, 0.2), (16.6, 17.2, 0.35)] {
        let min = DVec3::new(-half - out, low, z - half - out);
        tower.block(min, DVec3::new(half + out, high, z + half + out));
    }
    let spire = [DVec3::new(-half, 17.2, z - half), DVec3::new(half, 25.0, z + half)];
    tower.frustum(spire, DVec3::new(half - 0.05, 0.0, half - 0.05));
    for (x0, x1) in [(-16.0, -half), (half, 16.0)] {
        tower.block(DVec3::new(x0, 0.0, z), DVec3::new(x1, 6.5, z + 2.0));
    }
    tower
}
