use super::super::TriMesh;
use crate::base::{Error, Result};
use crate::io::Source;

/// What a reader of a line or an element finds wrong; where that is, [`Fault::at`] and [`Fault::of`] say.
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
    /// The error, at the last line of the source if it is about that.
    pub fn at(self, source: &Source<'_>) -> Error {
        match self {
            Self::What(what) => source.fail(what),
            Self::Error(error) => error,
        }
    }

    /// The same, of an element.
    pub fn of(self, element: impl FnOnce() -> String) -> Self {
        match self {
            Self::What(what) => Self::What(format!("{}: {what}", element())),
            error => error,
        }
    }
}

/// Adds to a list; memory that can't be had is an error.
pub(super) fn push<T>(list: &mut Vec<T>, item: T) -> Result<()> {
    if list.len() == list.capacity() {
        let bytes = list.capacity().saturating_mul(2 * size_of::<T>());
        list.try_reserve(1).map_err(|_| Error::OutOfMemory { bytes })?;
    }
    list.push(item);
    Ok(())
}

/// A list with room for `count` items, or for as many as may be believed before they are there.
pub(super) fn roomy<T>(count: usize) -> Vec<T> {
    Vec::with_capacity(count.min(1 << 16))
}

/// A mesh being read.
#[derive(Default)]
pub(super) struct Draft {
    pub vertices: Vec<[f64; 3]>,
    pub faces: Vec<[u32; 3]>,
}

impl Draft {
    pub fn push_vertex(&mut self, position: [f64; 3]) -> Checked<()> {
        if position.iter().any(|x| !x.is_finite()) {
            return Err(format!("position {position:?} is not finite").into());
        }
        Ok(push(&mut self.vertices, position)?)
    }

    /// The triangles between the first corner of a polygon and each of its other edges.
    pub fn push_polygon(&mut self, corners: &[u32]) -> Checked<()> {
        if corners.len() < 3 {
            return Err(format!("a face of {} corners", corners.len()).into());
        }
        for pair in corners[1..].windows(2) {
            let face = [corners[0], pair[0], pair[1]];
            let [a, b, c] = face;
            if a == b || b == c || c == a {
                let twice = if b == c { b } else { a };
                return Err(format!("vertex {twice} (numbered from 0) twice in a face").into());
            }
            push(&mut self.faces, face)?;
        }
        Ok(())
    }

    /// # Errors
    /// [`Error::Mesh`] for what is no mesh.
    pub fn finish(self) -> Result<TriMesh> {
        TriMesh::new(self.vertices, self.faces)
    }
}
