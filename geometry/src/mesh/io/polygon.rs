//! Cuts polygons into triangles.

use std::collections::HashMap;

use earcut::Earcut;

use super::super::vector::{Vector, cross, dot, sub};

/// Polygons of more corners stay fans: the crate earcut stores byte counts of its nodes in 32 bits.
const MOST_CORNERS: usize = 1 << 16;

/// A triangle has no area if its signed area is at most this share of that of the polygon, and is
/// turned over if it is below minus this share.
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

/// Returns the triangles of a polygon whose fan does not cover it or has triangles without area, as
/// indices of corners: two triangles fewer than corners. Returns `None` where the fan is right, as
/// for a convex polygon, or where the polygon crosses itself and has no triangulation.
///
/// The polygon is cut in the plane of Newell's normal (Sutherland, Sproull and Schumacker 1974).
/// Triangles without area, which corners in the middle of a straight side make, are flipped away.
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
    let shares: Vec<f64> = areas.iter().map(|&area| dot(area, normal) / square).collect();
    if shares.iter().all(|&share| share > TOLERANCE) {
        return None;
    }
    let is_covered = shares.iter().all(|&share| share >= -TOLERANCE);
    let mut triangles = match is_covered {
        true => (1..=rest.len() - 1).map(|i| [0, i, i + 1]).collect(),
        false => ears(&local, normal.map(|x| x / square.sqrt()))?,
    };
    let share = |[a, b, c]: [usize; 3]| {
        dot(cross(sub(local[b], local[a]), sub(local[c], local[a])), normal) / square
    };
    let is_flipped = flip_empty(&mut triangles, share);
    (!is_covered || is_flipped).then(|| triangles.into_iter().map(ordered).collect())
}

/// Cuts a polygon into triangles in the plane of its unit normal; `None` if crate earcut does not
/// find all of them.
fn ears(corners: &[Vector], normal: Vector) -> Option<Vec<[usize; 3]>> {
    let across = [0, 1, 2].into_iter().min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()));
    let mut axis = [0.0; 3];
    axis[across?] = 1.0;
    let right = cross(axis, normal);
    let up = cross(normal, right);
    let mut numbers: Vec<u32> = Vec::new();
    let flat = corners.iter().map(|&p| [dot(p, right), dot(p, up)]);
    Earcut::new().earcut(flat, &[], &mut numbers);
    let (triangles, _) = numbers.as_chunks::<3>();
    let found = triangles.iter().map(|triangle| ordered(triangle.map(|corner| corner as usize)));
    (triangles.len() == corners.len() - 2).then(|| found.collect())
}

/// Returns a triangle with its corners in the order of the polygon, which gives it the orientation
/// of that.
fn ordered(mut triangle: [usize; 3]) -> [usize; 3] {
    triangle.sort_unstable();
    triangle
}

/// Flips edges of triangles without area, as long as the smaller of the two becomes larger, and
/// returns whether one was flipped. `share` is the share of a triangle in the area of the polygon.
fn flip_empty(triangles: &mut [[usize; 3]], share: impl Fn([usize; 3]) -> f64) -> bool {
    // The triangle that has each edge in this direction. An edge that a flip removed stays, and is
    // replaced where a later flip makes it again.
    let mut owners: HashMap<[usize; 2], usize> = HashMap::new();
    for (i, &triangle) in triangles.iter().enumerate() {
        owners.extend(sides(triangle).map(|side| (side, i)));
    }
    let mut waiting: Vec<usize> = (0..triangles.len()).collect();
    let mut is_flipped = false;
    while let Some(i) = waiting.pop() {
        let own = triangles[i];
        if share(own) > TOLERANCE {
            continue;
        }
        // Over each edge ab, with c behind it, and d on the other side.
        let flips = [0, 1, 2].into_iter().filter_map(|k| {
            let [a, b, c] = [0, 1, 2].map(|shift| own[(k + shift) % 3]);
            let &j = owners.get(&[b, a])?;
            let d = triangles[j].into_iter().find(|&v| v != a && v != b)?;
            let least = |pair: [[usize; 3]; 2]| share(pair[0]).min(share(pair[1]));
            let pair = [ordered([a, c, d]), ordered([b, c, d])];
            (least(pair) > least([own, triangles[j]])).then_some((least(pair), j, pair))
        });
        let Some((_, j, pair)) = flips.max_by(|x, y| x.0.total_cmp(&y.0)) else { continue };
        [triangles[i], triangles[j]] = pair;
        is_flipped = true;
        for (number, triangle) in [i, j].into_iter().zip(pair) {
            owners.extend(sides(triangle).map(|side| (side, number)));
        }
        // Both triangles, and those beside them, may have a flip now.
        let around = pair.into_iter().flat_map(sides).map(|[a, b]| [b, a]);
        waiting.extend(around.filter_map(|side| owners.get(&side)));
    }
    is_flipped
}

