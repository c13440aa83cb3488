//! The memory that the arguments of a call describe: no output may overlap another argument.

use std::cell::RefCell;

use super::status::{CATA_ERR_ARGUMENT, Failure};
use catamaran::base::reserved;

thread_local! {
    static REGIONS: RefCell<Regions> = RefCell::default();
}

/// The regions of the calls that this thread is in: a callback may call the library again.
#[derive(Default)]
struct Regions {
    list: Vec<Region>,
    /// The first one of the innermost call.
    first: Option<usize>,
}

impl Regions {
    /// Returns an argument of the innermost call that shares a byte with a new one, when one of
    /// both is written.
    fn met_by(&self, new: &Region) -> Option<Region> {
        let first = self.first.filter(|_| !new.is_empty())?;
        let both = |old: &&Region| (old.written || new.written) && old.overlaps(new);
        self.list[first..].iter().find(both).copied()
    }
}

/// The bytes of an argument: lines of `line` bytes, each `stride` after the one before, which is at
/// least `line`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Region {
    pub what: &'static str,
    pub start: usize,
    pub line: usize,
    pub stride: usize,
    pub lines: usize,
    pub written: bool,
}

impl Region {
    /// Returns so many bytes without gaps.
    pub fn bytes(what: &'static str, start: usize, line: usize, written: bool) -> Self {
        Self { what, start, line, stride: line, lines: 1, written }
    }

    fn is_empty(&self) -> bool {
        self.lines == 0 || self.line == 0
    }

    /// Returns the address after the last byte.
    fn end(&self) -> usize {
        self.start + (self.lines - 1) * self.stride + self.line
    }

    /// Returns whether a line has a byte in `from..to`.
    fn meets(&self, from: usize, to: usize) -> bool {
        if to <= self.start {
            return false;
        }
        let last = ((to - 1 - self.start) / self.stride).min(self.lines - 1);
        self.start + last * self.stride + self.line > from
    }

    /// Returns whether both have a byte. What lies between lines belongs to neither, so that blocks
    /// of columns of one matrix do not overlap.
    fn overlaps(&self, other: &Self) -> bool {
        if self.end() <= other.start || other.end() <= self.start {
            return false;
        }
        let (few, many) = if self.lines <= other.lines { (self, other) } else { (other, self) };
        (0..few.lines).map(|i| few.start + i * few.stride).any(|at| many.meets(at, at + few.line))
    }
}

/// A call, while its arguments are compared with each other; those of the call around it are not.
pub(super) struct Call {
    around: Option<usize>,
    first: usize,
}

impl Call {
    pub fn begin() -> Self {
        let begin = |all: &RefCell<Regions>| {
            let mut all = all.borrow_mut();
            let first = all.list.len();
            Self { around: all.first.replace(first), first }
        };
        // The thread-local may be gone while the thread destroys its other thread-locals. (Lazily:
        // a call that is dropped ends this one.)
        REGIONS.try_with(begin).unwrap_or_else(|_| Self { around: None, first: 0 })
    }
}

impl Drop for Call {
    fn drop(&mut self) {
        let _ = REGIONS.try_with(|all| {
            let mut all = all.borrow_mut();
            all.list.truncate(self.first);
            all.first = self.around;
        });
    }
}

/// Adds the memory of an argument to this thread's call, or returns an error when it, or the
/// argument that it overlaps, is written.
pub(super) fn add(new: Region) -> Result<(), Failure> {
    let check = |all: &RefCell<Regions>| {
        let mut all = all.borrow_mut();
        let found = all.met_by(&new);
        // Outside of a call, nothing would ever remove it.
        if all.first.is_some() && !new.is_empty() {
            all.list.push(new);
        }
        found
    };
    match REGIONS.try_with(check) {
        Ok(Some(old)) => {
            let (output, other) = if new.written { (new, old) } else { (old, new) };
            Err(overlap(output.what, other.what))
        }
        _ => Ok(()),
    }
}

fn overlap(output: &str, other: &str) -> Failure {
    Failure::new(CATA_ERR_ARGUMENT, format!("{output}: must not overlap {other}"))
}

/// Returns an error when one of the matrices that are written overlaps another one, or an argument
/// of this thread's call, such as the pointers to them. `all` are those of arrays of `count`
/// matrices each, array by array.
pub(super) fn check_batch(all: &[Region], count: usize) -> Result<(), Failure> {
    let name = |i: usize| format!("{}[{}]", all[i].what, i % count);
    let met = |call: &RefCell<Regions>| {
        let call = call.borrow();
        let mut written = all.iter().enumerate().filter(|(_, region)| region.written);
        written.find_map(|(i, region)| Some((i, call.met_by(region)?)))
    };
    if let Ok(Some((i, other))) = REGIONS.try_with(met) {
        return Err(overlap(&name(i), other.what));
    }
    // Line by line only where it matters: blocks of one matrix have lines between those of others.
    if first_overlap(all, false)?.is_none() {
        return Ok(());
    }
    let Some((old, new)) = first_overlap(all, true)? else { return Ok(()) };
    let (output, other) = if all[new].written { (new, old) } else { (old, new) };
    Err(overlap(&name(output), &name(other)))
}

