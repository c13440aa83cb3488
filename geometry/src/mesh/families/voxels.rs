//! Rounded surfaces of sets of cubes.

use std::collections::{HashMap, HashSet};

use super::super::TriMesh;
use super::draft::Draft;
use catamaran::base::Result;

/// Generates the surface of unit `cubes` (lower corners; cubes that meet must share a face), each
/// side cut into `cells` x `cells` cells of two triangles, then smoothed a little.
pub(super) fn surface(cubes: &[[i32; 3]], cells: i32, mut draft: Draft) -> Result<TriMesh> {
    let set: HashSet<_> = cubes.iter().collect();
    let mut numbers = HashMap::new();
    for cube in cubes {
        for axis in 0..3 {
            for side in [0, 1] {
                let mut beyond = *cube;
                beyond[axis] += 2 * side - 1;
                if set.contains(&beyond) {
                    continue;
                }
                // Counter-clockwise from outside: the other two axes in cyclic order on the upper
                // side.
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let (u, v) = if side == 1 { (u, v) } else { (v, u) };
                let mut corner = cube.map(|x| x * cells);
                corner[axis] += side * cells;
                let mut number = |i: i32, j: i32| {
                    let mut point = corner;
                    point[u] += i;
                    point[v] += j;
                    *numbers.entry(point).or_insert_with(|| {
                        draft.vertices.push(point.map(|x| f64::from(x) / f64::from(cells)));
                        draft.vertices.len() as u32 - 1
                    })
                };
                for i in 0..cells {
                    for j in 0..cells {
                        let [a, b] = [number(i, j), number(i + 1, j)];
                        let [c, d] = [number(i + 1, j + 1), number(i, j + 1)];
                        draft.faces.extend([[a, b, c], [a, c, d]]);
                    }
                }
            }
        }
    }
    // The number of steps makes the time of this heat flow independent of the resolution.
    for _ in 0..=i64::from(cells).pow(2) / 4 {
        smooth(&mut draft);
    }
    draft.finish()
}

/// Moves every vertex half the way to the mean of its neighbours, for a closed mesh.
fn smooth(draft: &mut Draft) {
    let mut sums = vec![[0.0; 4]; draft.vertices.len()];
    for &[a, b, c] in &draft.faces {
        // Each edge occurs twice, once from each end.
        for (u, v) in [(a, b), (b, c), (c, a)] {
            let sum = &mut sums[u as usize];
            let p = draft.vertices[v as usize];
            *sum = [sum[0] + p[0], sum[1] + p[1], sum[2] + p[2], sum[3] + 1.0];
        }
    }
    for (p, [x, y, z, count]) in draft.vertices.iter_mut().zip(sums) {
        *p = [(p[0] + x / count) / 2.0, (p[1] + y / count) / 2.0, (p[2] + z / count) / 2.0];
    }
}
