use std::hash::{BuildHasher, RandomState};

use super::super::{Part, TriMesh, has_corner_twice};
use super::attributes::MeshFile;
use super::notes::{COLLAPSED, Notes};
use super::polygon::{corners_of, fan, not_a_fan};
use catamaran::base::{Error, Result, push, repeated};
use catamaran::io::Source;

/// An error of a reader in a line or an element. [`Fault::at`] and [`Fault::of`] add the position.
pub(super) enum Fault {
    What(String),
    Error(Error),
}

impl From<String> for Fault {
    fn from(what: String) -> Self {
        Self::What(what)
    }
}

impl From<&str> for Fault {
    fn from(what: &str) -> Self {
        Self::What(what.into())
    }
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        Self::Error(error)
    }
}

/// The result of reading a line or an element.
pub(super) type Checked<T> = std::result::Result<T, Fault>;

impl Fault {
    /// Returns the error, with the last line of the source as its position unless it has one.
    pub fn at(self, source: &Source<'_>) -> Error {
        match self {
            Self::What(what) => source.fail(what),
            Self::Error(error) => error,
        }
    }

    /// Returns the same fault with the name of an element in front.
    pub fn of(self, element: impl FnOnce() -> String) -> Self {
        match self {
            Self::What(what) => Self::What(format!("{}: {what}", element())),
            error => error,
        }
    }
}

/// Returns a list with room for `count` items, or for fewer if the count can't be trusted yet.
pub(super) fn roomy<T>(count: usize) -> Vec<T> {
    Vec::with_capacity(count.min(1 << 16))
}

/// Numbers items in the order of first use. The caller has the items: this is a table of their
/// numbers, in which an item is found by a hash of its words.
pub(super) struct Numbers {
    /// Each has a number, plus one, and above it the upper bits of the hash, by which the slots are
    /// in order; 0 where it is empty. The number of slots is a power of 2, or 0.
    slots: Vec<u64>,
    len: usize,
    /// Unknown to files, which could otherwise have many items of one hash.
    seed: u64,
}

impl Default for Numbers {
    fn default() -> Self {
        Self { slots: Vec::new(), len: 0, seed: RandomState::new().hash_one(0) }
    }
}

impl Numbers {
    /// Returns the number of an item, and whether it is new. The words of equal items are equal;
    /// `is_same` returns whether the item with this number is this one.
    #[inline]
    pub fn of(
        &mut self,
        words: impl IntoIterator<Item = u64>,
        is_same: impl Fn(usize) -> bool,
    ) -> Checked<(u32, bool)> {
        if 2 * self.len >= self.slots.len() {
            self.grow()?;
        }
        let tag = self.hash(words) >> 32;
        let mut at = self.start(tag);
        // Half of the slots are empty.
        loop {
            let slot = self.slots[at];
            if slot == 0 {
                let number = u32::try_from(self.len).ok().filter(|&number| number < u32::MAX);
                let number = number.ok_or("2^32 vertices or names")?;
                self.slots[at] = tag << 32 | u64::from(number + 1);
                self.len += 1;
                return Ok((number, true));
            }
            let number = (slot as u32).wrapping_sub(1);
            if slot >> 32 == tag && is_same(number as usize) {
                return Ok((number, false));
            }
            at = (at + 1) & (self.slots.len() - 1);
        }
    }

    /// Returns a hash by multiplications to 128 bits, whose halves are joined (wyhash, Wang Yi).
    fn hash(&self, words: impl IntoIterator<Item = u64>) -> u64 {
        words.into_iter().fold(self.seed, |hash, word| {
            let product = u128::from(hash ^ word) * u128::from(self.seed | 1);
            product as u64 ^ (product >> 64) as u64
        })
    }

    /// Returns the slot from which on an item with these bits of its hash is found.
    fn start(&self, tag: u64) -> usize {
        (tag >> (32 - self.slots.len().trailing_zeros().min(32))) as usize
    }

    fn grow(&mut self) -> Result<()> {
        const LEAST: usize = 16;
        let count = self.slots.len().saturating_mul(2).max(LEAST);
        let old = std::mem::replace(&mut self.slots, repeated(0, count)?);
        for slot in old.into_iter().filter(|&slot| slot != 0) {
            let mut at = self.start(slot >> 32);
            while self.slots[at] != 0 {
                at = (at + 1) & (count - 1);
            }
            self.slots[at] = slot;
        }
        Ok(())
    }
}

