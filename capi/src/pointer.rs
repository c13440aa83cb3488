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
        other => Err(Failure::argument("uplo", UPLO, other)),
    }
}

/// What a triangle may be.
pub(super) const UPLO: &str = "CATA_UPPER (121), CATA_LOWER (122) or CATA_BOTH (123)";

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
    // SAFETY: clause `memory` (`entries`, as many elements as `columns`), clause `passed on`
    // (`places`).
    let (row_starts, columns, entries) = unsafe {
        let (row_starts, columns) = places(rows, row_starts, columns)?;
        (row_starts, columns, slice("entries", entries, columns.len())?)
    };
    CsMatView::try_new((rows, cols), row_starts, columns, entries)
        .map_err(|(_, _, _, why)| not_sparse(why))
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
    // SAFETY: clause `passed on` (`places`).
    let (row_starts, columns) = unsafe { places(rows, row_starts, columns) }?;
    Places::try_new((rows, cols), row_starts, columns, vec![(); columns.len()])
        .map_err(|(_, _, _, why)| not_sparse(why))
}

/// Returns where the rows of a sparse matrix begin and the last one ends, and the columns of its
/// entries.
///
/// # Safety
/// As for [`sparse`], without entries.
#[cfg(feature = "chapters")]
unsafe fn places<'a>(
    rows: usize,
    row_starts: *const usize,
    columns: *const usize,
) -> Result<(&'a [usize], &'a [usize]), Failure> {
    // SAFETY: clause `memory` (`row_starts`, rows + 1 elements where there are rows, of which a
    // number that saturates is refused; `columns`, as many elements as the last one says).
    unsafe {
        let row_starts: &[usize] = match rows {
            0 => &[0],
            _ => slice("row_starts", row_starts, rows.saturating_add(1))?,
        };
        Ok((row_starts, slice("columns", columns, row_starts[rows])?))
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
    let extent = Extent::new::<T>(what, layout, rows, cols, ld)?;
    let pointer = noted(what, pointer, &extent, false)?;
    let (down, across) = extent.strides(layout);
    // SAFETY: `noted` has excluded NULL and checked the alignment, `Extent` that the elements are
    // within an allocation's limit; clause `memory` for them.
    Ok(unsafe { MatRef::from_raw_parts(pointer, rows, cols, down, across) })
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
    let extent = Extent::new::<T>(what, layout, rows, cols, ld)?;
    let pointer = noted(what, pointer, &extent, true)?.cast_mut();
    let (down, across) = extent.strides(layout);
    // SAFETY: the checks are those of `matrix`; clause `memory` for the elements, which are
    // distinct because ld is at least the length of a line, and `regions` has refused other
    // arguments that overlap them.
    Ok(unsafe { MatMut::from_raw_parts_mut(pointer, rows, cols, down, across) })
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
    let extent = Extent::new::<T>(what, layout, rows, cols, ld)?;
    let (len, (down, across)) = (extent.len(), extent.strides(layout));
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
                all.push(extent.region(what, start, written));
                views.push(view(start, down, across));
            }
        }
    }
    Ok(views)
}

/// Returns `len` elements, read only. Where there are several numbers for each of `len` things, an
/// element is an array of them, so that no product of sizes can overflow.
///
/// # Safety
/// They can be read, and no thread writes them, during `'a`.
pub(super) unsafe fn slice<'a, T: Copy>(
    what: &'static str,
    pointer: *const T,
    len: usize,
) -> Result<&'a [T], Failure> {
    let pointer = noted(what, pointer, &Extent::line::<T>(what, len)?, false)?;
    // SAFETY: `noted` has excluded NULL and checked the alignment, `Extent` that the elements are
    // within an allocation's limit; clause `memory` for them.
    Ok(unsafe { std::slice::from_raw_parts(pointer, len) })
}

/// Returns a copy of W elements.
///
/// # Safety
/// As [`slice()`].
pub(super) unsafe fn array<T: Copy, const W: usize>(
    what: &'static str,
    pointer: *const T,
) -> Result<[T; W], Failure> {
    // SAFETY: clause `passed on` (`slice`), of W elements.
    unsafe { slice(what, pointer.cast::<[T; W]>(), 1) }.map(|one| one[0])
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
    let pointer = checked(what, pointer, Extent::line::<T>(what, len)?.len())?;
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
    let pointer = noted(what, pointer, &Extent::line::<T>(what, len)?, true)?.cast_mut();
    // SAFETY: the checks are those of `slice`; clause `memory` for the elements, and `regions` has
    // refused other arguments that overlap them.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, len) })
}

