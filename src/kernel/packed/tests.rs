//! One suite for every isa, against the definition in integers, which are exact.

mod ladder;

use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicUsize, Ordering};

use faer::{MatMut, MatRef};

use super::geometry::{Area, line_len};
use super::pack::Panels;
use super::schedule::aligned;
use super::vectors::Vectors;
use super::*;
use crate::base::{Arena, Par, Pin, Progress, Real, Rng, ThreadPool, Tracker};

/// Returns the isas that this machine supports, and prints why it skips the others.
fn isas() -> impl Iterator<Item = FloatIsa> {
    FloatIsa::ALL.into_iter().filter(|isa| match isa.refusal() {
        None => true,
        Some(why) => {
            println!("skipped: {}, {why}", isa.name());
            false
        }
    })
}

/// A value that no product has; it fills memory that must not be written.
const POISON: f64 = -7_654_321.0;

/// A budget that no test exceeds.
const PLENTY: usize = 1 << 24;

fn below(rng: &mut Rng, end: usize) -> usize {
    (rng.uniform() * end as f64) as usize
}

fn pick<X: Copy>(rng: &mut Rng, from: &[X]) -> X {
    from[below(rng, from.len())]
}

fn integer(rng: &mut Rng) -> f64 {
    (rng.uniform() * 9.0).floor() - 4.0
}

/// The order of a matrix in memory.
#[derive(Debug, Clone, Copy)]
enum Layout {
    Rows,
    Columns,
    PaddedRows,
    PaddedColumns,
    /// Neither rows nor columns are contiguous.
    Spread,
    /// Rows from the last to the first, each forwards.
    ReversedRows,
    /// Rows from the last to the first, each backwards.
    Reversed,
}

const LAYOUTS: [Layout; 7] = [
    Layout::Rows,
    Layout::Columns,
    Layout::PaddedRows,
    Layout::PaddedColumns,
    Layout::Spread,
    Layout::ReversedRows,
    Layout::Reversed,
];

/// A matrix inside memory that also holds other entries.
#[derive(Debug, Clone)]
struct Stored<T> {
    memory: Vec<T>,
    start: usize,
    rows: usize,
    cols: usize,
    row_stride: isize,
    col_stride: isize,
}

/// The total that the progress of a case is measured against: more than any case has.
const WORK: f64 = 1e12;

impl<T: Real> Stored<T> {
    /// Creates a matrix with entries `entry(i, j)`; the memory around them holds `around`.
    fn new(
        layout: Layout,
        rows: usize,
        cols: usize,
        around: f64,
        mut entry: impl FnMut(usize, usize) -> f64,
    ) -> Self {
        const MARGIN: usize = 5;
        let (row_stride, col_stride) = match layout {
            Layout::Rows => (cols as isize, 1),
            Layout::Columns => (1, rows as isize),
            Layout::PaddedRows => (cols as isize + 3, 1),
            Layout::PaddedColumns => (1, rows as isize + 2),
            Layout::Spread => (2, 2 * rows as isize + 1),
            Layout::ReversedRows => (-(cols as isize) - 1, 1),
            Layout::Reversed => (-(cols as isize) - 2, -1),
        };
        let end = |stride: isize, len: usize| stride * len.saturating_sub(1) as isize;
        let ends = [end(row_stride, rows), end(col_stride, cols)];
        let before: isize = ends.iter().map(|e| -e.min(&0)).sum();
        let after: isize = ends.iter().map(|e| e.max(&0)).sum();
        let start = MARGIN + before as usize;
        let memory = vec![T::from_f64(around); start + after as usize + 1 + MARGIN];
        let mut stored = Self { memory, start, rows, cols, row_stride, col_stride };
        for i in 0..rows {
            for j in 0..cols {
                *stored.entry(i, j) = T::from_f64(entry(i, j));
            }
        }
        stored
    }

    fn integers(layout: Layout, rows: usize, cols: usize, rng: &mut Rng) -> Self {
        Self::new(layout, rows, cols, f64::NAN, |_, _| integer(rng))
    }

    fn entry(&mut self, i: usize, j: usize) -> &mut T {
        let at = i as isize * self.row_stride + j as isize * self.col_stride;
        &mut self.memory[(self.start as isize + at) as usize]
    }

    fn view(&self) -> MatRef<'_, T> {
        let Self { rows, cols, row_stride, col_stride, .. } = *self;
        let start = self.memory[self.start..].as_ptr();
        // SAFETY: `new` has made room for every entry.
        unsafe { MatRef::from_raw_parts(start, rows, cols, row_stride, col_stride) }
    }

    fn view_mut(&mut self) -> MatMut<'_, T> {
        let Self { rows, cols, row_stride, col_stride, .. } = *self;
        let start = self.memory.as_mut_ptr().wrapping_add(self.start);
        // SAFETY: `new` has made room for every entry, each at its own place.
        unsafe { MatMut::from_raw_parts_mut(start, rows, cols, row_stride, col_stride) }
    }

    /// Returns the bits of all of the memory.
    fn memory_bits(&self) -> Vec<u64> {
        self.memory.iter().map(|x| x.to_f64().to_bits()).collect()
    }

    /// Returns the bits of all of the memory, with positive zeros.
    fn bits(&self) -> Vec<u64> {
        self.memory.iter().map(|x| (x.to_f64() + 0.0).to_bits()).collect()
    }
}

