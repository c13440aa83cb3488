//! The input in the form that the algorithms traverse: for each vertex its edges in rotational
//! order, with lengths.

use std::borrow::Cow;

use super::density::Stretch;
use crate::mesh::vector::distance;
use crate::mesh::{Adjacency, TriMesh};
use catamaran::base::{Error, Par, Result, reserved};

/// Number of vertices that one thread takes at a time.
const BLOCK: usize = 8192;

/// Least length of an edge: with it, coincident points are still nearest to themselves.
pub(super) const SHORTEST: f32 = 1e-30;

/// An edge in the list of one of its vertices.
#[derive(Debug, Clone, Copy)]
pub(super) struct Link {
    pub to: u32,
    /// Stretched length relative to [`Surface::scale`].
    pub length: f32,
}

/// A manifold mesh with the edges around each vertex.
pub(super) struct Surface<'m> {
    pub mesh: Cow<'m, TriMesh>,
    pub faces_of: Adjacency,
    starts: Vec<u32>,
    links: Vec<Link>,
    /// The factors by which lengths are stretched.
    pub stretch: Stretch,
    /// Whether each vertex is on the boundary, where its first and last edge are boundary edges.
    pub on_boundary: Vec<bool>,
    /// The diagonal of the bounding box, to which lengths are relative, because single precision
    /// has a small range.
    pub scale: f64,
    /// Whether all neighbouring faces agree about which side is outside.
    pub oriented: bool,
}

/// The data of a block of vertices.
struct Block {
    counts: Vec<u32>,
    links: Vec<Link>,
    on_boundary: Vec<bool>,
    oriented: bool,
    /// The first vertex whose faces are not one fan.
    broken: Option<u32>,
}

impl Block {
    fn with_capacity(vertices: usize) -> Self {
        Self {
            counts: Vec::with_capacity(vertices),
            links: Vec::with_capacity(7 * vertices),
            on_boundary: Vec::with_capacity(vertices),
            oriented: true,
            broken: None,
        }
    }

    fn push(&mut self, mesh: &TriMesh, v: usize, around: &[u32], open: bool, scale: f64) {
        let positions = mesh.vertices();
        let link = |&to: &u32| {
            let length = distance(positions[v], positions[to as usize]) / scale;
            Link { to, length: (length as f32).max(SHORTEST) }
        };
        self.counts.push(around.len() as u32);
        self.on_boundary.push(open);
        self.links.extend(around.iter().map(link));
    }
}

fn scale_of(mesh: &TriMesh) -> Result<f64> {
    mesh.check_size()?;
    let diagonal = mesh.bounding_box().map_or(0.0, |[low, high]| distance(low, high));
    Ok(if diagonal > 0.0 { diagonal } else { 1.0 })
}

impl<'m> Surface<'m> {
    /// Creates the surface of a manifold mesh.
    ///
    /// # Errors
    /// [`Error::Mesh`] that names a vertex whose faces are not one fan, or says that lengths are
    /// out of range; [`Error::OutOfMemory`].
    pub fn new(mesh: Cow<'m, TriMesh>, par: Par) -> Result<Self> {
        match Self::read(mesh, par)? {
            (surface, None) => Ok(surface),
            (_, Some(v)) => Err(Error::Mesh {
                what: "its faces are not one fan: the surface meets itself there".into(),
                element: format!("vertex {v}"),
            }),
        }
    }

    /// Creates the surface, and returns the first vertex whose faces are not one fan; if there is
    /// one, only the mesh of the surface is usable.
    ///
    /// # Errors
    /// As [`Surface::new`], except for such a vertex.
    pub fn read(mesh: Cow<'m, TriMesh>, par: Par) -> Result<(Self, Option<u32>)> {
        let scale = scale_of(&mesh)?;
        let faces_of = mesh.vertex_faces();
        let blocks = par.map_blocks(mesh.vertices().len(), BLOCK, |range| {
            let mut block = Block::with_capacity(range.len());
            let mut star = Star::default();
            for v in range {
                let Some(open) = star.read(&mesh, v as u32, faces_of.row(v)) else {
                    block.broken = Some(v as u32);
                    break;
                };
                block.oriented &= star.oriented;
                block.push(&mesh, v, &star.around, open, scale);
            }
            block
        });
        Self::from_blocks(mesh, faces_of, blocks, scale)
    }

