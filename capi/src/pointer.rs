//! Views of memory of C: all checks of pointers, and all raw casts.

use faer::{MatMut, MatRef};
#[cfg(feature = "chapters")]
use sprs::{CsMatBase, CsMatView};

use super::boundary::boundary;
use super::layout::{CATA_BOTH, CATA_COL_MAJOR, CATA_LOWER, CATA_ROW_MAJOR, CATA_UPPER};
use super::regions::{self, Region};
use super::status::{CATA_ERR_ARGUMENT, CATA_ERR_SHAPE, Failure};
#[cfg(feature = "chapters")]
use catamaran::Real;
use catamaran::Uplo;
use catamaran::base::{reserved, room};
#[cfg(feature = "chapters")]
use catamaran_geometry::mesh::TriMesh;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Layout {
    RowMajor,
    ColMajor,
}

impl Layout {
    pub(super) fn new(layout: i32) -> Result<Self, Failure> {
        Self::named("layout", layout)
    }

    /// Returns the layout that the argument `what` has.
    pub(super) fn named(what: &str, layout: i32) -> Result<Self, Failure> {
        match layout {
            CATA_ROW_MAJOR => Ok(Self::RowMajor),
            CATA_COL_MAJOR => Ok(Self::ColMajor),
            other => {
                Err(Failure::argument(what, "CATA_ROW_MAJOR (101) or CATA_COL_MAJOR (102)", other))
            }
        }
    }
}

pub(super) fn uplo_from(uplo: i32) -> Result<Uplo, Failure> {
    match uplo {
        CATA_UPPER => Ok(Uplo::Upper),
        CATA_LOWER => Ok(Uplo::Lower),
        CATA_BOTH => Ok(Uplo::Both),
        other => {
            let any = "CATA_UPPER (121), CATA_LOWER (122) or CATA_BOTH (123)";
            Err(Failure::argument("uplo", any, other))
        }
    }
}

/// Returns a sparse m x n matrix by rows (CSR), read only: its entries are checked.
///
/// # Safety
/// `row_starts` has rows + 1 elements (or may be NULL without rows), `columns` and `entries` as
/// many as its last one; they can be read, and no thread writes them, during `'a`.
#[cfg(feature = "chapters")]
pub(super) unsafe fn sparse<'a, T: Real>(
    rows: usize,
    cols: usize,
    row_starts: *const usize,
    columns: *const usize,
    entries: *const T,
) -> Result<CsMatView<'a, T>, Failure> {
    // SAFETY: clause `memory`: each array is checked and has as many elements as the contract says;
    // `starts` returns rows + 1 elements, the last of which is the number of entries.
    unsafe {
        let row_starts = starts(rows, row_starts)?;
        let count = row_starts[rows];
        let columns = slice("columns", columns, count)?;
        let entries = slice("entries", entries, count)?;
        CsMatView::try_new((rows, cols), row_starts, columns, entries)
            .map_err(|(_, _, _, why)| not_sparse(why))
    }
}

/// A sparse matrix of which only the places of the entries are known.
#[cfg(feature = "chapters")]
pub(super) type Places<'a> = CsMatBase<(), usize, &'a [usize], &'a [usize], Vec<()>>;

/// Returns the places of the entries of a sparse m x n matrix by rows.
///
/// # Safety
/// As for [`sparse`], without entries.
#[cfg(feature = "chapters")]
pub(super) unsafe fn pattern<'a>(
    rows: usize,
    cols: usize,
    row_starts: *const usize,
    columns: *const usize,
) -> Result<Places<'a>, Failure> {
    // SAFETY: clause `memory`: each array is checked and has as many elements as the contract says;
    // `starts` returns rows + 1 elements, the last of which is the number of entries.
    unsafe {
        let row_starts = starts(rows, row_starts)?;
        let count = row_starts[rows];
        let columns = slice("columns", columns, count)?;
        Places::try_new((rows, cols), row_starts, columns, vec![(); count])
            .map_err(|(_, _, _, why)| not_sparse(why))
    }
}

/// Returns where the rows of a sparse matrix begin and the last one ends.
///
/// # Safety
/// As for [`sparse`].
#[cfg(feature = "chapters")]
unsafe fn starts<'a>(rows: usize, row_starts: *const usize) -> Result<&'a [usize], Failure> {
    match rows {
        0 => Ok(&[0]),
        // SAFETY: clause `memory`: there are rows, so that `row_starts` has rows + 1 elements; a
        // number that saturates is refused.
        _ => unsafe { slice("row_starts", row_starts, rows.saturating_add(1)) },
    }
}