/// A mesh that is being read.
#[derive(Default)]
pub(super) struct Draft {
    pub vertices: Vec<[f64; 3]>,
    /// The faces, polygons as fans; `finish` replaces fans of polygons that are not convex.
    pub faces: Vec<[u32; 3]>,
    /// First face and number of faces of each polygon of more than three corners.
    polygons: Vec<[u32; 2]>,
    /// Position of the first triangle that has a vertex twice.
    collapsed_at: Option<String>,
    lost: Lost,
    pub notes: Notes,
}

impl Draft {
    /// Adds a vertex. A position that is not finite counts as lost; `line` is its line in a file
    /// of text.
    pub fn push_vertex_or_lose(&mut self, position: [f64; 3], line: Option<usize>) -> Result<()> {
        if position.iter().all(|x| x.is_finite()) {
            return push(&mut self.vertices, position);
        }
        push(&mut self.lost.0, (self.vertices.len(), line))?;
        push(&mut self.vertices, [0.0; 3])
    }

    /// Returns the vertices without a finite position, and notes that they are left out.
    ///
    /// # Errors
    /// [`Error::Mesh`] when a face has one of them.
    pub fn lost(&mut self) -> Result<Lost> {
        let lost = std::mem::take(&mut self.lost);
        let Some(&(first, line)) = lost.0.first() else { return Ok(lost) };
        let place = |vertex: usize, line: Option<usize>| match line {
            Some(line) => format!("line {line}"),
            None => format!("vertex {vertex}"),
        };
        let find = |v: usize| lost.0.binary_search_by_key(&v, |(vertex, _)| *vertex).ok();
        let mut corners = self.faces.as_flattened().iter();
        if let Some(i) = corners.find_map(|&v| find(v as usize)) {
            let (vertex, line) = lost.0[i];
            let what = "the position of a vertex of a face is not finite".into();
            return Err(Error::Mesh { what, element: place(vertex, line) });
        }
        let what = "left out vertices without a face whose position is not finite";
        self.notes.add_many(what, lost.0.len(), || place(first, line));
        Ok(lost)
    }

    /// Adds a vertex, whose position must be finite.
    pub fn push_vertex(&mut self, position: [f64; 3]) -> Checked<()> {
        if position.iter().any(|x| !x.is_finite()) {
            return Err(format!("position {position:?} is not finite").into());
        }
        Ok(push(&mut self.vertices, position)?)
    }

    /// Adds a face of any number of corners, which is at `place` in the file. Returns whether a
    /// face was added: a face of fewer than three corners is not.
    pub fn push_polygon(&mut self, corners: &[u32], place: impl Fn() -> String) -> Result<bool> {
        if corners.len() < 3 {
            self.notes.add("left out faces of fewer than three corners", place);
            return Ok(false);
        }
        if let &[a, b, c] = corners {
            self.push_triangle([a, b, c], place)?;
            return Ok(true);
        }
        let first = self.faces.len();
        for face in fan(corners) {
            self.push_triangle(face, &place)?;
        }
        if let Ok(first) = u32::try_from(first) {
            push(&mut self.polygons, [first, (corners.len() - 2) as u32])?;
        }
        Ok(true)
    }

    /// Adds a triangle, which is at `place` in the file.
    pub fn push_triangle(&mut self, face: [u32; 3], place: impl FnOnce() -> String) -> Result<()> {
        if has_corner_twice(&face) {
            self.collapse(place);
        }
        push(&mut self.faces, face)
    }

    /// Records that a triangle at `place` has a vertex twice.
    pub fn collapse(&mut self, place: impl FnOnce() -> String) {
        self.collapsed_at.get_or_insert_with(place);
    }

    /// Returns the numbers, with 0 in place of those that are not finite, and notes how many were
    /// replaced.
    pub fn finite<const N: usize>(
        &mut self,
        values: [f64; N],
        place: impl FnOnce() -> String,
    ) -> [f64; N] {
        let wrong = values.iter().filter(|x| !x.is_finite()).count();
        let what =
            "took 0 for numbers of colours, normals and texture coordinates that are not finite";
        self.notes.add_many(what, wrong, place);
        values.map(|x| if x.is_finite() { x } else { 0.0 })
    }