/// Returns a source without a scale.
fn source<T>(coefficient: T, matrix: MatRef<'_, T>) -> Source<'_, T> {
    Source { coefficient, matrix, scale: None }
}

/// A block of C that receives a product.
#[derive(Debug, Clone)]
struct Output {
    rows: Range<usize>,
    cols: Range<usize>,
    coefficient: f64,
    beta: f64,
}

/// A product before it is bound to matrices.
#[derive(Debug)]
struct Spec<T> {
    left: Vec<(f64, Stored<T>)>,
    right: Vec<(f64, Stored<T>)>,
    outputs: Vec<Output>,
    shape: Shape,
    /// Whether the product is run for the transposed targets.
    transposed: bool,
}

impl<T: FloatOperand> Spec<T> {
    fn product<'a>(&'a self, destination: &Destination<'_, T>) -> KernelProduct<'a, T> {
        let sources = |side: &'a [(f64, Stored<T>)]| {
            side.iter().map(|(c, matrix)| source(T::from_f64(*c), matrix.view())).collect()
        };
        let target = |o: &Output| {
            let [coefficient, beta] = [o.coefficient, o.beta].map(T::from_f64);
            destination.block(o.rows.clone(), o.cols.clone(), coefficient, beta)
        };
        let product = KernelProduct {
            left: sources(&self.left),
            right: sources(&self.right),
            targets: self.outputs.iter().map(target).collect(),
            shape: self.shape,
        };
        if self.transposed { product.transposed() } else { product }
    }

    /// Computes the product by the definition, and the sums of absolute values of its terms.
    fn naive(&self) -> [Vec<f64>; 2] {
        let Shape { depth, rows, cols, same } = self.shape;
        let sum = |side: &[(f64, Stored<T>)], width: usize| {
            let mut sum = vec![0.0; width * depth];
            for (c, matrix) in side {
                let view = matrix.view();
                for j in 0..view.ncols() {
                    for k in 0..view.nrows() {
                        sum[j * depth + k] += c * view[(k, j)].to_f64();
                    }
                }
            }
            sum
        };
        let left = sum(&self.left, rows);
        let right = if same { left.clone() } else { sum(&self.right, cols) };
        let mut products = [vec![0.0; rows * cols], vec![0.0; rows * cols]];
        for i in 0..rows {
            for j in 0..cols {
                let (l, r) = (&left[i * depth..][..depth], &right[j * depth..][..depth]);
                for (x, y) in l.iter().zip(r) {
                    products[0][i * cols + j] += x * y;
                    products[1][i * cols + j] += (x * y).abs();
                }
            }
        }
        products
    }
}

/// Products that go to one C in order, and how they are run.
#[derive(Debug)]
struct Case<T> {
    specs: Vec<Spec<T>>,
    part: Part,
    c: Stored<T>,
    budget: usize,
}

impl<T: FloatOperand> Case<T> {
    fn wants(&self, i: usize, j: usize) -> bool {
        match self.part {
            Part::All => true,
            Part::Lower => i >= j,
            Part::Upper => i <= j,
        }
    }

    /// Computes the result by the definition, and the same with absolute values of all terms.
    fn expected(&self) -> [Stored<T>; 2] {
        let (mut c, mut sizes) = (self.c.clone(), self.c.clone());
        for spec in &self.specs {
            let [products, absolute] = spec.naive();
            for o in &spec.outputs {
                for (i, row) in o.rows.clone().enumerate() {
                    for (j, col) in o.cols.clone().enumerate() {
                        if !self.wants(row, col) {
                            continue;
                        }
                        let at = i * spec.shape.cols + j;
                        let update = |entry: &mut T, coefficient: f64, beta: f64, sum: f64| {
                            let old = if beta == 0.0 { 0.0 } else { beta * entry.to_f64() };
                            *entry = T::from_f64(old + coefficient * sum);
                        };
                        update(c.entry(row, col), o.coefficient, o.beta, products[at]);
                        let [coefficient, beta] = [o.coefficient, o.beta].map(f64::abs);
                        update(sizes.entry(row, col), coefficient, beta, absolute[at]);
                    }
                }
            }
        }
        [c, sizes]
    }

    /// Returns C after [`run`] in scratch of exactly [`scratch_len`] scalars, filled with NaN; and
    /// whether the run finished.
    fn run(&self, isa: FloatIsa, threads: usize, progress: Progress<'_>) -> (Stored<T>, bool) {
        /// Elements on either side of the scratch; an odd number, so that nothing is aligned.
        const GUARD: usize = 131;
        let kernel = T::kernel(isa);
        let mut c = self.c.clone();
        let destination = Destination::new(c.view_mut(), self.part);
        let products: Vec<_> = self.specs.iter().map(|s| s.product(&destination)).collect();
        let shapes = products.iter().map(|p| p.shape);
        let len = scratch_len::<T>(kernel.geometry(), shapes, self.budget, threads);
        let mut scratch = vec![T::from_f64(POISON); len + 2 * GUARD];
        let own = &mut scratch[GUARD..GUARD + len];
        own.fill(T::from_f64(f64::NAN));
        let tracker = &Tracker::new(progress, WORK);
        let job = Job { kernel, products: &products, budget: self.budget, progress: tracker };
        let par = if threads == 1 { Par::Seq } else { Par::Threads(threads) };
        // SAFETY: this function owns `c`, and nothing else uses it meanwhile.
        unsafe { run(&job, par, own) };
        let guards = scratch[..GUARD].iter().chain(&scratch[GUARD + len..]);
        assert!(guards.copied().all(|x| x == T::from_f64(POISON)), "scratch overrun");
        (c, tracker.finish().is_ok())
    }