/// Returns the error about arrays that are no sparse matrix.
#[cfg(feature = "chapters")]
fn not_sparse(why: impl std::fmt::Display) -> Failure {
    Failure::new(CATA_ERR_ARGUMENT, format!("row_starts, columns: {why}"))
}

/// Returns an m x n matrix to read. `what` names the pointer, `ld` + `what` its leading dimension.
///
/// # Safety
/// The elements that the arguments describe can be read, and no thread writes them, during `'a`.
pub(super) unsafe fn matrix<'a, T: Copy>(
    what: &'static str,
    layout: Layout,
    rows: usize,
    cols: usize,
    pointer: *const T,
    ld: usize,
) -> Result<MatRef<'a, T>, Failure> {
    let (len, row_stride, col_stride) = strides::<T>(what, layout, rows, cols, ld)?;
    let pointer = checked(what, pointer, len)?;
    regions::add(region(what, layout, rows, cols, pointer, ld, false))?;
    // SAFETY: `checked` has excluded NULL and checked the alignment, `strides` that the extent is
    // within an allocation's limit; clause `memory` for the elements.
    Ok(unsafe { MatRef::from_raw_parts(pointer, rows, cols, row_stride, col_stride) })
}

/// Returns an m x n matrix.
///
/// # Safety
/// The elements that the arguments describe can be read and written, and no other thread does
/// either, during `'a`.
pub(super) unsafe fn matrix_mut<'a, T: Copy>(
    what: &'static str,
    layout: Layout,
    rows: usize,
    cols: usize,
    pointer: *mut T,
    ld: usize,
) -> Result<MatMut<'a, T>, Failure> {
    let (len, row_stride, col_stride) = strides::<T>(what, layout, rows, cols, ld)?;
    let pointer = checked(what, pointer, len)?.cast_mut();
    regions::add(region(what, layout, rows, cols, pointer, ld, true))?;
    // SAFETY: the checks are those of `matrix`; clause `memory` for the elements, which are
    // distinct because ld is at least the length of a line, and `regions` has refused other
    // arguments that overlap them.
    Ok(unsafe { MatMut::from_raw_parts_mut(pointer, rows, cols, row_stride, col_stride) })
}

/// Where the matrices of a batch begin.
pub(super) enum Starts<T> {
    /// The first one here, and each so many elements after the one before.
    Every(*const T, usize),
    /// Each where an element of this array points.
    At(*const *const T),
}

/// Returns matrices of one shape to read. Their memory is added to `all` if nothing but
/// [`regions::check_batch`] can compare it.
///
/// # Safety
/// As [`matrix`], for each of them.
pub(super) unsafe fn matrices<'a, T: Copy>(
    what: &'static str,
    layout: Layout,
    shape: [usize; 3],
    starts: Starts<T>,
    ld: usize,
    all: &mut Vec<Region>,
) -> Result<Vec<MatRef<'a, T>>, Failure> {
    let [_, rows, cols] = shape;
    // SAFETY: `batch` has checked each pointer and the shape as `matrix` does; clause `memory` for
    // the elements of each matrix.
    unsafe {
        batch(what, layout, shape, starts, ld, false, all, |start, down, across| {
            MatRef::from_raw_parts(start, rows, cols, down, across)
        })
    }
}

/// Returns matrices of one shape as [`matrices`] does, to write.
///
/// # Safety
/// As [`matrix_mut`], for each of them; `all` is checked before one is written.
pub(super) unsafe fn matrices_mut<'a, T: Copy>(
    what: &'static str,
    layout: Layout,
    shape: [usize; 3],
    starts: Starts<T>,
    ld: usize,
    all: &mut Vec<Region>,
) -> Result<Vec<MatMut<'a, T>>, Failure> {
    let [_, rows, cols] = shape;
    // SAFETY: `batch` has checked each pointer and the shape as `matrix` does, and matrices at one
    // distance do not overlap; clause `memory` for the elements. Those at pointers of their own are
    // compared by `regions::check_batch` before one is written, as the contract asks.
    unsafe {
        batch(what, layout, shape, starts, ld, true, all, |start, down, across| {
            MatMut::from_raw_parts_mut(start.cast_mut(), rows, cols, down, across)
        })
    }
}

