//! Compares with double precision in polar form, the method of the thesis.

use super::*;
use catamaran::base::{Error, Progress, Rng};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

type Complex = [f64; 2];

fn times(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

fn norm(a: Complex) -> f64 {
    a[0].hypot(a[1])
}

fn minus(a: Complex, b: Complex) -> Complex {
    [a[0] - b[0], a[1] - b[1]]
}

fn quotient(a: Complex, b: Complex) -> Complex {
    let square = b[0] * b[0] + b[1] * b[1];
    times(a, [b[0] / square, -b[1] / square])
}

/// Returns the result of one step of Newton's method.
fn step(polynomial: &Polynomial, z: Complex) -> Complex {
    match polynomial {
        Polynomial::Power(n) => {
            let n = f64::from(*n);
            let (radius, angle) = (norm(z).powf(1.0 - n), (1.0 - n) * z[1].atan2(z[0]));
            [
                ((n - 1.0) * z[0] + radius * angle.cos()) / n,
                ((n - 1.0) * z[1] + radius * angle.sin()) / n,
            ]
        }
        Polynomial::Roots(roots) => {
            // The polynomial and its derivative, by the product rule.
            let (mut value, mut slope) = ([1.0, 0.0], [0.0, 0.0]);
            for &root in roots {
                let away = minus(z, root);
                let next = times(slope, away);
                slope = [next[0] + value[0], next[1] + value[1]];
                value = times(value, away);
            }
            if value == [0.0; 2] { z } else { minus(z, quotient(value, slope)) }
        }
    }
}

fn complex_roots(polynomial: &Polynomial) -> Vec<Complex> {
    match polynomial {
        Polynomial::Power(n) => {
            let angle = |k: u32| TAU * f64::from(k) / f64::from(*n);
            (0..*n).map(|k| [angle(k).cos(), angle(k).sin()]).collect()
        }
        Polynomial::Roots(roots) => roots.clone(),
    }
}

/// Returns root and t of (x, y, z, w): equation 7.3 as printed, and the nearest roots.
fn oracle(options: &NewtonOptions, p: [f64; 4]) -> (u16, f64) {
    let p: [f64; 4] = std::array::from_fn(|c| {
        let offset = if c < 3 { options.offset[c] } else { 0.0 };
        (p[c] + offset) * options.scale
    });
    let mut z = [[p[0] + p[3], p[1] - p[2]], [p[0] - p[3], p[1] + p[2]]];
    let iterations = options.iterations as usize;
    let thesis = options.gradient == Gradient::Thesis;
    let mut sum = 0.0;
    for _ in 0..iterations + usize::from(thesis) {
        let next = z.map(|part| step(&options.polynomial, part));
        let squares = [0, 1].map(|c| norm(minus(next[c], z[c])).powi(2));
        let square = (squares[0] + squares[1]) / 2.0;
        let length = if thesis { square.sqrt() } else { square };
        sum += 1.0 / (1.0 + (length + options.theta).exp() - options.theta.exp());
        z = next;
    }
    let t = iterations as f64 - sum;
    let roots = complex_roots(&options.polynomial);
    let [a, b] = z.map(|part| {
        // |part - root|^2 minus |part|^2, which is the same for all roots and may be too large to
        // show a difference.
        let distance = |r: &Complex| r[0] * (r[0] - 2.0 * part[0]) + r[1] * (r[1] - 2.0 * part[1]);
        let all = roots.iter().map(distance).enumerate();
        all.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap().0
    });
    let nearest = a * roots.len() + b;
    (nearest as u16, if thesis { t } else { t / iterations as f64 })
}

/// Returns the 14 points at this distance from p along the axes and the diagonals of space.
fn around(p: [f64; 4], radius: f64) -> impl Iterator<Item = [f64; 4]> {
    (0..14).map(move |d| {
        let mut q = p;
        if d < 6 {
            q[d / 2] += if d % 2 == 0 { radius } else { -radius };
        } else {
            for c in 0..3 {
                let sign = if (d - 6) >> c & 1 == 1 { 1.0 } else { -1.0 };
                q[c] += sign * radius / 3.0_f64.sqrt();
            }
        }
        q
    })
}

/// Returns whether p is in the basin of this root and farther than 1e-4 from its border.
fn is_inside(options: &NewtonOptions, p: [f64; 4], root: u16) -> bool {
    [1e-4, 4e-5].iter().all(|&radius| around(p, radius).all(|q| oracle(options, q).0 == root))
}

/// Returns how much t changes when a point moves by the rounding error of n products in single
/// precision.
fn variation(options: &NewtonOptions, p: [f64; 4], t: f64) -> f64 {
    let radius = 1.2e-7 * options.polynomial.roots().max(4) as f64;
    around(p, radius).map(|q| (oracle(options, q).1 - t).abs()).fold(0.0, f64::max)
}

fn random_points(count: usize, size: f64, seed: u64) -> Vec<[f32; 3]> {
    let mut rng = Rng::new(seed);
    (0..count).map(|_| [0; 3].map(|_| (size * (2.0 * rng.uniform() - 1.0)) as f32)).collect()
}

fn evaluate(options: &NewtonOptions, points: Points<'_>) -> Fractal {
    Newton::new(options).unwrap().evaluate(points, Par::Threads(2), Progress::none()).unwrap()
}

/// The results for points inside of basins.
#[derive(Default, Debug)]
struct Comparison {
    /// The share of such points.
    inside: f64,
    /// The share of such points whose t is wrong by more than 1e-5.
    beyond: f64,
    /// The largest error of t, less what moving the point by a rounding error changes.
    worst: f64,
}

/// Compares with the oracle, and asserts that all roots inside of basins are right.
fn compare(options: &NewtonOptions, points: &[[f32; 3]]) -> Comparison {
    let found = evaluate(options, Points::List(points));
    let (mut inside, mut beyond, mut worst) = (0, 0, 0.0_f64);
    for (i, p) in points.iter().enumerate() {
        let p = [p[0].into(), p[1].into(), p[2].into(), options.w];
        let (root, t) = oracle(options, p);
        if is_inside(options, p, root) {
            inside += 1;
            assert_eq!(found.roots[i], root, "{options:?} at {p:?}");
            let error = (f64::from(found.convergence[i]) - t).abs();
            if error > 1e-5 {
                beyond += 1;
                worst = worst.max(error - variation(options, p, t));
            } else {
                worst = worst.max(error);
            }
        }
    }
    let share = |part: usize, of: usize| part as f64 / of.max(1) as f64;
    Comparison { inside: share(inside, points.len()), beyond: share(beyond, inside), worst }
}

/// Near a border of basins, t is steep, and the rounding of the point itself changes t by more than
/// 1e-5. There the bound holds for the rest of the error.
#[test]
fn roots_and_gradient_are_those_of_double_precision_away_from_borders() {
    for n in 2..=16 {
        for (w, gradient) in
            [(0.0, Gradient::Thesis), (0.37, Gradient::Thesis), (0.0, Gradient::Shader)]
        {
            let polynomial = Polynomial::Power(n);
            let options = NewtonOptions { polynomial, w, gradient, ..NewtonOptions::default() };
            let found = compare(&options, &random_points(150, 1.5, u64::from(n)));
            println!("n {n} w {w} {gradient:?}: {found:?}");
            assert!(found.inside > 0.3, "n = {n}: {found:?}");
            assert!(found.beyond < 0.35 && found.worst <= 1e-5, "n = {n}: {found:?}");
        }
    }
}

#[test]
fn polynomials_of_given_roots_converge_to_them() {
    let roots = [[1.0, 0.5], [-0.5, 0.8], [-1.25, 0.25], [0.25, -1.0]];
    for n in 1..=roots.len() {
        let polynomial = Polynomial::Roots(roots[..n].to_vec());
        let options = NewtonOptions { polynomial, w: 0.2, ..NewtonOptions::default() };
        let found = compare(&options, &random_points(150, 2.0, 77));
        println!("{n} roots: {found:?}");
        // The step after the last one is a rounding error of the root, and counts.
        assert!(found.inside > 0.5 && found.worst <= 2e-5, "{n} roots: {found:?}");
    }
}

#[test]
fn a_power_and_its_roots_are_the_same_polynomial() {
    for n in [2, 3, 5] {
        let power = NewtonOptions { polynomial: Polynomial::Power(n), ..NewtonOptions::default() };
        let roots = Polynomial::Roots(complex_roots(&power.polynomial));
        let given = NewtonOptions { polynomial: roots, ..power.clone() };
        let plane = Points::Grid(Grid::plane(101, 67, [0.013, 0.021], 3.0));
        let (a, b) = (evaluate(&power, plane), evaluate(&given, plane));
        let different = (0..a.roots.len()).filter(|&i| a.roots[i] != b.roots[i]).count();
        assert!(different <= a.roots.len() / 500, "{n}: {different} of {}", a.roots.len());
    }
}

#[test]
fn small_roots_have_the_basins_of_larger_ones() {
    let at = |size: f64| {
        let roots = [[1.0, 0.5], [-0.5, 0.8], [-1.25, 0.25], [0.25, -1.0]];
        let polynomial = Polynomial::Roots(roots.map(|root| root.map(|x| size * x)).to_vec());
        let options = NewtonOptions { polynomial, ..NewtonOptions::default() };
        let plane = Grid::plane(101, 67, [0.013 * size, 0.021 * size], 3.0 * size);
        evaluate(&options, Points::Grid(plane)).roots
    };
    let usual = at(1.0);
    for power in [-10, -17, -30] {
        let small = at(2.0_f64.powi(power));
        let different = (0..usual.len()).filter(|&i| small[i] != usual[i]).count();
        assert!(different <= usual.len() / 200, "2^{power}: {different} of {}", usual.len());
    }
    let tiny = NewtonOptions {
        polynomial: Polynomial::Roots(vec![[1e-13, 0.0], [0.0, -1e-13]]),
        ..NewtonOptions::default()
    };
    let refused = Newton::new(&tiny).unwrap_err().to_string();
    assert!(refused.contains("the largest root must be 0 or at least 1e-12"), "{refused}");
}

#[test]
fn the_idempotent_basis_multiplies_bicomplex_numbers() {
    // (a + b j)(c + d j) = (a c - b d) + (a d + b c) j for complex a, b, c, d.
    let split = |p: [f64; 4]| [[p[0] + p[3], p[1] - p[2]], [p[0] - p[3], p[1] + p[2]]];
    let mut rng = Rng::new(3);
    for _ in 0..100 {
        let [p, q] = [0, 1].map(|_| [0; 4].map(|_| rng.normal()));
        // x + y i + z j + w i j = (x + y i) + (z + w i) j.
        let ([a, b], [c, d]) = ([[p[0], p[1]], [p[2], p[3]]], [[q[0], q[1]], [q[2], q[3]]]);
        let (first, second) = (minus(times(a, c), times(b, d)), [times(a, d), times(b, c)]);
        let r = [first[0], first[1], second[0][0] + second[1][0], second[0][1] + second[1][1]];
        for (half, expected) in split(r).into_iter().enumerate() {
            let product = times(split(p)[half], split(q)[half]);
            assert!(norm(minus(product, expected)) < 1e-12);
        }
    }
}

#[test]
fn points_at_roots_and_at_the_null_cone_are_defined() {
    let newton = |n| {
        Newton::new(&NewtonOptions { polynomial: Polynomial::Power(n), ..NewtonOptions::default() })
            .unwrap()
    };
    for n in 2..=16 {
        let at = |points: &[[f32; 3]]| {
            newton(n).evaluate(Points::List(points), Par::Seq, Progress::none()).unwrap()
        };
        // 1 is the root (0, 0); 0 does not converge; alpha is 0 at y = z, and beta at y = -z, if x
        // is 0.
        let found =
            at(&[[1.0, 0.0, 0.0], [0.0; 3], [0.0, 0.5, 0.5], [0.0, 0.5, -0.5], [1e-30, 0.0, 0.0]]);
        assert_eq!(found.roots[..2], [0, 0]);
        assert_eq!((found.convergence[0], found.convergence[1]), (-1.0, 32.0));
        assert_eq!(usize::from(found.roots[2]) / n as usize, 0);
        assert_eq!(usize::from(found.roots[3]) % n as usize, 0);
        assert_eq!(found.convergence[2..], [32.0; 3]);
    }
}

#[test]
fn nothing_is_ever_not_a_number() {
    // The null cone and its neighbourhood, large and tiny numbers, and random ones.
    let mut points = random_points(20_000, 2.0, 1);
    points.extend(random_points(5_000, 1e-3, 2));
    points.extend(random_points(5_000, 1e-20, 3));
    points.extend(random_points(5_000, 1e9, 4));
    points.extend(random_points(5_000, 2.0, 5).iter().map(|p| [0.0, p[1], p[1]]));
    points.extend(random_points(5_000, 2.0, 6).iter().map(|p| [p[0] * 1e-15, p[1], -p[1]]));
    let given = Polynomial::Roots(vec![[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [-1e4, 1e4]]);
    let polynomials = [2, 3, 5, 16, 64].map(Polynomial::Power).into_iter().chain([given]);
    for polynomial in polynomials {
        for (theta, gradient) in [(-10.0, Gradient::Thesis), (20.0, Gradient::Shader)] {
            let polynomial = polynomial.clone();
            let options = NewtonOptions { polynomial, theta, gradient, ..NewtonOptions::default() };
            let found = evaluate(&options, Points::List(&points));
            let most = if gradient == Gradient::Thesis { 32.001 } else { 1.0001 };
            let n = options.polynomial.roots();
            for (i, (&root, &t)) in found.roots.iter().zip(&found.convergence).enumerate() {
                assert!(usize::from(root) < n * n, "{options:?} at {:?}: root {root}", points[i]);
                assert!((-1.001..=most).contains(&t), "{options:?} at {:?}: t {t}", points[i]);
            }
        }
    }
}

#[test]
fn grids_are_the_lists_of_their_points() {
    let options = NewtonOptions { w: 0.3, ..NewtonOptions::default() };
    let [nx, ny, nz] = [7_u32, 5, 3];
    let grid = Grid {
        origin: [-1.0, 0.5, 0.25],
        steps: [[0.25, 0.0, 0.125], [0.0, -0.5, 0.0], [0.0, 0.0, 0.5]],
        counts: [nx, ny, nz],
    };
    let mut list = Vec::new();
    for i in 0..nx * ny * nz {
        let ijk = [i % nx, i / nx % ny, i / nx / ny].map(|i| i as f32);
        list.push(
            [0, 1, 2]
                .map(|c| grid.origin[c] + (0..3).map(|a| ijk[a] * grid.steps[a][c]).sum::<f32>()),
        );
    }
    assert_eq!(evaluate(&options, Points::Grid(grid)), evaluate(&options, Points::List(&list)));
    let plane = Grid::plane(4, 2, [1.0, 2.0], 8.0);
    assert_eq!((plane.origin, plane.counts), ([-2.0, 3.0, 0.0], [4, 2, 1]));
    assert_eq!(Grid::cube(2, 1.0).origin, [-0.25; 3]);
}

#[test]
fn threads_decide_nothing() {
    let newton = Newton::new(&NewtonOptions::default()).unwrap();
    for len in [0, 1, 7, BLOCK, 3 * BLOCK + 1] {
        let points = random_points(len, 1.5, 9);
        let one = newton.evaluate(Points::List(&points), Par::Seq, Progress::none()).unwrap();
        for threads in [2, 3] {
            let par = Par::Threads(threads);
            assert_eq!(newton.evaluate(Points::List(&points), par, Progress::none()).unwrap(), one);
        }
        // Lanes do not depend on their neighbours.
        if let [first, ..] = points[..] {
            let alone =
                newton.evaluate(Points::List(&[first]), Par::Seq, Progress::none()).unwrap();
            assert_eq!((alone.roots[0], alone.convergence[0]), (one.roots[0], one.convergence[0]));
        }
    }
}

#[test]
fn options_of_coordinates_have_the_bound_of_scaled_coordinates() {
    let bound = options::FARTHEST;
    let changes: [fn(&mut NewtonOptions, f64); 3] =
        [|o, x| o.scale = x, |o, x| o.offset[1] = x, |o, x| o.w = x];
    for change in changes {
        for (x, is_within) in [(bound, true), (bound.next_up(), false)] {
            for x in [x, -x] {
                let mut options = NewtonOptions::default();
                change(&mut options, x);
                assert_eq!(Newton::new(&options).is_ok(), is_within, "{x}: {options:?}");
            }
        }
    }
}

#[test]
fn what_can_not_be_computed_is_refused() {
    let with = |change: &dyn Fn(&mut NewtonOptions)| {
        let mut options = NewtonOptions::default();
        change(&mut options);
        Newton::new(&options)
    };
    assert!(with(&|o| o.polynomial = Polynomial::Power(1)).is_err());
    assert!(with(&|o| o.polynomial = Polynomial::Power(65)).is_err());
    assert!(with(&|o| o.polynomial = Polynomial::Roots(vec![])).is_err());
    let nan = with(&|o| o.polynomial = Polynomial::Roots(vec![[0.0; 2], [f64::NAN, 0.0]]));
    assert!(nan.unwrap_err().to_string().contains("root 1"));
    let bound = "must be from -1000000000 to 1000000000, is";
    let says = |change: &dyn Fn(&mut NewtonOptions), why: &str| {
        assert_eq!(with(change).unwrap_err().to_string(), why);
    };
    says(&|o| o.iterations = 0, "iterations: must be from 1 to 1,000, is 0");
    says(&|o| o.theta = f64::NAN, "theta: must be from -10 to 20, is NaN");
    says(&|o| o.w = f64::INFINITY, &format!("w: {bound} inf"));
    says(&|o| o.scale = -2e9, &format!("scale: {bound} -2000000000"));
    says(&|o| o.offset[2] = 2e9, &format!("offset: {bound} 2000000000"));
    let newton = Newton::new(&NewtonOptions::default()).unwrap();
    let points = [[0.0; 3], [0.0, f32::NAN, 0.0]];
    let found = newton.evaluate(Points::List(&points), Par::Seq, Progress::none());
    assert_eq!(found, Err(Error::NonFinite { what: "points", index: (1, 0) }));
    let large = Grid { counts: [1 << 17, 1, 1], ..Grid::plane(1, 1, [0.0; 2], 1.0) };
    assert!(newton.evaluate(Points::Grid(large), Par::Seq, Progress::none()).is_err());
    let large = Grid::plane(1 << 16, 1 << 16, [0.0; 2], 1.0);
    assert!(newton.evaluate(Points::Grid(large), Par::Seq, Progress::none()).is_err());
    let plane = Points::Grid(Grid::plane(64, 64, [0.0; 2], 1.0));
    let cancelled =
        newton.evaluate(plane, Par::Threads(2), Progress::new(&|_| ControlFlow::Break(())));
    assert_eq!(cancelled, Err(Error::Cancelled));
}
