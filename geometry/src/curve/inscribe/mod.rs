//! Draws curves into a mesh: creates a mesh of the same surface with the curves along its edges.

mod cells;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use super::result::{Curve, Waypoint, total};
use crate::mesh::vector::distance;
use crate::mesh::{Edges, Origin, Refined, TriMesh};
use catamaran::base::{Error, Result};
use cells::{Cells, Point};

/// Points of an edge nearer to each other than this share of it, or to its ends, become one.
const SAME: f64 = 1e-9;

/// A mesh with curves along its edges.
#[derive(Debug, Clone, PartialEq)]
pub struct Inscribed {
    /// The mesh, with its origin on the input.
    pub refined: Refined,
    /// The curves, as paths of its vertices. Curves that cross share a vertex there.
    pub curves: Vec<Curve>,
}

impl Curve {
    /// Returns the edges of the path, each with its lower vertex first.
    ///
    /// ```
    /// use catamaran_geometry::curve::{CurveOptions, CurveSolver};
    /// use catamaran_geometry::mesh::families;
    ///
    /// let mesh = families::grid(8, 8)?;
    /// let found = CurveSolver::new(&mesh)?.reconstruct(&[10, 70, 16, 64], &CurveOptions::new())?;
    /// assert_eq!(found.curves[0].edges().len(), found.curves[0].path.len()); // closed
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let next = self.path.iter().skip(1).chain(self.path.first().filter(|_| self.closed));
        let ends = self.path.iter().zip(next).filter(|(a, b)| a != b);
        ends.map(|(&a, &b)| [a.min(b), a.max(b)]).collect()
    }
}

/// Cuts the faces of a mesh along curves: new vertices, numbered after those of the mesh, lie where
/// curves cross edges and each other. Curves along edges change nothing. It takes O(V + F), plus
/// the number of faces that the curves pass.
///
/// Points nearer to each other than 1e-9 of an edge become one.
///
/// ```
/// use catamaran_geometry::curve::{CurveOptions, CurveSolver, inscribe};
/// use catamaran_geometry::mesh::families;
///
/// let (mesh, samples) = (families::grid(8, 8)?, [10, 25, 64]);
/// let mut found = CurveSolver::new(&mesh)?.reconstruct(&samples, &CurveOptions::new())?;
/// found.smooth(&mesh, &samples)?;
/// let inscribed = inscribe(&mesh, &found.curves)?;
/// assert!(inscribed.refined.mesh.faces().len() > mesh.faces().len());
/// assert!((inscribed.refined.mesh.area() - mesh.area()).abs() < 1e-14);
/// assert!((inscribed.curves[0].length - found.length()).abs() < 1e-9);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] for waypoints that are not on the mesh, or for successive waypoints on no
/// common face; [`Error::Mesh`] names a face on which curves are too near to each other to be
/// distinguished.
pub fn inscribe(mesh: &TriMesh, curves: &[Curve]) -> Result<Inscribed> {
    let edges = Edges::new(mesh);
    let mut draft = Draft::new(mesh, &edges);
    let spots = draft.spots(curves)?;
    let legs = draft.legs(curves, &spots)?;
    let ways = draft.cut_faces(&legs)?;
    let refined = draft.finish()?;
    let positions = refined.mesh.vertices();
    let drawn = curves.iter().zip(ways).zip(&spots).map(|((curve, ways), spots)| {
        let first = spots.first().map(|spot| spot.vertex);
        let mut path: Vec<u32> = first.into_iter().chain(ways.into_iter().flatten()).collect();
        path.dedup();
        if curve.closed && path.len() > 1 && path.first() == path.last() {
            path.pop();
        }
        let points: Vec<_> = path.iter().map(|&v| positions[v as usize]).collect();
        let next = points.iter().skip(1).chain(points.first().filter(|_| curve.closed));
        let length = total(points.iter().zip(next).map(|(&p, &q)| distance(p, q)));
        let waypoints = path.iter().map(|&v| Waypoint::Vertex(v)).collect();
        Curve { order: curve.order.clone(), path, points, waypoints, closed: curve.closed, length }
    });
    Ok(Inscribed { curves: drawn.collect(), refined })
}

/// A waypoint as a vertex of the finer mesh, with the edge that contains it.
#[derive(Clone, Copy)]
struct Spot {
    vertex: u32,
    edge: Option<u32>,
}

/// The step from one waypoint to the next, across a face.
struct Leg {
    face: u32,
    curve: usize,
    number: usize,
    ends: [u32; 2],
}

struct Draft<'m> {
    mesh: &'m TriMesh,
    edges: &'m Edges,
    /// For each edge with new points, their positions from its first end and their vertices,
    /// sorted.
    on_edges: BTreeMap<u32, Vec<(f64, u32)>>,
    positions: Vec<[f64; 3]>,
    origins: Vec<Origin>,
    /// The pieces of each face that was cut.
    pieces: BTreeMap<u32, Vec<[u32; 3]>>,
}