/// Returns what `view` makes of the start and the strides of each of `count` rows x cols matrices.
///
/// # Safety
/// An array of pointers can be read.
unsafe fn batch<T: Copy, V>(
    what: &'static str,
    layout: Layout,
    [count, rows, cols]: [usize; 3],
    starts: Starts<T>,
    ld: usize,
    written: bool,
    all: &mut Vec<Region>,
    view: impl Fn(*const T, isize, isize) -> V,
) -> Result<Vec<V>, Failure> {
    let (len, down, across) = strides::<T>(what, layout, rows, cols, ld)?;
    let mut views = reserved(count)?;
    match starts {
        Starts::Every(start, distance) => {
            let distance = if count > 1 && len > 0 { distance } else { len };
            let shape_error = |why: String| Err(Failure::new(CATA_ERR_SHAPE, why));
            if written && distance < len {
                return shape_error(format!(
                    "stride_{what}: must be at least {len}, is {distance}"
                ));
            }
            let span = count.saturating_sub(1).checked_mul(distance);
            let span = span.and_then(|span| span.checked_add(len));
            let Some(span) = span.filter(|&span| span <= isize::MAX as usize / size_of::<T>())
            else {
                return shape_error(format!(
                    "stride_{what}: {count} matrices at this distance exceed the address space"
                ));
            };
            let start = checked(what, start, if count == 0 { 0 } else { span })?;
            // Matrices that overlap are one line.
            let (line, lines) = if distance < len { (span, count.min(1)) } else { (len, count) };
            let bytes = size_of::<T>();
            let (line, stride) = (line * bytes, distance.max(line) * bytes);
            regions::add(Region { what, start: start.addr(), line, stride, lines, written })?;
            let starts = (0..count).map(|i| start.wrapping_add(i * distance));
            views.extend(starts.map(|start| view(start, down, across)));
        }
        Starts::At(pointers) => {
            // SAFETY: clause `memory`: the array has `count` pointers.
            let pointers = unsafe { slice(what, pointers, count) }?;
            room(all, count)?;
            for (i, &start) in pointers.iter().enumerate() {
                // The name with the index takes longer than a small product.
                let start = checked(what, start, len)
                    .or_else(|_| checked(&format!("{what}[{i}]"), start, len))?;
                all.push(region(what, layout, rows, cols, start, ld, written));
                views.push(view(start, down, across));
            }
        }
    }
    Ok(views)
}

/// Returns `len` elements, read only.
///
/// # Safety
/// They can be read, and no thread writes them, during `'a`.
pub(super) unsafe fn slice<'a, T: Copy>(
    what: &'static str,
    pointer: *const T,
    len: usize,
) -> Result<&'a [T], Failure> {
    check_size::<T>(what, len, 1)?;
    let pointer = checked(what, pointer, len)?;
    regions::add(region(what, Layout::RowMajor, 1, len, pointer, len, false))?;
    // SAFETY: `checked` has excluded NULL and checked the alignment, `check_size` that the extent
    // is within an allocation's limit; clause `memory` for the elements.
    Ok(unsafe { std::slice::from_raw_parts(pointer, len) })
}

/// Returns a copy of `len` elements, where an output may be.
///
/// # Safety
/// They can be read, and no thread writes them.
#[cfg(feature = "chapters")]
pub(super) unsafe fn copied<T: Copy>(
    what: &str,
    pointer: *const T,
    len: usize,
) -> Result<Vec<T>, Failure> {
    check_size::<T>(what, len, 1)?;
    let pointer = checked(what, pointer, len)?;
    // SAFETY: the checks are those of `slice`; clause `memory` for the elements, which are copied
    // at once.
    Ok(unsafe { std::slice::from_raw_parts(pointer, len) }.to_vec())
}

/// Returns elements, or `None` for NULL.
///
/// # Safety
/// As [`slice()`], or the pointer is NULL.
pub(super) unsafe fn optional_slice<'a, T: Copy>(
    what: &'static str,
    pointer: *const T,
    len: usize,
) -> Result<Option<&'a [T]>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: not NULL, so that the contract is that of `slice`.
    unsafe { slice(what, pointer, len) }.map(Some)
}

/// Returns `len` elements.
///
/// # Safety
/// They can be read and written, and no other thread does either, during `'a`.
pub(super) unsafe fn slice_mut<'a, T: Copy>(
    what: &'static str,
    pointer: *mut T,
    len: usize,
) -> Result<&'a mut [T], Failure> {
    check_size::<T>(what, len, 1)?;
    let pointer = checked(what, pointer, len)?.cast_mut();
    regions::add(region(what, Layout::RowMajor, 1, len, pointer, len, true))?;
    // SAFETY: the checks are those of `slice`; clause `memory` for the elements, and `regions` has
    // refused other arguments that overlap them.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, len) })
}

