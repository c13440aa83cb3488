//! Matrices of a few rows, and rotations.

use catamaran_geometry::mesh::vector::{Vector, cross, dot};

/// An N x N matrix by rows.
pub(super) type Matrix<const N: usize> = [[f64; N]; N];

pub(super) fn identity<const N: usize>() -> Matrix<N> {
    let mut a = [[0.0; N]; N];
    (0..N).for_each(|i| a[i][i] = 1.0);
    a
}

pub(super) fn times<const N: usize>(a: &Matrix<N>, b: &Matrix<N>) -> Matrix<N> {
    let mut c = [[0.0; N]; N];
    for i in 0..N {
        for k in 0..N {
            for j in 0..N {
                c[i][j] += a[i][k] * b[k][j];
            }
        }
    }
    c
}

pub(super) fn transposed<const N: usize>(a: &Matrix<N>) -> Matrix<N> {
    let mut b = [[0.0; N]; N];
    (0..N).for_each(|i| (0..N).for_each(|j| b[j][i] = a[i][j]));
    b
}

pub(super) fn image<const N: usize>(a: &Matrix<N>, x: &[f64; N]) -> [f64; N] {
    let mut y = [0.0; N];
    for i in 0..N {
        for j in 0..N {
            y[i] += a[i][j] * x[j];
        }
    }
    y
}

/// Computes `a += s b`.
pub(super) fn add<const N: usize>(a: &mut Matrix<N>, s: f64, b: &Matrix<N>) {
    for i in 0..N {
        for j in 0..N {
            a[i][j] += s * b[i][j];
        }
    }
}

/// L of a positive definite matrix `L L^T`, whose diagonal is inverted: a division takes as long as
/// a row of products.
pub(super) type Factor<const N: usize> = Matrix<N>;

/// Returns the factor of a positive definite matrix, whose lower triangle is read; `None` if the
/// matrix is not positive definite.
pub(super) fn cholesky<const N: usize>(a: &Matrix<N>) -> Option<Factor<N>> {
    let mut l = [[0.0; N]; N];
    (factor_rows(a, &mut l) == N).then_some(l)
}

/// Computes the rows of the factor up to the first whose pivot is not positive; returns their
/// number.
fn factor_rows<const N: usize>(a: &Matrix<N>, l: &mut Factor<N>) -> usize {
    for i in 0..N {
        for j in 0..=i {
            let sum = a[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            if i > j {
                l[i][j] = sum * l[j][j];
            } else if sum > 1e-14 * a[i][i].abs() && sum.is_finite() {
                l[i][i] = 1.0 / sum.sqrt();
            } else {
                return i;
            }
        }
    }
    N
}

/// Returns x with `x^T A x <= 0`, to within rounding, for a symmetric matrix A, N >= 1, that is not
/// positive definite; its lower triangle is read.
pub(super) fn descent<const N: usize>(a: &Matrix<N>) -> [f64; N] {
    let (mut l, mut x) = ([[0.0; N]; N], [0.0; N]);
    let row = factor_rows(a, &mut l).min(N - 1);
    // The form is the pivot of this row for the x whose product with the rows before is 0.
    x[row] = 1.0;
    for i in (0..row).rev() {
        let sum: f64 = (i + 1..=row).map(|k| l[k][i] * x[k]).sum();
        x[i] = -sum * l[i][i];
    }
    x
}

/// Returns `(L L^T)^-1 b`.
pub(super) fn solve<const N: usize>(l: &Factor<N>, b: &[f64; N]) -> [f64; N] {
    let mut x = *b;
    for i in 0..N {
        for k in 0..i {
            x[i] -= l[i][k] * x[k];
        }
        x[i] *= l[i][i];
    }
    for i in (0..N).rev() {
        for k in i + 1..N {
            x[i] -= l[k][i] * x[k];
        }
        x[i] *= l[i][i];
    }
    x
}

/// Returns `(L L^T)^-1 B`, row by row, so that the columns share vectors.
pub(super) fn solve_matrix<const N: usize>(l: &Factor<N>, b: &Matrix<N>) -> Matrix<N> {
    let mut x = *b;
    for i in 0..N {
        let mut row = x[i];
        for k in 0..i {
            (0..N).for_each(|j| row[j] -= l[i][k] * x[k][j]);
        }
        x[i] = row.map(|y| y * l[i][i]);
    }
    for i in (0..N).rev() {
        let mut row = x[i];
        for k in i + 1..N {
            (0..N).for_each(|j| row[j] -= l[k][i] * x[k][j]);
        }
        x[i] = row.map(|y| y * l[i][i]);
    }
    x
}

/// Returns the inverse of a matrix; `None` for a singular one.
pub(super) fn reciprocal(a: &Matrix<3>) -> Option<Matrix<3>> {
    let rows = [cross(a[1], a[2]), cross(a[2], a[0]), cross(a[0], a[1])];
    let determinant = dot(a[0], rows[0]);
    let inverse = transposed(&rows.map(|row| row.map(|x| x / determinant)));
    inverse.iter().flatten().all(|x| x.is_finite()).then_some(inverse)
}

/// Returns the matrix of `a -> v x a`.
pub(super) fn cross_matrix(v: Vector) -> Matrix<3> {
    [[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]]
}

/// A rotation: a unit quaternion (w, x, y, z).
pub(super) type Quaternion = [f64; 4];

pub(super) const NO_ROTATION: Quaternion = [1.0, 0.0, 0.0, 0.0];

pub(super) fn product(a: Quaternion, b: Quaternion) -> Quaternion {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
    ]
}

pub(super) fn inverse(q: Quaternion) -> Quaternion {
    [q[0], -q[1], -q[2], -q[3]]
}

/// Returns the rotation by the vector `a`, whose length is the angle.
pub(super) fn exponential(a: Vector) -> Quaternion {
    let angle = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt();
    // sin(x / 2) / x, whose limit is 1 / 2.
    let scale = if angle > 1e-8 { (0.5 * angle).sin() / angle } else { 0.5 };
    [(0.5 * angle).cos(), scale * a[0], scale * a[1], scale * a[2]]
}

/// Returns the vector of a rotation, of length at most pi.
pub(super) fn logarithm(q: Quaternion) -> Vector {
    let sign = if q[0] < 0.0 { -1.0 } else { 1.0 };
    let sine = (q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    let scale = if sine > 1e-12 { 2.0 * sine.atan2(sign * q[0]) / sine } else { 2.0 };
    [1, 2, 3].map(|i| sign * scale * q[i])
}

/// Returns `q` rotated by the vector `a`, normalized.
pub(super) fn turned(q: Quaternion, a: Vector) -> Quaternion {
    let p = product(exponential(a), q);
    let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
    p.map(|x| x / length)
}

pub(super) fn rotation_matrix([w, x, y, z]: Quaternion) -> Matrix<3> {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use catamaran::base::Rng;

    #[test]
    fn a_matrix_that_is_not_positive_definite_has_a_direction_of_descent() {
        let mut rng = Rng::new(8);
        let mut count = 0;
        for _ in 0..200 {
            let b: Matrix<3> = [0; 3].map(|_| [0; 3].map(|_| rng.normal()));
            let mut a = times(&b, &transposed(&b));
            (0..3).for_each(|i| a[i][i] -= 0.5);
            let x = descent(&a);
            let form: f64 = (0..3).map(|i| x[i] * image(&a, &x)[i]).sum();
            assert!(cholesky(&a).is_some() || form <= 1e-9, "{a:?}: {form}");
            count += usize::from(cholesky(&a).is_none());
        }
        assert!(count > 20 && count < 200, "{count}");
    }
}