    /// Creates the surface of any mesh. Edges are not in rotational order, and the boundary is
    /// unknown.
    pub fn of_edges(mesh: Cow<'m, TriMesh>, par: Par) -> Result<Self> {
        let scale = scale_of(&mesh)?;
        let neighbours = mesh.vertex_neighbors();
        let blocks = par.map_blocks(mesh.vertices().len(), BLOCK, |range| {
            let mut block = Block::with_capacity(range.len());
            range.for_each(|v| block.push(&mesh, v, neighbours.row(v), false, scale));
            block
        });
        let faces_of = mesh.vertex_faces();
        Ok(Self::from_blocks(mesh, faces_of, blocks, scale)?.0)
    }

    fn from_blocks(
        mesh: Cow<'m, TriMesh>,
        faces_of: Adjacency,
        blocks: Vec<Block>,
        scale: f64,
    ) -> Result<(Self, Option<u32>)> {
        let broken = blocks.iter().find_map(|block| block.broken);
        let total: usize = blocks.iter().map(|block| block.links.len()).sum();
        if u32::try_from(total).is_err() {
            let why = format!("{} have too many edges for indices", mesh.faces().len());
            return Err(Error::Argument { what: "faces", why });
        }
        let vertices = mesh.vertices().len();
        let mut starts = reserved(vertices + 1)?;
        let mut links = reserved(total)?;
        let mut on_boundary = reserved(vertices)?;
        let mut oriented = true;
        let mut end = 0;
        starts.push(0);
        for block in blocks {
            for count in block.counts {
                end += count;
                starts.push(end);
            }
            links.extend(block.links);
            on_boundary.extend(block.on_boundary);
            oriented &= block.oriented;
        }
        let stretch = Stretch::default();
        let surface = Self { mesh, faces_of, starts, links, stretch, on_boundary, scale, oriented };
        Ok((surface, broken))
    }

    /// Measures all edges with another stretch.
    pub fn measure(&mut self, stretch: Stretch) {
        if stretch.factors().is_none() && self.stretch.factors().is_none() {
            return;
        }
        self.stretch = stretch;
        for v in 0..self.len() as u32 {
            let here = self.position(v);
            for i in self.starts[v as usize] as usize..self.starts[v as usize + 1] as usize {
                let to = self.links[i].to;
                let length = distance(here, self.position(to)) / self.scale;
                let length = length * self.stretch.between(v, to);
                self.links[i].length = (length as f32).max(SHORTEST);
            }
        }
    }

    /// Returns the edges at a vertex in rotational order.
    pub fn links(&self, v: u32) -> &[Link] {
        &self.links[self.starts[v as usize] as usize..self.starts[v as usize + 1] as usize]
    }

    /// Returns the neighbours of v along the boundary; `None` if v is not on it.
    pub fn along_boundary(&self, v: u32) -> Option<[u32; 2]> {
        let links = self.links(v);
        let ends = [links.first()?.to, links.last()?.to];
        self.on_boundary[v as usize].then_some(ends)
    }

    /// Returns the stretched length of the longest edge, in units of length.
    pub fn longest_edge(&self, par: Par) -> f64 {
        let blocks = par.map_blocks(self.links.len(), 8 * BLOCK, |range| {
            self.links[range].iter().map(|link| link.length).fold(0.0, f32::max)
        });
        f64::from(blocks.into_iter().fold(0.0, f32::max)) * self.scale
    }

    /// Returns the number of vertices.
    pub fn len(&self) -> usize {
        self.on_boundary.len()
    }

    /// Returns the position of v.
    pub fn position(&self, v: u32) -> [f64; 3] {
        self.mesh.vertices()[v as usize]
    }
}