/// Returns the contents of a handle.
///
/// # Safety
/// `handle` is NULL or alive, and no thread changes its contents, during `'a`.
#[cfg(feature = "chapters")]
pub(super) unsafe fn known<'a, T>(what: &str, handle: *const T) -> Result<&'a T, Failure> {
    // SAFETY: clause `handles`; NULL gives `None`.
    unsafe { handle.as_ref() }.ok_or_else(|| Failure::null(what))
}

/// Returns the contents of a handle, to be changed.
///
/// # Safety
/// `handle` is NULL or alive, and no other thread uses it, during `'a`.
#[cfg(feature = "chapters")]
pub(super) unsafe fn known_mut<'a, T>(what: &str, handle: *mut T) -> Result<&'a mut T, Failure> {
    // SAFETY: clause `handles`, to be changed: nobody else uses it during `'a`; NULL gives `None`.
    unsafe { handle.as_mut() }.ok_or_else(|| Failure::null(what))
}

/// Frees a handle; NULL does nothing.
///
/// # Safety
/// `handle` is NULL, or came from `Box::into_raw` and is freed once.
pub(super) unsafe fn free<T>(handle: *mut T) {
    boundary(|| {
        if !handle.is_null() {
            // SAFETY: clause `handles`: not NULL, so that it came from `Box::into_raw` and is freed
            // once.
            drop(unsafe { Box::from_raw(handle) });
        }
        Ok(())
    });
}

/// Returns a place for one result.
///
/// # Safety
/// It is NULL or can be written, and no other thread uses it, during `'a`.
pub(super) unsafe fn output<'a, T>(
    what: &'static str,
    pointer: *mut T,
) -> Result<&'a mut T, Failure> {
    let pointer = checked(what, pointer, 1)?.cast_mut();
    regions::add(region(what, Layout::RowMajor, 1, 1, pointer, 1, true))?;
    // SAFETY: `checked` has excluded NULL and checked the alignment; clause `memory` for the place,
    // which `regions` keeps apart from other arguments.
    Ok(unsafe { &mut *pointer })
}

/// Returns a place for one result, or `None` for NULL.
///
/// # Safety
/// As [`output`].
pub(super) unsafe fn optional_output<'a, T>(
    what: &'static str,
    pointer: *mut T,
) -> Result<Option<&'a mut T>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: not NULL, so that the contract is that of `output`.
    unsafe { output(what, pointer) }.map(Some)
}

/// Writes a value where it is wanted.
pub(super) fn put<T>(place: Option<&mut T>, value: T) {
    if let Some(place) = place {
        *place = value;
    }
}

/// Returns a mesh of x, y, z of each vertex and three vertices of each face, which are copied.
///
/// # Safety
/// They can be read, and no thread writes them.
#[cfg(feature = "chapters")]
pub(super) unsafe fn mesh(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
) -> Result<TriMesh, Failure> {
    check_size::<f64>("vertices", n_vertices, 3)?;
    check_size::<u32>("faces", n_faces, 3)?;
    // SAFETY: clause `memory`: 3 numbers of each vertex and 3 indices of each face, whose products
    // `check_size` has kept from an overflow.
    let (vertices, faces) = unsafe {
        (slice("vertices", vertices, 3 * n_vertices)?, slice("faces", faces, 3 * n_faces)?)
    };
    Ok(TriMesh::new(vertices.as_chunks().0.to_vec(), faces.as_chunks().0.to_vec())?)
}

/// Returns elements to write, or `None` for NULL.
///
/// # Safety
/// As [`slice_mut`], or the pointer is NULL.
#[cfg(feature = "chapters")]
pub(super) unsafe fn optional_slice_mut<'a, T: Copy>(
    what: &'static str,
    pointer: *mut T,
    len: usize,
) -> Result<Option<&'a mut [T]>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: not NULL, so that the contract is that of `slice_mut`.
    unsafe { slice_mut(what, pointer, len) }.map(Some)
}

/// Returns a matrix to write, or `None` for NULL.
///
/// # Safety
/// NULL, or as [`matrix_mut`].
#[cfg(feature = "chapters")]
pub(super) unsafe fn optional_matrix_mut<'a>(
    what: &'static str,
    layout: Layout,
    rows: usize,
    cols: usize,
    pointer: *mut f64,
    ld: usize,
) -> Result<Option<MatMut<'a, f64>>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: not NULL, so that the contract is that of `matrix_mut`.
    unsafe { matrix_mut(what, layout, rows, cols, pointer, ld) }.map(Some)
}

/// Returns an error for a rows x cols matrix that no memory can hold.
pub(super) fn check_size<T>(what: &str, rows: usize, cols: usize) -> Result<(), Failure> {
    strides::<T>(what, Layout::RowMajor, rows, cols, cols.max(1)).map(|_| ())
}

