//! Compares two meshes: how far each is from the other, and how their normals differ.

use rstar::{AABB, PointDistance, RTree, RTreeObject};

use super::TriMesh;
use super::vector::{Vector, cross, dot, doubled_normal, norm, square, sub, unit};
use catamaran::base::{Error, Par, Result};

/// Points that one thread takes at a time.
const BLOCK: usize = 1024;

/// Number of points spread over each surface, in addition to its vertices.
const SAMPLES: usize = 100_000;

/// Distances from one surface to another one, in units of length.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct OneSided {
    /// The largest distance of its vertices, and of points spread over it by area, from the surface
    /// of the other mesh, in units of length.
    pub largest: f64,
    /// The mean distance of the points spread over it, in units of length.
    pub mean: f64,
    /// The mean angle between its normals at these points and those of the other mesh nearest to
    /// them, in degrees from 0 to 180; faces without area are not counted.
    pub angle: f64,
}

/// Distances between two meshes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Comparison {
    /// From the first mesh to the second one.
    pub out: OneSided,
    /// From the second mesh to the first one.
    pub back: OneSided,
}

impl Comparison {
    /// Compares `first` and `second` at their vertices and at 100,000 points spread over each by
    /// area. O(V log F); the same for any `par`.
    ///
    /// ```
    /// use catamaran::Par;
    /// use catamaran_geometry::mesh::{Comparison, families};
    ///
    /// let sphere = families::icosphere(2)?;
    /// let found = Comparison::between(&sphere, &families::icosphere(4)?, Par::Seq)?;
    /// // The finer sphere lies outside of the coarser one.
    /// assert!(found.out.largest < found.back.largest && found.back.largest < 0.05);
    /// assert!(found.back.angle < 10.0);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Mesh`] when one of them has no face with an area, and that of
    /// [`TriMesh::check_size`].
    pub fn between(first: &TriMesh, second: &TriMesh, par: Par) -> Result<Self> {
        first.check_size()?;
        second.check_size()?;
        let [a, b] = [Triangles::of(first), Triangles::of(second)];
        Ok(Self { out: one_sided(first, &b, par)?, back: one_sided(second, &a, par)? })
    }
}

fn one_sided(mesh: &TriMesh, other: &Triangles, par: Par) -> Result<OneSided> {
    let points = spread(mesh)?;
    let none = || Error::Mesh { what: "has no face".into(), element: "mesh".into() };
    let blocks = par.map_blocks(points.len(), BLOCK, |range| {
        let found = |(p, normal): &(Vector, Vector)| {
            let near = other.nearest(*p)?;
            let angle = angle(*normal, near.normal);
            Some((near.square.sqrt(), angle))
        };
        points[range].iter().map(found).collect::<Option<Vec<_>>>()
    });
    let at_points = blocks.into_iter().collect::<Option<Vec<_>>>().ok_or_else(none)?.concat();
    let distances = at_points.iter().map(|(distance, _)| *distance);
    let angles: Vec<f64> = at_points.iter().filter_map(|(_, angle)| *angle).collect();
    let largest = distances.clone().fold(0.0, f64::max);
    // Not vertices without a face, which are no part of the surface.
    let corners = mesh.vertices().iter().zip(mesh.referenced());
    let corners = corners.filter_map(|(&p, used)| used.then_some(p));
    let corners: Vec<_> = corners.collect();
    let vertices = other.squares(&corners, par).into_iter().fold(0.0, f64::max).sqrt();
    Ok(OneSided {
        largest: largest.max(vertices),
        mean: distances.sum::<f64>() / at_points.len().max(1) as f64,
        angle: angles.iter().sum::<f64>() / angles.len().max(1) as f64,
    })
}

/// Returns the angle between two directions, in degrees; `None` when one is zero.
fn angle(a: Vector, b: Vector) -> Option<f64> {
    let there = norm(a) > 0.0 && norm(b) > 0.0;
    there.then(|| norm(cross(a, b)).atan2(dot(a, b)).to_degrees())
}

