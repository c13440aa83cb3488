//! Densities of vertices that are larger where a surface bends.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::size::edge_length_for;
use crate::mesh::vector::{Vector, cross, distance, dot, doubled_normal, norm, sub, unit};
use crate::mesh::{Edges, TriMesh, vertex_areas};
use catamaran::base::{Result, spend, within};

/// Standard deviation of the weights of the curvatures around a vertex of which its own is the
/// mean, along each axis, in edges of the result: triangles can't follow finer bends.
const REACH: f64 = 0.35;

/// Largest growth of the length of edges over a path, relative to its length.
const GRADING: f64 = 0.2;

/// Curvature times length of edges below which a surface is flat.
const FLAT: f64 = 1e-3;

/// Bounds of the cotangent weights of edges, so that few steps solve an equation.
const WEIGHTS: (f64, f64) = (0.02, 20.0);

/// Largest number of steps that solve an equation, and the part of the error that they leave.
const STEPS: usize = 200;
const LEFT: f64 = 1e-4;

/// Operations that a vertex is equal to in a step.
const STEP: f64 = 200.0;

/// Computes a density for [`DecimateOptions::density`](super::DecimateOptions::density) that is
/// proportional to the curvature of `mesh`, so that `n` vertices are as far from the surface where
/// it bends as elsewhere: one positive number for each vertex, of which only ratios count. The
/// largest is at most `range`, from 1 to 10^6, times the least.
///
/// The curvature at a vertex is the root of the sum of the squares of the principal curvatures, of
/// their tensor (Cohen-Steiner and Morvan, Restricted Delaunay Triangulations and Normal Cycle,
/// 2003) averaged over about an edge of the result, which is insensitive to finer noise. It counts
/// from 1 / sqrt(`range`) to sqrt(`range`) times its mean. Lengths of edges that the density
/// implies grow by at most a fifth of the way between two vertices.
///
/// ```
/// use catamaran_geometry::{decimate::curvature_density, mesh::families};
///
/// let mesh = families::cylinder(40, 20, 1.0, 4.0)?;
/// let density = curvature_density(&mesh, 200, 16.0)?;
/// let (least, most) = density.iter().fold((f64::MAX, 0f64), |(a, b), &d| (a.min(d), b.max(d)));
/// assert!(least > 0.0 && most <= 16.0 * least);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`](catamaran::Error::Argument) when n is 0, `range` is out of range, or the
/// mesh has no area; [`Error::Mesh`](catamaran::Error::Mesh) when lengths are out of range;
/// [`Error::Cancelled`](catamaran::Error::Cancelled).
pub fn curvature_density(mesh: &TriMesh, n: usize, range: f64) -> Result<Vec<f64>> {
    within("range", range, 1.0, 1e6)?;
    mesh.check_size()?;
    let length = edge_length_for(mesh.area(), n)?;
    let graph = Graph::new(mesh);
    let tensors = graph.smoothed(tensors(mesh, &graph.edges), (REACH * length).powi(2))?;
    let curvatures: Vec<f64> = tensors
        .iter()
        .map(|[xx, yy, zz, xy, yz, zx]| {
            let square = xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + yz * yz + zx * zx);
            square.sqrt().max(FLAT / length)
        })
        .collect();
    let total: f64 = graph.areas.iter().sum();
    let mean = curvatures.iter().zip(&graph.areas).map(|(k, area)| k * area).sum::<f64>() / total;
    let bound = range.sqrt();
    let counted = curvatures.into_iter().map(|k| (k / mean).clamp(1.0 / bound, bound));
    let sizes = graph.graded(counted.map(|k| 1.0 / k.sqrt()).collect(), GRADING / length)?;
    Ok(sizes.into_iter().map(|size| 1.0 / (size * size)).collect())
}

/// The components xx, yy, zz, xy, yz and zx of a symmetric tensor.
type Tensor = [f64; 6];

/// Returns the integral of the tensor of curvature over the surface at each vertex: half of that
/// of each of its edges, the dihedral angle times the length along the direction.
fn tensors(mesh: &TriMesh, edges: &Edges) -> Vec<Tensor> {
    let position = |v: u32| mesh.vertices()[v as usize];
    let mut tensors = vec![[0.0; 6]; mesh.vertices().len()];
    for (e, &ends) in edges.ends().iter().enumerate() {
        let &[first, second] = edges.corners().row(e) else { continue };
        let of_corner = |corner: u32| {
            let face = mesh.faces()[corner as usize / 3];
            let normal = unit(doubled_normal(face.map(position)));
            (face[corner as usize % 3], normal)
        };
        let ((from, normal), (other, across)) = (of_corner(first), of_corner(second));
        // Faces that agree pass the edge in opposite directions.
        let across = if other == from { across.map(|x| -x) } else { across };
        let [a, b] = ends.map(position);
        let edge = sub(b, a);
        let direction = unit(if ends[0] == from { edge } else { edge.map(|x| -x) });
        let angle = dot(cross(normal, across), direction).atan2(dot(normal, across));
        let [x, y, z] = direction;
        let half = 0.5 * angle * norm(edge);
        let products = [x * x, y * y, z * z, x * y, y * z, z * x];
        for v in ends {
            (0..6).for_each(|k| tensors[v as usize][k] += half * products[k]);
        }
    }
    tensors
}

/// The edges of a mesh, with their lengths and the weights of its Laplacian, and the areas of the
/// vertices.
struct Graph {
    edges: Edges,
    lengths: Vec<f64>,
    weights: Vec<f64>,
    areas: Vec<f64>,
}

