//! Geodesic smoothing by edge flips (Sharp and Crane, You Can Find Geodesic Paths in Triangle
//! Meshes by Just Flipping Edges, 2020): a path shortens in an intrinsic triangulation whose
//! vertices are those of the mesh, until it is straight at every vertex except the marked ones.
//!
//! Differences from the paper: joints are processed in cyclic order, not the sharpest first; a
//! joint that could only be shortened onto a vertex of the curve itself does not change, so that
//! curves which do not meet before do not meet afterwards.

mod intrinsic;
mod trace;

use std::collections::{HashMap, HashSet};

use super::result::{Curve, Reconstruction, Waypoint};
use super::sites::refined;
use crate::mesh::vector::{Vector, dot, doubled_normal};
use crate::mesh::{Edges, TriMesh};
use catamaran::base::{Error, Result};
use intrinsic::{Intrinsic, Side};
use trace::{Chord, Tracer};

/// Largest deviation of an angle from pi that counts as straight, in radians.
const STRAIGHT: f64 = 1e-6;

/// Largest number of joints that are shortened for each vertex of the curves.
const STEPS: usize = 1000;

/// Curves after [`smooth()`].
#[derive(Debug, Clone, PartialEq)]
pub struct Smoothed {
    /// The points of each curve on the surface: vertices, and crossings of edges; the first point
    /// is not repeated.
    pub points: Vec<Vec<[f64; 3]>>,
    /// The points of each curve as waypoints on the mesh.
    pub waypoints: Vec<Vec<Waypoint>>,
    /// The length of each curve.
    pub lengths: Vec<f64>,
    /// Number of joints that were shortened.
    pub steps: usize,
    /// Whether every joint that can be straightened is straight, within the allowed steps.
    pub converged: bool,
}

impl Reconstruction {
    /// Shortens the curves to geodesics between their samples, as [`smooth()`] does. Points and
    /// lengths become those of the geodesics, while [`Curve::path`] stays. Returns whether the
    /// curves are straight except at samples; otherwise, 1,000 steps for each vertex did not
    /// suffice.
    ///
    /// - `mesh`, `samples`: the arguments of the reconstruction.
    ///
    /// ```
    /// use catamaran_geometry::{curve::{CurveOptions, CurveSolver}, mesh::families};
    ///
    /// let (mesh, samples) = (families::grid(8, 8)?, [10, 25, 64]);
    /// let mut found = CurveSolver::new(&mesh)?.reconstruct(&samples, &CurveOptions::new())?;
    /// let before = found.length();
    /// assert!(found.smooth(&mesh, &samples)? && found.length() < before);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`refined`] and [`smooth()`].
    pub fn smooth(&mut self, mesh: &TriMesh, samples: &[u32]) -> Result<bool> {
        let refined = refined(mesh, &self.steiner)?;
        self.shorten(&refined, samples)
    }

    /// Does what [`smooth`](Self::smooth) does on the mesh with the Steiner points.
    pub(super) fn shorten(&mut self, refined: &TriMesh, samples: &[u32]) -> Result<bool> {
        // A curve that happens to run over an outlier need not stay there.
        let is_outlier = |i: &u32| self.outliers.binary_search(i).is_ok();
        let marked = (0..).zip(samples).filter(|(i, _)| !is_outlier(i)).map(|(_, &v)| v);
        let marked: Vec<u32> = marked.collect();
        shorten(refined, &mut self.curves, &marked)
    }
}

/// Turns curves along edges of `mesh` into geodesics between samples, and returns whether the steps
/// sufficed.
fn shorten(mesh: &TriMesh, curves: &mut [Curve], samples: &[u32]) -> Result<bool> {
    let vertices: usize = curves.iter().map(|curve| curve.path.len()).sum();
    let smoothed = smooth(mesh, curves, samples, STEPS * vertices)?;
    let all = smoothed.points.into_iter().zip(smoothed.waypoints).zip(smoothed.lengths);
    for (curve, ((points, waypoints), length)) in curves.iter_mut().zip(all) {
        (curve.points, curve.waypoints, curve.length) = (points, waypoints, length);
    }
    Ok(smoothed.converged)
}

