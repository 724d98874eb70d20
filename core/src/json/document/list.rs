//! Lists of parts.

use super::node::Node;
use super::operation::Operation;
use super::part::{Part, read_part};
use super::place::Place;
use crate::json::Checker;
use crate::shared::Shared;

/// How far behind a place the next item that stayed is looked for: runs of taken-out items are short, and
/// a run that is not seen through only makes the patch longer.
const LOOK_AHEAD: usize = 64;

/// A list of which more items than this and half of all differ is replaced as a whole: that is shorter.
const FEW: usize = 16;

impl<T: Part> Part for Vec<T> {
    fn open(&self) -> Node {
        Node::List(self.iter().map(Node::kept).collect())
    }

    fn close_opened(mut node: Node, at: &Place, check: &mut Checker) -> Option<Self> {
        let Some(items) = node.items() else { return read_part(node, at, check) };
        let items = std::mem::take(items).into_iter().enumerate();
        let mut closed = Self::new();
        let mut is_whole = true;
        for (i, item) in items {
            // As much as an answer lists of what is wrong is looked for, and no more.
            if check.found() >= Checker::MOST {
                return None;
            }
            match T::close(item, &at.item(i), check) {
                Some(item) => closed.push(item),
                None => is_whole = false,
            }
        }
        is_whole.then_some(closed)
    }

    fn values(&self) -> usize {
        1 + self.iter().map(T::values).sum::<usize>()
    }

    fn differ(before: &Self, after: &Self, at: &Place, patch: &mut Vec<Operation>) {
        let steps = steps(before, after);
        if steps.len() > FEW && 2 * steps.len() > after.len() {
            return patch.push(Operation::replace(at, after));
        }
        for step in steps {
            match step {
                Step::Take(j) => patch.push(Operation::remove(&at.item(j))),
                Step::Put(j) => patch.push(Operation::add(&at.item(j), &after[j])),
                Step::Change(i, j) => T::differ(&before[i], &after[j], &at.item(j), patch),
            }
        }
    }
}

/// What happens to a list, from its front to its back.
enum Step {
    /// The item that stands at this place by now is taken out.
    Take(usize),
    /// The new list's item is put to its place.
    Put(usize),
    /// An old item becomes a new one.
    Change(usize, usize),
}

fn steps<T: PartialEq>(before: &[T], after: &[T]) -> Vec<Step> {
    let same =
        |pairs: &mut dyn Iterator<Item = (&T, &T)>| pairs.take_while(|(a, b)| a == b).count();
    let front = same(&mut before.iter().zip(after));
    let back = same(&mut before[front..].iter().rev().zip(after[front..].iter().rev()));
    let (old_end, new_end) = (before.len() - back, after.len() - back);
    let (mut i, mut j) = (front, front);
    let mut steps = Vec::new();
    while i < old_end || j < new_end {
        let (old, new) = (&before[i..old_end], &after[j..new_end]);
        if let (Some(a), Some(b)) = (old.first(), new.first()) {
            if a == b {
                (i, j) = (i + 1, j + 1);
                continue;
            }
            // As many as there are too many may be taken out, or put in, before one that stayed.
            let taken = ahead(old, b, old.len().saturating_sub(new.len()));
            let put = ahead(new, a, new.len().saturating_sub(old.len()));
            if taken == 0 && put == 0 {
                steps.push(Step::Change(i, j));
                (i, j) = (i + 1, j + 1);
                continue;
            }
            steps.extend((0..taken).map(|_| Step::Take(j)));
            steps.extend((j..j + put).map(Step::Put));
            (i, j) = (i + taken, j + put);
        } else if old.is_empty() {
            steps.extend((j..new_end).map(Step::Put));
            j = new_end;
        } else {
            steps.extend(old.iter().map(|_| Step::Take(j)));
            i = old_end;
        }
    }
    steps
}

/// How many items stand before the one that equals `item`, of at most so many; 0 if none does.
fn ahead<T: PartialEq>(items: &[T], item: &T, most: usize) -> usize {
    let near = items.iter().take(most.min(LOOK_AHEAD) + 1);
    near.enumerate().find(|(_, other)| *other == item).map_or(0, |(count, _)| count)
}

impl<T: Part> Part for Shared<T> {
    fn open(&self) -> Node {
        T::open(self)
    }

    fn close_opened(node: Node, at: &Place, check: &mut Checker) -> Option<Self> {
        T::close(node, at, check).map(Self::from)
    }

    fn values(&self) -> usize {
        T::values(self)
    }

    fn differ(before: &Self, after: &Self, at: &Place, patch: &mut Vec<Operation>) {
        if before != after {
            T::differ(before, after, at, patch);
        }
    }
}
