//! ScaLAPACK, loaded at run time, with the routines of the race.

use std::error::Error;
use std::ffi::{CStr, c_char, c_int};
use std::path::Path;

use catamaran_bench::Result;
use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};

/// `p?syrk`.
type Syrk<T> = unsafe extern "C" fn(
    uplo: *const c_char,
    trans: *const c_char,
    n: *const c_int,
    k: *const c_int,
    alpha: *const T,
    a: *const T,
    ia: *const c_int,
    ja: *const c_int,
    desc_a: *const Descriptor,
    beta: *const T,
    c: *mut T,
    ic: *const c_int,
    jc: *const c_int,
    desc_c: *const Descriptor,
);

/// `Cp?gemr2d`: copies a matrix from one distribution to another.
type Copy<T> = unsafe extern "C" fn(
    m: c_int,
    n: c_int,
    a: *const T,
    ia: c_int,
    ja: c_int,
    desc_a: *const Descriptor,
    b: *mut T,
    ib: c_int,
    jb: c_int,
    desc_b: *const Descriptor,
    context: c_int,
);

/// `Cp?trmr2d`: the same for a triangle.
type CopyTriangle<T> = unsafe extern "C" fn(
    uplo: *const c_char,
    diag: *const c_char,
    m: c_int,
    n: c_int,
    a: *const T,
    ia: c_int,
    ja: c_int,
    desc_a: *const Descriptor,
    b: *mut T,
    ib: c_int,
    jb: c_int,
    desc_b: *const Descriptor,
    context: c_int,
);

/// A block-cyclic distribution in ScaLAPACK's format: type 1, context, rows, columns, rows and
/// columns of a block, process row and column of the first one, local leading dimension.
pub type Descriptor = [c_int; 9];

/// The library in one precision.
pub struct Scalapack<T> {
    /// Its file or name, and the version of its BLAS.
    pub description: String,
    syrk: Syrk<T>,
    copy: Copy<T>,
    copy_triangle: CopyTriangle<T>,
    get: unsafe extern "C" fn(c_int, c_int, *mut c_int),
    grid_init: unsafe extern "C" fn(*mut c_int, *const c_char, c_int, c_int),
    grid_info: unsafe extern "C" fn(c_int, *mut c_int, *mut c_int, *mut c_int, *mut c_int),
    grid_exit: unsafe extern "C" fn(c_int),
    _library: Library,
}

/// A matrix of the library: its distribution over a grid, and the part of this process,
/// column-major.
pub struct Distributed<'g, T> {
    grid: &'g Grid<'g, T>,
    descriptor: Descriptor,
    /// The part of this process.
    pub entries: Vec<T>,
}

/// All processes as a rectangle.
pub struct Grid<'s, T> {
    scalapack: &'s Scalapack<T>,
    context: c_int,
    /// Number of rows and columns.
    pub sides: [usize; 2],
    /// Row and column of this process.
    pub own: [usize; 2],
}

impl<T> Scalapack<T> {
    /// Loads the library at `path`, otherwise that of the system for the MPI library `mpi_version`;
    /// its BLAS will use `threads` threads.
    ///
    /// # Errors
    /// When the library can't be loaded or lacks a symbol.
    pub fn load(path: Option<&Path>, mpi_version: &str, threads: usize) -> Result<Self> {
        let flavour = if mpi_version.contains("Open MPI") { "openmpi" } else { "mpich" };
        let name = format!("libscalapack-{flavour}.so.2.2");
        let path = path.unwrap_or(Path::new(&name));
        // SAFETY: runs the library's initializers; the user named it, or the system did.
        let library = unsafe { Library::open(Some(path), RTLD_NOW | RTLD_LOCAL) };
        let library = library.map_err(|e| {
            let why = e.source().map_or_else(|| e.to_string(), ToString::to_string);
            format!("{why}; Debian has it in libscalapack-{flavour}-dev, --rival pdsyrk=PATH names another")
        })?;
        let precision = if size_of::<T>() == 8 { 'd' } else { 's' };
        // SAFETY: the signatures of ScaLAPACK with 32-bit integers; the library is kept beside the
        // pointers.
        unsafe {
            Ok(Self {
                description: format!("{}, {}", path.display(), blas(&library, threads)?),
                syrk: symbol(&library, &format!("p{precision}syrk_"))?,
                copy: symbol(&library, &format!("Cp{precision}gemr2d"))?,
                copy_triangle: symbol(&library, &format!("Cp{precision}trmr2d"))?,
                get: symbol(&library, "Cblacs_get")?,
                grid_init: symbol(&library, "Cblacs_gridinit")?,
                grid_info: symbol(&library, "Cblacs_gridinfo")?,
                grid_exit: symbol(&library, "Cblacs_gridexit")?,
                _library: library,
            })
        }
    }

