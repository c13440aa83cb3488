use super::super::TriMesh;
use catamaran::base::{Error, Result, at_least, check_request, reserved, spend};

/// A mesh under construction, with all of its memory reserved.
pub(super) struct Draft {
    pub vertices: Vec<[f64; 3]>,
    pub faces: Vec<[u32; 3]>,
}

impl Draft {
    /// Creates a draft with room for the given numbers of vertices and faces. `None`, a count that
    /// overflowed, gives an error.
    pub fn with_counts(vertices: Option<usize>, faces: Option<usize>) -> Result<Self> {
        // `TriMesh::new` would refuse these counts, too, but only after the memory was filled.
        let fits = |count: Option<usize>, each: u32| {
            count.filter(|&n| n <= (u32::MAX / each) as usize).ok_or_else(|| Error::Argument {
                what: "mesh",
                why: "it would have 2^32 vertices or corners of faces, or more".into(),
            })
        };
        let (vertices, faces) = (fits(vertices, 1)?, fits(faces, 3)?);
        let bytes = vertices * size_of::<[f64; 3]>() + faces * size_of::<[u32; 3]>();
        let request = format_args!("{vertices} vertices and {faces} faces");
        check_request("mesh", request, bytes as f64)?;
        Ok(Self { vertices: reserved(vertices)?, faces: reserved(faces)? })
    }

    /// Returns the mesh.
    pub fn finish(self) -> Result<TriMesh> {
        TriMesh::new(self.vertices, self.faces)
    }
}

/// How the last column of a sheet is joined to the first one.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Seam {
    /// Not at all.
    Open,
    /// Row by row.
    Joined,
    /// Row by row, with the rows in reverse order.
    Twisted,
}

/// Generates a sheet of `columns` x `rows` cells, each cut into two triangles; `position(i, j)` is
/// the position of the vertex in column i and row j. With joined rows the last row is joined to the
/// first one.
pub(super) fn sheet(
    columns: usize,
    rows: usize,
    seam: Seam,
    rows_joined: bool,
    position: impl Fn(usize, usize) -> [f64; 3],
) -> Result<TriMesh> {
    at_least("columns", columns, if seam == Seam::Open { 1 } else { 3 })?;
    at_least("rows", rows, if rows_joined { 3 } else { 1 })?;
    let plus_one = |cells: usize, joined: bool| cells.checked_add(usize::from(!joined));
    let lines = plus_one(columns, seam != Seam::Open);
    let per_line = plus_one(rows, rows_joined);
    let (Some(lines), Some(per_line)) = (lines, per_line) else {
        return Draft::with_counts(None, None)?.finish();
    };
    let faces = columns.checked_mul(rows).and_then(|cells| cells.checked_mul(2));
    let mut draft = Draft::with_counts(lines.checked_mul(per_line), faces)?;
    for i in 0..lines {
        spend(PLACED * per_line as f64)?;
        draft.vertices.extend((0..per_line).map(|j| position(i, j)));
    }
    let number = |i: usize, j: usize| {
        let j = j % per_line;
        let (i, j) = match seam {
            Seam::Twisted if i == lines => (0, per_line - 1 - j),
            _ => (i % lines, j),
        };
        (i * per_line + j) as u32
    };
    for i in 0..columns {
        for j in 0..rows {
            let [a, b] = [number(i, j), number(i + 1, j)];
            let [c, d] = [number(i + 1, j + 1), number(i, j + 1)];
            draft.faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    draft.finish()
}

/// Operations for the position of a vertex, roughly, with its two faces.
const PLACED: f64 = 100.0;

/// Returns the angle of step `i` of `count` around a circle.
pub(super) fn turn(i: usize, count: usize) -> f64 {
    std::f64::consts::TAU * i as f64 / count as f64
}
