use std::fmt;
use std::ops::Range;

use super::blocks::check_block_rows;
use super::grid::moduli;
use crate::base::steps::step;
use crate::base::{Error, Result, block_rows, byte_size, triangle_len};
use crate::blas::BlasReal;
use crate::product::AtaOptions;
use crate::product::exact::{self, ExactLayout};
use crate::product::plan::{Op, Plan};

/// A plan of the stream of an m x n matrix A, as data: blocks, reads, memory. It depends on the
/// shape and on the allowed memory: C is computed in strips of rows, and each strip reads A once.
/// The cut into blocks does not depend on the memory.
///
/// ```
/// use catamaran::{AtaOptions, rows::StreamPlan};
///
/// // C takes 800 MB: with 500 MB for everything, A is read more than once.
/// let options = AtaOptions::new().threads(2);
/// let plan = |memory| StreamPlan::new::<f64>(1 << 20, 10_000, false, None, memory, &options);
/// assert_eq!(plan(4_000_000_000)?.reads(), 1);
/// let short = plan(500_000_000)?;
/// assert!(short.reads() > 1 && short.bytes() <= 500_000_000);
/// assert_eq!(short.strips().last().map(|rows| rows.end), Some(10_000));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct StreamPlan {
    rows: usize,
    block_rows: usize,
    strips: Vec<Range<usize>>,
    bytes: usize,
    /// Whether sums are exact, after a pass for the bounds.
    exact: bool,
    /// The plan of the product of a block, when one strip is all of C.
    product: Option<Plan>,
}

/// More reads of A are refused: they take days, and their list would be as long as C is wide.
const MOST_READS: usize = 4096;

/// What strips of rows of C need of memory.
struct StripNeeds<'a> {
    /// Rows of a block of A.
    height: usize,
    /// Columns of A.
    n: usize,
    weighted: bool,
    exact: bool,
    /// Blocks of rows that are in memory at once.
    blocks: usize,
    options: &'a AtaOptions<'a>,
}

impl StripNeeds<'_> {
    /// Returns the bytes of a strip if they fit. Strips that do not even without scratch are not
    /// planned.
    fn bytes_within<T: BlasReal>(
        &self,
        strip: &Range<usize>,
        memory: usize,
    ) -> Result<Option<usize>> {
        step();
        if self.bytes_without_scratch::<T>(strip) > memory {
            return Ok(None);
        }
        Ok(Some(self.bytes::<T>(strip)?).filter(|&bytes| bytes <= memory))
    }

    /// Returns the bytes of blocks, of a strip and of the scratch of its products.
    fn bytes<T: BlasReal>(&self, strip: &Range<usize>) -> Result<usize> {
        let scratch = self.scratch_len::<T>(strip)?.saturating_mul(size_of::<T>());
        Ok(self.bytes_without_scratch::<T>(strip).saturating_add(scratch))
    }

    fn bytes_without_scratch<T: BlasReal>(&self, strip: &Range<usize>) -> usize {
        let bytes = |elements: usize| elements.saturating_mul(size_of::<T>());
        let blocks = bytes(self.blocks.saturating_mul(self.height).saturating_mul(self.n));
        let mut c = bytes(strip.len().saturating_mul(strip.end));
        if self.exact {
            let entries = triangle_len(strip.end) - triangle_len(strip.start);
            c = c.saturating_add(entries.saturating_mul(size_of::<i128>()));
        }
        c.saturating_add(blocks)
    }

    /// Returns the elements of scratch of the two products of a strip, whichever needs more.
    fn scratch_len<T: BlasReal>(&self, strip: &Range<usize>) -> Result<usize> {
        let Self { height, weighted, options, .. } = *self;
        let own = strip.len();
        if self.exact {
            let len = |k: usize, symmetric: bool| {
                let same = symmetric && !weighted;
                let (extents, entry) = ([height, own, k], size_of::<T>());
                let layout = ExactLayout::new(extents, entry, moduli::<T>(), symmetric, same);
                exact::scratch_len::<T>(extents, &layout, options.par.threads())
            };
            return Ok(len(own, true).max(len(strip.start, false)));
        }
        let op = if weighted { Op::Gemmt } else { Op::Syrk };
        let square = Plan::new::<T>(op, height, own, own, options)?;
        let square = square.scratch_len::<T>(options.par);
        if strip.start == 0 {
            return Ok(square);
        }
        let left = Plan::atb::<T>(height, own, strip.start, options)?;
        Ok(square.max(left.scratch_len::<T>(options.par)))
    }
}

