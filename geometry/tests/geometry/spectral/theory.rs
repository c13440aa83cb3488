//! What the thesis proves of products (section 1.3.1).

use catamaran::Par;
use catamaran::faer::Mat;
use catamaran::sparse::{CsMat, Mass};
use catamaran_geometry::spectral::{Eigenproducts, dirichlet_energies};

use crate::surface::{blob, eigenbasis, laplacian};

/// Linear elements on a ring of length 2 pi.
fn ring(n: usize) -> (CsMat<f64>, Mass) {
    let h = std::f64::consts::TAU / n as f64;
    let mut w = sprs::TriMat::new((n, n));
    for i in 0..n {
        let next = (i + 1) % n;
        for (row, column, value) in
            [(i, i, 1.0), (next, next, 1.0), (i, next, -1.0), (next, i, -1.0)]
        {
            w.add_triplet(row, column, value / h);
        }
    }
    (w.to_csr(), Mass::Lumped(vec![h; n]))
}

#[test]
fn the_energy_of_an_eigenpower_is_that_of_equality_1_5() {
    let n = 4000;
    let (stiffness, mass) = ring(n);
    for frequency in [1.0, 2.0, 5.0f64] {
        let powers = Mat::from_fn(n, 6, |x, power| {
            (frequency * std::f64::consts::TAU * x as f64 / n as f64).cos().powi(power as i32 + 1)
        });
        let energies = dirichlet_energies(powers.as_ref(), stiffness.view(), &mass).unwrap();
        for (index, energy) in energies.iter().enumerate() {
            let order = (index + 1) as f64;
            let expected = order * order / (2.0 * order - 1.0) * frequency * frequency;
            assert!((energy / expected - 1.0).abs() < 1e-3, "{order}: {energy} {expected}");
        }
    }
}

#[test]
fn the_product_of_two_sines_has_the_sum_of_their_energies() {
    // The example of section 1.3.1, on the interval as a ring.
    let n = 4000;
    let (stiffness, mass) = ring(n);
    let product = Mat::from_fn(n, 1, |x, _| {
        let angle = std::f64::consts::TAU * x as f64 / n as f64;
        angle.sin() * (2.0 * angle).sin()
    });
    let energies = dirichlet_energies(product.as_ref(), stiffness.view(), &mass).unwrap();
    assert!((energies[0] - 5.0).abs() < 1e-4);
}

#[test]
fn energies_of_products_are_at_least_half_the_sum_of_the_eigenvalues_and_cover_the_band() {
    let mesh = blob(3);
    let (stiffness, mass) = laplacian(&mesh);
    let mass = Mass::Lumped(mass);
    let (k, order) = (12, 3);
    let eigen = eigenbasis(&mesh, order * k + 1);
    let products = Eigenproducts::new(k, order).unwrap();
    let mut functions = Mat::zeros(mass.len(), products.len());
    let factors = eigen.functions().subcols(1, k);
    products.evaluate(factors, functions.as_mut(), Par::Seq).unwrap();
    let energies = dirichlet_energies(functions.as_ref(), stiffness.view(), &mass).unwrap();
    // Of eigenfunctions, the energy is the eigenvalue.
    for i in 1..=k {
        assert!((energies[i] / eigen.values()[i] - 1.0).abs() < 1e-9);
    }
    // Theorem 1.1; linear elements have a Leibniz rule up to their resolution only.
    for (index, energy) in energies.iter().enumerate().skip(1) {
        let half: f64 =
            0.5 * products.factors(index).unwrap().iter().map(|&i| eigen.values()[i]).sum::<f64>();
        assert!(*energy >= 0.98 * half, "{:?}: {energy} {half}", products.factors(index));
    }
    // Corollary 1.1 and figure 1.4: every one of the first NK eigenvalues is met.
    let largest = energies.iter().copied().fold(0.0, f64::max);
    assert!(largest >= 0.9 * (order * order) as f64 / (2 * order - 1) as f64 * eigen.values()[k]);
    let mut worst = 0.0f64;
    for &value in &eigen.values()[1..] {
        let nearest =
            energies.iter().map(|energy| (energy / value - 1.0).abs()).fold(f64::MAX, f64::min);
        worst = worst.max(nearest);
    }
    assert!(worst < 0.05, "{worst}");
}