/// Returns points at equal shares of the area, each with the normal there. Positions in the faces
/// follow the sequence R2 (Roberts 2018), so that the points are not random.
fn spread(mesh: &TriMesh) -> Result<Vec<(Vector, Vector)>> {
    const STEPS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
    let areas = mesh.face_areas();
    let total: f64 = areas.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        let what = format!("must have a positive finite area, has {total}");
        return Err(Error::Mesh { what, element: "mesh".into() });
    }
    let normals = mesh.face_normals();
    let share = total / SAMPLES as f64;
    let mut points = Vec::with_capacity(SAMPLES);
    let mut sum = 0.0;
    for (f, area) in areas.into_iter().enumerate() {
        sum += area;
        while (points.len() as f64 + 0.5) * share < sum && points.len() < SAMPLES {
            let [s, t] = STEPS.map(|step| (step * (points.len() + 1) as f64).fract());
            let [s, t] = if s + t > 1.0 { [1.0 - s, 1.0 - t] } else { [s, t] };
            let [a, b, c] = mesh.corners_of(mesh.faces()[f]);
            let p = std::array::from_fn(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]));
            points.push((p, normals[f]));
        }
    }
    Ok(points)
}

/// The faces of a mesh, in a tree that finds nearest points.
pub(crate) struct Triangles(RTree<Triangle>);

/// The nearest point of a mesh.
struct Near {
    square: f64,
    normal: Vector,
}

impl Triangles {
    /// Creates the face tree of a mesh.
    pub fn of(mesh: &TriMesh) -> Self {
        let corners = mesh.faces().iter().map(|&face| mesh.corners_of(face));
        Self(RTree::bulk_load(corners.map(Triangle).collect()))
    }

    fn nearest(&self, p: Vector) -> Option<Near> {
        let triangle = self.0.nearest_neighbor(p)?;
        Some(Near { square: triangle.distance_2(&p), normal: unit(doubled_normal(triangle.0)) })
    }

    /// Returns the corners of the face nearest to p; `None` when the mesh has no face.
    pub fn nearest_face(&self, p: Vector) -> Option<[Vector; 3]> {
        self.0.nearest_neighbor(p).map(|triangle| triangle.0)
    }

    /// Returns the squared distance of each point from the nearest face; 0 when the mesh has no
    /// face.
    pub fn squares(&self, points: &[Vector], par: Par) -> Vec<f64> {
        squares(points, &self.0, par)
    }
}

/// Returns the squared distance of each point from the nearest item of the tree; 0 when the tree is
/// empty.
pub(crate) fn squares<T>(points: &[Vector], tree: &RTree<T>, par: Par) -> Vec<f64>
where
    T: PointDistance + RTreeObject<Envelope = AABB<Vector>> + Sync,
{
    let blocks = par.map_blocks(points.len(), BLOCK, |range| {
        let square = |p: &Vector| tree.nearest_neighbor(*p).map_or(0.0, |near| near.distance_2(p));
        points[range].iter().map(square).collect::<Vec<_>>()
    });
    blocks.concat()
}

struct Triangle([Vector; 3]);

impl RTreeObject for Triangle {
    type Envelope = AABB<Vector>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_points(&self.0)
    }
}

impl PointDistance for Triangle {
    fn distance_2(&self, p: &Vector) -> f64 {
        square(sub(nearest_on_triangle(self.0, *p).0, *p))
    }
}

/// Returns the point of the triangle nearest to p, and the barycentric coordinates of that point.
pub(crate) fn nearest_on_triangle(corners: [Vector; 3], p: Vector) -> (Vector, [f64; 3]) {
    let weights = weights_on_triangle(corners, p);
    let ([u, v, w], [a, b, c]) = (weights, corners);
    (std::array::from_fn(|k| u * a[k] + v * b[k] + w * c[k]), weights)
}

/// Returns the barycentric coordinates of the point of the triangle nearest to p (Ericson,
/// Real-Time Collision Detection, 2005, section 5.1.5).
fn weights_on_triangle([a, b, c]: [Vector; 3], p: Vector) -> [f64; 3] {
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = sub(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = if d1 - d3 > 0.0 { d1 / (d1 - d3) } else { 0.0 };
        return [1.0 - t, t, 0.0];
    }
    let cp = sub(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = if d2 - d6 > 0.0 { d2 / (d2 - d6) } else { 0.0 };
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let total = (d4 - d3) + (d5 - d6);
        let t = if total > 0.0 { (d4 - d3) / total } else { 0.0 };
        return [0.0, 1.0 - t, t];
    }
    let total = va + vb + vc;
    if total <= 0.0 || !total.is_finite() {
        return [1.0, 0.0, 0.0];
    }
    [va / total, vb / total, vc / total]
}
