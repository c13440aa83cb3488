//! The joint between a segment and its parent: it does not stretch, and resists bending and
//! twisting.
//!
//! Rotations are relative to the rest pose, so that all are the identity at rest. The strain of a
//! joint is twice the vector part of `d = conj(q_parent) q_child`, the discrete Darboux vector of
//! Kugelstadt and Schoemer (2016) and of Deul et al. (2018), in the coordinates of the rest pose;
//! its energy is `strain^T K strain / 2`.

use super::small::{
    Matrix, Quaternion, add, cross_matrix, identity, image, inverse, product, rotation_matrix,
    times, transposed,
};
use catamaran_geometry::mesh::vector::{Vector, dot, scale};

/// Returns `K = bend (I - t t^T) + twist t t^T` for the direction t of the child, in N m.
pub(super) fn stiffness(bend: f64, twist: f64, direction: Vector) -> Matrix<3> {
    let mut k = identity();
    for i in 0..3 {
        for j in 0..3 {
            k[i][j] = bend * k[i][j] + (twist - bend) * direction[i] * direction[j];
        }
    }
    k
}

/// Returns d of two rotations, with a scalar part that is not negative.
pub(super) fn difference(parent: Quaternion, child: Quaternion) -> Quaternion {
    let d = product(inverse(parent), child);
    if d[0] < 0.0 { d.map(|x| -x) } else { d }
}

/// Returns the strain of d.
pub(super) fn strain(d: Quaternion) -> Vector {
    [2.0 * d[1], 2.0 * d[2], 2.0 * d[3]]
}

/// Returns the derivative of the strain of d with respect to a small rotation of the child, in the
/// coordinates of the parent.
pub(super) fn strain_derivative(d: Quaternion) -> Matrix<3> {
    let mut j = identity();
    (0..3).for_each(|i| j[i][i] = d[0]);
    add(&mut j, -1.0, &cross_matrix([d[1], d[2], d[3]]));
    j
}

pub(super) fn energy(k: &Matrix<3>, parent: Quaternion, child: Quaternion) -> f64 {
    let strain = strain(difference(parent, child));
    0.5 * dot(strain, image(k, &strain))
}

/// The derivatives of the energy with respect to small rotations of the two segments, in the
/// coordinates of the world.
pub(super) struct Derivatives {
    /// The derivative with respect to the child; the derivative with respect to the parent is its
    /// negative.
    pub gradient: Vector,
    /// The second derivative with respect to the child, which equals that with respect to the
    /// parent.
    pub own: Matrix<3>,
    /// The mixed derivative with respect to the child (rows) and the parent (columns).
    pub mixed: Matrix<3>,
}

pub(super) fn derivatives(k: &Matrix<3>, parent: Quaternion, child: Quaternion) -> Derivatives {
    let d = difference(parent, child);
    let (strain, j) = (strain(d), strain_derivative(d));
    let moment = image(k, &strain);
    let gradient = image(&transposed(&j), &moment);
    // To second order, the strain of a rotation by x is strain + J x - strain |x|^2 / 8.
    let mut own = times(&transposed(&j), &times(k, &j));
    add(&mut own, -0.25 * dot(strain, moment), &identity());
    // exp(-a) exp(b) = exp(b - a - a x b / 2 + ...): the product of small rotations has a
    // second-order part of its own.
    let mut mixed = cross_matrix(scale(gradient, -0.5));
    add(&mut mixed, -1.0, &own);
    let to_world = rotation_matrix(parent);
    let turn = |m: &Matrix<3>| times(&to_world, &times(m, &transposed(&to_world)));
    Derivatives { gradient: image(&to_world, &gradient), own: turn(&own), mixed: turn(&mixed) }
}

#[cfg(test)]
mod tests {
    use super::super::small::{exponential, turned};
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_energy() {
        let k = stiffness(2.0, 3.0, [0.6, 0.0, 0.8]);
        let p = exponential([0.3, -0.5, 0.2]);
        let c = turned(p, [0.4, 0.7, -0.3]);
        let u = |a: Vector, b: Vector| energy(&k, turned(p, a), turned(c, b));
        let unit = |i: usize, s: f64| [0, 1, 2].map(|j| if i == j { s } else { 0.0 });
        let sum = |a: Vector, b: Vector| [0, 1, 2].map(|i| a[i] + b[i]);
        let d = derivatives(&k, p, c);
        let (h, none) = (1e-3, [0.0; 3]);
        for i in 0..3 {
            let up = (u(none, unit(i, h)) - u(none, unit(i, -h))) / (2.0 * h);
            assert!((up - d.gradient[i]).abs() < 1e-5, "{up} {:?}", d.gradient);
            let up = (u(unit(i, h), none) - u(unit(i, -h), none)) / (2.0 * h);
            assert!((up + d.gradient[i]).abs() < 1e-5);
            for j in 0..3 {
                let second = |f: &dyn Fn(f64, f64) -> f64| {
                    (f(h, h) - f(h, -h) - f(-h, h) + f(-h, -h)) / (4.0 * h * h)
                };
                let own = second(&|s, t| u(none, sum(unit(i, s), unit(j, t))));
                assert!((own - d.own[i][j]).abs() < 1e-4, "{own} {:?}", d.own);
                let mixed = second(&|s, t| u(unit(j, t), unit(i, s)));
                assert!((mixed - d.mixed[i][j]).abs() < 1e-4, "{i} {j} {mixed} {:?}", d.mixed);
            }
        }
    }
}
