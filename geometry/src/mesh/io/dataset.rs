//! A surface of points, cells and arrays of values of the points, as formats of simulation and of
//! imaging store it.

use super::attributes::{Attribute, MeshFile, Scalars};
use super::draft::{Checked, Draft, Fault};
use super::stored::{Indices, Kind};
use catamaran::base::{Error, Result, room};

/// The types of cells that are read, with the codes of VTK.
pub(super) mod cell {
    pub const STRIP: usize = 6;
    pub const POLYGON: usize = 7;
    pub const PIXEL: usize = 8;
    pub const TRIANGLE: usize = 5;
    pub const QUAD: usize = 9;
    /// Lagrange triangles and quadrilaterals, of any order.
    pub const CURVED_TRIANGLE: usize = 69;
    pub const CURVED_QUAD: usize = 70;
    /// Any cell that is no face.
    pub const OTHER: usize = 0;

    /// Returns the number of corners of a face of this type, whose other vertices are on its edges
    /// and inside; `None` for cells that are no faces.
    pub fn corners(kind: usize, vertices: usize) -> Option<usize> {
        match kind {
            STRIP | POLYGON => Some(vertices),
            // Also those with vertices on edges: quadratic, biquadratic, Lagrange and Bezier.
            TRIANGLE | 22 | 34 | CURVED_TRIANGLE | 76 => Some(3),
            PIXEL | QUAD | 23 | 28 | 30 | CURVED_QUAD | 77 => Some(4),
            // Quadratic polygons: the corners come first.
            36 => Some(vertices / 2),
            _ => None,
        }
    }
}

/// What an array of values of vertices is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Scalars,
    Normals,
    Uv,
    Colors,
}

impl Role {
    /// Returns the role that a name implies for an array of so many numbers for each vertex.
    pub fn of(name: &str, width: usize) -> Self {
        match (name.to_ascii_lowercase().as_str(), width) {
            ("normals" | "normal", 3) => Self::Normals,
            ("tcoords" | "texture coordinates" | "texturecoordinates" | "uv", 2 | 3) => Self::Uv,
            ("rgb" | "rgba" | "color" | "colors" | "colour" | "colours", 3 | 4) => Self::Colors,
            _ => Self::Scalars,
        }
    }
}

/// Largest number of values of a vertex in an array: each of them becomes a function with a name.
const MOST_VALUES: usize = 1 << 12;

/// Values of vertices.
pub(super) struct Array {
    pub name: String,
    pub role: Role,
    /// Number of values for each vertex.
    pub width: usize,
    pub values: Vec<f64>,
    /// The value that stands for 1 in a colour.
    pub full: f64,
}

impl Array {
    /// Returns an array whose role its name implies; integers of 8 bits are 255 times a colour.
    pub fn named(name: String, width: usize, values: Vec<f64>, kind: Kind) -> Checked<Self> {
        if width > MOST_VALUES {
            let what = format!("array {name:?} has {width} values for each vertex");
            return Err(format!("{what}, where {MOST_VALUES} are supported").into());
        }
        let role = Role::of(&name, width);
        Ok(Self { name, role, width, values, full: if kind == Kind::U8 { 255.0 } else { 1.0 } })
    }
}

/// What makes a surface of other data.
const HELP: &str =
    "extract the surface first (PyVista: extract_surface, ParaView: Extract Surface)";

/// Returns the error about a file whose content, `what`, is no surface but has one.
pub(super) fn not_a_surface(what: &str) -> Fault {
    format!("{what} is not a surface: {HELP}").into()
}

/// The vertices of cells, list after list.
pub(super) struct Lists<'a> {
    pub corners: Indices<'a>,
    pub ends: Ends<'a>,
}

/// Where the lists of the vertices of cells end.
pub(super) enum Ends<'a> {
    /// The length of each list comes before its vertices; the number of lists, which fill the
    /// numbers.
    Counted(usize),
    /// Before the vertices with these numbers, one for each list.
    At(Indices<'a>),
    /// The length of each list, and the number of lists.
    Each(usize, usize),
}

/// A dataset that is being read.
#[derive(Default)]
pub(super) struct Dataset {
    pub draft: Draft,
    pub arrays: Vec<Array>,
    /// Whether cells were left out whose vertices may be in no face.
    pub has_other_cells: bool,
}

impl Dataset {
    /// Adds the vertices with these coordinates.
    pub fn points(&mut self, values: &[f64]) -> Checked<()> {
        let (positions, rest) = values.as_chunks::<3>();
        if !rest.is_empty() {
            return Err(
                format!("{} coordinates of points, not three for each", values.len()).into()
            );
        }
        room(&mut self.draft.vertices, positions.len())?;
        for &position in positions {
            let v = self.draft.vertices.len();
            let pushed = self.draft.push_vertex(position);
            pushed.map_err(|fault| fault.of(|| format!("point {v}")))?;
        }
        Ok(())
    }

