//! Splits long edges before a mesh is sampled (thesis, algorithm 5.3).

use super::splits::{Splits, Stretched};
use super::strips::{cut_strip, slender};
use crate::mesh::TriMesh;
use crate::mesh::vector::{distance, doubled_normal, norm};
use catamaran::base::{Error, Progress, Result, check_request, room};

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
/// measured again in every round). A slender face, at most as high as `longest` and more than four
/// times as long as high, becomes a strip of triangles between its sides instead, whose number is
/// proportional to its length.
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
    Ok(resample_with(mesh, longest, None, Progress::none())?.0)
}

/// Most parts of a face that is no strip and is split once.
const PARTS: usize = 5;

/// Bytes of a face, of its share of the vertices and of its parent.
const BYTES_OF_A_FACE: f64 = 28.0;

/// As [`resample`], for lengths with a `stretch`, the factors at the vertices, which is also
/// returned for the new ones.
pub(super) fn resample_with(
    mesh: &TriMesh,
    longest: f64,
    stretch: Option<&[f64]>,
    progress: Progress<'_>,
) -> Result<(Resampled, Option<Stretched>)> {
    if longest.is_nan() || longest <= 0.0 {
        let why = format!("must be positive, is {longest}");
        return Err(Error::Argument { what: "longest", why });
    }
    let least = least_faces(mesh, longest, stretch);
    if least > f64::from(u32::MAX) {
        let why =
            format!("{longest:e} needs at least {least:.1e} faces, more than a mesh can have");
        return Err(Error::Argument { what: "longest", why });
    }
    let request = format_args!("{longest:e}, at least {least:.1e} faces");
    check_request("longest", request, least * BYTES_OF_A_FACE)?;
    let mut faces = mesh.faces().to_vec();
    let mut parents: Vec<u32> = (0..faces.len() as u32).collect();
    let mut splits = Splits::new(mesh.vertices().to_vec(), longest, stretch);
    let mut open: Vec<u32> =
        (0..).zip(&faces).filter(|(_, face)| splits.has_long(**face)).map(|f| f.0).collect();
    for round in 1.. {
        progress.report(1.0 - 1.0 / f64::from(round))?;
        if open.is_empty() {
            break;
        }
        splits.next_round();
        let mut next = Vec::new();
        for &f in &open {
            let face = faces[f as usize];
            let first = faces.len();
            match slender(face, &splits) {
                Some(face) => cut_strip(face, &mut splits, &mut faces)?,
                None => {
                    let middles = splits.middles_of(face)?;
                    split_face(face, middles, &mut splits, &mut faces)?;
                }
            }
            // One of the parts replaces the face.
            let parts = faces.len() - first;
            faces.swap_remove(f as usize);
            room(&mut parents, parts)?;
            parents.resize(faces.len(), parents[f as usize]);
            room(&mut next, parts)?;
            let parts = (first..faces.len()).chain([f as usize]);
            next.extend(parts.filter(|&g| splits.has_long(faces[g])).map(|g| g as u32));
        }
        next.sort_unstable();
        open = next;
    }
    Ok((Resampled { mesh: TriMesh::new(splits.vertices, faces)?, parents }, splits.stretched))
}

/// Returns a lower bound of the number of faces without longer edges, of which one has at most the
/// area of an equilateral triangle, and one is at each part of an edge.
fn least_faces(mesh: &TriMesh, longest: f64, stretch: Option<&[f64]>) -> f64 {
    let largest = longest * longest * 3f64.sqrt() / 4.0;
    let of_face = |face: &[u32; 3]| {
        let [a, b, c] = face.map(|v| mesh.vertices()[v as usize]);
        let length = distance(a, b).max(distance(b, c)).max(distance(c, a));
        let least = |factors: &[f64]| {
            face.iter().fold(f64::INFINITY, |least, &v| least.min(factors[v as usize]))
        };
        let factor = stretch.map_or(1.0, least);
        let area = 0.5 * norm(doubled_normal([a, b, c])) * factor * factor;
        (area / largest).max(length * factor / longest).max(1.0)
    };
    mesh.faces().iter().map(of_face).sum()
}

/// Adds the parts of a face; `middles` are those of the edges that start at its corners.
fn split_face(
    face: [u32; 3],
    middles: [Option<u32>; 3],
    splits: &mut Splits,
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
            let middle = splits.add(&[a, b, p, q])?;
            faces.extend([[a, b], [b, p], [p, q], [q, a]].map(|[u, v]| [u, v, middle]));
        }
        [Some(m), Some(p), Some(q)] => {
            faces.extend([[a, m, q], [m, b, p], [q, p, c], [m, p, q]]);
        }
        // The rotation excludes this case.
        _ => faces.push(face),
    }
    Ok(())
}
