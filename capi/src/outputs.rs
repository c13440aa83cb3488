//! Writes results into memory of the caller.

use std::ffi::c_char;

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};

#[cfg(feature = "chapters")]
use super::pointer::optional_slice_mut;
#[cfg(feature = "chapters")]
use super::status::{CATA_ERR_SHAPE, Failure};
#[cfg(feature = "chapters")]
use catamaran_geometry::mesh::TriMesh;

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

/// Writes elements of W values where they are wanted and there is room for so many.
#[cfg(feature = "chapters")]
pub(super) fn fill_room<T: Copy, const W: usize>(
    what: &str,
    place: Option<&mut [T]>,
    room: usize,
    found: &[[T; W]],
) -> Result<(), Failure> {
    let Some(place) = place else { return Ok(()) };
    if found.len() > room {
        let why = format!("room: must be at least {} ({what}), is {room}", found.len());
        return Err(Failure::new(CATA_ERR_SHAPE, why));
    }
    place[..W * found.len()].copy_from_slice(found.as_flattened());
    Ok(())
}

/// Writes the vertices and the faces of a mesh where they are wanted.
///
/// # Safety
/// `vertices` and `faces` are NULL, or have room for 3 numbers of each.
#[cfg(feature = "chapters")]
pub(super) unsafe fn fill_mesh(
    mesh: &TriMesh,
    vertices: *mut f64,
    faces: *mut u32,
) -> Result<(), Failure> {
    let (points, corners) = (mesh.vertices().as_flattened(), mesh.faces().as_flattened());
    // SAFETY: clause `memory` (`vertices`, `points.len()` elements; `faces`, `corners.len()`
    // elements).
    let (vertices, faces) = unsafe {
        (
            optional_slice_mut("vertices", vertices, points.len())?,
            optional_slice_mut("faces", faces, corners.len())?,
        )
    };
    fill_slice(vertices, points);
    fill_slice(faces, corners);
    Ok(())
}

/// Writes each value into its place, where there is one.
pub(super) fn tell<T, const N: usize>(places: [Option<&mut T>; N], values: [T; N]) {
    for (place, value) in places.into_iter().zip(values) {
        if let Some(place) = place {
            *place = value;
        }
    }
}

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