    /// Adds the cells that have these vertices, numbered from vertex `base`; cell i is of type
    /// `kind(i)`.
    pub fn cells(
        &mut self,
        lists: &Lists<'_>,
        base: usize,
        kind: impl Fn(usize) -> Checked<usize>,
    ) -> Checked<()> {
        let Lists { corners, ends } = lists;
        let base = u32::try_from(base).map_err(|_| "2^32 points")?;
        let count = match ends {
            Ends::Counted(count) | Ends::Each(_, count) => *count,
            Ends::At(ends) => ends.len(),
        };
        room(&mut self.draft.faces, count.min(corners.len()))?;
        let mut start = 0;
        let mut numbers = Vec::new();
        for i in 0..count {
            let end = match ends {
                Ends::Counted(_) => {
                    let length = corners.whole(start)?;
                    start += 1;
                    start + length
                }
                Ends::Each(width, _) => start + width,
                Ends::At(ends) => ends.whole(i)?,
            };
            if start > end || end > corners.len() {
                let count = corners.len();
                return Err(format!("cell {i} has vertices {start} to {end} of {count}").into());
            }
            numbers.clear();
            room(&mut numbers, end - start)?;
            for k in start..end {
                let number = corners.vertex(k, base);
                numbers.push(number.map_err(|fault| fault.of(|| format!("cell {i}")))?);
            }
            start = end;
            self.cell(kind(i)?, &mut numbers, i)?;
        }
        match corners.len() - start {
            0 => Ok(()),
            left => Err(format!("{left} vertices come after those of the last cell").into()),
        }
    }

    /// Adds cell `i` of a type; `vertices` is a buffer that may change.
    pub fn cell(&mut self, kind: usize, vertices: &mut Vec<u32>, i: usize) -> Checked<()> {
        let place = || format!("cell {i}");
        let Some(corners) = cell::corners(kind, vertices.len()) else {
            self.has_other_cells = true;
            self.draft.notes.add("left out cells that are not faces", place);
            return Ok(());
        };
        if vertices.len() < corners {
            let count = vertices.len();
            return Err(format!("cell {i} has {count} vertices, and its type {corners}").into());
        }
        if vertices.len() > corners {
            self.has_other_cells = true;
            self.draft.notes.add("took faces with vertices on their edges as flat", place);
            vertices.truncate(corners);
        }
        match kind {
            cell::STRIP => {
                for (k, triangle) in vertices.windows(3).enumerate() {
                    let &[a, b, c] = triangle else { continue };
                    let face = if k % 2 == 0 { [a, b, c] } else { [b, a, c] };
                    self.draft.push_polygon(&face, place)?;
                }
            }
            cell::PIXEL => {
                vertices.swap(2, 3);
                self.draft.push_polygon(vertices, place)?;
            }
            _ => {
                self.draft.push_polygon(vertices, place)?;
            }
        }
        Ok(())
    }

    /// Returns the values of the vertices alone.
    pub fn scalars(self) -> Vec<Scalars> {
        let columns = |a: Array| Scalars::columns(&a.name, a.width, &a.values);
        self.arrays.into_iter().filter(|a| !a.values.is_empty()).flat_map(columns).collect()
    }

    /// Returns the mesh with the values of its vertices.
    ///
    /// # Errors
    /// [`Error::Mesh`] for cells of which none is a face, and when the vertices and faces make no
    /// mesh.
    pub fn finish(mut self) -> Result<MeshFile> {
        let count = self.draft.vertices.len();
        let fits = |array: &Array| {
            count > 0
                && count.checked_mul(array.width) == Some(array.values.len())
                && array.width > 0
        };
        for array in self.arrays.iter().filter(|array| !fits(array)) {
            let what = "left out arrays without a value for each vertex";
            self.draft.notes.add(what, || array.name.clone());
        }
        self.arrays.retain(fits);
        for array in &mut self.arrays {
            if array.role == Role::Scalars {
                continue;
            }
            let name = &array.name;
            for x in &mut array.values {
                [*x] = self.draft.finite([*x / array.full], || name.clone());
            }
        }
        let mut file = self.draft.finish(&mut [], &mut [])?;
        if self.has_other_cells && file.mesh.faces().is_empty() {
            let what = format!("no faces: they are volumes, lines or points; of volumes, {HELP}");
            return Err(Error::Mesh { what, element: "the cells".into() });
        }
        for Array { name, role, width, values, .. } in self.arrays {
            match role {
                Role::Normals if file.normals.is_none() => {
                    let values = values.as_chunks::<3>().0.to_vec();
                    file.normals = Some(Attribute { values, corners: None });
                }
                Role::Uv if file.uv.is_none() => {
                    let values = values.chunks_exact(width).map(|uv| [uv[0], uv[1]]).collect();
                    file.uv = Some(Attribute { values, corners: None });
                }
                Role::Colors if file.colors.is_none() => {
                    let opacity = |color: &[f64]| color.get(3).copied().unwrap_or(1.0);
                    let color = |c: &[f64]| [c[0], c[1], c[2], opacity(c)];
                    file.colors = Some(values.chunks_exact(width).map(color).collect());
                }
                _ => file.scalars.extend(Scalars::columns(&name, width, &values)),
            }
        }
        if self.has_other_cells { file.without_lone_vertices() } else { Ok(file) }
    }
}
