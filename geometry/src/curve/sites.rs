use std::borrow::Cow;

use super::refinement::Refinement;
use crate::mesh::{Refined, Site, SurfacePoint, TriMesh, nearest_vertex};
use catamaran::base::{Error, Result};

/// Barycentric coordinates below this count as 0: the point is on an edge, or at a vertex.
const NOTHING: f64 = 1e-9;

/// The treatment of a point that is not at a vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Placement {
    /// The corner with the largest weight replaces it.
    Snap,
    /// It becomes a vertex, which cuts its face, or both faces of its edge.
    Insert,
}

/// Samples as vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// The mesh with inserted vertices after its own; `None` when there are none.
    pub mesh: Option<Refined>,
    /// The vertex of each site; several sites can have the same vertex.
    pub vertices: Vec<u32>,
}

/// Finds the vertices of these sites.
///
/// ```
/// use catamaran_geometry::curve::{Placement, Site, place};
/// use catamaran_geometry::mesh::{SurfacePoint, families};
///
/// let mesh = families::grid(2, 2)?;
/// let point = SurfacePoint { face: 0, weights: [0.2, 0.3, 0.5] };
/// let sites = [Site::Near([0.9, 0.1, 0.0]), Site::Face(point)];
/// let placed = place(&mesh, &sites, Placement::Insert)?;
/// assert_eq!(placed.vertices, [6, 9]); // a corner of the square, and a new vertex
/// assert_eq!(placed.mesh.map(|refined| refined.mesh.vertices().len()), Some(10));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] names a site whose vertex or face does not exist, whose weights are not
/// barycentric coordinates, or whose point is not finite; also for a point in space when the mesh
/// has no faces.
pub fn place(mesh: &TriMesh, sites: &[Site], placement: Placement) -> Result<Placed> {
    let mut refinement = Refinement::new(Cow::Borrowed(mesh));
    let mut vertices = Vec::with_capacity(sites.len());
    let used = mesh.referenced();
    for (i, site) in sites.iter().enumerate() {
        let refused = |why| Error::Argument { what: "sites", why: format!("site {i}: {why}") };
        if let Some(why) = site.fault(mesh) {
            return Err(refused(why));
        }
        vertices.push(match *site {
            Site::Vertex(vertex) => vertex,
            Site::Near(point) => nearest_vertex(mesh, &used, point)
                .ok_or_else(|| refused("no vertex has a face".into()))?,
            Site::Face(point) => match placement {
                Placement::Snap => mesh.faces()[point.face as usize][largest(point.weights)],
                Placement::Insert => insert(&mut refinement, point)?,
            },
        });
    }
    let inserted = !refinement.positions().is_empty();
    Ok(Placed { mesh: if inserted { Some(refinement.to_mesh()?) } else { None }, vertices })
}

/// Returns the mesh with the [Steiner points](super::Reconstruction::steiner) of a reconstruction
/// as vertices after its own, so that the curves run along its edges.
///
/// ```
/// use catamaran_geometry::{curve::refined, mesh::families};
///
/// let mesh = families::grid(1, 1)?;
/// let found = refined(&mesh, &[[0, 1]])?;
/// assert_eq!((found.vertices().len(), found.faces().len()), (5, 3));
/// assert_eq!(found.area(), mesh.area());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] for an end that is neither a vertex nor an earlier point, and for two ends
/// that no edge joins.
pub fn refined(mesh: &TriMesh, steiner: &[[u32; 2]]) -> Result<TriMesh> {
    Ok(with_steiner(mesh, steiner)?.mesh)
}

/// Returns the mesh of [`refined`], with the origins of its vertices and faces.
///
/// ```
/// use catamaran_geometry::{curve::with_steiner, mesh::families};
///
/// let found = with_steiner(&families::grid(1, 1)?, &[[0, 1]])?;
/// assert_eq!((found.vertices[4].weights, found.faces.len()), ([0.5, 0.5, 0.0], 3));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`refined`].
pub fn with_steiner(mesh: &TriMesh, steiner: &[[u32; 2]]) -> Result<Refined> {
    let mut refinement = Refinement::new(Cow::Borrowed(mesh));
    for (i, ends) in steiner.iter().enumerate() {
        let known = mesh.vertices().len() + i;
        if let Some(end) = ends.iter().find(|&&end| end as usize >= known) {
            let why = format!("end {end} of point {i} is out of range: {known} vertices");
            return Err(Error::Argument { what: "steiner", why });
        }
        let [a, b] = *ends;
        if !refinement.neighbours(a).contains(&b) {
            let why = format!("point {i}: no edge joins {a} and {b}");
            return Err(Error::Argument { what: "steiner", why });
        }
        refinement.bisect(*ends)?;
    }
    refinement.to_mesh()
}

fn largest(weights: [f64; 3]) -> usize {
    (0..3).rev().max_by(|&i, &j| weights[i].total_cmp(&weights[j])).unwrap_or_default()
}

/// Returns the vertex of a point on a face, which earlier points may have cut.
fn insert(refinement: &mut Refinement<'_>, at: SurfacePoint) -> Result<u32> {
    let SurfacePoint { face, weights } = at;
    let point = at.position(refinement.mesh());
    let [first, second, _] = refinement.face(face);
    let mut best = (f64::NEG_INFINITY, face, weights);
    for piece in refinement.pieces(face) {
        // In barycentric coordinates of the whole face, which may be far from the origin, or have
        // no area.
        let corners = refinement.face(piece).map(|v| {
            let origin = refinement.origin(v);
            [origin.share(first), origin.share(second)]
        });
        let own = match piece == face {
            true => weights,
            false => shares(corners, [weights[0], weights[1]]),
        };
        let least = own.into_iter().reduce(f64::min).unwrap_or_default();
        if least > best.0 {
            best = (least, piece, own);
        }
    }
    let (_, piece, own) = best;
    let corners = refinement.face(piece);
    let there: Vec<usize> = (0..3).filter(|&i| own[i] > NOTHING).collect();
    match there[..] {
        [i] => Ok(corners[i]),
        [i, j] => {
            let share = own[j] / (own[i] + own[j]);
            Ok(refinement.cut_edge([corners[i], corners[j]], share, point)?.0)
        }
        _ => refinement.cut_face(piece, point, own),
    }
}

/// Returns the barycentric coordinates of a point in a triangle of the plane; negative infinity for
/// a triangle without area.
fn shares([a, b, c]: [[f64; 2]; 3], point: [f64; 2]) -> [f64; 3] {
    let area = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    match area(a, b, c) {
        0.0 => [f64::NEG_INFINITY; 3],
        whole => [area(point, b, c), area(a, point, c), area(a, b, point)].map(|x| x / whole),
    }
}
