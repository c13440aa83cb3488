//! Points that are near each other, each compared with a length of its own.

use std::collections::HashMap;

use super::super::vector::{Vector, distance};

/// Two points are near each other if their distance is at most this share of the lengths of both.
const NEAR: f64 = 1e-3;

/// Returns the points that are near an earlier point, but not in its place, each with the first
/// such point; ascending. Points whose length is 0 or not finite are not near any other.
///
/// The lengths may differ by any factor: points whose lengths are between two powers of 2 have a
/// grid of their own, and each point is looked up in all grids, of which there are as many as such
/// powers. Of points of one grid that are near each other or in one place, only the first is kept
/// to be compared with later ones, so that a cell has few.
pub(in crate::mesh) fn near_points(points: &[Vector], lengths: &[f64]) -> Vec<[u32; 2]> {
    let reach: Vec<f64> = lengths.iter().map(|length| NEAR * length).collect();
    let is_usable = |reach: &f64| *reach > 0.0 && reach.is_finite();
    let mut grids: Vec<u64> = reach.iter().copied().filter(is_usable).map(power).collect();
    grids.sort_unstable();
    grids.dedup();
    let mut cells: HashMap<(u64, [i64; 3]), Vec<u32>> = HashMap::new();
    let mut pairs = Vec::new();
    for (v, (&p, &own)) in (0u32..).zip(points.iter().zip(&reach)) {
        if !is_usable(&own) {
            continue;
        }
        let (mut first, mut is_kept) = (v, true);
        for &grid in &grids {
            let there = cells.get(&(grid, cell(p, width(grid)))).into_iter().flatten();
            for &u in there {
                let apart = distance(points[u as usize], p);
                if apart <= own.min(reach[u as usize]) {
                    is_kept &= grid != power(own);
                    if apart > 0.0 {
                        first = first.min(u);
                    }
                }
            }
        }
        if first < v {
            pairs.push([v, first]);
        }
        if is_kept {
            let grid = power(own);
            let around = cells_around(p, own, width(grid));
            around.for_each(|at| cells.entry((grid, at)).or_default().push(v));
        }
    }
    pairs
}

/// Returns the exponent of a positive number, as its bits have it.
fn power(x: f64) -> u64 {
    x.to_bits() >> (f64::MANTISSA_DIGITS - 1)
}

/// Returns the width of the cells of a grid: 16 to 32 times the distances that count there. It is
/// finite, as these are [`NEAR`] times a length.
fn width(grid: u64) -> f64 {
    f64::from_bits((grid + 5) << (f64::MANTISSA_DIGITS - 1))
}

/// Returns the cell of a point. Points beyond the range of integers share the outermost cells,
/// where distances tell them apart.
fn cell(p: Vector, width: f64) -> [i64; 3] {
    p.map(|x| (x / width).floor() as i64)
}

/// Returns the cells that meet the cube around a point: at most two along each axis, as cells are
/// wider.
fn cells_around(p: Vector, reach: f64, width: f64) -> impl Iterator<Item = [i64; 3]> {
    let low = cell(p.map(|x| (x - reach).max(f64::MIN)), width);
    let high = cell(p.map(|x| (x + reach).min(f64::MAX)), width);
    let [x, y, z] = [0, 1, 2].map(|k| low[k]..=high[k]);
    x.flat_map(move |x| {
        let z = z.clone();
        y.clone().flat_map(move |y| z.clone().map(move |z| [x, y, z]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use catamaran::base::Rng;

    /// Returns what a comparison of all points with all earlier ones finds.
    fn compared(points: &[Vector], lengths: &[f64]) -> Vec<[u32; 2]> {
        let near = |v: usize, u: usize| {
            let apart = distance(points[u], points[v]);
            apart > 0.0 && apart <= NEAR * lengths[u].min(lengths[v])
        };
        let first = |v: usize| (0..v).find(|&u| near(v, u)).map(|u| [v as u32, u as u32]);
        (0..points.len()).filter_map(first).collect()
    }

    #[test]
    fn near_points_of_all_sizes_are_found() {
        let mut rng = Rng::new(7);
        for scale in [1.0, 1e-120, 1e100] {
            let (mut points, mut lengths) = (Vec::new(), Vec::new());
            for _ in 0..400 {
                let p: Vector = std::array::from_fn(|_| scale * (2.0 * rng.uniform() - 1.0));
                let mut length = || scale * 10f64.powf(-6.0 * rng.uniform());
                let own = [length(), length()];
                // Half of the twins are near, half are not quite.
                let apart = [0.9, 1.1][(rng.bits() % 2) as usize] * NEAR * own[0].min(own[1]);
                let direction: Vector = std::array::from_fn(|_| rng.normal());
                let size = distance(direction, [0.0; 3]);
                points.extend([p, std::array::from_fn(|k| p[k] + apart * direction[k] / size)]);
                lengths.extend(own);
            }
            let found = near_points(&points, &lengths);
            assert_eq!(found, compared(&points, &lengths), "{scale:e}");
            assert!(found.len() > 150, "{scale:e}: {}", found.len());
        }
    }

    #[test]
    fn copies_of_a_point_are_not_near_each_other() {
        let points = [0.0, 0.0, 1e-4, 0.0, 5.0, 5.0].map(|x| [x, 0.0, 0.0]);
        assert_eq!(near_points(&points, &[1.0; 6]), [[2, 0]]);
        // The third point has a grid of its own, in which it is kept.
        let lengths = [1.0, 1.0, 100.0, 1.0, 1.0, 1.0];
        assert_eq!(near_points(&points, &lengths), [[2, 0], [3, 2]]);
    }

    #[test]
    fn lengths_and_distances_out_of_range_have_nothing_near() {
        let points = [[0.0; 3], [1e-300, 0.0, 0.0], [f64::MAX; 3], [f64::MIN; 3]];
        for length in [0.0, 5e-324, f64::MAX, f64::INFINITY, f64::NAN] {
            assert!(near_points(&points, &[length; 4]).is_empty(), "{length:e}");
        }
        assert!(near_points(&[], &[]).is_empty());
    }
}