impl Graph {
    fn new(mesh: &TriMesh) -> Self {
        let edges = Edges::new(mesh);
        let position = |v: u32| mesh.vertices()[v as usize];
        let mut weights = vec![0.0; edges.len()];
        for (corner, &e) in edges.of_corners().iter().enumerate() {
            let face = mesh.faces()[corner / 3];
            let [a, b, c] = [0, 1, 2].map(|k| position(face[(corner + k) % 3]));
            weights[e as usize] += 0.5 * cotangent(a, b, c);
        }
        let lengths = edges.ends().iter().map(|ends| {
            let [a, b] = ends.map(position);
            distance(a, b)
        });
        let (low, high) = WEIGHTS;
        Self {
            lengths: lengths.collect(),
            weights: weights.into_iter().map(|weight| weight.clamp(low, high)).collect(),
            areas: vertex_areas(mesh),
            edges,
        }
    }

    /// Returns the means of tensors, of which the integrals at each vertex are given, in its
    /// neighbourhood: the solution x of (M + t L) x = `integrals`, where M has the areas of the
    /// vertices and L is the Laplacian, by conjugate gradients for all six components.
    fn smoothed(&self, integrals: Vec<Tensor>, t: f64) -> Result<Vec<Tensor>> {
        let mut diagonal = self.areas.clone();
        for (&[a, b], weight) in self.edges.ends().iter().zip(&self.weights) {
            diagonal[a as usize] += t * weight;
            diagonal[b as usize] += t * weight;
        }
        let inverse: Vec<f64> =
            diagonal.iter().map(|&d| if d > 0.0 { 1.0 / d } else { 0.0 }).collect();
        let product = |x: &[Tensor], y: &[Tensor], scale: &dyn Fn(usize) -> f64| {
            let mut sums = [0.0; 6];
            for (v, (x, y)) in x.iter().zip(y).enumerate() {
                let scale = scale(v);
                (0..6).for_each(|k| sums[k] += scale * x[k] * y[k]);
            }
            sums
        };
        let ratio = |x: Tensor, y: Tensor| {
            std::array::from_fn::<f64, 6, _>(|k| if y[k] > 0.0 { x[k] / y[k] } else { 0.0 })
        };
        let mut rest = integrals;
        let mut found = vec![[0.0; 6]; rest.len()];
        let scaled = |rest: &[Tensor]| -> Vec<Tensor> {
            rest.iter().zip(&inverse).map(|(rest, inverse)| rest.map(|x| x * inverse)).collect()
        };
        let mut step = scaled(&rest);
        let mut size = product(&rest, &rest, &|v| inverse[v]);
        let enough = LEFT * LEFT * size.iter().sum::<f64>();
        for _ in 0..STEPS {
            if size.iter().sum::<f64>() <= enough {
                break;
            }
            spend(STEP * rest.len() as f64)?;
            let applied = self.apply(&step, t);
            let part = ratio(size, product(&step, &applied, &|_| 1.0));
            for (v, applied) in applied.iter().enumerate() {
                for k in 0..6 {
                    found[v][k] += part[k] * step[v][k];
                    rest[v][k] -= part[k] * applied[k];
                }
            }
            let next = product(&rest, &rest, &|v| inverse[v]);
            let keep = ratio(next, size);
            size = next;
            for (v, step) in step.iter_mut().enumerate() {
                (0..6).for_each(|k| step[k] = rest[v][k] * inverse[v] + keep[k] * step[k]);
            }
        }
        Ok(found)
    }

    /// Returns (M + t L) x.
    fn apply(&self, x: &[Tensor], t: f64) -> Vec<Tensor> {
        let mut y: Vec<Tensor> =
            x.iter().zip(&self.areas).map(|(x, area)| x.map(|x| area * x)).collect();
        for (&[a, b], weight) in self.edges.ends().iter().zip(&self.weights) {
            let [a, b] = [a as usize, b as usize];
            for k in 0..6 {
                let flow = t * weight * (x[a][k] - x[b][k]);
                y[a][k] += flow;
                y[b][k] -= flow;
            }
        }
        y
    }

    /// Returns the largest sizes that are at most these, and whose differences are at most `slope`
    /// times the lengths of edges.
    fn graded(&self, mut sizes: Vec<f64>, slope: f64) -> Result<Vec<f64>> {
        let mut starts = vec![0u32; sizes.len() + 1];
        self.edges.ends().iter().flatten().for_each(|&v| starts[v as usize + 1] += 1);
        (0..sizes.len()).for_each(|v| starts[v + 1] += starts[v]);
        let mut next = starts.clone();
        let mut links = vec![(0, 0.0); 2 * self.edges.len()];
        for (&[a, b], &length) in self.edges.ends().iter().zip(&self.lengths) {
            for (from, to) in [(a, b), (b, a)] {
                links[next[from as usize] as usize] = (to, length);
                next[from as usize] += 1;
            }
        }
        // Sizes are positive, so that their bits have the order of the numbers.
        let mut waiting: BinaryHeap<_> =
            (0u32..).zip(&sizes).map(|(v, size)| Reverse((size.to_bits(), v))).collect();
        while let Some(Reverse((bits, v))) = waiting.pop() {
            spend(STEP)?;
            let size = f64::from_bits(bits);
            if size > sizes[v as usize] {
                continue; // lowered since
            }
            let around = starts[v as usize] as usize..starts[v as usize + 1] as usize;
            for &(to, length) in &links[around] {
                let most = size + slope * length;
                if most < sizes[to as usize] {
                    sizes[to as usize] = most;
                    waiting.push(Reverse((most.to_bits(), to)));
                }
            }
        }
        Ok(sizes)
    }
}

/// Returns the cotangent of the angle at c; 0 in a face without area.
fn cotangent(a: Vector, b: Vector, c: Vector) -> f64 {
    let (p, q) = (sub(a, c), sub(b, c));
    let height = norm(cross(p, q));
    if height > 0.0 { dot(p, q) / height } else { 0.0 }
}