    /// Checks that every isa gives the integers of the definition and changes nothing else.
    fn check(&self, threads: &[usize]) {
        let expected = self.expected()[0].bits();
        for isa in isas() {
            for &threads in threads {
                let (c, finished) = self.run(isa, threads, Progress::none());
                assert!(finished);
                if c.bits() == expected {
                    continue;
                }
                let Self { part, budget, .. } = self;
                let shapes: Vec<_> = self.specs.iter().map(|s| s.shape).collect();
                let outputs: Vec<_> = self.specs.iter().map(|s| &s.outputs).collect();
                let wrong = c.bits().iter().zip(&expected).filter(|(x, y)| x != y).count();
                panic!(
                    "{} {}, {threads} threads, budget {budget}, {part:?}: {wrong} entries wrong\n\
                     shapes {shapes:?}\noutputs {outputs:?}",
                    isa.name(),
                    T::NAME
                );
            }
        }
    }
}

/// Returns the blocks of a grid in C as outputs, some of them a row or a column short.
fn outputs(
    grid: (usize, usize),
    shape: Shape,
    corner: (usize, usize),
    rng: &mut Rng,
) -> Vec<Output> {
    let Shape { rows, cols, .. } = shape;
    let mut outputs = Vec::new();
    for i in 0..grid.0 {
        for j in 0..grid.1 {
            let (row, col) = (corner.0 + i * rows, corner.1 + j * cols);
            let short = |rng: &mut Rng| usize::from(grid != (1, 1) && below(rng, 3) == 0);
            outputs.push(Output {
                rows: row..row + rows.saturating_sub(short(rng)),
                cols: col..col + cols.saturating_sub(short(rng)),
                coefficient: pick(rng, &[1.0, -1.0, -2.0]),
                beta: pick(rng, &[0.0, 1.0, -2.0]),
            });
        }
    }
    outputs
}

/// Creates C for some outputs: integers, but NaN where beta is zero, and poison where no output
/// writes.
fn destination<T: Real>(layout: Layout, part: Part, specs: &[Spec<T>], rng: &mut Rng) -> Stored<T> {
    let all = || specs.iter().flat_map(|s| &s.outputs);
    let rows = all().map(|o| o.rows.end).max().unwrap_or(0) + 1;
    let cols = all().map(|o| o.cols.end).max().unwrap_or(0) + 2;
    Stored::new(layout, rows, cols, POISON, |i, j| {
        let wanted = match part {
            Part::All => true,
            Part::Lower => i >= j,
            Part::Upper => i <= j,
        };
        match all().find(|o| wanted && o.rows.contains(&i) && o.cols.contains(&j)) {
            Some(o) if o.beta == 0.0 => f64::NAN,
            Some(_) => integer(rng),
            None => POISON,
        }
    })
}

/// Returns `count` signed sources, of which some lack a row or a column.
fn side<T: Real>(count: usize, depth: usize, width: usize, rng: &mut Rng) -> Vec<(f64, Stored<T>)> {
    let all_by_rows = below(rng, 2) == 0;
    let one = |i: usize| {
        let layouts = if all_by_rows { &LAYOUTS[..1] } else { &LAYOUTS };
        let layout = pick(rng, layouts);
        let mut short = || usize::from(i > 0 && below(rng, 3) == 0);
        let (rows, cols) = (depth.saturating_sub(short()), width.saturating_sub(short()));
        (pick(rng, &[1.0, -1.0]), Stored::integers(layout, rows, cols, rng))
    };
    (0..count).map(one).collect()
}

const PARTS: [Part; 3] = [Part::All, Part::Lower, Part::Upper];

/// Returns a product of sums of so many `sources` (left and right) into the blocks of a `grid` in
/// C.
fn spec<T: Real>(
    shape: Shape,
    sources: (usize, usize),
    grid: (usize, usize),
    rng: &mut Rng,
) -> Spec<T> {
    let corner = (below(rng, 1 + shape.rows / 2), below(rng, 1 + shape.cols / 2));
    Spec {
        left: side(sources.0, shape.depth, shape.rows, rng),
        right: if shape.same { vec![] } else { side(sources.1, shape.depth, shape.cols, rng) },
        outputs: outputs(grid, shape, corner, rng),
        shape,
        transposed: below(rng, 4) == 0,
    }
}

fn case<T: Real>(specs: Vec<Spec<T>>, budget: usize, rng: &mut Rng) -> Case<T> {
    let (layout, part) = (pick(rng, &LAYOUTS), pick(rng, &PARTS));
    let c = destination(layout, part, &specs, rng);
    Case { specs, part, c, budget }
}

fn general(depth: usize, rows: usize, cols: usize) -> Shape {
    Shape { depth, rows, cols, same: false }
}

fn square(depth: usize, side: usize) -> Shape {
    Shape { depth, rows: side, cols: side, same: true }
}

