use super::super::slots::NONE;
use super::super::vector::{Vector, cross, distance, dot, scale, sub, unit};
use super::super::{Edges, TriMesh};
use super::{Element, LaplacianKind, element};
use catamaran::base::{Error, Result, spend};

/// Least slack in the triangle inequality, relative to the mean length of edges (Sharp and Crane
/// 2020, section 4.5).
const MOLLIFICATION: f64 = 1e-5;

/// Operations that sorting and gluing a side of a face takes, roughly.
const GLUED: f64 = 50.0;

/// Triangles given by the lengths of their edges and glued along them, which determines the
/// intrinsic geometry of a surface. A triangle may have a vertex twice and be glued to itself.
#[derive(Debug, Clone)]
pub(crate) struct Complex {
    /// Vertices of the triangles.
    pub faces: Vec<[u32; 3]>,
    /// Lengths of the edges, by slot; both sides of an edge agree.
    pub lengths: Vec<[f64; 3]>,
    /// For each slot, the slot on the other side, which runs the other way, or [`NONE`].
    pub(super) twins: Vec<u32>,
    /// The number of sheets that cover the surface: areas and weights are divided by it.
    sheets: u8,
}

impl Complex {
    /// Creates the complex of the triangles of a mesh as they are, not glued.
    ///
    /// # Errors
    /// That of [`TriMesh::check_size`].
    pub fn of_mesh(mesh: &TriMesh) -> Result<Self> {
        mesh.check_size()?;
        let p = |v: u32| mesh.vertices()[v as usize];
        let faces = mesh.faces().to_vec();
        let lengths = faces
            .iter()
            .map(|f| std::array::from_fn(|k| distance(p(f[k]), p(f[(k + 1) % 3]))))
            .collect();
        Ok(Self { faces, lengths, twins: Vec::new(), sheets: 1 })
    }

    /// Computes the intrinsic Delaunay triangulation of a mesh or, for [`LaplacianKind::Tufted`],
    /// of its tufted cover.
    ///
    /// # Errors
    /// As [`laplacian`](fn@super::laplacian).
    pub fn delaunay(mesh: &TriMesh, kind: LaplacianKind) -> Result<Self> {
        let mut complex = Self::of_mesh(mesh)?;
        if kind == LaplacianKind::Tufted {
            complex.cover(mesh)?;
        } else {
            complex.glue(mesh)?;
        }
        complex.mollify();
        complex.flip_to_delaunay()?;
        Ok(complex)
    }

    /// Glues the triangles of a manifold along their common edges.
    fn glue(&mut self, mesh: &TriMesh) -> Result<()> {
        self.twins = vec![NONE; 3 * self.faces.len()];
        let edges = Edges::new(mesh);
        for (e, slots) in edges.corners().rows().enumerate() {
            let refused = |what: &str| {
                let what = format!("{what}; the tufted Laplacian allows this");
                Err(Error::Mesh { what, element: edges.name(e) })
            };
            match *slots {
                [_] => {}
                [s, t] if self.origin(s) != self.origin(t) => {
                    self.twins[s as usize] = t;
                    self.twins[t as usize] = s;
                }
                [_, _] => return refused("its faces disagree about which side is outside"),
                _ => return refused("has three faces or more"),
            }
        }
        Ok(())
    }

