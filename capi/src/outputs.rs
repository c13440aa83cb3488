//! Writes results into memory of the caller.

use std::ffi::c_char;

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};

use super::pointer::{optional_slice_mut, slice_mut};
use super::status::{CATA_ERR_SHAPE, Failure};
use catamaran_geometry::mesh::TriMesh;

/// Writes a matrix into the upper left of another one, where it is wanted, and zeros into the rest.
pub(super) fn fill<'a>(place: impl Into<Option<MatMut<'a, f64>>>, found: MatRef<'_, f64>) {
    let Some(mut place) = place.into() else { return };
    place.fill(0.0);
    place.rb_mut().submatrix_mut(0, 0, found.nrows(), found.ncols()).copy_from(found);
}

/// Writes values where they are wanted, and zeros after them.
pub(super) fn fill_slice<T: Copy + Default>(place: Option<&mut [T]>, found: &[T]) {
    if let Some(place) = place {
        place[found.len()..].fill(T::default());
        place[..found.len()].copy_from_slice(found);
    }
}

/// Writes elements where they are wanted and there is room for so many.
pub(super) fn fill_room<T: Copy>(
    what: &str,
    place: Option<&mut [T]>,
    found: &[T],
) -> Result<(), Failure> {
    let Some(place) = place else { return Ok(()) };
    if found.len() > place.len() {
        let (least, room) = (found.len(), place.len());
        let why = format!("room: must be at least {least} ({what}), is {room}");
        return Err(Failure::new(CATA_ERR_SHAPE, why));
    }
    place[..found.len()].copy_from_slice(found);
    Ok(())
}

/// Returns an element of a list of `things`; `what` names its number.
pub(super) fn element<'a, T>(
    what: &str,
    all: &'a [T],
    things: &str,
    index: usize,
) -> Result<&'a T, Failure> {
    all.get(index).ok_or_else(|| Failure::beyond(what, all.len(), things, index))
}

/// Copies elements into memory of the caller.
///
/// # Safety
/// `place` is as [`slice_mut`] wants it, for as many elements.
pub(super) unsafe fn copy<T: Copy>(
    what: &'static str,
    place: *mut T,
    found: &[T],
) -> Result<(), Failure> {
    // SAFETY: clause `passed on` (`slice_mut`).
    unsafe { slice_mut(what, place, found.len()) }?.copy_from_slice(found);
    Ok(())
}

/// Elements for the caller, and a place of their number where they are wanted.
pub(super) struct Wanted<'a, T> {
    place: Option<&'a mut [T]>,
    found: &'a [T],
}

impl<'a, T: Copy> Wanted<'a, T> {
    /// Returns elements with the place that a pointer says, NULL for none.
    ///
    /// # Safety
    /// As [`optional_slice_mut`], for as many elements.
    pub unsafe fn new(what: &'static str, place: *mut T, found: &'a [T]) -> Result<Self, Failure> {
        // SAFETY: clause `passed on` (`optional_slice_mut`).
        let place = unsafe { optional_slice_mut(what, place, found.len()) }?;
        Ok(Self { place, found })
    }

    pub fn write(self) {
        if let Some(place) = self.place {
            place.copy_from_slice(self.found);
        }
    }
}

/// Copies elements to the arguments of these names, each NULL where not wanted. All places are
/// checked before one is written. Unsafe as [`Wanted::new`].
macro_rules! copy_wanted {
    ($($place:ident: $found:expr),+ $(,)?) => {{
        $(let $place = $crate::outputs::Wanted::new(stringify!($place), $place, $found)?;)+
        $($place.write();)+
    }};
}
pub(super) use copy_wanted;

/// Writes the vertices and the faces of a mesh where they are wanted.
///
/// # Safety
/// `vertices` and `faces` are NULL, or have room for 3 numbers of each.
pub(super) unsafe fn fill_mesh(
    mesh: &TriMesh,
    vertices: *mut f64,
    faces: *mut u32,
) -> Result<(), Failure> {
    let (points, corners) = (mesh.vertices().as_flattened(), mesh.faces().as_flattened());
    // SAFETY: clause `memory` (`vertices`, `points.len()` elements; `faces`, `corners.len()`
    // elements).
    unsafe { copy_wanted!(vertices: points, faces: corners) };
    Ok(())
}

/// Writes values to the arguments of these names, each NULL where not wanted. All places are
/// checked before one is written. Unsafe as `optional_output`.
macro_rules! tell {
    ($($place:ident: $value:expr),+ $(,)?) => {{
        $(let $place = $crate::pointer::optional_output(stringify!($place), $place)?;)+
        $($crate::pointer::put($place, $value);)+
    }};
}
pub(super) use tell;

/// Writes a text, cut to fit between two characters, and NUL to the end of the place.
pub(super) fn write_text(place: &mut [c_char], found: &str) {
    let Some(most) = place.len().checked_sub(1) else { return };
    let cut = (0..=most.min(found.len())).rfind(|&end| found.is_char_boundary(end));
    place.fill(0);
    // The bytes of the text, whether a C char is signed or not.
    let bytes = found.bytes().take(cut.unwrap_or_default());
    place.iter_mut().zip(bytes).for_each(|(out, byte)| *out = byte as c_char);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_cut_between_characters() {
        let written = |size: usize, text: &str| {
            let mut place: Vec<c_char> = vec![7; size];
            write_text(&mut place, text);
            place.into_iter().map(|c| c as u8).collect::<Vec<u8>>()
        };
        assert_eq!(written(6, "abc"), b"abc\0\0\0");
        assert_eq!(written(3, "abc"), b"ab\0");
        assert_eq!(written(3, "a\u{e9}"), b"a\0\0");
        assert_eq!(written(4, "a\u{e9}"), b"a\xc3\xa9\0");
        assert_eq!(written(1, "a"), b"\0");
        assert_eq!(written(0, "a"), b"");
    }
}