/// Returns the edges of a triangle, in its direction.
fn sides([a, b, c]: [usize; 3]) -> [[usize; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::vector::{self, doubled_normal};

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
    fn corners_on_straight_sides_make_no_triangle_without_area() {
        let straight = vec![[0, 0], [1, 0], [2, 0], [0, 2]];
        let square = [[0, 0], [1, 0], [2, 0], [3, 0], [3, 1], [3, 3], [2, 3], [0, 3], [0, 2]];
        let plus = [
            [1, 0],
            [2, 0],
            [2, 1],
            [3, 1],
            [3, 2],
            [2, 2],
            [2, 3],
            [1, 3],
            [1, 2],
            [0, 2],
            [0, 1],
            [1, 1],
        ];
        let t = [[1, 0], [2, 0], [2, 1], [2, 2], [3, 2], [3, 3], [2, 3], [0, 3], [0, 2], [1, 2]];
        let polygons = [(straight, 2.0), (square.into(), 9.0), (plus.into(), 5.0), (t.into(), 5.0)];
        for (polygon, area) in polygons {
            // In a plane of the axes, and in one in which numbers are rounded.
            for axes in [[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0.1, 0.7, -0.3], [0.9, -0.2, 0.3]]] {
                let place = |p: &[i32; 2]| {
                    std::array::from_fn(|k| {
                        f64::from(p[0]) * axes[0][k] + f64::from(p[1]) * axes[1][k]
                    })
                };
                let scale = vector::norm(cross(axes[0], axes[1]));
                for start in 0..polygon.len() {
                    let mut corners: Vec<Vector> = polygon.iter().map(place).collect();
                    corners.rotate_left(start);
                    let numbers: Vec<usize> = (0..corners.len()).collect();
                    let triangles = not_a_fan(&corners).unwrap_or_else(|| fan(&numbers).collect());
                    assert_eq!(triangles.len(), corners.len() - 2);
                    let areas = triangles
                        .iter()
                        .map(|t| vector::norm(doubled_normal(t.map(|i| corners[i]))) / 2.0 / scale);
                    assert!(areas.clone().all(|area| area > 0.1), "{polygon:?} from {start}");
                    assert!((areas.sum::<f64>() - area).abs() < 1e-12, "{polygon:?} from {start}");
                }
            }
        }
    }

    #[test]
    fn straight_sides_of_thousands_of_corners_make_no_triangle_without_area() {
        // The time of flips must not grow with the cube of this number, to many minutes.
        const SIDE: u32 = 4000;
        fn side(corner: fn(u32) -> [u32; 2]) -> impl Iterator<Item = Vector> {
            (0..SIDE).map(corner).map(|[x, y]| [f64::from(x), f64::from(y), 0.0])
        }
        let square: Vec<Vector> = side(|i| [i, 0])
            .chain(side(|i| [SIDE, i]))
            .chain(side(|i| [SIDE - i, SIDE]))
            .chain(side(|i| [0, SIDE - i]))
            .collect();
        for start in [0, SIDE as usize / 3] {
            let mut corners = square.clone();
            corners.rotate_left(start);
            let triangles = not_a_fan(&corners).expect("no fan");
            assert_eq!(triangles.len(), corners.len() - 2);
            let areas = triangles.iter().map(|t| doubled_normal(t.map(|i| corners[i]))[2] / 2.0);
            assert!(areas.clone().all(|area| area >= 0.5), "from {start}");
            assert_eq!(areas.sum::<f64>(), f64::from(SIDE * SIDE), "from {start}");
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
