//! An exact test whether two triangles intersect.

use robust::{Coord, Coord3D, orient2d, orient3d};

use crate::mesh::has_corner_twice;
use crate::mesh::vector::{Vector, add, cross, dot, doubled_normal, sub, unit};

/// The corners of a triangle.
pub(crate) type Corners = [Vector; 3];

/// Returns whether two triangles share a point beyond their common corners and edges, where equal
/// positions are a common corner. Two triangles with the same three corners intersect.
pub(crate) fn intersect(first: &Corners, second: &Corners) -> bool {
    let mut common = 0;
    let (mut in_first, mut in_second) = (0, 0);
    for (i, p) in first.iter().enumerate() {
        for (j, q) in second.iter().enumerate() {
            if p == q {
                common += 1;
                in_first ^= i + 1;
                in_second ^= j + 1;
            }
        }
    }
    match common {
        0 => {
            !apart(first, second)
                && !clear_of(first, second)
                && !clear_of(second, first)
                && edges(first)
                    .into_iter()
                    .map(|edge| (second, edge))
                    .chain(edges(second).into_iter().map(|edge| (first, edge)))
                    .any(|(triangle, edge)| meets_edge(triangle, edge))
        }
        1 => {
            // Beyond the common corner, an edge opposite to it meets the other triangle.
            let opposite = |t: &Corners, corner: usize| [t[corner % 3], t[(corner + 1) % 3]];
            let (of_first, of_second) = (opposite(first, in_first), opposite(second, in_second));
            !beyond(first[in_first - 1], &of_first, &of_second)
                && !clear_of(second, &of_first)
                && !clear_of(first, &of_second)
                && (meets_edge(second, of_first) || meets_edge(first, of_second))
        }
        // A triangle with two equal corners is an edge.
        2.. if [first, second].into_iter().any(has_corner_twice) => false,
        2 => {
            // The xor of both common corners, numbered from 1, is the third one.
            let (lone, other) = (in_first - 1, second[in_second - 1]);
            let [p, a, b] = [0, 1, 2].map(|k| first[(lone + k) % 3]);
            !clear_of(first, &[other]) && folded([a, b], p, other)
        }
        _ => true,
    }
}

fn edges(t: &Corners) -> [[Vector; 2]; 3] {
    [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]
}

/// An upper bound of the rounding error of a determinant of three differences, relative to the
/// product of their longest components: 12 products of three differences, each with 4 roundings,
/// and 11 sums.
const ERROR: f64 = 1e-14;

fn longest([x, y, z]: Vector) -> f64 {
    x.abs().max(y.abs()).max(z.abs())
}

/// Returns whether a plane across the line between their middles certainly, beyond rounding, lies
/// between two triangles, as it does for most that are near each other in one sheet.
fn apart(first: &Corners, second: &Corners) -> bool {
    let middle = |[a, b, c]: &Corners| add(*a, add(*b, *c));
    let axis = sub(middle(second), middle(first));
    let origin = first[0];
    let (mut low, mut high, mut size) = (0.0f64, f64::INFINITY, 0.0f64);
    for p in &first[1..] {
        let step = sub(*p, origin);
        low = low.max(dot(axis, step));
        size = size.max(longest(step));
    }
    for p in second {
        let step = sub(*p, origin);
        high = high.min(dot(axis, step));
        size = size.max(longest(step));
    }
    high - low > 2.0 * ERROR * longest(axis) * size
}

/// Returns whether a plane through their common corner certainly, beyond rounding, has the first
/// edge on one side, and the second on the other.
fn beyond(corner: Vector, first: &[Vector; 2], second: &[Vector; 2]) -> bool {
    let [a, b] = first.map(|p| sub(p, corner));
    let [c, d] = second.map(|p| sub(p, corner));
    let axis = sub(unit(add(c, d)), unit(add(a, b)));
    let height = |p: Vector| dot(axis, p);
    let error = |p: Vector| ERROR * longest(axis) * longest(p);
    [a, b].iter().all(|&p| height(p) < -error(p)) && [c, d].iter().all(|&p| height(p) > error(p))
}

/// Returns whether these points are certainly, beyond rounding, on one side of the plane of a
/// triangle.
fn clear_of([a, b, c]: &Corners, points: &[Vector]) -> bool {
    let (ab, ac) = (sub(*b, *a), sub(*c, *a));
    let normal = cross(ab, ac);
    let error = ERROR * longest(ab) * longest(ac);
    let (mut above, mut below) = (true, true);
    for p in points {
        let ap = sub(*p, *a);
        let (height, error) = (dot(normal, ap), error * longest(ap));
        above &= height > error;
        below &= height < -error;
    }
    above || below
}

/// Returns a number whose sign is the side of the plane of the triangle on which a point lies.
fn side([a, b, c]: &Corners, p: Vector) -> f64 {
    orient3d(point(*a), point(*b), point(*c), point(p))
}

fn point([x, y, z]: Vector) -> Coord3D<f64> {
    Coord3D { x, y, z }
}