/// Runs a test in both precisions, with threads enough for its workers.
macro_rules! in_both_precisions {
    ($test:ident) => {{
        let team = ThreadPool::new(3, Pin::No).expect("threads");
        team.run(|| {
            $test::<f64>(&mut Rng::new(1));
            $test::<f32>(&mut Rng::new(2));
        });
    }};
}

fn check_shapes<T: FloatOperand>(rng: &mut Rng) {
    const EXTENTS: [usize; 11] = [0, 1, 2, 7, 8, 23, 24, 25, 47, 49, 97];
    for depth in EXTENTS {
        for rows in EXTENTS {
            for cols in EXTENTS {
                let spec = spec(general(depth, rows, cols), (1, 1), (1, 1), rng);
                let budget = pick(rng, &[1, 5000, PLENTY]);
                case::<T>(vec![spec], budget, rng).check(&[1 + below(rng, 3)]);
            }
        }
    }
}

#[test]
fn products_of_every_shape_are_exact() {
    in_both_precisions!(check_shapes);
}

fn check_layouts<T: FloatOperand>(rng: &mut Rng) {
    for left in LAYOUTS {
        for right in LAYOUTS {
            for target in LAYOUTS {
                for part in PARTS {
                    let shape = general(11, 53, 50);
                    let mut spec = spec(shape, (1, 1), (1, 1), rng);
                    spec.left[0].1 = Stored::integers(left, shape.depth, shape.rows, rng);
                    spec.right[0].1 = Stored::integers(right, shape.depth, shape.cols, rng);
                    let specs = vec![spec];
                    let c = destination(target, part, &specs, rng);
                    Case::<T> { specs, part, c, budget: PLENTY }.check(&[1]);
                }
            }
        }
    }
}

#[test]
fn any_layout_of_sources_and_targets_is_taken() {
    in_both_precisions!(check_layouts);
}

fn check_factors<T: FloatOperand>(rng: &mut Rng) {
    for coefficient in [0.0, 1.0, -2.0] {
        for beta in [0.0, 1.0, -2.0] {
            for budget in [1, PLENTY] {
                let mut spec = spec(general(29, 61, 59), (1, 1), (1, 1), rng);
                spec.outputs[0] = Output { coefficient, beta, ..spec.outputs[0].clone() };
                spec.left[0].0 = pick(rng, &[0.0, 1.0, -2.0]);
                case::<T>(vec![spec], budget, rng).check(&[2]);
            }
        }
    }
}

#[test]
fn factors_are_applied_once_and_beta_zero_reads_nothing() {
    in_both_precisions!(check_factors);
}

fn check_depths<T: FloatOperand>(rng: &mut Rng) {
    // Around one and two blocks of rows, and several chunks of one or more blocks.
    for depth in [319, 320, 321, 641, 701] {
        for budget in [1, 70_000, PLENTY] {
            let (rows, cols) = (pick(rng, &[24, 61, 131]), pick(rng, &[7, 49, 127]));
            let specs = vec![spec(general(depth, rows, cols), (1, 2), (1, 1), rng)];
            case::<T>(specs, budget, rng).check(&[1, 3]);
            let specs = vec![spec(square(depth, rows), (2, 0), (1, 1), rng)];
            case::<T>(specs, budget, rng).check(&[1, 3]);
        }
    }
}

#[test]
fn depths_of_several_blocks_and_chunks_are_exact() {
    in_both_precisions!(check_depths);
}

/// Checks chunks of more than 16 MiB, of narrow products, so that the reference is fast.
fn check_past_caches<T: FloatOperand>(rng: &mut Rng) {
    for (rows, cols) in [(4, 700), (700, 5)] {
        let product = spec(general(6200, rows, cols), (2, 1), (2, 1), rng);
        case::<T>(vec![product], PLENTY, rng).check(&[1, 3]);
    }
}

#[test]
fn chunks_that_are_written_past_the_caches_are_exact() {
    in_both_precisions!(check_past_caches);
}

fn check_unwanted<T: FloatOperand>(rng: &mut Rng) {
    let mut c = Stored::<T>::integers(Layout::Rows, 130, 130, rng);
    let a = Stored::integers(Layout::Rows, 700, 60, rng);
    let before = c.memory_bits();
    let destination = Destination::new(c.view_mut(), Part::Lower);
    let product = KernelProduct {
        left: vec![source(T::ONE, a.view())],
        right: Vec::new(),
        targets: vec![destination.block(0..60, 70..130, T::ONE, T::ONE)],
        shape: square(700, 60),
    };
    let kernel = T::kernel(FloatIsa::Portable);
    let len = scratch_len::<T>(kernel.geometry(), [product.shape].into_iter(), 1, 1);
    let mut scratch = vec![T::from_f64(f64::NAN); len];
    let progress = &Tracker::new(Progress::none(), WORK);
    let job = Job { kernel, products: &[product], budget: 1, progress };
    // SAFETY: this function owns `c`, and nothing else uses it meanwhile.
    unsafe { run(&job, Par::Seq, &mut scratch) };
    assert!(scratch.iter().all(|x| x.to_f64().is_nan()));
    assert_eq!(c.memory_bits(), before);
}

/// Checks that products of which nothing is wanted are skipped: threads wait for a phase by waiting
/// for its pieces, so a phase without pieces would not make them wait.
#[test]
fn what_nobody_wants_is_not_packed() {
    in_both_precisions!(check_unwanted);
}