/// Returns the number of elements from the first to the last of a matrix with both included, and
/// its row and column strides.
fn strides<T>(
    what: &str,
    layout: Layout,
    rows: usize,
    cols: usize,
    ld: usize,
) -> Result<(usize, isize, isize), Failure> {
    let (lines, line, unit) = match layout {
        Layout::RowMajor => (rows, cols, "columns"),
        Layout::ColMajor => (cols, rows, "rows"),
    };
    if ld < line.max(1) {
        let message =
            format!("ld{what}: must be at least {} ({unit} of {what}), is {ld}", line.max(1));
        return Err(Failure::new(CATA_ERR_SHAPE, message));
    }
    let len = if rows == 0 || cols == 0 {
        Some(0)
    } else {
        (lines - 1).checked_mul(ld).and_then(|len| len.checked_add(line))
    };
    let most = isize::MAX as usize / size_of::<T>();
    // A dimension alone can exceed the address space when the other one is 0.
    match len.filter(|&len| len <= most && rows <= most && cols <= most) {
        Some(len) => {
            // A single line has no stride; ld may then be anything.
            let stride = if lines > 1 { ld as isize } else { line.max(1) as isize };
            Ok(match layout {
                Layout::RowMajor => (len, stride, 1),
                Layout::ColMajor => (len, 1, stride),
            })
        }
        None => Err(Failure::new(
            CATA_ERR_SHAPE,
            format!(
                "{what}: {rows} x {cols} with leading dimension {ld} exceeds the address space"
            ),
        )),
    }
}

/// Returns the memory of a matrix whose size and leading dimension have been checked.
fn region<T>(
    what: &'static str,
    layout: Layout,
    rows: usize,
    cols: usize,
    pointer: *const T,
    ld: usize,
    written: bool,
) -> Region {
    let (lines, line) = match layout {
        Layout::RowMajor => (rows, cols),
        Layout::ColMajor => (cols, rows),
    };
    let (line, start) = (line * size_of::<T>(), pointer.addr());
    // A single line has no stride; ld may then be anything.
    let stride = if lines > 1 { ld * size_of::<T>() } else { line };
    Region { what, start, line, stride, lines, written }
}

/// Returns `pointer`, or any aligned pointer when `len` is 0.
pub(super) fn checked<T>(what: &str, pointer: *const T, len: usize) -> Result<*const T, Failure> {
    if len == 0 {
        return Ok(std::ptr::NonNull::dangling().as_ptr());
    }
    if pointer.is_null() {
        return Err(Failure::null(what));
    }
    if !pointer.is_aligned() {
        let message = format!("{what}: not aligned to {} bytes", align_of::<T>());
        return Err(Failure::new(CATA_ERR_ARGUMENT, message));
    }
    Ok(pointer)
}

#[cfg(test)]
mod tests {
    use super::super::status::CATA_ERR_NULL;
    use super::*;

    #[test]
    fn strides_follow_layout() {
        let of = |layout, ld| strides::<f64>("a", layout, 3, 5, ld).unwrap();
        assert_eq!(of(Layout::RowMajor, 7), (19, 7, 1));
        assert_eq!(of(Layout::ColMajor, 7), (31, 1, 7));
    }

    #[test]
    fn short_leading_dimension_is_named() {
        let failure = strides::<f64>("a", Layout::RowMajor, 3, 5, 4).unwrap_err();
        assert_eq!(failure.status, CATA_ERR_SHAPE);
        assert_eq!(failure.message, "lda: must be at least 5 (columns of a), is 4");
        assert!(strides::<f64>("a", Layout::ColMajor, 0, 0, 0).is_err());
    }

    #[test]
    fn overflow_is_refused() {
        let refused =
            |rows, cols, ld| strides::<f64>("a", Layout::RowMajor, rows, cols, ld).is_err();
        assert!(refused(1 << 33, 1 << 33, 1 << 33));
        assert!(refused(3, 1, usize::MAX));
        assert!(refused(usize::MAX, 0, 1));
        assert!(refused(0, usize::MAX, usize::MAX));
        assert!(!refused(1, 3, usize::MAX), "one line has no stride");
    }

    #[test]
    fn pointers_are_checked() {
        assert_eq!(checked::<f64>("a", std::ptr::null(), 1).unwrap_err().status, CATA_ERR_NULL);
        assert!(checked::<f64>("a", std::ptr::null(), 0).is_ok());
        let odd = std::ptr::without_provenance::<f64>(9);
        assert_eq!(checked("a", odd, 1).unwrap_err().status, CATA_ERR_ARGUMENT);
    }
}
