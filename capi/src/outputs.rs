//! Writes results into memory of the caller.

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};

/// Writes a matrix into the upper left of another one, and zeros into the rest.
pub(super) fn fill(mut place: MatMut<'_, f64>, found: MatRef<'_, f64>) {
    place.fill(0.0);
    place.rb_mut().submatrix_mut(0, 0, found.nrows(), found.ncols()).copy_from(found);
}

/// Moves a value to the heap, and its handle to the caller.
pub(super) fn hand_over<T>(place: &mut *mut T, value: T) {
    *place = Box::into_raw(Box::new(value));
}

/// Writes values where they are wanted, and zeros after them.
pub(super) fn fill_slice<T: Copy + Default>(place: Option<&mut [T]>, found: &[T]) {
    if let Some(place) = place {
        place[found.len()..].fill(T::default());
        place[..found.len()].copy_from_slice(found);
    }
}