/// Returns whether each of `len` elements is 1, where each is 0 or 1.
///
/// # Safety
/// As [`slice()`].
#[cfg(feature = "chapters")]
pub(super) unsafe fn mask(
    what: &'static str,
    pointer: *const u8,
    len: usize,
) -> Result<Vec<bool>, Failure> {
    // SAFETY: clause `passed on` (`slice`).
    let mask = unsafe { slice(what, pointer, len) }?;
    if let Some(i) = mask.iter().position(|&inside| inside > 1) {
        let why = format!("{what}: must be 0 or 1, but element {i} is {}", mask[i]);
        return Err(Failure::new(CATA_ERR_ARGUMENT, why));
    }
    Ok(mask.iter().map(|&inside| inside == 1).collect())
}

/// Returns the contents of a handle, which calls on several threads may use at a time.
///
/// # Safety
/// `handle` is NULL or alive, and no thread changes its contents, during `'a`.
#[cfg(feature = "chapters")]
pub(super) unsafe fn known<'a, T: Sync>(what: &str, handle: *const T) -> Result<&'a T, Failure> {
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

/// Moves a value to the heap, and its handle to the caller, for calls on any thread.
pub(super) fn hand_over<T: Send>(place: &mut *mut T, value: T) {
    *place = Box::into_raw(Box::new(value));
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
    let pointer = noted(what, pointer, &Extent::ONE, true)?.cast_mut();
    // SAFETY: `noted` has excluded NULL and checked the alignment; clause `memory` for the place,
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
    // SAFETY: clause `passed on` (`mesh_arrays`).
    let (vertices, faces) = unsafe { mesh_arrays(n_vertices, vertices, n_faces, faces)? };
    Ok(TriMesh::new(vertices.to_vec(), faces.to_vec())?)
}

/// The positions and the triangles of a mesh that a caller has.
#[cfg(feature = "chapters")]
pub(super) type MeshArrays<'a> = (&'a [[f64; 3]], &'a [[u32; 3]]);

/// Returns the arrays of a mesh.
///
/// # Safety
/// As [`slice()`], for 3 numbers of each vertex and 3 indices of each face.
#[cfg(feature = "chapters")]
pub(super) unsafe fn mesh_arrays<'a>(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
) -> Result<MeshArrays<'a>, Failure> {
    let (vertices, faces) = (vertices.cast::<[f64; 3]>(), faces.cast::<[u32; 3]>());
    // SAFETY: clause `memory`: 3 numbers of each vertex and 3 indices of each face.
    unsafe { Ok((slice("vertices", vertices, n_vertices)?, slice("faces", faces, n_faces)?)) }
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

/// Returns an error for a leading dimension that is too small. `name` is its own, for a matrix
/// `what` of which it is not the name after `ld`.
pub(super) fn check_leading(
    name: impl std::fmt::Display,
    what: &str,
    layout: Layout,
    [rows, cols]: [usize; 2],
    ld: usize,
) -> Result<(), Failure> {
    let (line, unit) = match layout {
        Layout::RowMajor => (cols, "columns"),
        Layout::ColMajor => (rows, "rows"),
    };
    let least = line.max(1);
    if ld < least {
        let why = format!("{name}: must be at least {least} ({unit} of {what}), is {ld}");
        return Err(Failure::new(CATA_ERR_SHAPE, why));
    }
    Ok(())
}

/// Returns an error for a rows x cols matrix that no memory can hold.
pub(super) fn check_size<T>(what: &str, rows: usize, cols: usize) -> Result<(), Failure> {
    Extent::new::<T>(what, Layout::RowMajor, rows, cols, cols.max(1)).map(|_| ())
}

/// Where the elements of a matrix are: `lines` of `line` elements, each `stride` after the one
/// before. All that an allocation can hold, in bytes.
#[derive(Debug, PartialEq)]
struct Extent {
    lines: usize,
    line: usize,
    stride: usize,
}

impl Extent {
    /// That of a single element.
    const ONE: Self = Self { lines: 1, line: 1, stride: 1 };

    fn new<T>(
        what: &str,
        layout: Layout,
        rows: usize,
        cols: usize,
        ld: usize,
    ) -> Result<Self, Failure> {
        check_leading(format_args!("ld{what}"), what, layout, [rows, cols], ld)?;
        let (lines, line) = match layout {
            Layout::RowMajor => (rows, cols),
            Layout::ColMajor => (cols, rows),
        };
        let least = line.max(1);
        // A single line has no stride, nor have lines of nothing; ld may then be anything.
        let stride = if lines > 1 && line > 0 { ld } else { least };
        let len = lines.saturating_sub(1).checked_mul(stride).and_then(|len| len.checked_add(line));
        let most = isize::MAX as usize / size_of::<T>();
        // A dimension alone can exceed the address space when the other one is 0.
        if lines.max(line) > most || len.is_none_or(|len| len > most) {
            let why = format!(
                "{what}: {rows} x {cols} with leading dimension {ld} exceeds the address space"
            );
            return Err(Failure::new(CATA_ERR_SHAPE, why));
        }
        Ok(Self { lines, line, stride })
    }