/// For each curve and each of its legs, the vertices after the first.
type Ways = Vec<Vec<Vec<u32>>>;

impl<'m> Draft<'m> {
    fn new(mesh: &'m TriMesh, edges: &'m Edges) -> Self {
        Self {
            mesh,
            edges,
            on_edges: BTreeMap::new(),
            positions: mesh.vertices().to_vec(),
            origins: (0..mesh.vertices().len() as u32).map(Origin::vertex).collect(),
            pieces: BTreeMap::new(),
        }
    }

    /// Returns the vertices of all waypoints, and creates those on edges.
    fn spots(&mut self, curves: &[Curve]) -> Result<Vec<Vec<Spot>>> {
        let n = self.mesh.vertices().len();
        let mut crossings = Vec::new();
        let mut spots: Vec<Vec<Spot>> = Vec::new();
        for (i, curve) in curves.iter().enumerate() {
            let refused = |why| Err(Error::Argument { what: "curves", why });
            let mut own = Vec::with_capacity(curve.waypoints.len());
            for (j, waypoint) in curve.waypoints.iter().enumerate() {
                let vertex = match *waypoint {
                    Waypoint::Vertex(v) => v,
                    Waypoint::Edge { ends: [a, b], share } => {
                        let Ok(edge) = self.edges.ends().binary_search(&[a.min(b), a.max(b)])
                        else {
                            return refused(format!("curve {i}, point {j}: no edge {a}-{b}"));
                        };
                        let share = if a < b { share } else { 1.0 - share };
                        if !(0.0..=1.0).contains(&share) {
                            return refused(format!(
                                "curve {i}, point {j}: share {share} of {a}-{b} is not in 0..=1"
                            ));
                        }
                        if share <= SAME {
                            a.min(b)
                        } else if share >= 1.0 - SAME {
                            a.max(b)
                        } else {
                            crossings.push((edge as u32, share, i, j));
                            u32::MAX
                        }
                    }
                };
                if vertex != u32::MAX && vertex as usize >= n {
                    return refused(format!("curve {i}, point {j}: no vertex {vertex}"));
                }
                own.push(Spot { vertex, edge: None });
            }
            spots.push(own);
        }
        crossings.sort_by(|x, y| x.0.cmp(&y.0).then(x.1.total_cmp(&y.1)));
        for (edge, share, i, j) in crossings {
            let known = self.on_edges.get(&edge).and_then(|points| points.last());
            let vertex = match known {
                Some(&(before, vertex)) if share - before <= SAME => vertex,
                _ => {
                    let [a, b] = self.edges.ends()[edge as usize];
                    let [p, q] = [a, b].map(|v| self.mesh.vertices()[v as usize]);
                    let parts = [(Origin::vertex(a), 1.0 - share), (Origin::vertex(b), share)];
                    let at = std::array::from_fn(|k| p[k] + share * (q[k] - p[k]));
                    let vertex = self.add(at, Origin::between(&parts));
                    self.on_edges.entry(edge).or_default().push((share, vertex));
                    vertex
                }
            };
            spots[i][j] = Spot { vertex, edge: Some(edge) };
        }
        Ok(spots)
    }

    fn add(&mut self, at: [f64; 3], origin: Origin) -> u32 {
        self.positions.push(at);
        self.origins.push(origin);
        self.positions.len() as u32 - 1
    }

    /// Returns the legs between waypoints, each across a face that has both.
    fn legs(&self, curves: &[Curve], spots: &[Vec<Spot>]) -> Result<Vec<Leg>> {
        let mut legs = Vec::new();
        for (i, (curve, own)) in curves.iter().zip(spots).enumerate() {
            let next = own.iter().skip(1).chain(own.first().filter(|_| curve.closed));
            for (j, (from, to)) in own.iter().zip(next).enumerate() {
                let Some(face) = self.common_face(*from, *to) else {
                    return Err(Error::Argument {
                        what: "curves",
                        why: format!("curve {i}: no face has both point {j} and the next one"),
                    });
                };
                legs.push(Leg { face, curve: i, number: j, ends: [from.vertex, to.vertex] });
            }
        }
        Ok(legs)
    }