    /// Creates a grid of `rows x cols` processes, row by row. MPI must run, and all processes must
    /// call this.
    pub fn grid(&self, rows: usize, cols: usize) -> Grid<'_, T> {
        let mut context = 0;
        let (mut sides, mut own) = ([0; 2], [0; 2]);
        // SAFETY: as BLACS documents the calls: the first gives the default context, which the
        // second replaces.
        unsafe {
            (self.get)(-1, 0, &mut context);
            (self.grid_init)(&mut context, c"Row".as_ptr(), rows as c_int, cols as c_int);
            let ([rows, cols], [row, col]) = (&mut sides, &mut own);
            (self.grid_info)(context, rows, cols, row, col);
        }
        let [sides, own] = [sides, own].map(|pair: [c_int; 2]| pair.map(|x| x.max(0) as usize));
        Grid { scalapack: self, context, sides, own }
    }
}

impl<T> Drop for Grid<'_, T> {
    fn drop(&mut self) {
        // SAFETY: the context is that of this grid, and is not used again.
        unsafe { (self.scalapack.grid_exit)(self.context) };
    }
}

impl<T: Clone> Grid<'_, T> {
    /// Creates a matrix `shape` in blocks `block`, distributed cyclically over the grid; `entry`
    /// returns its entries.
    ///
    /// # Errors
    /// When there is not enough memory, or a side is too long for 32-bit integers.
    pub fn matrix(
        &self,
        shape: [usize; 2],
        block: [usize; 2],
        entry: impl Fn(usize, usize) -> T,
    ) -> Result<Distributed<'_, T>> {
        let axis =
            |x| Axis { len: shape[x], block: block[x], sides: self.sides[x], own: self.own[x] };
        let axes = [axis(0), axis(1)];
        let local = axes.each_ref().map(Axis::count);
        let [rows, cols] = &axes;
        let entries =
            crate::job::filled(local[1], local[0], |j, i| entry(rows.global(i), cols.global(j)))?;
        let mut descriptor = [1, self.context, 0, 0, 0, 0, 0, 0, 0];
        let sides = [shape[0], shape[1], block[0], block[1], 0, 0, local[0].max(1)];
        for (slot, side) in descriptor[2..].iter_mut().zip(sides) {
            *slot = c_int::try_from(side)?;
        }
        Ok(Distributed { grid: self, descriptor, entries })
    }
}

/// One direction of a block-cyclic distribution.
struct Axis {
    len: usize,
    block: usize,
    sides: usize,
    own: usize,
}

impl Axis {
    /// Returns the number of lines of this process.
    fn count(&self) -> usize {
        let round = self.block * self.sides;
        let rest = (self.len % round).saturating_sub(self.own * self.block).min(self.block);
        self.len / round * self.block + rest
    }

    /// Returns the global index of the `local`-th line of this process.
    fn global(&self, local: usize) -> usize {
        (local / self.block * self.sides + self.own) * self.block + local % self.block
    }
}