/// Shortens curves along edges of `mesh` to geodesics between the vertices of `marked`, through
/// which the curves still run. At most `most_steps` joints are shortened. It takes O(V + F), plus
/// the number of faces that the curves pass.
///
/// ```
/// use catamaran_geometry::curve::{CurveOptions, CurveSolver, smooth};
/// use catamaran_geometry::mesh::families;
///
/// let mesh = families::grid(8, 8)?;
/// let samples = [10, 25, 64];
/// let found = CurveSolver::new(&mesh)?.reconstruct(&samples, &CurveOptions::new())?;
/// let smoothed = smooth(&mesh, &found.curves, &samples, 1000)?;
/// // The sides of a triangle in the plane.
/// let p = samples.map(|v| mesh.vertices()[v as usize]);
/// let side = |i: usize| (0..2).map(|k| (p[i][k] - p[(i + 1) % 3][k]).powi(2)).sum::<f64>().sqrt();
/// assert!(smoothed.converged && smoothed.lengths[0] < found.length());
/// assert!((smoothed.lengths[0] - side(0) - side(1) - side(2)).abs() < 1e-9);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Mesh`] for a mesh that is not manifold, or whose faces disagree about which side is
/// outside; [`Error::Argument`] for curves that are not along edges, or use a vertex twice;
/// [`Error::NotConverged`] when the result can't be drawn on the mesh without crossings, as on
/// faces without area.
pub fn smooth(
    mesh: &TriMesh,
    curves: &[Curve],
    marked: &[u32],
    most_steps: usize,
) -> Result<Smoothed> {
    let edges = Edges::new(mesh);
    mesh.require_manifold()?;
    if let Some(&e) = mesh.inconsistent_edges(&edges).first() {
        return Err(Error::Mesh {
            what: "its faces run in the same direction".into(),
            element: edges.name(e as usize),
        });
    }
    let mut intrinsic = Intrinsic::new(mesh, &edges);
    let tracer = Tracer::new(mesh, &intrinsic);
    let marked: HashSet<u32> = marked.iter().copied().collect();
    let mut occupied = HashSet::new();
    let mut paths = Vec::new();
    for curve in curves {
        paths.push(Path::new(curve, &edges, &mut occupied, mesh.vertices().len())?);
    }
    let mut steps = 0;
    let mut converged = true;
    for path in &mut paths {
        converged &= path.shorten(&mut intrinsic, &marked, &mut occupied, most_steps, &mut steps);
    }
    let mut chords: HashMap<u32, Vec<[Vector; 2]>> = HashMap::new();
    let (mut points, mut waypoints, mut lengths) = (Vec::new(), Vec::new(), Vec::new());
    let failed = |residual| Error::NotConverged { iterations: steps, residual };
    for path in &paths {
        let (mut own, mut places) = (Vec::new(), Vec::new());
        let mut length = 0.0;
        for (i, &v) in path.vertices.iter().enumerate() {
            own.push(mesh.vertices()[v as usize]);
            places.push(Waypoint::Vertex(v));
            let Some(&edge) = path.edges.get(i) else { continue };
            let slot = intrinsic.slot(edge, v);
            length += intrinsic.length(slot);
            if intrinsic.is_original(edge) {
                continue;
            }
            let target = path.vertices[(i + 1) % path.vertices.len()];
            let found = tracer
                .trace(v, intrinsic.direction(slot), intrinsic.length(slot), target)
                .ok_or_else(|| failed(intrinsic.length(slot)))?;
            for Chord { face, ends, at } in found {
                chords.entry(face).or_default().push(ends);
                own.push(ends[1]);
                places.push(at);
            }
            // The last chord ends at the next vertex.
            own.pop();
            places.pop();
        }
        points.push(own);
        waypoints.push(places);
        lengths.push(length);
    }
    let crossing = chords.iter().filter(|(face, chords)| crosses(mesh, **face, chords)).count();
    if crossing > 0 {
        return Err(failed(crossing as f64));
    }
    Ok(Smoothed { points, waypoints, lengths, steps, converged })
}

/// A curve in the intrinsic triangulation.
struct Path {
    vertices: Vec<u32>,
    /// The edge from each vertex to the next; one fewer than vertices if the path is open.
    edges: Vec<u32>,
    closed: bool,
}