impl StreamPlan {
    /// Plans the stream of A m x n in blocks of `rows` rows (`None`: [`block_rows`]) within
    /// `memory` bytes: C or a strip of it, two blocks (three in the memory of two with weights),
    /// and the scratch of a product.
    ///
    /// # Errors
    /// [`Error::Argument`] when the memory is less than one row of C needs or makes more than 4096
    /// reads necessary, for `rows` 0, and for options out of range.
    pub fn new<T: BlasReal>(
        m: usize,
        n: usize,
        weighted: bool,
        rows: Option<usize>,
        memory: usize,
        options: &AtaOptions<'_>,
    ) -> Result<Self> {
        let block_rows = rows.unwrap_or_else(|| block_rows::<T>(n, weighted));
        check_block_rows(block_rows)?;
        let height = block_rows.min(m);
        let blocks = if m > height { 2 } else { 1 } + usize::from(weighted);
        let product = Plan::ata::<T>(height, n, options)?;
        let exact = options.asks_for_exact();
        let needs = StripNeeds { height, n, weighted, exact, blocks, options };
        let all = 0..n;
        if let Some(whole) = needs.bytes_within::<T>(&all, memory)? {
            let (strips, product) = (vec![all], Some(product));
            return Ok(Self { rows: m, block_rows, strips, bytes: whole, exact, product });
        }
        let mut strips: Vec<Range<usize>> = Vec::new();
        let mut largest = 0;
        while strips.last().is_none_or(|s| s.end < n) {
            let start = strips.last().map_or(0, |s| s.end);
            // The longest strip that fits: scratch and C grow with its length.
            let (mut fits, mut over) = (start, n + 1);
            while over - fits > 1 {
                let middle = fits.midpoint(over);
                let strip = start..middle;
                let there = needs.bytes_within::<T>(&strip, memory)?.is_some();
                if there { fits = middle } else { over = middle }
            }
            if fits == start {
                let least = needs.bytes::<T>(&(start..start + 1))?;
                let hint = if height > 1 { ": blocks of fewer rows need less" } else { "" };
                let why = format!(
                    "{memory} bytes, but blocks of {height} rows and a row of C need {least}{hint}"
                );
                return Err(Error::Argument { what: "memory", why });
            }
            largest = largest.max(needs.bytes::<T>(&(start..fits))?);
            strips.push(start..fits);
            if strips.len() > MOST_READS {
                let why = format!(
                    "{memory} bytes are enough for strips of {} rows of C: A would be read more \
                     than {MOST_READS} times",
                    fits - start
                );
                return Err(Error::Argument { what: "memory", why });
            }
        }
        Ok(Self { rows: m, block_rows, strips, bytes: largest, exact, product: None })
    }

    /// Returns the number of rows of a block.
    pub fn block_rows(&self) -> usize {
        self.block_rows
    }

    /// Returns the rows of C that each read of A computes.
    pub fn strips(&self) -> &[Range<usize>] {
        &self.strips
    }

    /// Returns how often A is read.
    pub fn reads(&self) -> usize {
        self.strips.len()
    }

    /// Returns the bytes of memory: the largest strip of C, blocks, scratch.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// Returns the plan of the product of a block; `None` when C is cut into strips.
    pub fn product(&self) -> Option<&Plan> {
        self.product.as_ref()
    }
}

/// Writes the plan as lines of text.
impl fmt::Display for StreamPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (blocks, reads) = (self.rows.div_ceil(self.block_rows), self.reads());
        let height = self.block_rows.min(self.rows);
        let m = self.rows;
        writeln!(f, "rows       {m} in {blocks} blocks of {height}, converted block by block")?;
        if self.exact {
            writeln!(
                f,
                "sums       exact, in any order the same; A is read once more, for its bounds"
            )?;
        }
        write!(f, "reads      A is read {}", if reads == 1 { "once" } else { "" })?;
        if reads > 1 {
            write!(f, "{reads} times, for strips of at most ")?;
            let longest = self.strips.iter().map(Range::len).max().unwrap_or(0);
            write!(f, "{longest} rows of C")?;
        }
        write!(f, "\nmemory     {}: C, two blocks, scratch", byte_size(self.bytes as f64))
    }
}
