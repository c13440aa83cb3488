use std::ops::ControlFlow;

use super::super::session::tests::device;
use super::*;
use crate::texture::newton::{Gradient, Grid, NewtonOptions, Polynomial};
use catamaran::base::{Par, Progress, Rng};

/// Inverse share of points that may differ: fractals are chaotic, and devices may round divisions
/// in other ways.
const BUDGET: usize = 4_000;

fn compare(device: &Device, options: &NewtonOptions, points: Points<'_>, group: Option<usize>) {
    let newton = Newton::new(options).unwrap();
    let twin = newton.evaluate(points, Par::Threads(2), Progress::none()).unwrap();
    let found =
        evaluate_newton_in_groups(device, &newton, points, group, Progress::none()).unwrap();
    assert_eq!(found.roots.len(), twin.roots.len());
    let tolerance = 1e-4 * if options.gradient == Gradient::Shader { 1.0 } else { 32.0 };
    let different = (0..twin.roots.len())
        .filter(|&i| {
            found.roots[i] != twin.roots[i]
                || (found.convergence[i] - twin.convergence[i]).abs() > tolerance
        })
        .count();
    let count = twin.roots.len();
    println!("{options:?} {group:?}: {different} of {count} differ");
    assert!(different <= count / BUDGET, "{different} of {count} points differ: {options:?}");
}

fn options(polynomial: Polynomial) -> NewtonOptions {
    NewtonOptions { polynomial, w: 0.1, offset: [0.1, 0.0, -0.2], ..NewtonOptions::default() }
}

#[test]
fn the_kernel_does_what_its_twin_does() {
    let Some(device) = device() else { return };
    let plane = Points::Grid(Grid::plane(200, 101, [0.1, -0.2], 3.0));
    for n in [2, 3, 4, 5, 7, 16] {
        compare(&device, &options(Polynomial::Power(n)), plane, None);
    }
    let roots = vec![[1.0, 0.0], [-0.5, 0.8], [-1.5, 0.1], [0.2, -1.0]];
    compare(&device, &options(Polynomial::Roots(roots)), plane, None);
    let shader = NewtonOptions { gradient: Gradient::Shader, ..options(Polynomial::Power(3)) };
    compare(&device, &shader, plane, None);
    compare(&device, &options(Polynomial::Power(3)), Points::Grid(Grid::cube(23, 3.0)), None);
}

#[test]
fn groups_of_any_size_give_the_same() {
    let Some(device) = device() else { return };
    let mut rng = Rng::new(5);
    let mut list = vec![[0.0; 3], [1.0, 0.0, 0.0]];
    list.extend((0..4999).map(|_| [0; 3].map(|_| (3.0 * rng.uniform() - 1.5) as f32)));
    for group in [1, 64, 256] {
        let plane = Points::Grid(Grid::plane(97, 61, [0.0; 2], 3.0));
        compare(&device, &options(Polynomial::Power(3)), plane, Some(group));
        for len in [0, 1, 127, list.len()] {
            let points = Points::List(&list[..len]);
            compare(&device, &options(Polynomial::Power(5)), points, Some(group));
        }
    }
    let newton = Newton::new(&options(Polynomial::Power(3))).unwrap();
    let points = Points::List(&list);
    assert!(
        evaluate_newton_in_groups(&device, &newton, points, Some(0), Progress::none()).is_err()
    );
    let cancelled =
        evaluate_newton(&device, &newton, points, Progress::new(&|_| ControlFlow::Break(())));
    assert_eq!(cancelled, Err(Error::Cancelled));
}