/// Returns two regions that overlap, one of them written, if there are any: compares their lines,
/// or all that lies between their ends.
fn first_overlap(all: &[Region], by_line: bool) -> Result<Option<(usize, usize)>, Failure> {
    let lines = all.iter().map(|region| if by_line { region.lines } else { 1 });
    let mut pieces = reserved(lines.fold(0, usize::saturating_add))?;
    for (i, region) in all.iter().enumerate().filter(|(_, it)| !it.is_empty()) {
        match by_line {
            true => pieces.extend((0..region.lines).map(|line| {
                let start = region.start + line * region.stride;
                (start, start + region.line, i)
            })),
            false => pieces.push((region.start, region.end(), i)),
        }
    }
    // Stable: fast for two arrays that ascend.
    pieces.sort();
    // What reaches farthest so far: of all pieces, and of those that are written.
    let mut farthest: [(usize, usize); 2] = [(0, 0); 2];
    for (start, end, i) in pieces {
        let written = all[i].written;
        let (before, old) = farthest[usize::from(!written)];
        if start < before {
            return Ok(Some((old, i)));
        }
        for reached in &mut farthest[..1 + usize::from(written)] {
            *reached = (*reached).max((end, i));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn region(start: usize, line: usize, stride: usize, lines: usize) -> Region {
        Region { what: "a", start, line, stride, lines, written: true }
    }

    #[test]
    fn regions_overlap_when_they_share_a_byte() {
        let sizes = [(1, 1, 1), (2, 3, 4), (3, 3, 2), (1, 7, 3), (4, 9, 2), (2, 2, 5), (9, 9, 1)];
        let bytes = |r: Region| {
            (0..r.lines).flat_map(move |i| (0..r.line).map(move |j| r.start + i * r.stride + j))
        };
        for (line, stride, lines) in sizes {
            for (line2, stride2, lines2) in sizes {
                for start in 0..45 {
                    let (a, b) =
                        (region(20, line, stride, lines), region(start, line2, stride2, lines2));
                    let shared = bytes(a).any(|byte| bytes(b).any(|other| other == byte));
                    assert_eq!((a.overlaps(&b), b.overlaps(&a)), (shared, shared), "{a:?} {b:?}");
                }
            }
        }
    }

    #[test]
    fn overlaps_in_a_batch_are_named_and_blocks_of_one_matrix_are_none() {
        let read = |start| Region { what: "a", written: false, ..region(start, 8, 8, 2) };
        let block = |start| Region { what: "c", ..region(start, 8, 32, 2) };
        let check = |all: &[Region]| check_batch(all, 2).map_err(|failure| failure.message);
        check(&[read(100), read(104), block(0), block(8)]).unwrap();
        check(&[read(8), read(16), block(0), block(48)]).unwrap();
        let message = "c[1]: must not overlap c[0]";
        assert_eq!(check(&[read(100), read(200), block(0), block(7)]).unwrap_err(), message);
        let message = "c[0]: must not overlap a[1]";
        assert_eq!(check(&[read(100), read(39), block(0), block(8)]).unwrap_err(), message);
        let none = Region { line: 0, ..block(0) };
        check(&[none, none, none, none]).unwrap();
        check(&[]).unwrap();
    }

    #[test]
    fn a_call_within_a_call_has_arguments_of_its_own() {
        add(region(0, 8, 8, 1)).unwrap();
        let _outer = Call::begin();
        add(region(0, 8, 8, 1)).unwrap();
        {
            let _inner = Call::begin();
            add(region(0, 8, 8, 1)).unwrap();
            assert!(add(region(7, 8, 8, 1)).is_err());
        }
        add(region(8, 8, 8, 1)).unwrap();
        assert_eq!(add(region(4, 1, 1, 1)).unwrap_err().message, "a: must not overlap a");
    }

    #[test]
    fn inputs_and_empty_outputs_may_overlap() {
        let _call = Call::begin();
        let read = Region { written: false, ..region(0, 8, 8, 4) };
        add(read).unwrap();
        add(read).unwrap();
        add(region(0, 0, 8, 4)).unwrap();
        add(region(0, 8, 8, 0)).unwrap();
        assert!(add(region(31, 8, 8, 1)).is_err());
    }
}