/// Returns whether an edge meets a triangle; never when that has no area.
fn meets_edge(triangle: &Corners, [p, q]: [Vector; 2]) -> bool {
    let (before, behind) = (side(triangle, p), side(triangle, q));
    if (before > 0.0 && behind > 0.0) || (before < 0.0 && behind < 0.0) {
        return false;
    }
    let [a, b, c] = *triangle;
    if before == 0.0 && behind == 0.0 {
        return meets_in_plane(triangle, [p, q]);
    }
    let turn = |u: Vector, v: Vector| side(&[p, q, u], v);
    let turns = [turn(a, b), turn(b, c), turn(c, a)];
    turns.iter().all(|&t| t >= 0.0) || turns.iter().all(|&t| t <= 0.0)
}

/// Returns whether an edge in the plane of a triangle meets it.
fn meets_in_plane(triangle: &Corners, edge: [Vector; 2]) -> bool {
    let Some(flat) = projection(triangle) else { return false };
    let [a, b, c] = triangle.map(flat);
    let [p, q] = edge.map(flat);
    let inside = |p: Coord<f64>| {
        let turns = [orient2d(a, b, p), orient2d(b, c, p), orient2d(c, a, p)];
        turns.iter().all(|&t| t >= 0.0) || turns.iter().all(|&t| t <= 0.0)
    };
    inside(p) || [[a, b], [b, c], [c, a]].into_iter().any(|[u, v]| cross_in_plane([p, q], [u, v]))
}

/// Returns whether two segments in a plane meet.
fn cross_in_plane([p, q]: [Coord<f64>; 2], [u, v]: [Coord<f64>; 2]) -> bool {
    let opposite = |a: f64, b: f64| (a >= 0.0 && b <= 0.0) || (a <= 0.0 && b >= 0.0);
    let (at_u, at_v) = (orient2d(p, q, u), orient2d(p, q, v));
    if at_u == 0.0 && at_v == 0.0 {
        let overlap = |p: f64, q: f64, u: f64, v: f64| p.min(q) <= u.max(v) && u.min(v) <= p.max(q);
        return overlap(p.x, q.x, u.x, v.x) && overlap(p.y, q.y, u.y, v.y);
    }
    opposite(at_u, at_v) && opposite(orient2d(u, v, p), orient2d(u, v, q))
}

/// Returns whether the triangles of an edge with p and with q lie in one plane and overlap.
fn folded([a, b]: [Vector; 2], p: Vector, q: Vector) -> bool {
    if side(&[a, b, p], q) != 0.0 {
        return false;
    }
    let Some(flat) = projection(&[a, b, p]) else { return false };
    let [a, b, p, q] = [a, b, p, q].map(flat);
    orient2d(a, b, p) * orient2d(a, b, q) > 0.0
}

/// Returns the projection along the axis closest to the normal of a triangle; `None` when the
/// triangle has no area.
fn projection(corners: &Corners) -> Option<fn(Vector) -> Coord<f64>> {
    let projections: [fn(Vector) -> Coord<f64>; 3] = [
        |[_, y, z]| Coord { x: y, y: z },
        |[x, _, z]| Coord { x: z, y: x },
        |[x, y, _]| Coord { x, y },
    ];
    let normal = doubled_normal(*corners).map(f64::abs);
    let steepest = (0..3).max_by(|&i, &j| normal[i].total_cmp(&normal[j])).unwrap_or(0);
    // Rounding may select an axis in the plane of the triangle; then another axis gives a
    // projection with an area.
    let has_area = |k: &usize| {
        let [a, b, c] = corners.map(projections[*k]);
        orient2d(a, b, c) != 0.0
    };
    [steepest, 0, 1, 2].into_iter().find(has_area).map(|k| projections[k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use catamaran::base::Rng;

    /// Returns whether an edge of either triangle meets the other one, by exact predicates alone.
    fn meet(first: &Corners, second: &Corners) -> bool {
        edges(first).into_iter().any(|edge| meets_edge(second, edge))
            || edges(second).into_iter().any(|edge| meets_edge(first, edge))
    }

    #[test]
    fn triangles_that_a_plane_separates_do_not_meet() {
        let mut rng = Rng::new(9);
        let mut point = |size: f64| -> Vector { std::array::from_fn(|_| size * rng.normal()) };
        let (mut separate, mut through_corner, mut meeting) = (0, 0, 0);
        for round in 0..20000 {
            // Also nearly in one plane, where few bits decide.
            let thin = [1.0, 1e-3, 1e-12, 0.0][round % 4];
            let mut triangle = || -> Corners {
                let shift = point(0.7);
                let corners: Corners = std::array::from_fn(|_| add(shift, point(1.0)));
                corners.map(|[x, y, z]| [x, y, thin * z])
            };
            let first = triangle();
            let mut second = triangle();
            let meets = meet(&first, &second);
            assert!(!(apart(&first, &second) && meets), "{first:?}, {second:?}");
            separate += usize::from(apart(&first, &second));
            meeting += usize::from(meets);
            second[0] = first[0];
            let [[a, b], [c, d]] = [first, second].map(|t| [t[1], t[2]]);
            if beyond(first[0], &[a, b], &[c, d]) {
                through_corner += 1;
                assert!(!meets_edge(&second, [a, b]) && !meets_edge(&first, [c, d]));
                assert!(!intersect(&first, &second));
            }
        }
        assert!(separate > 2000 && through_corner > 2000 && meeting > 2000);
    }
}
