//! The small pieces, one file for each chapter: on one thread, on generated input.
//!
//! A piece that is not public is measured by the smallest public call that it dominates.

mod curves;
mod decimation;
mod exact;
mod plants;
mod products;
mod textures;

use criterion::Criterion;

fn main() {
    let mut criterion = Criterion::default().sample_size(20).configure_from_args();
    products::all(&mut criterion);
    exact::all(&mut criterion);
    plants::all(&mut criterion);
    decimation::all(&mut criterion);
    curves::all(&mut criterion);
    textures::all(&mut criterion);
    criterion.final_summary();
}