fn check_sums<T: FloatOperand>(rng: &mut Rng) {
    const COUNTS: [usize; 6] = [1, 2, 3, 4, 5, 16];
    for left in COUNTS {
        for right in COUNTS {
            for grid in [(1, 1), (1, 2), (2, 1), (4, 4)] {
                let shape =
                    general(pick(rng, &[1, 13, 40]), 20 + below(rng, 60), 20 + below(rng, 60));
                let budget = pick(rng, &[1, PLENTY]);
                let specs = vec![spec(shape, (left, right), grid, rng)];
                case::<T>(specs, budget, rng).check(&[1 + below(rng, 3)]);
            }
        }
    }
}

#[test]
fn sums_of_unequal_blocks_go_to_many_targets() {
    in_both_precisions!(check_sums);
}

fn check_same<T: FloatOperand>(rng: &mut Rng) {
    for side in [0, 1, 7, 24, 25, 49, 97, 150] {
        for sources in [1, 2, 3, 5, 16] {
            for grid in [(1, 1), (2, 1), (4, 4)] {
                let shape = square(pick(rng, &[0, 1, 17, 50]), side);
                let budget = pick(rng, &[1, PLENTY]);
                let mut spec = spec(shape, (sources, 0), grid, rng);
                if below(rng, 2) == 0 {
                    // On the diagonal, where squares belong.
                    spec.outputs = outputs(grid, shape, (3, 3), rng);
                }
                case::<T>(vec![spec], budget, rng).check(&[1 + below(rng, 3)]);
            }
        }
    }
}

#[test]
fn one_side_serves_as_both() {
    in_both_precisions!(check_same);
}

fn check_sequences<T: FloatOperand>(rng: &mut Rng) {
    for count in 2..8 {
        let mut specs = Vec::new();
        for i in 0..count {
            let shape = general(below(rng, 60), 20 + below(rng, 40), 20 + below(rng, 40));
            let mut next = spec(shape, (1 + below(rng, 3), 1), (2, 1), rng);
            for output in &mut next.outputs {
                // Factors of magnitude 1 keep the numbers small enough to be exact.
                output.beta = if i == 0 { output.beta } else { pick(rng, &[1.0, -1.0]) };
            }
            specs.push(next);
        }
        // The blocks overlap: entries that the first product leaves out must hold numbers.
        let mut case = case::<T>(specs, 3000, rng);
        for i in 0..case.c.rows {
            for j in 0..case.c.cols {
                *case.c.entry(i, j) = T::from_f64(integer(rng));
            }
        }
        case.check(&[1, 2, 3]);
    }
}

#[test]
fn products_with_overlapping_targets_run_in_order() {
    in_both_precisions!(check_sequences);
}

/// Returns a case of random reals.
fn reals<T: FloatOperand>(depth: usize, side: usize, budget: usize, rng: &mut Rng) -> Case<T> {
    let mut real =
        |layout, rows, cols| Stored::new(layout, rows, cols, f64::NAN, |_, _| rng.normal());
    let (left, right) = (real(Layout::Rows, depth, side), real(Layout::Columns, depth, side + 5));
    let c = real(Layout::PaddedRows, side, side + 5);
    let output = Output { rows: 0..side, cols: 0..side + 5, coefficient: 0.7, beta: -1.3 };
    let spec = Spec {
        left: vec![(1.0, left)],
        right: vec![(1.0, right)],
        outputs: vec![output],
        shape: general(depth, side, side + 5),
        transposed: false,
    };
    Case { specs: vec![spec], part: Part::Lower, c, budget }
}

fn check_reals<T: FloatOperand>(rng: &mut Rng) {
    for (depth, budget) in [(1, PLENTY), (50, PLENTY), (331, PLENTY), (700, 1), (700, PLENTY)] {
        let case = reals::<T>(depth, 83, budget, rng);
        let [expected, sizes] = case.expected();
        // One rounding per product, sum and factor, and as many of the reference in f64.
        let bound = 2.0 * (depth + 6) as f64 * T::UNIT_ROUNDOFF;
        for isa in isas() {
            let (c, _) = case.run(isa, 1, Progress::none());
            for i in 0..c.rows {
                for j in (0..c.cols).filter(|&j| case.wants(i, j)) {
                    let [got, expected, size] =
                        [&c, &expected, &sizes].map(|m| m.view()[(i, j)].to_f64());
                    let size = size.abs() + 4.0;
                    assert!(
                        (got - expected).abs() <= bound * size,
                        "{} {}, depth {depth}, ({i}, {j}): {got} for {expected}",
                        isa.name(),
                        T::NAME
                    );
                }
            }
        }
    }
}

#[test]
fn errors_of_reals_stay_within_the_bound_of_dot_products() {
    in_both_precisions!(check_reals);
}