impl<T: catamaran::Real> Distributed<'_, T> {
    fn sides(&self) -> [c_int; 2] {
        [self.descriptor[2], self.descriptor[3]]
    }

    /// Computes the lower triangle of `self := A^T A`, or `A A^T` if A is given `transposed`; k is
    /// the other side of A.
    pub fn set_to_syrk(&mut self, a: &Self, transposed: bool) {
        let [n, _] = self.sides();
        let [rows, cols] = a.sides();
        let (trans, k) = if transposed { (c"N", cols) } else { (c"T", rows) };
        let (one, alpha, beta) = (1, T::ONE, T::ZERO);
        // SAFETY: both matrices are as their descriptors say, and A has n columns, or rows.
        unsafe {
            (self.grid.scalapack.syrk)(
                c"L".as_ptr(),
                trans.as_ptr(),
                &n,
                &k,
                &alpha,
                a.entries.as_ptr(),
                &one,
                &one,
                &a.descriptor,
                &beta,
                self.entries.as_mut_ptr(),
                &one,
                &one,
                &self.descriptor,
            );
        }
    }

    /// Copies `self := other`, of the same shape, which one process holds completely.
    pub fn copy_from_one(&mut self, other: &Self) {
        let [rows, cols] = self.sides().map(|side| side as usize);
        // The library counts the bytes of its matrices in 32 bits, so it gets them in strips.
        const MOST: usize = 1 << 25;
        let along = usize::from(rows <= cols);
        let (long, short) = if along == 0 { (rows, cols) } else { (cols, rows) };
        // Strips begin on the first process.
        let round = self.axis(along).block * self.axis(along).sides;
        let step = (MOST / short.max(1)).next_multiple_of(round);
        for first in (0..long).step_by(step) {
            let count = step.min(long - first);
            let (from, from_offset) = other.strip(along, first, count);
            let (to, to_offset) = self.strip(along, first, count);
            let [m, n] = [to[2], to[3]];
            // SAFETY: both strips are as their descriptors say, and of this shape.
            unsafe {
                (self.grid.scalapack.copy)(
                    m,
                    n,
                    other.entries.as_ptr().add(from_offset),
                    1,
                    1,
                    &from,
                    self.entries.as_mut_ptr().add(to_offset),
                    1,
                    1,
                    &to,
                    self.grid.context,
                );
            }
        }
    }

    /// Returns direction 0 (rows) or 1 (columns) of the distribution.
    fn axis(&self, along: usize) -> Axis {
        let [len, block] = [2, 4].map(|slot| self.descriptor[slot + along] as usize);
        Axis { len, block, sides: self.grid.sides[along], own: self.grid.own[along] }
    }

    /// Returns the descriptor of `count` lines from `first` on, which must be a line of process 0,
    /// and the start of their entries.
    fn strip(&self, along: usize, first: usize, count: usize) -> ([c_int; 9], usize) {
        let axis = self.axis(along);
        let before = Axis { len: first, ..axis }.count();
        let mut descriptor = self.descriptor;
        descriptor[2 + along] = count as c_int;
        // A block of the whole matrix remains one block.
        let block = if axis.block == axis.len { count } else { axis.block };
        descriptor[4 + along] = block as c_int;
        let leading = descriptor[8] as usize;
        let offset = if along == 0 { before } else { before * leading };
        (descriptor, offset.min(self.entries.len()))
    }

    /// Copies the lower triangle of `other` into that of `self`; both are square.
    pub fn copy_lower_from(&mut self, other: &Self) {
        let [n, _] = self.sides();
        // SAFETY: both matrices are as their descriptors say, n x n.
        unsafe {
            (self.grid.scalapack.copy_triangle)(
                c"L".as_ptr(),
                c"N".as_ptr(),
                n,
                n,
                other.entries.as_ptr(),
                1,
                1,
                &other.descriptor,
                self.entries.as_mut_ptr(),
                1,
                1,
                &self.descriptor,
                self.grid.context,
            );
        }
    }
}

/// Sets the threads of the BLAS that the library resolved to; returns the version that it reports.
fn blas(library: &Library, threads: usize) -> Result<String> {
    type Text = unsafe extern "C" fn() -> *const c_char;
    type WriteText = unsafe extern "C" fn(*mut c_char, c_int);
    type SetThreads = unsafe extern "C" fn(c_int);
    let text;
    // SAFETY: OpenBLAS and MKL document these signatures. The text of OpenBLAS is static, MKL pads
    // the buffer with blanks and leaves its last byte, which stays zero, alone.
    unsafe {
        if let Ok(config) = symbol::<Text>(library, "openblas_get_config") {
            symbol::<SetThreads>(library, "openblas_set_num_threads")?(threads as c_int);
            text = CStr::from_ptr(config()).to_string_lossy().trim().to_owned();
        } else if let Ok(write) = symbol::<WriteText>(library, "MKL_Get_Version_String") {
            symbol::<SetThreads>(library, "MKL_Set_Num_Threads")?(threads as c_int);
            let mut buffer = [0_u8; 256];
            write(buffer.as_mut_ptr().cast(), buffer.len() as c_int - 1);
            text = CStr::from_bytes_until_nul(&buffer)?.to_string_lossy().trim().to_owned();
        } else {
            let text = "over a BLAS that is neither OpenBLAS nor MKL: the race may not be fair";
            return if threads == 1 {
                Ok(text.into())
            } else {
                Err(format!("{text}, threads unknown").into())
            };
        }
    }
    Ok(format!("over {text}"))
}

/// Returns the symbol `name` of the library or of its dependencies.
///
/// # Safety
/// `F` must be the pointer type of that symbol.
unsafe fn symbol<F: std::marker::Copy>(library: &Library, name: &str) -> Result<F> {
    // SAFETY: `F` is the pointer type of the symbol, by the contract; it is only copied.
    Ok(*unsafe { library.get::<F>(name.as_bytes()) }?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_dealt_once() {
        for (len, block, sides) in [(0, 3, 2), (1, 64, 4), (17, 3, 2), (24, 4, 3), (25, 4, 3)] {
            let mut seen = vec![0; len];
            for own in 0..sides {
                let axis = Axis { len, block, sides, own };
                (0..axis.count()).for_each(|l| seen[axis.global(l)] += 1);
            }
            assert!(seen.iter().all(|&s| s == 1), "{len} by {block} on {sides}: {seen:?}");
        }
    }
}
