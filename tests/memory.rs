//! Memory: what the scratch queries promise, counted by the allocator.

mod common;
#[path = "common/counting.rs"]
mod counting;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use catamaran::base::release_memory;
use catamaran::faer::Mat;
use catamaran::rows::{Accumulator, DenseRows, StreamPlan, stream};
use catamaran::{AtaOptions, Par, Plan, SchemeChoice, ata_into, atb_into};

use counting::{held, peak_of};

/// One test at a time: what others allocate would count.
fn turn() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    // What the test before has left.
    release_memory();
    turn
}

/// Peak of bytes allocated by `work` beyond what there was; a first run has filled what
/// rayon keeps.
fn peak(mut work: impl FnMut()) -> usize {
    work();
    peak_of(work).0
}

/// Options with a back end that allocates nothing itself.
fn lean() -> AtaOptions<'static> {
    AtaOptions::new().backend(Arc::new(common::Naive))
}

/// What the bookkeeping of a call may take: tasks, lanes, block lists, a pool of threads.
const SMALL: usize = 256 << 10;

#[test]
fn the_faithful_mode_needs_at_most_three_halves_n_squared_elements() {
    let _turn = turn();
    for n in [128, 250, 389] {
        for par in [Par::Seq, Par::Threads(2)] {
            let options = lean().scheme(SchemeChoice::Ata2).leaf(32).par(par);
            let len = Plan::ata::<f64>(n, n, &options).unwrap().scratch_len::<f64>(options.par);
            assert!(len > 0 && 2 * len <= 3 * n * n, "n = {n}: {len} elements");
            let a = Mat::<f64>::ones(n, n);
            let mut c = Mat::<f64>::zeros(n, n);
            let used = peak(|| ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap());
            assert!(used <= 8 * len + SMALL, "n = {n}: {used} bytes for {len} elements");
            // The threads of the run before may still give memory back.
            assert!(used + SMALL >= 8 * len, "n = {n}: the scratch is one allocation");
        }
    }
}

/// Returns the start of a file of an accumulator of `columns` columns, up to its vectors.
fn head_of_an_accumulator(columns: u64) -> Vec<u8> {
    let mut file = b"CATAACC\0\x02\0\0\0\x08\0\0\0".to_vec();
    let mut head: Vec<u8> = Vec::new();
    [columns, 0, columns, 5, 5, 5].iter().for_each(|x| head.extend(x.to_le_bytes()));
    head.extend([0; 5]);
    file.extend((head.len() as u32).to_le_bytes());
    file.extend(head);
    let check = crc32fast::hash(&file);
    file.extend(check.to_le_bytes());
    file.extend([0; 16]);
    file
}

#[test]
fn memory_of_an_accumulator_grows_with_the_bytes_that_arrive() {
    let _turn = turn();
    for columns in [10_000, 30_000, 1 << 20, 1 << 40] {
        let file = head_of_an_accumulator(columns);
        let mut error = None;
        let read = || error = Accumulator::<f64>::read(&mut &file[..]).err();
        let (used, _) = peak_of(read);
        assert!(used < SMALL, "{columns} columns: {used} bytes");
        assert_eq!(error.unwrap().kind(), std::io::ErrorKind::InvalidData, "{columns}");
    }
}

#[test]
fn faststrassen_needs_at_most_three_halves_n_squared_elements() {
    let _turn = turn();
    for n in [128, 255, 300] {
        let options = lean().scheme(SchemeChoice::Ata2).leaf(32).tasks(1).par(Par::Seq);
        let len = Plan::atb::<f64>(n, n, n, &options).unwrap().scratch_len::<f64>(options.par);
        assert!(len > 0 && 2 * len <= 3 * n * n, "n = {n}: {len} elements");
        let (a, b) = (Mat::<f64>::ones(n, n), Mat::<f64>::ones(n, n));
        let mut c = Mat::<f64>::zeros(n, n);
        let work = || atb_into(1.0, a.as_ref(), b.as_ref(), 0.0, c.as_mut(), &options).unwrap();
        assert!(peak(work) <= 8 * len + SMALL, "n = {n}");
    }
}