    /// Replaces the mesh by its tufted cover (Sharp and Crane 2020, section 4.2): every face has a
    /// front and a back. Around each edge, the side of a face that looks one way is glued to the
    /// side of the next face that looks back.
    fn cover(&mut self, mesh: &TriMesh) -> Result<()> {
        let originals = mesh.faces();
        self.faces = originals.iter().flat_map(|&[a, b, c]| [[a, b, c], [a, c, b]]).collect();
        self.lengths = self.lengths.iter().flat_map(|&[a, b, c]| [[a, b, c], [c, b, a]]).collect();
        self.twins = vec![NONE; 3 * self.faces.len()];
        self.sheets = 2;
        // The slots of an original slot on the front and on the back of its face.
        let front = |slot: u32| 6 * (slot / 3) + slot % 3;
        let back = |slot: u32| 6 * (slot / 3) + 5 - slot % 3;
        let mut around = Vec::new();
        let edges = Edges::new(mesh);
        for (ends, slots) in edges.ends().iter().zip(edges.corners().rows()) {
            spend(GLUED * slots.len() as f64)?;
            sort_around(mesh, *ends, slots, &mut around);
            for (i, &slot) in around.iter().enumerate() {
                let next = around[(i + 1) % around.len()];
                // The side that faces forwards runs from the lower end of the edge to the upper
                // one.
                let up = |s: u32| originals[s as usize / 3][s as usize % 3] == ends[0];
                let ahead = if up(slot) { front(slot) } else { back(slot) };
                let behind = if up(next) { back(next) } else { front(next) };
                self.twins[ahead as usize] = behind;
                self.twins[behind as usize] = ahead;
            }
        }
        Ok(())
    }

    /// Adds the same length to all edges so that every triangle satisfies the triangle inequality
    /// with some slack (Sharp and Crane 2020, equation 6).
    fn mollify(&mut self) {
        let all = self.lengths.as_flattened();
        if all.is_empty() {
            return;
        }
        let mean = all.iter().map(|l| l / all.len() as f64).sum::<f64>();
        let slack =
            |l: &[f64; 3]| (l[0] + l[1] - l[2]).min(l[1] + l[2] - l[0]).min(l[2] + l[0] - l[1]);
        let least = self.lengths.iter().map(slack).fold(f64::INFINITY, f64::min);
        let missing = MOLLIFICATION * mean - least;
        if missing > 0.0 {
            self.lengths.as_flattened_mut().iter_mut().for_each(|l| *l += missing);
        }
    }

    /// Returns the contribution of each triangle to the matrices.
    ///
    /// # Errors
    /// [`Error::Mesh`] when a triangle has no area even after this.
    pub fn elements(&self) -> Result<Vec<Element>> {
        let mut elements = Vec::with_capacity(self.faces.len());
        for (f, &lengths) in self.lengths.iter().enumerate() {
            let element = Element::of_lengths(lengths);
            if !element.is_sound() {
                return Err(element::no_area(f / usize::from(self.sheets), ""));
            }
            spend(element::OPERATIONS)?;
            elements.push(element.scaled(1.0 / f64::from(self.sheets)));
        }
        Ok(elements)
    }

    /// Returns the vertices of the triangles.
    pub fn into_faces(self) -> Vec<[u32; 3]> {
        self.faces
    }

    pub(super) fn origin(&self, slot: u32) -> u32 {
        self.faces[slot as usize / 3][slot as usize % 3]
    }

    pub(super) fn length(&self, slot: u32) -> f64 {
        self.lengths[slot as usize / 3][slot as usize % 3]
    }
}

/// Sorts the slots of an edge in the order in which its faces lie around it, counter-clockwise as
/// seen from its upper end.
fn sort_around(mesh: &TriMesh, ends: [u32; 2], slots: &[u32], around: &mut Vec<u32>) {
    around.clear();
    around.extend_from_slice(slots);
    if around.len() < 3 {
        return; // two slots have only one cyclic order
    }
    let position = |v: u32| mesh.vertices()[v as usize];
    let base = position(ends[0]);
    let axis = unit(sub(position(ends[1]), base));
    let direction = |slot: u32| -> Vector {
        let opposite = mesh.faces()[slot as usize / 3][(slot as usize % 3 + 2) % 3];
        let d = sub(position(opposite), base);
        sub(d, scale(axis, dot(d, axis)))
    };
    let x = direction(around[0]);
    let y = cross(axis, x);
    let angle = |slot: u32| {
        let d = direction(slot);
        dot(d, y).atan2(dot(d, x))
    };
    around.sort_by(|&s, &t| angle(s).total_cmp(&angle(t)).then(s.cmp(&t)));
}