    /// Returns that of `len` elements one after the other.
    fn line<T>(what: &str, len: usize) -> Result<Self, Failure> {
        Self::new::<T>(what, Layout::RowMajor, 1, len, len.max(1))
    }

    /// Returns the number of elements from the first to the last, with both included.
    fn len(&self) -> usize {
        match self.lines.min(self.line) {
            0 => 0,
            _ => (self.lines - 1) * self.stride + self.line,
        }
    }

    /// Returns the row and column strides.
    fn strides(&self, layout: Layout) -> (isize, isize) {
        match layout {
            Layout::RowMajor => (self.stride as isize, 1),
            Layout::ColMajor => (1, self.stride as isize),
        }
    }

    /// Returns the memory at a pointer.
    fn region<T>(&self, what: &'static str, pointer: *const T, written: bool) -> Region {
        let [line, stride] = [self.line, self.stride].map(|count| count * size_of::<T>());
        Region { what, start: pointer.addr(), line, stride, lines: self.lines, written }
    }
}

/// Returns the pointer of an argument, [`checked`], when its memory overlaps no other argument in a
/// way that is not allowed.
fn noted<T>(
    what: &'static str,
    pointer: *const T,
    extent: &Extent,
    written: bool,
) -> Result<*const T, Failure> {
    let pointer = checked(what, pointer, extent.len())?;
    regions::add(extent.region(what, pointer, written))?;
    Ok(pointer)
}

/// Returns the pointer to `len` elements, or any aligned pointer when there are none.
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
    if pointer.addr().checked_add(len * size_of::<T>()).is_none() {
        let message = format!("{what}: its {len} elements exceed the address space from there on");
        return Err(Failure::new(CATA_ERR_SHAPE, message));
    }
    Ok(pointer)
}

#[cfg(test)]
mod tests {
    use super::super::status::CATA_ERR_NULL;
    use super::*;

    fn extent(layout: Layout, rows: usize, cols: usize, ld: usize) -> Result<Extent, Failure> {
        Extent::new::<f64>("a", layout, rows, cols, ld)
    }

    #[test]
    fn strides_follow_layout() {
        let of = |layout| extent(layout, 3, 5, 7).map(|e| (e.len(), e.strides(layout))).unwrap();
        assert_eq!(of(Layout::RowMajor), (19, (7, 1)));
        assert_eq!(of(Layout::ColMajor), (31, (1, 7)));
    }

    #[test]
    fn short_leading_dimension_is_named() {
        let failure = extent(Layout::RowMajor, 3, 5, 4).unwrap_err();
        assert_eq!(failure.status, CATA_ERR_SHAPE);
        assert_eq!(failure.message, "lda: must be at least 5 (columns of a), is 4");
        assert!(extent(Layout::ColMajor, 0, 0, 0).is_err());
    }

    #[test]
    fn overflow_is_refused() {
        let refused = |rows, cols, ld| extent(Layout::RowMajor, rows, cols, ld).is_err();
        assert!(refused(1 << 33, 1 << 33, 1 << 33));
        assert!(refused(3, 1, usize::MAX));
        assert!(refused(usize::MAX, 0, 1));
        assert!(refused(0, usize::MAX, usize::MAX));
    }

    #[test]
    fn one_line_and_lines_of_nothing_have_no_stride() {
        let len = |rows, cols| extent(Layout::RowMajor, rows, cols, usize::MAX).unwrap().len();
        assert_eq!((len(1, 3), len(5, 0), len(0, 3)), (3, 0, 0));
        let region = extent(Layout::RowMajor, 5, 0, usize::MAX).unwrap();
        assert_eq!(region.region("a", std::ptr::null::<f64>(), false).line, 0);
    }

    #[test]
    fn pointers_are_checked() {
        assert_eq!(checked::<f64>("a", std::ptr::null(), 1).unwrap_err().status, CATA_ERR_NULL);
        assert!(checked::<f64>("a", std::ptr::null(), 0).is_ok());
        let odd = std::ptr::without_provenance::<f64>(9);
        assert_eq!(checked("a", odd, 1).unwrap_err().status, CATA_ERR_ARGUMENT);
        let last = std::ptr::without_provenance::<f64>(usize::MAX - 15);
        assert!(checked("a", last, 1).is_ok());
        assert_eq!(checked("a", last, 2).unwrap_err().status, CATA_ERR_SHAPE);
    }
}