#[test]
fn every_scheme_stays_within_its_scratch_query() {
    let _turn = turn();
    let (m, n) = (300, 250);
    let a = Mat::<f32>::ones(m, n);
    let mut c = Mat::<f32>::zeros(n, n);
    for (name, scheme) in SchemeChoice::NAMES {
        let options = lean().scheme(scheme).leaf(20);
        let len = Plan::ata::<f32>(m, n, &options).unwrap().scratch_len::<f32>(options.par);
        let used = peak(|| ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap());
        assert!(used <= 4 * len + SMALL, "{name}: {used} bytes for {len} elements");
    }
}

#[test]
fn the_exact_path_needs_at_most_the_size_of_a_and_256_mib() {
    let _turn = turn();
    for (m, n, threads) in [(300_000, 50, 2), (3000, 300, 4), (60, 2000, 1)] {
        let a = Mat::<f64>::ones(m, n);
        let mut c = Mat::<f64>::zeros(n, n);
        let par = Par::Threads(threads);
        let options = AtaOptions::new().scheme(SchemeChoice::Exact).par(par);
        let len = Plan::ata::<f64>(m, n, &options).unwrap().scratch_len::<f64>(options.par);
        let used = peak(|| {
            ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
            release_memory();
        });
        let bound = 8 * m * n + (256 << 20);
        assert!(used <= bound, "{m} x {n}: {used} bytes of {bound}");
        // A huge page for the alignment.
        assert!(used <= 8 * len + (2 << 20) + SMALL, "{m} x {n}: {used} bytes for {len} elements");
    }
}

#[test]
fn large_scratch_is_kept_for_the_next_call_until_it_is_released() {
    let _turn = turn();
    let (m, n) = (2000, 400);
    let a = Mat::<f64>::ones(m, n);
    let mut c = Mat::<f64>::zeros(n, n);
    let options = AtaOptions::new().scheme(SchemeChoice::Exact).par(Par::Seq);
    let len = 8 * Plan::ata::<f64>(m, n, &options).unwrap().scratch_len::<f64>(options.par);
    assert!(len > 4 << 20);
    let mut work = || ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
    assert!(peak(&mut work) <= SMALL, "the second call has the memory of the first");
    let before = held();
    release_memory();
    assert!(before - held() >= len);
    work();
    release_memory();
}

#[test]
fn a_stream_takes_c_two_blocks_and_the_scratch_that_its_plan_says() {
    let _turn = turn();
    // About C: with and without fast and exact products.
    for (scheme, m, n, height, weighted) in [
        (SchemeChoice::Classical, 5000, 400, 640, false),
        (SchemeChoice::Classical, 5000, 400, 640, true),
        (SchemeChoice::Exact, 3000, 300, 512, false),
        (SchemeChoice::Classical, 500, 300, 640, false),
    ] {
        let a = Mat::<f64>::ones(m, n);
        let weights = vec![0.5; m];
        let weights = weighted.then_some(&weights[..]);
        let par = Par::Threads(2);
        let options = AtaOptions::new().scheme(scheme).par(par);
        let plan =
            StreamPlan::new::<f64>(m, n, weighted, Some(height), usize::MAX, &options).unwrap();
        let used = peak(|| {
            let mut sum = Accumulator::new(n, true).unwrap();
            let rows = &mut DenseRows(a.as_ref());
            stream(rows, weights, height, &mut sum, &options, &mut |_| Ok(())).unwrap();
            drop(sum);
            release_memory();
        });
        // Huge pages for the alignment of C, blocks and scratch; a second thread's stack is not
        // ours.
        let bound = plan.bytes() + 5 * (2 << 20) + SMALL;
        assert!(used <= bound, "{scheme:?}: {used} bytes of {bound}");
        let blocks = 8 * n * (n + height.min(m) * if m > height { 2 } else { 1 });
        assert!(used >= blocks, "{scheme:?}: {used} bytes are less than {blocks}");
    }
}
