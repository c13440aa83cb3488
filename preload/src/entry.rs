//! An exported symbol: its address in the next library, and counts of its calls.

use std::ffi::{CStr, c_void};
use std::ptr::{self, NonNull};
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicU64, Ordering};
use std::time::Instant;

use crate::host::{Code, Next};

/// Why a call was not computed here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Why {
    /// `CATAMARAN_BLAS=off`.
    Off,
    /// An argument is wrong, or means something to the next library alone.
    Arguments,
    /// Nothing is multiplied: a side is 0, or alpha is.
    Trivial,
    /// The result shares memory with an operand.
    Overlap,
    /// Too little work.
    Small,
    /// The planner expects to be slower.
    Slower,
    /// More memory is needed than `CATAMARAN_BLAS_MEMORY` allows, or than there is.
    Memory,
    /// The caller rounds otherwise than to nearest, or flushes subnormal numbers to zero.
    Rounding,
}

impl Why {
    /// Each reason and its name in the report.
    pub const NAMES: [(&'static str, Self); 8] = [
        ("off", Self::Off),
        ("arguments", Self::Arguments),
        ("trivial", Self::Trivial),
        ("overlap", Self::Overlap),
        ("small", Self::Small),
        ("slower", Self::Slower),
        ("memory", Self::Memory),
        ("rounding", Self::Rounding),
    ];
}

/// Calls and their time.
#[derive(Debug)]
pub struct Tally {
    calls: AtomicU64,
    nanoseconds: AtomicU64,
}

impl Tally {
    const fn new() -> Self {
        Self { calls: AtomicU64::new(0), nanoseconds: AtomicU64::new(0) }
    }

    fn add(&self, start: Instant) {
        let nanoseconds = u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.calls.fetch_add(1, Ordering::Relaxed);
        self.nanoseconds.fetch_add(nanoseconds, Ordering::Relaxed);
    }

    fn clear(&self) {
        self.calls.store(0, Ordering::Relaxed);
        self.nanoseconds.store(0, Ordering::Relaxed);
    }

    /// Returns the number of calls so far.
    pub fn calls(&self) -> u64 {
        self.calls.load(Ordering::Relaxed)
    }

    /// Returns the time of the calls in seconds.
    pub fn seconds(&self) -> f64 {
        self.nanoseconds.load(Ordering::Relaxed) as f64 * 1e-9
    }
}

/// An exported symbol.
#[derive(Debug)]
pub struct Entry {
    name: &'static CStr,
    next: Next,
    /// The address in the next library, when small calls may go there without any look at the
    /// settings.
    quick: AtomicPtr<c_void>,
    /// What was computed here.
    ours: Tally,
    /// What was forwarded, by reason.
    forwarded: [Tally; Why::NAMES.len()],
    /// The symbol whose first call was counted before that of this one.
    earlier: AtomicPtr<Entry>,
}

/// The symbol whose first call was counted last.
static LATEST: AtomicPtr<Entry> = AtomicPtr::new(ptr::null_mut());

/// The end of the list. A null pointer means that a symbol is not in the list.
static END: Entry = Entry::new(c"");

impl Entry {
    /// Creates the entry of the symbol `name`.
    pub const fn new(name: &'static CStr) -> Self {
        Self {
            name,
            next: Next::new(name),
            quick: AtomicPtr::new(ptr::null_mut()),
            ours: Tally::new(),
            forwarded: [const { Tally::new() }; Why::NAMES.len()],
            earlier: AtomicPtr::new(ptr::null_mut()),
        }
    }

    /// Returns the name of the symbol.
    pub fn name(&self) -> String {
        self.name.to_string_lossy().into_owned()
    }

    /// Returns the address for small calls; `None` when [`Entry::next`] has to be called.
    #[inline(always)]
    pub fn quick(&self) -> Option<Code> {
        NonNull::new(self.quick.load(Ordering::Relaxed))
    }

    /// Returns the address in the next library. With `quick`, small calls use it at once from now
    /// on.
    pub fn next(&self, quick: bool) -> Option<Code> {
        let next = self.next.get();
        if quick && let Some(code) = next {
            self.quick.store(code.as_ptr(), Ordering::Relaxed);
        }
        next
    }