    fn common_face(&self, from: Spot, to: Spot) -> Option<u32> {
        let edge = match (from.edge, to.edge) {
            (Some(edge), _) | (None, Some(edge)) => edge,
            (None, None) => {
                let [a, b] = [from.vertex, to.vertex];
                // A leg has length zero after its points became one.
                let at = self.edges.ends().partition_point(|ends| ends[0] < a);
                if a == b {
                    let any = self.edges.ends().get(at).filter(|ends| ends[0] == a);
                    let edge = any
                        .map(|_| at)
                        .or_else(|| self.edges.ends().iter().position(|ends| ends[1] == a));
                    return self.edges.faces(edge?).next();
                }
                self.edges.ends().binary_search(&[a.min(b), a.max(b)]).ok()? as u32
            }
        };
        let has = |face: u32, spot: Spot| match spot.edge {
            Some(edge) => self.edges_of(face).contains(&edge),
            None => self.mesh.faces()[face as usize].contains(&spot.vertex),
        };
        self.edges.faces(edge as usize).find(|&face| has(face, from) && has(face, to))
    }

    fn edges_of(&self, face: u32) -> [u32; 3] {
        std::array::from_fn(|i| self.edges.of_corners()[3 * face as usize + i])
    }

    /// Cuts all faces with points on their sides or curves across them.
    fn cut_faces(&mut self, legs: &[Leg]) -> Result<Ways> {
        let mut by_face: BTreeMap<u32, Vec<&Leg>> = BTreeMap::new();
        for leg in legs {
            by_face.entry(leg.face).or_default().push(leg);
        }
        for &edge in self.on_edges.keys() {
            for face in self.edges.faces(edge as usize) {
                by_face.entry(face).or_default();
            }
        }
        let curves = legs.iter().map(|leg| leg.curve + 1).max().unwrap_or(0);
        let mut ways: Ways = vec![Vec::new(); curves];
        for leg in legs {
            ways[leg.curve].push(Vec::new());
        }
        for (face, legs) in by_face {
            let mut cells = Cells::new(self.sides(face));
            let place = |cells: &Cells, vertex| {
                let all = &cells.points;
                all.iter().position(|p| p.vertex == Some(vertex)).unwrap_or_default()
            };
            for leg in &legs {
                let [a, b] = leg.ends.map(|v| place(&cells, v));
                cells.cut(a, b).map_err(|e| near(e, face))?;
            }
            let triangle = self.mesh.faces()[face as usize];
            let corners = triangle.map(|v| self.mesh.vertices()[v as usize]);
            let vertices: Vec<u32> = (0..cells.points.len())
                .map(|i| match cells.points[i] {
                    Point { vertex: Some(v), .. } => v,
                    Point { shares, vertex: None } => {
                        let origin = Origin { vertices: triangle, weights: shares };
                        self.add(cells.place(i, corners), origin)
                    }
                })
                .collect();
            for leg in &legs {
                let [a, b] = leg.ends.map(|v| place(&cells, v));
                let way = cells.cut(a, b).map_err(|e| near(e, face))?;
                let behind = way.iter().skip(1).map(|&p| vertices[p]);
                ways[leg.curve][leg.number] = behind.collect();
            }
            let pieces = cells.triangles(corners).into_iter();
            self.pieces.insert(face, pieces.map(|t| t.map(|p| vertices[p])).collect());
        }
        Ok(ways)
    }

    /// Returns the corners and points of the sides of a face, each side from its first corner on.
    fn sides(&self, face: u32) -> [Vec<Point>; 3] {
        let triangle = self.mesh.faces()[face as usize];
        std::array::from_fn(|i| {
            let [a, b] = [triangle[i], triangle[(i + 1) % 3]];
            let edge = self.edges.of_corners()[3 * face as usize + i];
            let at = |share: f64, vertex| {
                let mut shares = [0.0; 3];
                shares[i] = 1.0 - share;
                shares[(i + 1) % 3] = share;
                Point { shares, vertex: Some(vertex) }
            };
            let points = self.on_edges.get(&edge).map_or(&[][..], |points| points);
            let mut side: Vec<Point> = points
                .iter()
                .map(|&(share, vertex)| at(if a < b { share } else { 1.0 - share }, vertex))
                .collect();
            if a > b {
                side.reverse();
            }
            side.insert(0, at(0.0, a));
            side
        })
    }

    fn finish(self) -> Result<Refined> {
        let (mut all, mut faces) = (Vec::new(), Vec::new());
        for (f, &face) in (0..).zip(self.mesh.faces()) {
            let own = self.pieces.get(&f).map_or(std::slice::from_ref(&face), |pieces| pieces);
            all.extend(own);
            faces.extend(std::iter::repeat_n(f, own.len()));
        }
        let mesh = TriMesh::new(self.positions, all)?;
        Ok(Refined { mesh, faces, vertices: self.origins })
    }
}

/// Returns an error that names the face that could not be cut.
fn near(error: Error, face: u32) -> Error {
    match error {
        Error::NotConverged { .. } => Error::Mesh {
            what: "curves on it are too near to each other to be distinguished".into(),
            element: format!("face {face}"),
        },
        other => other,
    }
}