impl Path {
    fn new(curve: &Curve, edges: &Edges, occupied: &mut HashSet<u32>, n: usize) -> Result<Self> {
        let refused = |why| Err(Error::Argument { what: "curves", why });
        let vertices = curve.path.clone();
        for &v in &vertices {
            if v as usize >= n {
                return refused(format!(
                    "vertex {v} is out of range: {n} vertices, numbered from 0"
                ));
            }
            if !occupied.insert(v) {
                return refused(format!("vertex {v} occurs twice"));
            }
        }
        let mut own = Vec::new();
        let next = vertices.iter().cycle().skip(1);
        let count = vertices.len() - usize::from(!curve.closed && !vertices.is_empty());
        for (&a, &b) in vertices.iter().zip(next).take(count) {
            match edges.ends().binary_search(&[a.min(b), a.max(b)]) {
                Ok(edge) => own.push(edge as u32),
                Err(_) => return refused(format!("there is no edge from vertex {a} to {b}")),
            }
        }
        Ok(Self { vertices, edges: own, closed: curve.closed })
    }

    /// Straightens joints until none can be straightened, or the steps are used up; returns whether
    /// the path is straight.
    fn shorten(
        &mut self,
        intrinsic: &mut Intrinsic,
        marked: &HashSet<u32>,
        occupied: &mut HashSet<u32>,
        most_steps: usize,
        steps: &mut usize,
    ) -> bool {
        let (mut stuck, mut i) = (0, 0);
        // A closed curve keeps three vertices, an open one its ends.
        let fewest = if self.closed { 3 } else { 2 };
        // The loop ends when no joint of the whole curve could be shortened.
        while stuck < self.vertices.len() {
            i %= self.vertices.len();
            let inner = self.closed || (i > 0 && i + 1 < self.vertices.len());
            if inner && !marked.contains(&self.vertices[i]) && self.vertices.len() > fewest {
                if *steps == most_steps {
                    return false;
                }
                if self.straighten(i, intrinsic, occupied) {
                    *steps += 1;
                    stuck = 0;
                    i = i.saturating_sub(1);
                    continue;
                }
            }
            stuck += 1;
            i += 1;
        }
        true
    }

    /// Replaces joint i by the outer arc of its smaller wedge, if that is shorter and free.
    fn straighten(
        &mut self,
        i: usize,
        intrinsic: &mut Intrinsic,
        occupied: &mut HashSet<u32>,
    ) -> bool {
        let n = self.vertices.len();
        let (before, after) = ((i + n - 1) % n, (i + 1) % n);
        let v = self.vertices[i];
        let back = intrinsic.slot(self.edges[before], v);
        let ahead = intrinsic.slot(self.edges[i], v);
        let Some(side) = intrinsic.wedge(back, ahead, STRAIGHT) else { return false };
        let (from, to) = match side {
            Side::FromFirst => (self.edges[before], self.edges[i]),
            Side::FromSecond => (self.edges[i], self.edges[before]),
        };
        let Some(mut arc) = intrinsic.flip_out(v, from, to, STRAIGHT) else { return false };
        if side == Side::FromSecond {
            arc.reverse();
        }
        // The edges from the previous vertex to the next one, and the vertices between them.
        let mut at = self.vertices[before];
        let mut inside = Vec::new();
        for &edge in &arc {
            at = intrinsic.other_end(edge, at);
            inside.push(at);
        }
        if inside.pop() != Some(self.vertices[after])
            || inside.iter().any(|u| occupied.contains(u))
            || arc.iter().any(|edge| self.edges.contains(edge))
            || (1..inside.len()).any(|k| inside[..k].contains(&inside[k]))
        {
            return false;
        }
        occupied.remove(&v);
        occupied.extend(&inside);
        self.vertices.splice(i..=i, inside);
        match i {
            0 => {
                // The previous edge is the last one.
                self.edges.remove(0);
                let last = self.edges.len() - 1;
                let split = arc.len() - 1;
                self.edges[last] = arc[0];
                self.edges.splice(0..0, arc[1..].iter().copied().take(split));
            }
            _ => {
                self.edges.splice(before..=i, arc);
            }
        }
        true
    }
}

/// Returns whether two of the lines on a face cross inside of both.
fn crosses(mesh: &TriMesh, face: u32, chords: &[[Vector; 2]]) -> bool {
    let corners = mesh.faces()[face as usize].map(|v| mesh.vertices()[v as usize]);
    let normal = doubled_normal(corners);
    let scale = dot(normal, normal);
    let side = |[p, q]: [Vector; 2], r: Vector| {
        let value = dot(doubled_normal([p, q, r]), normal) / scale;
        if value.abs() < 1e-9 { 0.0 } else { value }
    };
    let part = |x: [Vector; 2], y: [Vector; 2]| side(x, y[0]) * side(x, y[1]) < 0.0;
    chords.iter().enumerate().any(|(i, &x)| chords[..i].iter().any(|&y| part(x, y) && part(y, x)))
}
