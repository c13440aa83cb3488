//! The difference between a curve and the true curve (thesis, section 6.4.2).

/// Returns for each point of one curve the distance to the nearest point of the other.
fn nearest<'a>(from: &'a [[f64; 3]], to: &'a [[f64; 3]]) -> impl Iterator<Item = f64> {
    from.iter().map(|&x| {
        let square = |y: &[f64; 3]| (0..3).map(|k| (x[k] - y[k]).powi(2)).sum::<f64>();
        to.iter().map(square).fold(f64::INFINITY, f64::min).sqrt()
    })
}

/// Computes the Hausdorff distance of two sets of points; infinite when one of them is empty, and 0
/// when both are.
pub fn hausdorff(truth: &[[f64; 3]], found: &[[f64; 3]]) -> f64 {
    nearest(truth, found).chain(nearest(found, truth)).fold(0.0, f64::max)
}

/// Computes R of equation 6.1 as printed: the root of the mean distance from the points of the true
/// curve to the found curve; infinite when nothing was found.
pub fn root_mean_distance(truth: &[[f64; 3]], found: &[[f64; 3]]) -> f64 {
    mean(nearest(truth, found), truth.len()).sqrt()
}

/// Computes R with the square that its name implies: the root of the mean squared distance;
/// infinite when nothing was found.
pub fn root_mean_square_distance(truth: &[[f64; 3]], found: &[[f64; 3]]) -> f64 {
    mean(nearest(truth, found).map(|d| d * d), truth.len()).sqrt()
}

fn mean(values: impl Iterator<Item = f64>, count: usize) -> f64 {
    values.sum::<f64>() / count.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_the_formulas() {
        let truth = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        let found = [[0.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        // The nearest points are at distances 0 and 1 from the truth, and 0 and 4 from the found
        // points.
        assert_eq!(hausdorff(&truth, &found), 4.0);
        assert_eq!(root_mean_distance(&truth, &found), 0.5_f64.sqrt());
        assert_eq!(root_mean_square_distance(&truth, &found), 0.5_f64.sqrt());
        assert_eq!(root_mean_distance(&found, &truth), 2.0_f64.sqrt());
        assert_eq!(hausdorff(&truth, &[]), f64::INFINITY);
    }
}