    /// Returns the mesh. Polygons that are not convex are cut into triangles that cover them, and
    /// triangles that have a vertex twice are left out. The entries of the other lists, each of
    /// which is empty or has an entry for each face, follow their faces.
    ///
    /// # Errors
    /// [`Error::Mesh`] when the vertices and faces make no mesh.
    pub fn finish(
        mut self,
        corners: &mut [&mut Vec<[u32; 3]>],
        labels: &mut [&mut Vec<u32>],
    ) -> Result<MeshFile> {
        self.cut_polygons(corners);
        let (mut collapsed_faces, mut first_collapsed) = (0, String::new());
        if let Some(place) = self.collapsed_at.take() {
            let kept: Vec<bool> = self.faces.iter().map(|face| !has_corner_twice(face)).collect();
            collapsed_faces = kept.iter().filter(|&&kept| !kept).count();
            if collapsed_faces > 0 {
                first_collapsed = place;
            }
            self.notes.add_many(COLLAPSED, collapsed_faces, || first_collapsed.clone());
            keep(&mut self.faces, &kept);
            corners.iter_mut().for_each(|list| keep(list, &kept));
            labels.iter_mut().for_each(|list| keep(list, &kept));
        }
        let mesh = TriMesh::new(self.vertices, self.faces)?;
        let notes = self.notes.lines();
        let file = MeshFile::from(mesh);
        Ok(MeshFile { collapsed_faces, first_collapsed, notes, ..file })
    }

    fn cut_polygons(&mut self, corners: &mut [&mut Vec<[u32; 3]>]) {
        for &[first, count] in &self.polygons {
            let range = first as usize..first as usize + count as usize;
            let Some(fan) = self.faces.get(range.clone()) else { continue };
            let vertices = corners_of(fan);
            let position = |&v: &u32| self.vertices.get(v as usize).copied();
            let Some(positions) = vertices.iter().map(position).collect::<Option<Vec<_>>>() else {
                continue;
            };
            let Some(triangles) = not_a_fan(&positions) else { continue };
            let mut recut = |list: &mut [[u32; 3]]| {
                let corners = corners_of(list);
                for (triangle, numbers) in list.iter_mut().zip(&triangles) {
                    *triangle = numbers.map(|i| corners[i]);
                }
            };
            self.faces.get_mut(range.clone()).map(&mut recut);
            for list in corners.iter_mut() {
                list.get_mut(range.clone()).map(&mut recut);
            }
        }
    }
}

/// Vertices without a finite position, each with its line in a file of text. A draft has 0 in place
/// of their coordinates.
#[derive(Default)]
pub(super) struct Lost(Vec<(usize, Option<usize>)>);

impl Lost {
    /// Returns the file without these vertices, which are in no face.
    pub fn removed_from(self, file: MeshFile) -> Result<MeshFile> {
        if self.0.is_empty() {
            return Ok(file);
        }
        let mut lost = self.0.iter().map(|(vertex, _)| *vertex).peekable();
        let (mut numbers, mut kept) = (Vec::new(), Vec::new());
        let mut vertices = Vec::new();
        for (v, &position) in file.mesh.vertices().iter().enumerate() {
            numbers.push(kept.len() as u32);
            if lost.next_if_eq(&v).is_none() {
                kept.push(v as u32);
                vertices.push(position);
            }
        }
        let faces = file.mesh.faces().iter().map(|face| face.map(|v| numbers[v as usize]));
        let mesh = TriMesh::new(vertices, faces.collect())?;
        let faces = (0..mesh.faces().len() as u32).collect();
        file.part(Part { mesh, vertices: kept, faces })
    }
}

/// Drops the items that are not kept.
fn keep<T>(list: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    list.retain(|_| kept.next().copied().unwrap_or_default());
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn numbers_are_those_of_the_first_use_while_the_table_grows() {
        let mut numbers = Numbers::default();
        let mut items: Vec<[u64; 2]> = Vec::new();
        let mut known = HashMap::new();
        for i in 0..20_000u64 {
            // Each of 5000 items four times.
            let item = [i.wrapping_mul(7919) % 50, i.wrapping_mul(7919) % 5000];
            let next = known.len() as u32;
            let number = *known.entry(item).or_insert(next);
            let found = numbers.of(item, |k| items[k] == item).ok().unwrap();
            assert_eq!(found, (number, number == next));
            if found.1 {
                items.push(item);
            }
        }
        assert_eq!(items.len(), 5000);
    }

    #[test]
    fn items_with_the_same_words_are_told_apart_by_the_caller() {
        let mut numbers = Numbers::default();
        let all: Vec<u32> = (0..50).collect();
        for turn in 0..2 {
            for &item in &all {
                let found = numbers.of([7], |k| all[k] == item).ok().unwrap();
                assert_eq!(found, (item, turn == 0));
            }
        }
    }
}
