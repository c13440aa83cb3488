//! Every table is proven by the Brent equations over the integers.

use catamaran::product::schemes::{ProductKind, Scheme, SchemeId, Term};

/// Coefficient of `block(row, col)` in a sum.
fn coefficient(sum: &[Term], row: usize, col: usize) -> i64 {
    sum.iter().filter(|t| (t.row, t.col) == (row, col)).map(|t| i64::from(t.coefficient)).sum()
}

/// The Brent equations: the coefficient of `a<s><i>^T b<t><j>` in `c<r><q>` is 1 when `i = r`,
/// `j = q` and `s = t`, and 0 otherwise.
fn satisfies_brent(scheme: &Scheme) -> bool {
    let Scheme { inner, left, right, .. } = *scheme;
    let outputs = (0..left)
        .flat_map(|r| (0..right).map(move |q| (r, q)))
        .filter(|&(r, q)| !scheme.symmetric || r >= q);
    for (r, q) in outputs {
        for (s, i) in (0..inner).flat_map(|s| (0..left).map(move |i| (s, i))) {
            for (t, j) in (0..inner).flat_map(|t| (0..right).map(move |j| (t, j))) {
                let sum: i64 = scheme
                    .products
                    .iter()
                    .map(|p| {
                        coefficient(&p.outputs, r, q)
                            * coefficient(&p.left, s, i)
                            * coefficient(&p.right, t, j)
                    })
                    .sum();
                if sum != i64::from(i == r && j == q && s == t) {
                    return false;
                }
            }
        }
    }
    true
}

#[test]
fn every_scheme_satisfies_the_brent_equations() {
    for id in SchemeId::ALL {
        assert!(satisfies_brent(id.scheme()), "{id}");
    }
}

#[test]
fn a_wrong_coefficient_breaks_the_brent_equations() {
    for id in SchemeId::ALL {
        let mut scheme = id.scheme().clone();
        let last = scheme.products.len() - 1;
        scheme.products[last].left[0].coefficient += 1;
        assert!(!satisfies_brent(&scheme), "{id}");
    }
}

#[test]
fn half_products_feed_only_the_diagonal_and_squares_are_squares() {
    for id in SchemeId::ALL {
        for p in &id.scheme().products {
            let on_diagonal = p.outputs.iter().all(|t| t.row == t.col);
            let square = p.left == p.right;
            match p.kind {
                ProductKind::Syrk => assert!(on_diagonal && square, "{id}"),
                ProductKind::Gemmt => assert!(on_diagonal && !square, "{id}"),
                ProductKind::SyrkFull => assert!(!on_diagonal && square, "{id}"),
                ProductKind::Gemm => assert!(!square || !id.scheme().symmetric, "{id}"),
            }
            // Symmetric schemes never write above the diagonal.
            assert!(!id.scheme().symmetric || p.outputs.iter().all(|t| t.row >= t.col), "{id}");
        }
    }
}

#[test]
fn flop_ratios_are_those_of_the_papers() {
    let ratio = |id: SchemeId| id.scheme().flop_ratio();
    assert_eq!(ratio(SchemeId::Split), 1.0);
    assert_eq!(ratio(SchemeId::Ata2), 1.0);
    assert_eq!(ratio(SchemeId::Classical2), 1.0);
    assert_eq!(ratio(SchemeId::Strassen), 7.0 / 8.0);
    assert_eq!(ratio(SchemeId::Winograd), 7.0 / 8.0);
    assert_eq!(ratio(SchemeId::Rxtx), 58.0 / 64.0);
    assert_eq!(ratio(SchemeId::Kgp4), 56.0 / 64.0);
    assert_eq!(ratio(SchemeId::Kgp3), 25.0 / 27.0);
}