/// The faces around a vertex, sorted.
#[derive(Default)]
struct Star {
    /// For each face the other two corners.
    sides: Vec<[u32; 2]>,
    /// The neighbours in order.
    around: Vec<u32>,
    oriented: bool,
}

impl Star {
    /// Sorts the faces. Returns whether the fan is open; `None` when the faces are not one fan.
    fn read(&mut self, mesh: &TriMesh, v: u32, faces: &[u32]) -> Option<bool> {
        self.sides.clear();
        self.around.clear();
        self.oriented = true;
        if faces.is_empty() {
            return Some(false);
        }
        self.sides.extend(faces.iter().map(|&f| {
            let [a, b, c] = mesh.faces()[f as usize];
            if a == v {
                [b, c]
            } else if b == v {
                [c, a]
            } else {
                [a, b]
            }
        }));
        if self.sides.len() > 24 { self.long_walk() } else { self.short_walk() }
    }

    /// Sorts by a search of all remaining faces for each next one.
    fn short_walk(&mut self) -> Option<bool> {
        let sides = &mut self.sides;
        let count = sides.len();
        // Each neighbour is in two faces, except the ends of an open fan, which are then left over.
        let mut start = None;
        if sides.iter().flatten().fold(0, |all, x| all ^ x) != 0 {
            let single = |end| sides.iter().flatten().filter(|&&x| x == end).count() == 1;
            let mut ends = (0..count).flat_map(|i| [(i, 0), (i, 1)]);
            start = Some(ends.find(|&(i, k)| single(sides[i][k]))?);
        }
        let (first, k) = start.unwrap_or((0, 0));
        let open = start.is_some();
        sides.swap(0, first);
        let forward = k;
        self.around.push(sides[0][k]);
        let mut at = sides[0][1 - k];
        for done in 1..count {
            self.around.push(at);
            let next = (done..count).find(|&i| sides[i].contains(&at))?;
            sides.swap(done, next);
            let k = usize::from(sides[done][1] == at);
            self.oriented &= k == forward;
            at = sides[done][1 - k];
        }
        self.finish(at, open)
    }

    /// Sorts with a table of the faces at each neighbour.
    fn long_walk(&mut self) -> Option<bool> {
        let sides = &self.sides;
        let mut ends: Vec<(u32, u32)> =
            (0..).zip(sides).flat_map(|(i, s)| [(s[0], i), (s[1], i)]).collect();
        ends.sort_unstable();
        let at_neighbour = |x: u32| {
            let first = ends.partition_point(|&(y, _)| y < x);
            let count = ends[first..].iter().take(3).take_while(|&&(y, _)| y == x).count();
            &ends[first..first + count]
        };
        if ends.chunk_by(|a, b| a.0 == b.0).any(|group| group.len() > 2) {
            return None;
        }
        let start = ends.chunk_by(|a, b| a.0 == b.0).find(|group| group.len() == 1);
        let (from, mut face) = start.map_or((sides[0][0], 0), |group| group[0]);
        let forward = usize::from(sides[face as usize][1] == from);
        self.around.push(from);
        let mut at = sides[face as usize][1 - forward];
        for _ in 1..sides.len() {
            self.around.push(at);
            face = at_neighbour(at).iter().find(|&&(_, i)| i != face)?.1;
            let k = usize::from(sides[face as usize][1] == at);
            self.oriented &= k == forward;
            at = sides[face as usize][1 - k];
            if at == from && self.around.len() < sides.len() {
                return None; // the fan closed too early: there is a second fan
            }
        }
        self.finish(at, start.is_some())
    }

    /// Adds the last neighbour, which is new in an open fan and the first one in a closed fan.
    fn finish(&mut self, last: u32, open: bool) -> Option<bool> {
        if open {
            self.around.push(last);
        } else if last != self.around[0] {
            return None;
        }
        // A repeated neighbour means an edge of more than two faces, or two faces with the same
        // corners.
        let distinct = self.around.len() < 3 && !open;
        let repeated = self.around.len() <= 24
            && (1..self.around.len()).any(|i| self.around[..i].contains(&self.around[i]));
        (!distinct && !repeated).then_some(open)
    }
}
