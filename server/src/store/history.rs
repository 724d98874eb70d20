//! What can be undone and done again. It follows from the headings of all revisions, so it needs no place of its own.

use super::record::{Heading, Kind};

/// Revisions that are undone together: from the first to the last.
type Group = [u64; 2];

/// What can be undone, and done again, the newest last.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History {
    done: Vec<Group>,
    undone: Vec<Group>,
    /// The stroke that the newest group belongs to.
    stroke: Option<String>,
}

impl History {
    /// Of revisions, in order.
    pub fn of<'a>(headings: impl IntoIterator<Item = &'a Heading>) -> Self {
        let mut history = Self::default();
        headings.into_iter().for_each(|heading| history.add(heading));
        history
    }

    /// What would be undone.
    pub fn to_undo(&self) -> Option<Group> {
        self.done.last().copied()
    }

    /// What would be done again.
    pub fn to_redo(&self) -> Option<Group> {
        self.undone.last().copied()
    }

    /// Takes a revision in.
    pub fn add(&mut self, heading: &Heading) {
        match heading.kind {
            Kind::Undo => {
                self.done.pop();
                self.undone.extend(heading.of);
                self.stroke = None;
            }
            Kind::Redo => {
                self.undone.pop();
                // What is undone next is what was done again, as the revision that did it.
                self.done.push([heading.revision; 2]);
                self.stroke = None;
            }
            Kind::Create => *self = Self::default(),
            Kind::Put | Kind::Patch | Kind::Edit => {
                self.undone.clear();
                match self.done.last_mut() {
                    Some(group) if heading.stroke.is_some() && self.stroke == heading.stroke => {
                        group[1] = heading.revision;
                    }
                    _ => self.done.push([heading.revision; 2]),
                }
                self.stroke.clone_from(&heading.stroke);
            }
        }
    }

    /// Forgets revisions before `oldest`, whose changes are gone.
    pub fn forget_before(&mut self, oldest: u64) {
        for groups in [&mut self.done, &mut self.undone] {
            groups.retain(|group| group[0] >= oldest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heading(revision: u64, kind: Kind, of: Option<Group>, stroke: Option<&str>) -> Heading {
        let stroke = stroke.map(str::to_owned);
        Heading { revision, at_ms: 0, kind, ops: Vec::new(), stroke, of, key: None }
    }

    #[test]
    fn what_was_done_last_is_undone_first_and_done_again_first() {
        let mut history = History::default();
        for revision in 1..=3 {
            history.add(&heading(revision, Kind::Edit, None, None));
        }
        assert_eq!(history.to_undo(), Some([3, 3]));
        history.add(&heading(4, Kind::Undo, Some([3, 3]), None));
        history.add(&heading(5, Kind::Undo, Some([2, 2]), None));
        assert_eq!((history.to_undo(), history.to_redo()), (Some([1, 1]), Some([2, 2])));
        history.add(&heading(6, Kind::Redo, Some([2, 2]), None));
        assert_eq!((history.to_undo(), history.to_redo()), (Some([6, 6]), Some([3, 3])));
        history.add(&heading(7, Kind::Edit, None, None));
        assert_eq!((history.to_undo(), history.to_redo()), (Some([7, 7]), None));
    }

    #[test]
    fn a_stroke_is_one_step_unless_something_comes_between() {
        let mut history = History::default();
        history.add(&heading(1, Kind::Edit, None, Some("a")));
        history.add(&heading(2, Kind::Edit, None, Some("a")));
        assert_eq!(history.to_undo(), Some([1, 2]));
        history.add(&heading(3, Kind::Edit, None, None));
        history.add(&heading(4, Kind::Edit, None, Some("a")));
        assert_eq!(history.to_undo(), Some([4, 4]));
        history.add(&heading(5, Kind::Undo, Some([4, 4]), None));
        history.add(&heading(6, Kind::Undo, Some([3, 3]), None));
        assert_eq!((history.to_undo(), history.to_redo()), (Some([1, 2]), Some([3, 3])));
        history.add(&heading(7, Kind::Edit, None, Some("a")));
        assert_eq!(history.to_undo(), Some([7, 7]));
    }
}
