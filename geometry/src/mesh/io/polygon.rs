//! Cuts polygons into triangles.

use earcut::Earcut;

use super::super::vector::{Vector, cross, dot, sub};

/// Polygons of more corners stay fans: the crate earcut stores byte counts of its nodes in 32 bits.
const MOST_CORNERS: usize = 1 << 16;

/// A triangle of a fan is turned over if its signed area is below minus this fraction of the area
/// of the polygon.
const TOLERANCE: f64 = 1e-9;

/// Returns the triangles between the first corner of a polygon and each of its other edges.
pub(super) fn fan<T: Copy>(corners: &[T]) -> impl Iterator<Item = [T; 3]> {
    let first = corners.first().copied();
    let edges = corners.get(1..).unwrap_or_default().windows(2);
    edges.filter_map(move |edge| Some([first?, edge[0], edge[1]]))
}

/// Returns the corners of the polygon that became this fan; empty where there is no triangle.
pub(super) fn corners_of<T: Copy>(fan: &[[T; 3]]) -> Vec<T> {
    let start = fan.first().map(|triangle| triangle[0]);
    let end = fan.last().map(|triangle| triangle[2]);
    start.into_iter().chain(fan.iter().map(|triangle| triangle[1])).chain(end).collect()
}

/// Returns the triangles of a polygon whose fan does not cover it, as indices of corners: two
/// triangles fewer than corners. Returns `None` where the fan is right, as for a convex polygon, or
/// where the polygon crosses itself and has no triangulation.
///
/// The polygon is cut in the plane of Newell's normal (Sutherland, Sproull and Schumacker 1974).
pub(super) fn not_a_fan(corners: &[Vector]) -> Option<Vec<[usize; 3]>> {
    let (&first, rest) = corners.split_first()?;
    if !(3..MOST_CORNERS).contains(&rest.len()) {
        return None;
    }
    // Scaled to a size of about 1, so that no product overflows.
    let scale = corners.iter().flat_map(|&p| sub(p, first)).fold(0.0, |most, x| x.abs().max(most));
    let local: Vec<Vector> = corners.iter().map(|&p| sub(p, first).map(|x| x / scale)).collect();
    let areas: Vec<Vector> = local[1..].windows(2).map(|edge| cross(edge[0], edge[1])).collect();
    let normal: Vector = std::array::from_fn(|k| areas.iter().map(|area| area[k]).sum());
    let square = dot(normal, normal);
    // The normal is zero for a polygon without area, and not finite where numbers overflow.
    if square.is_nan() || square <= 0.0 {
        return None;
    }
    if areas.iter().all(|&area| dot(area, normal) >= -TOLERANCE * square) {
        return None;
    }
    let normal = normal.map(|x| x / square.sqrt());
    let across = [0, 1, 2].into_iter().min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()));
    let mut axis = [0.0; 3];
    axis[across?] = 1.0;
    let right = cross(axis, normal);
    let up = cross(normal, right);
    let mut numbers: Vec<u32> = Vec::new();
    let flat = local.iter().map(|&p| [dot(p, right), dot(p, up)]);
    Earcut::new().earcut(flat, &[], &mut numbers);
    let (triangles, _) = numbers.as_chunks::<3>();
    if triangles.len() != corners.len() - 2 {
        return None;
    }
    // Three corners in the order of the polygon have its orientation.
    let ordered = |triangle: &[u32; 3]| {
        let mut triangle = triangle.map(|corner| corner as usize);
        triangle.sort_unstable();
        triangle
    };
    Some(triangles.iter().map(ordered).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::vector::doubled_normal;

    #[test]
    fn convex_polygons_are_fans() {
        let corner = |i: u32| {
            let angle = f64::from(i);
            [angle.cos(), angle.sin(), 0.3 * angle.cos()]
        };
        for n in 3..7 {
            assert_eq!(not_a_fan(&(0..n).map(corner).collect::<Vec<_>>()), None, "{n}");
        }
    }

    #[test]
    fn the_corners_of_a_fan_are_those_of_the_polygon() {
        for n in 3..6 {
            let corners: Vec<u32> = (10..10 + n).collect();
            assert_eq!(corners_of(&fan(&corners).collect::<Vec<_>>()), corners);
        }
        assert!(corners_of::<u32>(&[]).is_empty());
    }

    #[test]
    fn concave_polygons_are_covered_once() {
        // A comb in an oblique plane.
        let comb = [[0, 0], [7, 0], [7, 3], [6, 3], [5, 1], [4, 3], [3, 1], [2, 3], [1, 1], [0, 3]];
        let place = |[x, y]: [i32; 2]| [f64::from(x), f64::from(y), f64::from(x - 2 * y)];
        for start in 0..comb.len() {
            let mut corners = comb.map(place);
            corners.rotate_left(start);
            let Some(triangles) = not_a_fan(&corners) else { continue };
            assert_eq!(triangles.len(), 8);
            let mut area = 0.0;
            for t in triangles {
                let doubled = doubled_normal(t.map(|i| corners[i]))[2];
                assert!(doubled >= 0.0, "{start}: {t:?} is turned over");
                area += doubled / 2.0;
            }
            assert!((area - 15.0).abs() < 1e-12, "{start}: {area}");
        }
    }

    #[test]
    fn what_is_no_polygon_stays_a_fan() {
        for corners in [
            [[0.0; 3]; 5],
            [[f64::MAX; 3], [-f64::MAX; 3], [f64::MAX, 0.0, 0.0], [0.0; 3], [1.0; 3]],
            [[0.0; 3], [1.0; 3], [2.0; 3], [1.0; 3], [3.0; 3]],
        ] {
            assert_eq!(not_a_fan(&corners), None);
        }
    }
}