fn check_threads<T: FloatOperand>(rng: &mut Rng) {
    for budget in [1, 40_000, PLENTY] {
        let case = reals::<T>(500, 151, budget, rng);
        for isa in isas() {
            let bits = |threads| case.run(isa, threads, Progress::none()).0.memory_bits();
            let alone = bits(1);
            for threads in [2, 3] {
                assert!(bits(threads) == alone, "{}, {threads} threads", isa.name());
            }
        }
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    in_both_precisions!(check_threads);
}

fn check_cancelling<T: FloatOperand>(rng: &mut Rng) {
    // Of many items, also for one thread.
    let case = reals::<T>(30, 1500, 1, rng);
    for isa in isas() {
        for threads in [1, 3] {
            for allowed in [0, 1, 4] {
                let calls = AtomicUsize::new(0);
                let progress = |done: f64| {
                    assert!(done > 0.0);
                    match calls.fetch_add(1, Ordering::Relaxed) < allowed {
                        true => ControlFlow::Continue(()),
                        false => ControlFlow::Break(()),
                    }
                };
                let (_, finished) = case.run(isa, threads, (&progress).into());
                assert!(!finished, "{}, {threads} threads, {allowed} calls", isa.name());
                // Each thread may be in the middle of one piece.
                assert!(calls.into_inner() <= allowed + threads);
            }
        }
    }
}

#[test]
fn a_cancelled_run_says_so_and_returns() {
    in_both_precisions!(check_cancelling);
}

#[test]
fn a_panic_in_progress_reaches_the_caller() {
    let case = reals::<f64>(300, 150, 1, &mut Rng::new(3));
    for threads in [1, 3] {
        let run = || case.run(FloatIsa::best(), threads, Progress::new(&|_| panic!("told so")));
        assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).is_err());
    }
}

#[test]
fn more_workers_than_threads_finish() {
    let mut rng = Rng::new(4);
    let specs = vec![spec::<f64>(general(50, 200, 200), (1, 1), (1, 1), &mut rng)];
    let case = case(specs, PLENTY, &mut rng);
    // A pool that is too small, and one whose threads run several products at once.
    ThreadPool::new(1, Pin::No).expect("a thread").run(|| case.check(&[3, 17]));
    ThreadPool::new(2, Pin::No).expect("threads").run(|| {
        rayon::join(
            || rayon::join(|| case.check(&[2, 1]), || case.check(&[2])),
            || rayon::join(|| case.check(&[2]), || case.check(&[2, 2])),
        )
    });
}

#[test]
fn the_work_reported_is_that_of_the_entries_wanted() {
    let mut rng = Rng::new(5);
    for part in PARTS {
        let case = Case { part, ..reals::<f64>(100, 300, 1, &mut rng) };
        let wanted = (0..300).flat_map(|i| (0..305).map(move |j| (i, j)));
        let exact = wanted.filter(|&(i, j)| case.wants(i, j)).count() as f64 * 100.0;
        for isa in isas() {
            let total = std::sync::Mutex::new(0.0);
            let progress = |done: f64| {
                *total.lock().expect("no panic") = done * WORK;
                ControlFlow::Continue(())
            };
            case.run(isa, 2, (&progress).into());
            let total = total.into_inner().expect("no panic");
            assert!(total >= exact && total <= 1.2 * exact, "{part:?}: {total} for {exact}");
        }
    }
}

fn check_blocking<T: FloatOperand>(rng: &mut Rng) {
    for isa in isas() {
        let geometry = T::kernel(isa).geometry();
        for _ in 0..2000 {
            let mut extent = |most: f64| (most.powf(rng.uniform()) - 1.0) as usize;
            let (depth, rows, cols) = (extent(1e6), extent(1e5), extent(1e5));
            let same = extent(4.0) == 0;
            let shape = if same { square(depth, rows) } else { general(depth, rows, cols) };
            let budget = extent(1e9);
            let threads = 1 + extent(64.0);
            let blocking = Blocking::new(geometry, size_of::<T>(), shape, budget, threads);
            let Blocking { depth: block, panels, chunk } = blocking;
            let what = format!("{blocking:?} of {shape:?} in {budget}");
            assert!(block >= 1 && panels >= 1 && chunk >= block, "{what}");
            assert!(block <= depth.max(1) && chunk.is_multiple_of(block), "{what}");
            let chunks = blocking.chunks(shape);
            assert!(chunks * chunk >= depth, "{what}");
            assert!(chunks == 1 || (chunks - 1) * chunk < depth, "{what}: an empty chunk");
            let columns = Blocking::packed_columns(geometry, shape);
            assert!(columns >= shape.rows + if same { 0 } else { shape.cols }, "{what}");
            let packed = blocking.packed_len(geometry, shape);
            if block * columns <= budget {
                assert!(packed <= budget, "{what}: {packed}");
            } else {
                assert_eq!(chunk, block, "{what}");
            }
            assert!(blocking.sums_len(geometry) >= geometry.rows * geometry.width, "{what}");
            // A narrow product on one thread is one item.
            let longest = shape.rows.max(shape.cols);
            let narrow = threads == 1 && longest <= 2 * geometry.width;
            assert!(!narrow || panels * geometry.width >= longest, "{what}");
        }
    }
}

#[test]
fn blocking_covers_the_depth_within_the_budget() {
    in_both_precisions!(check_blocking);
}

