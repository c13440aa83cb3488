//! Notes about what a reader left out or replaced.

use std::borrow::Cow;

/// The note about triangles that have a vertex twice.
pub(super) const COLLAPSED: &str = "left out triangles that have a vertex twice";

/// Kinds of things that a reader left out or replaced, each with a count and the position of the
/// first.
#[derive(Default)]
pub(super) struct Notes(Vec<Kind>);

struct Kind {
    what: Cow<'static, str>,
    count: usize,
    first: String,
}

impl Notes {
    /// Counts one more note of a kind. `place` is called for the first of its kind only, and
    /// returns its position; an empty text where the note has no position or names it itself.
    pub fn add(&mut self, what: impl Into<Cow<'static, str>>, place: impl FnOnce() -> String) {
        self.add_many(what, 1, place);
    }

    /// Adds `count` notes of a kind, possibly none.
    pub fn add_many(
        &mut self,
        what: impl Into<Cow<'static, str>>,
        count: usize,
        place: impl FnOnce() -> String,
    ) {
        if count == 0 {
            return;
        }
        let what = what.into();
        match self.0.iter_mut().find(|kind| kind.what == what) {
            Some(kind) => kind.count += count,
            None => self.0.push(Kind { what, count, first: place() }),
        }
    }

    /// Returns one line for each kind of note.
    pub fn lines(self) -> Vec<String> {
        let line = |Kind { what, count, first }: Kind| match first.is_empty() {
            true => format!("{what}: {count}"),
            false => format!("{what}: {count}, the first at {first}"),
        };
        self.0.into_iter().map(line).collect()
    }
}
