//! Regions that curves enclose.

use std::collections::{BTreeMap, VecDeque};

use super::Region;
use crate::curve::walls::Walls;
use crate::mesh::TriMesh;
use catamaran::base::{Error, Result};

/// The side of the curves that is the inside.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Side {
    /// The side of smaller area; of equal areas, the side with the lowest face. The default.
    #[default]
    Small,
    /// The side of larger area.
    Large,
    /// The pieces with these vertices, which must not be on a curve.
    Seeds(Vec<u32>),
}

impl Region {
    /// Returns the region that curves along edges of a mesh enclose.
    ///
    /// With a side by area, crossing a curve leads from one side to the other (the even-odd rule):
    /// a ring around a hole, or the band between two rings, is one region. One side is selected on
    /// each part of the surface with curves; parts without curves are outside. The boundary of the
    /// mesh bounds regions as curves do.
    ///
    /// ```
    /// use catamaran_geometry::curve::{Region, Side};
    /// use catamaran_geometry::mesh::families;
    ///
    /// // A grid of 3 x 1 squares, with a curve after the first square.
    /// let mesh = families::grid(3, 1)?;
    /// let small = Region::enclosed(&mesh, &[[2, 3]], &Side::Small)?;
    /// assert_eq!(small.faces(), [0, 1]);
    /// assert_eq!(Region::enclosed(&mesh, &[[2, 3]], &Side::Seeds(vec![7]))?, small.complement());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] for two vertices that are not joined by an edge, and for a seed that has
    /// no face or is on a curve; [`Error::Mesh`] names an edge with the same region on both sides:
    /// open curves, and curves around a handle, enclose nothing.
    pub fn enclosed(mesh: &TriMesh, along: &[[u32; 2]], side: &Side) -> Result<Self> {
        let walls = Walls::new(mesh, along)?;
        let pieces = walls.pieces(mesh.faces().len());
        match side {
            Side::Seeds(seeds) => seeded(mesh, along, &walls, &pieces, seeds),
            Side::Small => by_area(mesh, &walls, &pieces, false),
            Side::Large => by_area(mesh, &walls, &pieces, true),
        }
    }
}

/// Returns the region of the pieces with these vertices.
fn seeded(
    mesh: &TriMesh,
    along: &[[u32; 2]],
    walls: &Walls,
    pieces: &[u32],
    seeds: &[u32],
) -> Result<Region> {
    let refused = |why| Err(Error::Argument { what: "seeds", why });
    if seeds.is_empty() {
        return refused("must not be empty".into());
    }
    let mut wanted = vec![false; pieces.len()];
    for &seed in seeds {
        if along.as_flattened().contains(&seed) {
            return refused(format!("vertex {seed} is on the curve"));
        }
        let own = (0..).zip(mesh.faces()).filter(|(_, face)| face.contains(&seed));
        let mut found = false;
        for (f, _) in own {
            let f: usize = f;
            wanted[pieces[f] as usize] = true;
            found = true;
        }
        if !found {
            return refused(format!("vertex {seed} is in no face"));
        }
    }
    let inside: Vec<bool> = pieces.iter().map(|&piece| wanted[piece as usize]).collect();
    for (e, f, g) in walls.sides() {
        if pieces[f as usize] == pieces[g as usize] && inside[f as usize] {
            return Err(parts_nothing(walls, e));
        }
    }
    Ok(Region::new(inside))
}

/// Returns one of the two sides of each part with curves.
fn by_area(mesh: &TriMesh, walls: &Walls, pieces: &[u32], large: bool) -> Result<Region> {
    // The pieces across walls.
    let mut across: BTreeMap<u32, Vec<(u32, usize)>> = BTreeMap::new();
    for (e, f, g) in walls.sides() {
        let [p, q] = [f, g].map(|f| pieces[f as usize]);
        across.entry(p).or_default().push((q, e));
        across.entry(q).or_default().push((p, e));
    }
    if across.is_empty() {
        return Err(Error::Argument {
            what: "along",
            why: "must have an edge that is not on the boundary of the mesh".into(),
        });
    }
    let mut areas = vec![0.0; pieces.len()];
    for (&piece, area) in pieces.iter().zip(mesh.face_areas()) {
        areas[piece as usize] += area;
    }
    let mut sides: BTreeMap<u32, bool> = BTreeMap::new();
    let mut inside = vec![false; pieces.len()];
    for &start in across.keys() {
        if sides.contains_key(&start) {
            continue;
        }
        sides.insert(start, false);
        let mut part = Vec::new();
        let mut sums = [0.0; 2];
        let mut waiting = VecDeque::from([start]);
        while let Some(piece) = waiting.pop_front() {
            let side = sides[&piece];
            part.push(piece);
            sums[usize::from(side)] += areas[piece as usize];
            for &(other, e) in &across[&piece] {
                match sides.get(&other) {
                    Some(&known) if known == side => return Err(parts_nothing(walls, e)),
                    Some(_) => {}
                    None => {
                        sides.insert(other, !side);
                        waiting.push_back(other);
                    }
                }
            }
        }
        // The part starts at its lowest face.
        let small = sums[1] < sums[0];
        for piece in part {
            inside[piece as usize] = (sides[&piece] == small) != large;
        }
    }
    Ok(Region::new(pieces.iter().map(|&piece| inside[piece as usize]).collect()))
}

fn parts_nothing(walls: &Walls, e: usize) -> Error {
    Error::Mesh {
        what: "has the same region on both sides: curves that are open or go around a handle \
               enclose nothing"
            .into(),
        element: walls.edges.name(e),
    }
}
