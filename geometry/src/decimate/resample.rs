//! Splits long edges before a mesh is sampled (thesis, algorithm 5.3).

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::hash::BuildHasherDefault;

use super::batches::Multiply;
use crate::mesh::TriMesh;
use crate::mesh::vector::{Vector, distance};
use catamaran::base::{Error, Progress, Result, check_request, push, room};

/// A mesh with its long edges split.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Resampled {
    /// The mesh: the vertices of the input first, then the new ones.
    pub mesh: TriMesh,
    /// For each face, the face of the input that contains it.
    pub parents: Vec<u32>,
}

/// Splits edges in their middle until none is longer than `longest`, in units of length; each edge
/// is split in all of its faces, so that no gaps arise. A face with one split edge becomes two
/// faces; with two, a triangle and four triangles around the barycentre of the remaining
/// quadrilateral; with three, four triangles (thesis, algorithm 5.3 and figure 5.4; lengths are
/// measured again in every round). A quadrilateral more than four times as long as wide becomes two
/// triangles instead.
///
/// ```
/// use catamaran_geometry::{decimate::resample, mesh::families};
///
/// let mesh = families::icosphere(1)?;
/// let found = resample(&mesh, 0.2)?;
/// assert!(found.mesh.vertices().len() > mesh.vertices().len());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] when `longest` is not positive, or so small that there would be too many
/// vertices.
pub fn resample(mesh: &TriMesh, longest: f64) -> Result<Resampled> {
    resample_with(mesh, longest, Progress::none())
}

/// Most parts of a face that is split once.
const PARTS: usize = 5;

/// Length over width above which a quadrilateral is cut along a diagonal. Around the barycentre, a
/// needle would become five needles in each round.
const SLENDER: f64 = 4.0;

/// Bytes of a face, of its share of the vertices and of its parent.
const BYTES_OF_A_FACE: f64 = 28.0;

pub(super) fn resample_with(
    mesh: &TriMesh,
    longest: f64,
    progress: Progress<'_>,
) -> Result<Resampled> {
    if longest.is_nan() || longest <= 0.0 {
        let why = format!("must be positive, is {longest}");
        return Err(Error::Argument { what: "longest", why });
    }
    // A triangle without a longer edge has at most this area.
    let largest = longest * longest * 3f64.sqrt() / 4.0;
    let least = mesh.area() / largest;
    if least > f64::from(u32::MAX) {
        let why =
            format!("{longest:e} needs at least {least:.1e} faces, more than a mesh can have");
        return Err(Error::Argument { what: "longest", why });
    }
    let request = format_args!("{longest:e}, at least {least:.1e} faces");
    check_request("longest", request, least * BYTES_OF_A_FACE)?;
    let (mut vertices, mut faces) = (mesh.vertices().to_vec(), mesh.faces().to_vec());
    let mut parents: Vec<u32> = (0..faces.len() as u32).collect();
    let is_long = |vertices: &[Vector], a: u32, b: u32| {
        distance(vertices[a as usize], vertices[b as usize]) > longest
    };
    let has_long = |vertices: &[Vector], [a, b, c]: [u32; 3]| {
        is_long(vertices, a, b) || is_long(vertices, b, c) || is_long(vertices, c, a)
    };
    // The midpoint of a long edge is shared by all of its faces.
    let mut open: Vec<u32> =
        (0..).zip(&faces).filter(|(_, face)| has_long(&vertices, **face)).map(|f| f.0).collect();
    let mut middles: HashMap<[u32; 2], u32, BuildHasherDefault<Multiply>> = HashMap::default();
    for round in 1.. {
        progress.report(1.0 - 1.0 / f64::from(round))?;
        if open.is_empty() {
            break;
        }
        middles.clear();
        let mut next = Vec::new();
        for &f in &open {
            let [a, b, c] = faces[f as usize];
            let refused = |_| Error::OutOfMemory { bytes: 3 * size_of::<[u32; 3]>() };
            middles.try_reserve(3).map_err(refused)?;
            let mut of_edges = [None; 3];
            for (middle, (u, v)) in of_edges.iter_mut().zip([(a, b), (b, c), (c, a)]) {
                if !is_long(&vertices, u, v) {
                    continue;
                }
                *middle = Some(match middles.entry([u.min(v), u.max(v)]) {
                    Entry::Occupied(known) => *known.get(),
                    Entry::Vacant(new) => {
                        let ends = [u, v].map(|w| vertices[w as usize]);
                        *new.insert(add(&mut vertices, &ends)?)
                    }
                });
            }
            let first = faces.len();
            split_face([a, b, c], of_edges, &mut vertices, &mut faces)?;
            // One of the parts replaces the face.
            faces.swap_remove(f as usize);
            room(&mut parents, PARTS)?;
            parents.resize(faces.len(), parents[f as usize]);
            let parts = (first..faces.len()).chain([f as usize]);
            room(&mut next, PARTS)?;
            next.extend(parts.filter(|&g| has_long(&vertices, faces[g])).map(|g| g as u32));
        }
        next.sort_unstable();
        open = next;
    }
    Ok(Resampled { mesh: TriMesh::new(vertices, faces)?, parents })
}

/// Adds the mean of these points to the vertices, and returns its index.
fn add(vertices: &mut Vec<Vector>, points: &[Vector]) -> Result<u32> {
    let number = u32::try_from(vertices.len()).ok().filter(|&number| number < u32::MAX / 8);
    let Some(number) = number else {
        let why = "is too small: there would be 2^29 vertices".into();
        return Err(Error::Argument { what: "longest", why });
    };
    let share = 1.0 / points.len() as f64;
    push(vertices, std::array::from_fn(|k| points.iter().map(|p| share * p[k]).sum()))?;
    Ok(number)
}

/// Returns the parts of a face; `middles` are those of the edges that start at its corners.
fn split_face(
    face: [u32; 3],
    middles: [Option<u32>; 3],
    vertices: &mut Vec<Vector>,
    faces: &mut Vec<[u32; 3]>,
) -> Result<()> {
    let split = middles.iter().flatten().count();
    room(faces, PARTS)?;
    // Rotated so that a single split edge, or a single unsplit one, comes first.
    let alone = |middle: &Option<u32>| middle.is_some() == (split == 1);
    let turn = middles.iter().position(alone).unwrap_or(0);
    let [a, b, c] = [0, 1, 2].map(|k| face[(turn + k) % 3]);
    match [0, 1, 2].map(|k| middles[(turn + k) % 3]) {
        [None, None, None] => faces.push(face),
        [Some(m), None, None] => faces.extend([[a, m, c], [m, b, c]]),
        [None, Some(p), Some(q)] => {
            // The triangle at c, and the quadrilateral a, b, p, q.
            faces.push([q, p, c]);
            let corners = [a, b, p, q].map(|v| vertices[v as usize]);
            let side = |i: usize, k: usize| distance(corners[i], corners[k]);
            if SLENDER * side(0, 1) < side(1, 2).min(side(3, 0)) {
                let is_first = side(0, 2) <= side(1, 3);
                faces.extend(if is_first {
                    [[a, b, p], [a, p, q]]
                } else {
                    [[a, b, q], [b, p, q]]
                });
            } else {
                let middle = add(vertices, &corners)?;
                faces.extend([[a, b], [b, p], [p, q], [q, a]].map(|[u, v]| [u, v, middle]));
            }
        }
        [Some(m), Some(p), Some(q)] => {
            faces.extend([[a, m, q], [m, b, p], [q, p, c], [m, p, q]]);
        }
        // The rotation excludes this case.
        _ => faces.push(face),
    }
    Ok(())
}
