//! Spectral filters.

use catamaran::faer::Mat;
use catamaran::sparse::Mass;
use catamaran::{Error, Par};
use catamaran_geometry::spectral::{
    Orthogonalization, Response, add_coefficient, dirichlet_energies, filter,
};

use super::basis::products;
use crate::surface::{blob, coordinates, eigenbasis, laplacian};

#[test]
fn bands_add_up_to_the_function() {
    let eigen = eigenbasis(&blob(2), 20);
    let f = coordinates(&blob(2));
    let (a, b) = (eigen.values()[6], eigen.values()[13]);
    let part = |response: Response| {
        let gains: Vec<f64> = eigen.values().iter().map(|&value| response.gain(value)).collect();
        filter(eigen.basis(), f.as_ref(), &gains, response.limit(), Par::Seq).unwrap()
    };
    let sum = part(Response::LowPass(a)) + part(Response::HighPass(a));
    assert!((sum - &f).norm_max() < 1e-12);
    // The second band begins beyond the first one's end.
    let rest = part(Response::HighPass(a)) - part(Response::HighPass(b));
    let band = part(Response::BandPass(f64::midpoint(a, eigen.values()[7]), b));
    assert!((rest - band).norm_max() < 1e-12);
    let same = part(Response::Heat(0.0));
    assert!((same - &f).norm_max() < 1e-12);
}

#[test]
fn the_low_pass_is_the_projection_and_heat_decays_each_coefficient() {
    let mesh = blob(2);
    let eigen = eigenbasis(&mesh, 12);
    let f = coordinates(&mesh);
    let gains = vec![1.0; 12];
    let low = filter(eigen.basis(), f.as_ref(), &gains, 0.0, Par::Seq).unwrap();
    let projection = eigen.basis().approximation(f.as_ref(), Par::Seq).unwrap();
    assert!((&low - projection).norm_max() < 1e-14);
    let heat = Response::Heat(0.1);
    let gains: Vec<f64> = eigen.values().iter().map(|&value| heat.gain(value)).collect();
    let warm = filter(eigen.basis(), f.as_ref(), &gains, heat.limit(), Par::Seq).unwrap();
    let (before, after) =
        (eigen.analysis(f.as_ref(), Par::Seq), eigen.analysis(warm.as_ref(), Par::Seq));
    let (before, after) = (before.unwrap(), after.unwrap());
    for (i, value) in eigen.values().iter().enumerate() {
        for c in 0..3 {
            assert!((after[(i, c)] - (-0.1 * value).exp() * before[(i, c)]).abs() < 1e-12);
        }
    }
}

#[test]
fn products_are_filtered_by_their_energies() {
    let mesh = blob(2);
    let eigen = eigenbasis(&mesh, 6);
    let (stiffness, _) = laplacian(&mesh);
    let basis = products(&eigen, 2, Orthogonalization::Reorthogonalized);
    let mass = eigen.basis().mass();
    let energies = dirichlet_energies(basis.functions(), stiffness.view(), mass).unwrap();
    for (energy, value) in energies.iter().zip(eigen.values()) {
        assert!((energy - value).abs() < 1e-8 * (1.0 + value));
    }
    let f = coordinates(&mesh);
    let smooth: Vec<f64> = energies.iter().map(|&e| Response::Heat(0.05).gain(e)).collect();
    let sharp = Response::Sharpen { time: 0.05, amount: 1.0 };
    let sharpened: Vec<f64> = energies.iter().map(|&e| sharp.gain(e)).collect();
    let smooth = filter(basis.basis(), f.as_ref(), &smooth, 0.0, Par::Seq).unwrap();
    let sharp = filter(basis.basis(), f.as_ref(), &sharpened, 0.0, Par::Seq).unwrap();
    let all = basis.basis().approximation(f.as_ref(), Par::Seq).unwrap();
    // What one takes away the other adds.
    assert!(
        (&smooth + &sharp - Mat::from_fn(all.nrows(), 3, |i, c| 2.0 * all[(i, c)])).norm_max()
            < 1e-12
    );
    let energy = |f: &Mat<f64>| -> f64 {
        dirichlet_energies(f.as_ref(), stiffness.view(), mass).unwrap().iter().sum()
    };
    assert!(energy(&smooth) < energy(&all) && energy(&all) < energy(&sharp));
}

#[test]
fn a_single_coefficient_changes() {
    let eigen = eigenbasis(&blob(1), 5);
    let f = coordinates(&blob(1));
    let g = add_coefficient(eigen.basis(), f.as_ref(), 3, 0.5).unwrap();
    let (a, b) = (eigen.analysis(f.as_ref(), Par::Seq), eigen.analysis(g.as_ref(), Par::Seq));
    let change = b.unwrap() - a.unwrap();
    for i in 0..5 {
        let expected = if i == 3 { 0.5 } else { 0.0 };
        assert!((0..3).all(|c| (change[(i, c)] - expected).abs() < 1e-13));
    }
    let error = add_coefficient(eigen.basis(), f.as_ref(), 5, 0.5).unwrap_err();
    assert!(matches!(error, Error::Argument { what: "index", .. }), "{error}");
}

#[test]
fn responses_say_what_passes() {
    let values = [0.0, 1.0, 2.0];
    for (response, gains, limit) in [
        (Response::LowPass(1.0), [1.0, 1.0, 0.0], 0.0),
        (Response::HighPass(1.0), [0.0, 0.0, 1.0], 1.0),
        (Response::BandPass(1.0, 1.5), [0.0, 1.0, 0.0], 0.0),
        (Response::Heat(2f64.ln()), [1.0, 0.5, 0.25], 0.0),
        (Response::Sharpen { time: 2f64.ln(), amount: 2.0 }, [1.0, 2.0, 2.5], 3.0),
    ] {
        for (value, gain) in values.iter().zip(gains) {
            assert!((response.gain(*value) - gain).abs() < 1e-15, "{response:?} {value}");
        }
        assert_eq!(response.limit(), limit, "{response:?}");
    }
}

#[test]
fn dirty_input_is_refused_by_name() {
    let eigen = eigenbasis(&blob(1), 3);
    let f = coordinates(&blob(1));
    let run = |gains: &[f64], rest: f64| filter(eigen.basis(), f.as_ref(), gains, rest, Par::Seq);
    assert!(matches!(run(&[1.0, 1.0], 0.0), Err(Error::Shape { what: "gains", .. })));
    let error = run(&[1.0, f64::NAN, 0.0], 0.0).unwrap_err();
    assert_eq!(error, Error::NonFinite { what: "gains", index: (1, 0) });
    assert_eq!(
        run(&[1.0; 3], f64::INFINITY).unwrap_err(),
        Error::NonFinite { what: "rest", index: (0, 0) }
    );
    let (stiffness, _) = laplacian(&blob(2));
    let error = dirichlet_energies(f.as_ref(), stiffness.view(), &Mass::Lumped(vec![1.0; 42]));
    assert!(matches!(error, Err(Error::Shape { what: "stiffness", .. })));
}