fn check_whole_panels<T: FloatOperand>(rng: &mut Rng) {
    const DEPTH: usize = 3;
    for isa in isas() {
        let kernel = T::kernel(isa);
        let width = kernel.geometry().width;
        for columns in 1..2 * width + 2 {
            for (count, past_caches) in [(1, false), (1, true), (2, false), (3, true), (5, true)] {
                let layout = pick(rng, &LAYOUTS[..3]);
                let matrices: Vec<_> =
                    (0..count).map(|_| Stored::integers(layout, DEPTH, columns, rng)).collect();
                let sources: Vec<_> = matrices.iter().map(|m| source(T::ONE, m.view())).collect();
                let panel_stride = DEPTH * width;
                let len = columns.div_ceil(width) * panel_stride;
                let mut panels = vec![T::from_f64(f64::NAN); len + line_len::<T>()];
                let panels = aligned(&mut Arena::new(&mut panels), len);
                let area = Area { rows: 0..DEPTH, cols: 0..columns };
                let out = Panels { past_caches, ..Panels::new(panels.as_mut_ptr(), panel_stride) };
                // SAFETY: there is room for all panels, from the start of a cache line on.
                unsafe { kernel.pack(&sources, &area, out) };
                for (at, &x) in panels.iter().enumerate() {
                    let (row, column) =
                        (at % panel_stride / width, at / panel_stride * width + at % width);
                    let sum = |m: &Stored<T>| m.view()[(row, column)].to_f64();
                    let inside = column < columns;
                    let expected: f64 = if inside { matrices.iter().map(sum).sum() } else { 0.0 };
                    assert!(
                        x.to_f64() == expected,
                        "{} {}, {columns} columns of {count} sources, ({row}, {column}): {x}",
                        isa.name(),
                        T::NAME
                    );
                }
            }
        }
    }
}

#[test]
fn panels_are_written_to_their_end() {
    in_both_precisions!(check_whole_panels);
}

fn check_small<T: FloatOperand>(rng: &mut Rng) {
    const EXTENTS: [usize; 13] = [0, 1, 2, 3, 4, 6, 8, 9, 16, 17, 31, 50, 100];
    for depth in [0, 1, 2, 7, 33, 321, 700] {
        for rows in EXTENTS {
            for cols in EXTENTS {
                let same = rows == cols && below(rng, 2) == 0;
                let shape = Shape { depth, rows, cols, same };
                if !is_small(shape, true) {
                    continue;
                }
                let mut spec = spec(shape, (1, usize::from(!same)), (1, 1), rng);
                spec.transposed = false;
                for (coefficient, matrix) in spec.left.iter_mut().chain(&mut spec.right) {
                    *coefficient = 1.0;
                    if below(rng, 2) == 0 {
                        // Rows that share sets of the first-level cache are packed.
                        let (rows, cols) = (matrix.rows, matrix.cols);
                        let stride = pick(rng, &[cols, 4096 / size_of::<T>()]);
                        *matrix = Stored::integers(Layout::Rows, rows, stride, rng);
                        matrix.cols = cols;
                    }
                }
                let case = case::<T>(vec![spec], PLENTY, rng);
                check_small_case(&case);
            }
        }
    }
}

fn check_small_case<T: FloatOperand>(case: &Case<T>) {
    let Case { specs, part, c, .. } = case;
    let shape = specs[0].shape;
    let expected = case.expected()[0].bits();
    for isa in isas() {
        let mut c = c.clone();
        let destination = Destination::new(c.view_mut(), *part);
        let KernelProduct { left, right, mut targets, .. } = specs[0].product(&destination);
        let right = if shape.same { left[0] } else { right[0] };
        // SAFETY: this function owns `c`, and nothing else uses it meanwhile.
        unsafe { run_small(T::kernel(isa), left[0], right, &mut targets[0], shape) };
        assert!(c.bits() == expected, "{} {}: {shape:?}", isa.name(), T::NAME);
    }
}

#[test]
fn small_products_are_exact() {
    in_both_precisions!(check_small);
}

fn check_overlaps<T: FloatOperand>(rng: &mut Rng) {
    let (depth, rows) = (2, 5);
    for (part, cols) in (1..=14).flat_map(|cols| [(Part::All, cols), (Part::Lower, cols)]) {
        let mut side = |width| (1.0, Stored::integers(Layout::Rows, depth, width, rng));
        let spec = Spec {
            left: vec![side(rows)],
            right: vec![side(cols)],
            outputs: vec![Output { rows: 0..rows, cols: 0..cols, coefficient: 2.0, beta: 3.0 }],
            shape: Shape { depth, rows, cols, same: false },
            transposed: false,
        };
        let c = Stored::new(Layout::Rows, rows, cols, POISON, |i, j| (i + 2 * j) as f64);
        check_small_case::<T>(&Case { specs: vec![spec], part, c, budget: PLENTY });
    }
}

/// The sums of a small product begin as memory that was not written: Miri, which runs this test,
/// finds where they are read.
#[test]
fn overlapping_vectors_leave_no_sums_unwritten_that_are_read() {
    in_both_precisions!(check_overlaps);
}

/// Returns `x 2^exponent`, infinite or zero if that is out of range.
fn scaled(x: f64, exponent: i32) -> f64 {
    let half = exponent / 2;
    x * f64::from(half).exp2() * f64::from(exponent - half).exp2()
}