    /// Counts a call that was computed here.
    pub fn count_ours(&'static self, start: Instant) {
        self.ours.add(start);
        self.enlist();
    }

    /// Counts a call that was forwarded.
    pub fn count_forwarded(&'static self, why: Why, start: Instant) {
        self.forwarded[why as usize].add(start);
        self.enlist();
    }

    /// Returns the calls that were computed here.
    pub fn ours(&self) -> &Tally {
        &self.ours
    }

    /// Returns the calls that were forwarded, with the name of the reason.
    pub fn forwarded(&self) -> impl Iterator<Item = (&'static str, &Tally)> {
        Why::NAMES.iter().map(|(name, why)| (*name, &self.forwarded[*why as usize]))
    }

    fn enlist(&'static self) {
        let own = ptr::from_ref(self).cast_mut();
        let end = ptr::from_ref(&END).cast_mut();
        // The thread that changes it from null puts the symbol into the list.
        let (order, failed) = (Ordering::AcqRel, Ordering::Relaxed);
        if self.earlier.compare_exchange(ptr::null_mut(), end, order, failed).is_err() {
            return;
        }
        let mut latest = LATEST.load(Ordering::Relaxed);
        loop {
            let earlier = if latest.is_null() { end } else { latest };
            self.earlier.store(earlier, Ordering::Relaxed);
            match LATEST.compare_exchange(latest, own, Ordering::AcqRel, Ordering::Relaxed) {
                Ok(_) => return,
                Err(other) => latest = other,
            }
        }
    }
}

/// Returns the symbols that were called.
pub fn called() -> Vec<&'static Entry> {
    let mut found = Vec::new();
    let mut at = LATEST.load(Ordering::Acquire);
    while !at.is_null() && !ptr::eq(at, &END) {
        // SAFETY: entries are statics, which only link themselves into the list, and END has been
        // excluded.
        let entry: &'static Entry = unsafe { &*at };
        found.push(entry);
        at = entry.earlier.load(Ordering::Acquire);
    }
    found
}

/// Whether a call was computed here because that was expected to be faster.
static GAINED: AtomicBool = AtomicBool::new(false);
/// Calls that were large enough for a plan, and were forwarded.
static LARGE_FORWARDED: AtomicU64 = AtomicU64::new(0);

/// Remembers that a call was computed here.
pub fn gain() {
    // A store would move the line between the caches of threads.
    if !GAINED.load(Ordering::Relaxed) {
        GAINED.store(true, Ordering::Relaxed);
    }
}

/// Counts a large call that was forwarded.
pub fn count_large_forwarded() {
    LARGE_FORWARDED.fetch_add(1, Ordering::Relaxed);
}

/// Returns the number of large calls that were forwarded, if no call was computed here.
pub fn forwarded_without_gain() -> Option<u64> {
    let count = LARGE_FORWARDED.load(Ordering::Relaxed);
    (count > 0 && !GAINED.load(Ordering::Relaxed)).then_some(count)
}

/// Forgets all calls, for a process that was forked.
pub fn forget_calls() {
    GAINED.store(false, Ordering::Relaxed);
    LARGE_FORWARDED.store(0, Ordering::Relaxed);
    for entry in called() {
        entry.ours.clear();
        entry.forwarded.iter().for_each(Tally::clear);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_in_the_order_of_the_reasons() {
        for (i, (_, why)) in Why::NAMES.iter().enumerate() {
            assert_eq!(*why as usize, i);
        }
    }

    #[test]
    fn calls_are_counted_by_reason() {
        static FIRST: Entry = Entry::new(c"first");
        static SECOND: Entry = Entry::new(c"second");
        let start = Instant::now();
        FIRST.count_ours(start);
        FIRST.count_forwarded(Why::Small, start);
        SECOND.count_forwarded(Why::Overlap, start);
        FIRST.count_forwarded(Why::Small, start);
        let names: Vec<_> = called().iter().map(|entry| entry.name()).collect();
        assert_eq!(names, ["second", "first"]);
        let small = FIRST.forwarded().find(|(name, _)| *name == "small").unwrap().1;
        assert_eq!((FIRST.ours().calls(), small.calls()), (1, 2));
        assert!(small.seconds() >= 0.0);
        forget_calls();
        assert_eq!((FIRST.ours().calls(), small.calls()), (0, 0));
    }
}
