//! A bounding volume hierarchy over boxes, built from the top down: nodes are divided where the
//! surface areas of both halves, each times the boxes in it, have the smallest sum among a few planes
//! (binned surface area heuristic, Wald 2007), and into halves of as many boxes where no plane parts
//! them or the tree would grow too deep.
//!
//! Whatever the boxes, equal or nested, the depth is within [`DEPTH`], and the work within n times that.

use crate::progress::{Interrupted, Progress, Watch};
use glam::Vec3;

/// Most levels below the root: a walk of which every step replaces a node by its two children never
/// holds more than one node beyond them.
pub const DEPTH: usize = 64;
/// Nodes of a walk that wait at the same time.
pub const WAITING: usize = DEPTH + 1;

/// More boxes than this are divided even where that saves nothing.
const MOST_IN_LEAF: usize = 8;
/// Planes that are tried across a node, and one.
const BINS: usize = 16;

/// A box along the axes [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

/// A node: its two children, or what a leaf holds.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// What it encloses.
    pub bounds: Bounds,
    /// Place of the first child, the other one behind it; of a leaf, of its first item.
    pub first: u32,
    /// Items of a leaf; 0 for others.
    pub count: u32,
}

/// The hierarchy. The root is the first node; there is none over nothing.
#[derive(Debug, Default)]
pub struct Hierarchy {
    /// All nodes.
    pub nodes: Vec<Node>,
    /// What leaves hold, one leaf after the other: places among the boxes it was built from.
    pub items: Vec<u32>,
}

impl Bounds {
    const NOTHING: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    fn join(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Twice the middle, which needs no product.
    fn twice_middle(&self) -> Vec3 {
        self.min + self.max
    }

    /// Half of its surface; 0 of nothing.
    fn half_area(&self) -> f32 {
        let size = (self.max - self.min).max(Vec3::ZERO);
        size.x * size.y + size.y * size.z + size.z * size.x
    }
}

/// A box while the tree is built.
#[derive(Clone, Copy)]
struct Item {
    bounds: Bounds,
    place: u32,
}

/// A node that is not yet divided.
struct Open {
    node: usize,
    from: usize,
    to: usize,
    depth: usize,
}

impl Hierarchy {
    /// The hierarchy over some boxes, where a step from a node to its children costs as much as looks at so many
    /// items.
    ///
    /// # Errors
    /// [`Interrupted`] when `progress` says so.
    pub fn build(
        boxes: impl Iterator<Item = Bounds>,
        step: f32,
        progress: &Progress,
    ) -> Result<Self, Interrupted> {
        let watch = Watch::new(progress);
        let items = (0u32..).zip(boxes).map(|(place, bounds)| Item { bounds, place });
        let mut items: Vec<_> = items.take_while(|_| watch.allows(1)).collect();
        let mut nodes = Vec::with_capacity(items.len());
        let mut open = Vec::new();
        if !items.is_empty() {
            nodes.push(Node { bounds: Bounds::NOTHING, first: 0, count: 0 });
            open.push(Open { node: 0, from: 0, to: items.len(), depth: 0 });
        }
        while let Some(Open { node, from, to, depth }) = open.pop() {
            if !watch.allows(to - from) {
                break;
            }
            let part = &mut items[from..to];
            let around = part.iter().fold(Bounds::NOTHING, |all, item| all.join(item.bounds));
            let Some(left) = divide(part, &around, depth, step) else {
                nodes[node] =
                    Node { bounds: around, first: from as u32, count: (to - from) as u32 };
                continue;
            };
            let first = nodes.len();
            nodes[node] = Node { bounds: around, first: first as u32, count: 0 };
            nodes.extend([nodes[node]; 2]);
            let middle = from + left;
            open.push(Open { node: first + 1, from: middle, to, depth: depth + 1 });
            open.push(Open { node: first, from, to: middle, depth: depth + 1 });
        }
        progress.check()?;
        Ok(Self { nodes, items: items.iter().map(|item| item.place).collect() })
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.items.as_slice())
    }
}