fn check_scales<T: FloatOperand>(rng: &mut Rng) {
    // All quotients are normal numbers, or far out of range.
    let exponents: &[i32] = match size_of::<T>() {
        8 => &[-1000, -990, -500, 0, 3, 500, 990, 1000],
        _ => &[-120, -100, -60, 0, 3, 60, 100, 115],
    };
    const DEPTH: usize = 37;
    for side in [1, 7, 24, 49, 101] {
        for sources in [1, 2, 5] {
            for (layout, part) in [(Layout::Rows, Part::Lower), (Layout::Rows, Part::Upper)]
                .into_iter()
                .chain([(Layout::Columns, Part::Lower), (Layout::Spread, Part::All)])
            {
                let powers: Vec<_> = (0..side).map(|_| pick(rng, exponents)).collect();
                let scales: Vec<_> =
                    powers.iter().map(|&e| T::from_f64(f64::from(-e).exp2())).collect();
                let terms: Vec<(f64, Stored<T>)> = (0..sources)
                    .map(|_| {
                        let entry = |_: usize, j: usize| integer(rng) * f64::from(powers[j]).exp2();
                        (1.0, Stored::new(Layout::Rows, DEPTH, side, f64::NAN, entry))
                    })
                    .collect();
                // An infinite scale must give zeros, as for a column of zeros that rounding filled.
                let zero = below(rng, side);
                let mut divisors = scales.clone();
                divisors[zero] = T::from_f64(f64::INFINITY);
                let integer_at = |k: usize, j: usize| -> f64 {
                    let sum = |m: &Stored<T>| m.view()[(k, j)].to_f64() * scales[j].to_f64();
                    terms.iter().map(|(_, m)| sum(m)).sum()
                };
                let wants = |i: usize, j: usize| match part {
                    Part::All => true,
                    Part::Lower => i >= j,
                    Part::Upper => i <= j,
                };
                let expected = Stored::<T>::new(layout, side, side, POISON, |i, j| {
                    let dot = (0..DEPTH).map(|k| integer_at(k, i) * integer_at(k, j)).sum();
                    match wants(i, j) {
                        true if i == zero || j == zero => 0.0,
                        true => scaled(dot, powers[i] + powers[j]),
                        false => POISON,
                    }
                });
                for isa in isas() {
                    let mut c = Stored::new(layout, side, side, POISON, |i, j| {
                        if wants(i, j) { f64::NAN } else { POISON }
                    });
                    let destination =
                        Destination::new(c.view_mut(), part).unscaling(&divisors, &divisors);
                    let left = terms.iter().map(|(coefficient, m)| Source {
                        coefficient: T::from_f64(*coefficient),
                        matrix: m.view(),
                        scale: Some(&scales),
                    });
                    let products = [KernelProduct {
                        left: left.collect(),
                        right: vec![],
                        targets: vec![destination.block(0..side, 0..side, T::ONE, T::ZERO)],
                        shape: square(DEPTH, side),
                    }];
                    let kernel = T::kernel(isa);
                    let shapes = products.iter().map(|p| p.shape);
                    let len = scratch_len::<T>(kernel.geometry(), shapes, PLENTY, 1);
                    let progress = &Tracker::new(Progress::none(), WORK);
                    let job = Job { kernel, products: &products, budget: PLENTY, progress };
                    // SAFETY: this function owns `c`, and nothing else uses it meanwhile.
                    unsafe { run(&job, Par::Seq, &mut vec![T::from_f64(f64::NAN); len]) };
                    assert!(
                        c.bits() == expected.bits(),
                        "{} {}, side {side}, {sources} sources, {layout:?}, {part:?}",
                        isa.name(),
                        T::NAME
                    );
                }
            }
        }
    }
}

#[test]
fn scales_over_the_whole_range_of_exponents_are_exact() {
    in_both_precisions!(check_scales);
}

/// Checks that `store_lanes` writes the lanes whose bits are set and no others, for every pattern.
///
/// # Safety
/// The CPU has the instructions of V.
unsafe fn check_stores<V: Vectors>() {
    let numbers: Vec<_> = (0..V::LANES).map(|i| V::Scalar::from_f64(i as f64)).collect();
    let poison = V::Scalar::from_f64(POISON);
    for bits in 0..1_u64 << V::LANES {
        let mut found = vec![poison; V::LANES];
        // SAFETY: both have LANES scalars; the caller has the instructions.
        unsafe { V::store_lanes(found.as_mut_ptr(), bits, V::load(numbers.as_ptr())) };
        for (i, found) in found.into_iter().enumerate() {
            let expected = if bits >> i & 1 == 1 { numbers[i] } else { poison };
            assert_eq!(found, expected, "{} x {}: {bits:b}, lane {i}", V::Scalar::NAME, V::LANES);
        }
    }
}

#[test]
fn lanes_are_stored_where_bits_are_set() {
    for isa in isas() {
        // SAFETY: this machine supports the isa.
        unsafe {
            match isa {
                FloatIsa::Portable => {
                    check_stores::<portable::Array<f64, 2>>();
                    check_stores::<portable::Array<f32, 4>>();
                }
                #[cfg(target_arch = "x86_64")]
                FloatIsa::Avx2 => {
                    check_stores::<x86::Avx2F64>();
                    check_stores::<x86::Avx2F32>();
                }
                #[cfg(target_arch = "x86_64")]
                FloatIsa::Avx512 => {
                    check_stores::<x86::Avx512F64>();
                    check_stores::<x86::Avx512F32>();
                }
                #[cfg(target_arch = "aarch64")]
                FloatIsa::Neon => {
                    check_stores::<neon::NeonF64>();
                    check_stores::<neon::NeonF32>();
                }
                #[allow(unreachable_patterns)]
                _ => unreachable!("{} has no vectors here", isa.name()),
            }
        }
    }
}
