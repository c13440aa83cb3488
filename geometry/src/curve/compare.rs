//! Measures of the difference between a curve and the true curve (thesis, section 6.4.2).

/// Returns whether two orders of the same samples are the same cycle: equal up to the start and the
/// direction.
///
/// ```
/// use catamaran_geometry::curve::same_order;
///
/// assert!(same_order(&[2, 1, 0, 3], &[0, 1, 2, 3]));
/// assert!(!same_order(&[0, 2, 1, 3], &[0, 1, 2, 3]));
/// ```
pub fn same_order(order: &[u32], truth: &[u32]) -> bool {
    let n = order.len();
    if n != truth.len() {
        return false;
    }
    let Some(start) = truth.iter().position(|&i| Some(&i) == order.first()) else {
        return n == 0;
    };
    let ahead = (0..n).all(|i| order[i] == truth[(start + i) % n]);
    ahead || (0..n).all(|i| order[i] == truth[(start + n - i) % n])
}

/// Returns for each point of one curve the distance to the nearest point of the other.
fn nearest<'a>(from: &'a [[f64; 3]], to: &'a [[f64; 3]]) -> impl Iterator<Item = f64> {
    from.iter().map(|&x| {
        let square = |y: &[f64; 3]| (0..3).map(|k| (x[k] - y[k]).powi(2)).sum::<f64>();
        to.iter().map(square).fold(f64::INFINITY, f64::min).sqrt()
    })
}

/// Computes the Hausdorff distance of two sets of points; infinite when one of them is empty, and 0
/// when both are.
///
/// ```
/// use catamaran_geometry::curve::hausdorff;
///
/// let (one, two) = ([[0.0; 3]], [[0.0; 3], [3.0, 4.0, 0.0]]);
/// assert_eq!(hausdorff(&one, &two), 5.0);
/// ```
pub fn hausdorff(truth: &[[f64; 3]], found: &[[f64; 3]]) -> f64 {
    nearest(truth, found).chain(nearest(found, truth)).fold(0.0, f64::max)
}

/// Computes R of equation 6.1 as printed: the root of the mean distance from the points of the true
/// curve to the found curve; infinite when nothing was found.
///
/// ```
/// use catamaran_geometry::curve::root_mean_distance;
///
/// assert_eq!(root_mean_distance(&[[0.0; 3], [8.0, 0.0, 0.0]], &[[0.0; 3]]), 2.0);
/// ```
pub fn root_mean_distance(truth: &[[f64; 3]], found: &[[f64; 3]]) -> f64 {
    mean(nearest(truth, found), truth.len()).sqrt()
}

/// Computes R with the square that its name implies: the root of the mean squared distance;
/// infinite when nothing was found.
///
/// ```
/// use catamaran_geometry::curve::root_mean_square_distance;
///
/// assert_eq!(root_mean_square_distance(&[[1.0, 0.0, 0.0], [7.0, 0.0, 0.0]], &[[0.0; 3]]), 5.0);
/// ```
pub fn root_mean_square_distance(truth: &[[f64; 3]], found: &[[f64; 3]]) -> f64 {
    mean(nearest(truth, found).map(|d| d * d), truth.len()).sqrt()
}

fn mean(values: impl Iterator<Item = f64>, count: usize) -> f64 {
    values.sum::<f64>() / count.max(1) as f64
}
