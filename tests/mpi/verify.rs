//! The distributed check.

use catamaran::Real;
use catamaran::faer::Mat;
use catamaran::ranks::{Distributed, MpiReal, World, ata_columns, ata_rows, verify};

use crate::Case;
use crate::matrices::{options, uneven};

pub const CASES: &[Case] = &[
    ("correct_products_pass_the_check_f64", correct::<f64>),
    ("correct_products_pass_the_check_f32", correct::<f32>),
    ("a_wrong_entry_fails_the_check_on_every_rank", wrong),
    ("an_infinity_of_a_is_named_on_every_rank", infinite),
];

fn entry<T: Real>(i: usize, j: usize) -> T {
    T::from_f64((i as f64 * 0.37 + j as f64 * 1.3).sin())
}

fn correct<T: MpiReal>(world: &World) {
    for (m, n) in [(0, 3), (1, 1), (130, 40), (1500, 33), (40, 130)] {
        let own = uneven(m, world.size(), world.rank());
        let rows = Mat::<T>::from_fn(own.len(), n, |i, j| entry(own.start + i, j));
        let own = uneven(n, world.size(), world.rank());
        let columns = Mat::<T>::from_fn(m, own.len(), |i, j| entry(i, own.start + j));
        let by_rows = ata_rows(world, T::from_f64(0.5), rows.as_ref(), &options()).unwrap();
        let by_columns =
            ata_columns(world, T::from_f64(0.5), columns.as_ref(), &options()).unwrap();
        for c in [&by_rows, &by_columns] {
            for a in [Distributed::Rows(rows.as_ref()), Distributed::Columns(columns.as_ref())] {
                let found = verify(world, 0.5, a, c, 20, 7).unwrap();
                assert!(found.passed, "{m} x {n}: {found:?}");
            }
        }
    }
}

fn infinite(world: &World) {
    let (m, n) = (100, 50);
    let own = uneven(m, world.size(), world.rank());
    let rows = Mat::<f64>::from_fn(own.len(), n, |i, j| entry(own.start + i, j));
    let c = ata_rows(world, 1.0, rows.as_ref(), &options()).unwrap();
    let place = (m - 1, n - 1);
    let value = |at: (usize, usize)| if at == place { f64::INFINITY } else { entry(at.0, at.1) };
    let rows = Mat::from_fn(own.len(), n, |i, j| value((own.start + i, j)));
    let own = uneven(n, world.size(), world.rank());
    let columns = Mat::from_fn(m, own.len(), |i, j| value((i, own.start + j)));
    for a in [Distributed::Rows(rows.as_ref()), Distributed::Columns(columns.as_ref())] {
        let error = verify(world, 1.0, a, &c, 20, 7).unwrap_err().to_string();
        assert!(error.ends_with("A: not finite at row 99, column 49"), "{error}");
    }
}

fn wrong(world: &World) {
    let (m, n) = (100, 50);
    let own = uneven(m, world.size(), world.rank());
    let mut rows = Mat::<f64>::from_fn(own.len(), n, |i, j| entry(own.start + i, j));
    let c = ata_rows(world, 1.0, rows.as_ref(), &options()).unwrap();
    if world.rank() == world.size() - 1 {
        rows[(0, 3)] += 1e-8;
    }
    let found = verify(world, 1.0, Distributed::Rows(rows.as_ref()), &c, 20, 7).unwrap();
    assert!(!found.passed, "{found:?}");
    assert!(verify(world, 1.0, Distributed::Rows(rows.as_ref()), &c, 0, 7).is_err());
}
