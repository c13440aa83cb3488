//! Least squares of rows on every rank.

use std::ops::ControlFlow;

use catamaran::base::Progress;
use catamaran::faer::{Mat, mat};
use catamaran::ranks::{World, lstsq};
use catamaran::solve::{self, LeastSquares, LeastSquaresOptions};

use crate::matrices::{tell, uneven};
use crate::{Case, Scene};

pub const CASES: &[Case] = &[
    ("least_squares_are_those_of_one_rank_bit_for_bit", as_alone),
    ("least_squares_name_dependent_columns_on_every_rank", dependent),
];

pub const SCENES: &[Scene] = &[
    Scene {
        name: "a_rank_with_another_ridge_is_named",
        ranks: 3,
        starved: None,
        play: another_ridge,
        printed: &["0: rank 1: the ridge", "1: rank 1: the ridge", "2: rank 1: the ridge"],
        succeeds: true,
    },
    Scene {
        name: "a_negative_weight_of_one_rank_ends_least_squares_on_every_rank",
        ranks: 3,
        starved: None,
        play: negative_weight,
        printed: &["0: rank 2: weights: weight 0", "1: rank 2: weights", "2: weights: weight 0"],
        succeeds: true,
    },
    Scene {
        name: "a_target_that_is_not_finite_on_one_rank_is_named_on_every_rank",
        ranks: 2,
        starved: None,
        play: infinite_target,
        printed: &[
            "0: rank 1: B: not finite at row 1, column 1",
            "1: B: not finite at row 1, column 1",
        ],
        succeeds: true,
    },
    Scene {
        name: "a_rank_that_cancels_ends_least_squares_on_every_rank",
        ranks: 3,
        starved: None,
        play: cancel,
        printed: &["0: rank 1: cancelled", "1: cancelled", "2: rank 1: cancelled"],
        succeeds: true,
    },
];

/// Every number of a solution.
fn bits(found: &LeastSquares) -> Vec<u64> {
    let covariance = found.covariance(0).unwrap_or_else(|_| Mat::new());
    let matrices =
        [&found.coefficients, &found.coefficients_low, &found.standard_errors, &covariance];
    let entries = matrices.into_iter().flat_map(|m| m.col_iter().flat_map(|column| column.iter()));
    let vectors = [
        &found.intercepts,
        &found.residual_norms,
        &found.r_squared,
        &found.f_statistics,
        &found.intercept_errors,
    ];
    let values = vectors.into_iter().flatten().chain([&found.condition, &found.digits]);
    let counts = [found.rank as u64, found.observations, found.degrees_of_freedom];
    let dependent = found.dependent.iter().map(|&column| column as u64);
    entries.chain(values).map(|x| x.to_bits()).chain(counts).chain(dependent).collect()
}

fn as_alone(world: &World) {
    // Fewer rows than ranks too.
    for (m, n, k) in [(83, 7, 2), (5, 3, 1), (2, 1, 1)] {
        let a = Mat::from_fn(m, n, |i, j| (i as f64 * 0.37 + j as f64).sin());
        let b = Mat::from_fn(m, k, |i, q| (i as f64 * 0.11 - q as f64).exp2().fract());
        let weights: Vec<f64> = (0..m).map(|i| 1.0 + (i % 3) as f64).collect();
        let own = uneven(m, world.size(), world.rank());
        let a_own = a.subrows(own.start, own.len());
        let b_own = b.subrows(own.start, own.len());
        for (weighted, intercept, errors) in
            [(false, false, false), (false, true, true), (true, true, true), (true, false, true)]
        {
            let options = LeastSquaresOptions::new().intercept(intercept);
            let alone = options.standard_errors(errors);
            let all = weighted.then_some(&weights[..]);
            let expected = solve::lstsq(a.as_ref(), b.as_ref(), all, &alone).unwrap();
            // One rank that asks for standard errors is enough.
            let options = options.standard_errors(errors && world.rank() + 1 == world.size());
            let weights = all.map(|weights| &weights[own.clone()]);
            let found = lstsq(world, a_own, b_own, weights, &options, Progress::none()).unwrap();
            assert_eq!(bits(&found), bits(&expected), "{m} x {n}, {k} targets");
        }
    }
}

fn dependent(world: &World) {
    let t = world.rank() as f64;
    let (a, b) = (mat![[1.0, t, 1.0 + t], [2.0, 1.0, 3.0]], mat![[1.0 + t], [3.0]]);
    let options = LeastSquaresOptions::new();
    let found = lstsq(world, a.as_ref(), b.as_ref(), None, &options, Progress::none()).unwrap();
    assert_eq!((found.rank, found.dependent.len()), (2, 1));
    assert_eq!(found.degrees_of_freedom, 2 * world.size() as u64 - 2);
    let gap = &a * &found.coefficients - &b;
    assert!(gap.norm_max() < 1e-14, "{gap:?}");
}

fn play(world: &World, weight: f64, ridge: f64, progress: Progress<'_>) {
    let (a, b) = (mat![[1.0], [2.0]], mat![[3.0], [4.0]]);
    let options = LeastSquaresOptions::new().ridge(ridge);
    let weights = [weight, 1.0];
    let outcome = lstsq(world, a.as_ref(), b.as_ref(), Some(&weights), &options, progress);
    tell(world, outcome.unwrap_err());
}

fn another_ridge(world: &World) {
    play(world, 1.0, if world.rank() == 1 { 0.5 } else { 0.25 }, Progress::none());
}

fn negative_weight(world: &World) {
    play(world, if world.rank() == 2 { -1.0 } else { 1.0 }, 0.0, Progress::none());
}

fn infinite_target(world: &World) {
    let target = if world.rank() == 1 { f64::INFINITY } else { 4.0 };
    let (a, b) = (mat![[1.0, 0.0], [2.0, 1.0]], mat![[3.0, 1.0], [4.0, target]]);
    let options = LeastSquaresOptions::new();
    let outcome = lstsq(world, a.as_ref(), b.as_ref(), None, &options, Progress::none());
    tell(world, outcome.unwrap_err());
}

fn cancel(world: &World) {
    let rank = world.rank();
    let stop = move |_: f64| match rank {
        1 => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    play(world, 1.0, 0.0, Progress::new(&stop));
}