/// Brings the items of the first child to the front and tells how many they are; `None` for a leaf.
fn divide(part: &mut [Item], around: &Bounds, depth: usize, step: f32) -> Option<usize> {
    // Halves of halves must come down to single items before the tree is too deep.
    let halvings = part.len().next_power_of_two().ilog2() as usize;
    let split = (part.len() > 1 && depth + halvings < DEPTH).then(|| Split::best(part)).flatten();
    let whole = part.len() as f32 * around.half_area();
    match split {
        Some(split)
            if split.cost + step * around.half_area() < whole || part.len() > MOST_IN_LEAF =>
        {
            Some(split.part(part))
        }
        None if part.len() > MOST_IN_LEAF => Some(halve(part)),
        _ => None,
    }
}

/// A plane across an axis, by the bin that it stands before.
struct Split {
    axis: usize,
    bin: usize,
    scale: Scale,
    /// Areas times items of both sides.
    cost: f32,
}

/// Places on an axis as bins.
#[derive(Clone, Copy)]
struct Scale {
    from: f32,
    bins: f32,
}

impl Scale {
    fn bin(&self, at: f32) -> usize {
        (((at - self.from) * self.bins) as usize).min(BINS - 1)
    }
}

impl Split {
    /// The best plane across any axis; `None` if none parts the items.
    fn best(part: &[Item]) -> Option<Self> {
        let nothing = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (min, max) = part
            .iter()
            .map(|item| item.bounds.twice_middle())
            .fold(nothing, |(min, max): (Vec3, Vec3), middle| (min.min(middle), max.max(middle)));
        let on_axis = |axis: usize| {
            let bins = BINS as f32 / (max[axis] - min[axis]);
            bins.is_finite().then(|| Self::across(part, axis, Scale { from: min[axis], bins }))?
        };
        (0..3).filter_map(on_axis).min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    fn across(part: &[Item], axis: usize, scale: Scale) -> Option<Self> {
        let mut bins = [(Bounds::NOTHING, 0usize); BINS];
        for item in part {
            let (around, count) = &mut bins[scale.bin(item.bounds.twice_middle()[axis])];
            (*around, *count) = (around.join(item.bounds), *count + 1);
        }
        let mut behind = [0.0; BINS];
        let (mut around, mut count) = (Bounds::NOTHING, 0);
        for bin in (1..BINS).rev() {
            (around, count) = (around.join(bins[bin].0), count + bins[bin].1);
            behind[bin] = around.half_area() * count as f32;
        }
        let (mut best, mut around, mut count) = (None, Bounds::NOTHING, 0);
        for bin in 1..BINS {
            (around, count) = (around.join(bins[bin - 1].0), count + bins[bin - 1].1);
            let cost = around.half_area() * count as f32 + behind[bin];
            let parts = 0 < count && count < part.len();
            if parts && best.as_ref().is_none_or(|best: &Self| cost < best.cost) {
                best = Some(Self { axis, bin, scale, cost });
            }
        }
        best
    }

    /// Brings the items before the plane to the front.
    fn part(&self, part: &mut [Item]) -> usize {
        let mut left = 0;
        for at in 0..part.len() {
            if self.scale.bin(part[at].bounds.twice_middle()[self.axis]) < self.bin {
                part.swap(left, at);
                left += 1;
            }
        }
        left
    }
}

/// Two halves along the axis on which the items' middles lie farthest apart, or by size where they
/// lie in one point.
fn halve(part: &mut [Item]) -> usize {
    let middles = || part.iter().map(|item| item.bounds.twice_middle());
    let min = middles().fold(Vec3::INFINITY, Vec3::min);
    let size = middles().fold(Vec3::NEG_INFINITY, Vec3::max) - min;
    let axis = size.max_position();
    let key = |item: &Item| {
        if size[axis] > 0.0 { item.bounds.twice_middle()[axis] } else { item.bounds.half_area() }
    };
    let half = part.len() / 2;
    part.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)));
    half
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn build(boxes: &[Bounds]) -> Hierarchy {
        Hierarchy::build(boxes.iter().copied(), 1.0, &Progress::default()).unwrap()
    }

    fn cube(middle: Vec3, half: f32) -> Bounds {
        Bounds { min: middle - half, max: middle + half }
    }

    /// Every box is in one leaf, and in all nodes above it; leaves are small and no path is too long.
    fn holds(boxes: &[Bounds]) {
        let tree = build(boxes);
        let (mut seen, mut deepest) = (vec![false; boxes.len()], 0);
        let mut open: Vec<_> = tree.nodes.first().map(|node| (*node, 0)).into_iter().collect();
        while let Some((node, depth)) = open.pop() {
            deepest = deepest.max(depth);
            let within = |inner: &Bounds| inner.join(node.bounds) == node.bounds;
            let first = node.first as usize;
            if node.count == 0 {
                let children = &tree.nodes[first..first + 2];
                assert!(children.iter().all(|child| within(&child.bounds)));
                open.extend(children.iter().map(|child| (*child, depth + 1)));
                continue;
            }
            assert!(node.count as usize <= MOST_IN_LEAF, "{} in a leaf", node.count);
            for item in &tree.items[first..first + node.count as usize] {
                assert!(within(&boxes[*item as usize]));
                assert!(!std::mem::replace(&mut seen[*item as usize], true), "{item} twice");
            }
        }
        assert!(seen.into_iter().all(|seen| seen));
        assert!(deepest <= DEPTH, "{deepest} levels");
        assert!(tree.nodes.len() < 2 * boxes.len().max(1), "{} nodes", tree.nodes.len());
    }

    /// Equal boxes, nested ones, ones that shrink towards a point, and flat ones.
    #[test]
    fn no_boxes_make_a_tree_deep_or_a_leaf_large() {
        let many = 0..20_000u32;
        holds(&[]);
        holds(&[cube(Vec3::ONE, 1.0)]);
        holds(&many.clone().map(|_| cube(Vec3::ONE, 1.0)).collect::<Vec<_>>());
        holds(&many.clone().map(|i| cube(Vec3::ONE, 1.0 + i as f32)).collect::<Vec<_>>());
        let shrinking =
            |i: u32| cube(Vec3::X * 0.9f32.powi(i as i32), 0.04 * 0.9f32.powi(i as i32));
        holds(&(0..800).map(shrinking).collect::<Vec<_>>());
        let nested = |i: u32| Bounds { min: Vec3::ZERO, max: Vec3::splat(0.99f32.powi(i as i32)) };
        holds(&(0..5_000).map(nested).collect::<Vec<_>>());
        holds(&many.map(|i| cube(Vec3::X * i as f32, 0.0)).collect::<Vec<_>>());
    }

    /// Where it would come to be too deep it is divided in halves, down to single boxes.
    #[test]
    fn halving_keeps_the_bound() {
        let boxes: Vec<_> = (0..9).map(|i| cube(Vec3::X * 0.01f32.powi(i), 1e-9)).collect();
        let mut items: Vec<_> =
            (0..9).map(|place| Item { bounds: boxes[place], place: place as u32 }).collect();
        let around = Bounds { min: Vec3::ZERO, max: Vec3::ONE };
        assert_eq!(divide(&mut items, &around, 0, 1.0), Some(8));
        assert_eq!(divide(&mut items, &around, DEPTH - 4, 1.0), Some(4));
    }

    #[test]
    fn a_job_that_is_over_builds_nothing() {
        let progress = Progress::default();
        progress.cancel();
        let boxes = std::iter::repeat_n(cube(Vec3::ONE, 1.0), 100);
        assert!(Hierarchy::build(boxes, 1.0, &progress).is_err());
    }

    proptest! {
        #[test]
        fn any_boxes_are_held(
            boxes in prop::collection::vec((prop::array::uniform3(-9.0f32..9.0), 0.0f32..3.0), 0..200),
        ) {
            let boxes = boxes.into_iter().map(|(middle, half)| cube(Vec3::from(middle), half));
            holds(&boxes.collect::<Vec<_>>());
        }
    }
}
