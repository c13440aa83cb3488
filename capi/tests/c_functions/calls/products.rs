//! A^T A, A A^T and A^T B, in scratch of the caller or not.

use std::ptr;

use catamaran_capi::*;

use super::buffers::Matrix;
use super::choices::Choices;
use super::entries::{Entries, Real, factor};
use super::float_env::FloatEnv;
use super::oracle::{Expected, dot, norm};
use super::params::{Nearness, Params, of_product};
use super::refusal::{Fault, check_accepted, check_refused, odd};

/// A product of two matrices of columns, the same one for A^T A and the rows of one for A A^T.
struct Factors<'a, T> {
    left: &'a Matrix<T>,
    right: &'a Matrix<T>,
    transposed: bool,
}

impl<T: Real> Factors<'_, T> {
    /// Returns the length of the columns.
    fn len(&self) -> usize {
        if self.transposed { self.left.cols } else { self.left.rows }
    }

    fn entry(&self, matrix: &Matrix<T>, r: usize, j: usize) -> f64 {
        if self.transposed { matrix.get(j, r) } else { matrix.get(r, j) }.wide()
    }

    /// Returns the largest entry of both, and whether all are finite.
    fn largest(&self) -> (f64, bool) {
        let entries = |of: &Matrix<T>| {
            let all = (0..of.rows).flat_map(|i| (0..of.cols).map(move |j| (i, j)));
            let sizes = all.map(|(i, j)| of.get(i, j).wide().abs());
            sizes.fold((0.0_f64, true), |(most, finite), x| (most.max(x), finite && x.is_finite()))
        };
        let ((left, one), (right, other)) = (entries(self.left), entries(self.right));
        (left * right, one && other)
    }

    /// Checks the wanted entries of C.
    fn check(&self, what: &str, scalars: (T, T), c: &Matrix<T>, uplo: i32, nearness: Nearness) {
        let (len, (largest, finite)) = (self.len(), self.largest());
        let wanted = |i: usize, j: usize| match uplo {
            CATA_UPPER => i <= j,
            CATA_LOWER => i >= j,
            _ => true,
        };
        c.check_changes(what, wanted);
        let symmetric = uplo == CATA_BOTH;
        for i in 0..c.rows {
            for j in 0..c.cols {
                if !wanted(i, j) {
                    continue;
                }
                let columns = || {
                    (0..len).map(|r| (self.entry(self.left, r, i), self.entry(self.right, r, j)))
                };
                let norms = norm(columns().map(|x| x.0)) * norm(columns().map(|x| x.1));
                let unit = len as f64 * T::UNIT;
                let old = if symmetric && i < j { c.old(j, i, 0) } else { c.old(i, j, 0) };
                let expected = Expected {
                    alpha: scalars.0.wide(),
                    sum: dot(columns()),
                    beta: scalars.1.wide(),
                    old: old.wide(),
                    bound: match nearness {
                        Nearness::Largest => 256.0 * unit * len as f64 * largest,
                        _ => 4.0 * unit * norms,
                    },
                    as_loops: nearness == Nearness::Loops,
                    spread: !finite,
                    // Fast schemes add to C many times.
                    unit: if nearness == Nearness::Loops { T::UNIT } else { 64.0 * T::UNIT },
                    tiny: 4.0 * (len + 1) as f64 * T::SMALLEST,
                };
                let got = c.get(i, j);
                assert!(expected.allows(got.wide()), "{what}: ({i}, {j}) is {got:?}: {expected:?}");
                if symmetric {
                    let other = c.get(j, i);
                    let same = other.bits() == got.bits()
                        || (got.wide().is_nan() && other.wide().is_nan());
                    assert!(same, "{what}: ({i}, {j}) and ({j}, {i}) are {got:?} and {other:?}");
                }
            }
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Which {
    Ata,
    Aat,
    Atb,
    AtaIn,
    AtbIn,
}

fn sides(which: Which, m: usize, n: usize, k: usize) -> (usize, usize) {
    match which {
        Which::Ata | Which::AtaIn => (n, n),
        Which::Aat => (m, m),
        Which::Atb | Which::AtbIn => (n, k),
    }
}

/// Makes a call of one of the products.
pub fn call<T: Real>(choices: &mut Choices<'_>) {
    let which =
        choices.pick(&[Which::Ata, Which::Aat, Which::Atb, Which::AtaIn, Which::AtbIn, Which::Ata]);
    let general = matches!(which, Which::Atb | Which::AtbIn);
    let in_scratch = matches!(which, Which::AtaIn | Which::AtbIn);
    let layout = choices.pick(&[CATA_ROW_MAJOR, CATA_COL_MAJOR]);
    let uplo = choices.pick(&[CATA_BOTH, CATA_LOWER, CATA_UPPER]);
    let (m, n, k) = (choices.side(), choices.side(), if general { choices.side() } else { 0 });
    let (alpha, beta): (T, T) = (factor(choices), factor(choices));
    let mut entries = Entries::any(choices);
    let a = Matrix::<T>::new(choices, layout, (m, n), 1, |i, j| entries.next(i, j));
    let b = Matrix::<T>::new(choices, layout, (m, k), 1, |i, j| entries.next(i, j));
    let mut old = Entries::any(choices);
    let mut c = Matrix::<T>::new(choices, layout, sides(which, m, n, k), 1, |i, j| old.next(i, j));
    let (params, nearness) = of_product(choices);
    let mut scratch = scratch::<T>(choices, which, (m, n, k), &params);
    let fault = Fault::pick(choices, &faults(general, in_scratch, [&a, &b, &c]));
    let what = format!("{which:?} {m} x {n}, {k}, {:?}, {fault:?}", params.value);

    let arguments = Arguments { which, layout, uplo, m, n, k, alpha, beta, fault };
    let env = FloatEnv::pick(choices);
    let status =
        env.call(&what, || arguments.call(&a, &b, &mut c, scratch.as_mut(), params.pointer()));
    a.check_untouched(&what);
    b.check_untouched(&what);
    let mut names = params.refused.clone();
    // Few products need none.
    let none = fault == Fault::ShortScratch && scratch.as_ref().is_some_and(|x| x.cols == 0);
    if !none {
        names.extend(fault.names());
    }
    if !names.is_empty() {
        c.check_untouched(&what);
        return check_refused(&what, status, &names);
    }
    check_accepted(&what, status);
    if let Some(scratch) = scratch {
        scratch.check_changes(&what, |_, _| true);
    }
    let right = if general { &b } else { &a };
    let factors = Factors { left: &a, right, transposed: which == Which::Aat };
    let uplo = if general { 0 } else { uplo };
    factors.check(&what, (alpha, beta), &c, uplo, nearness);
}

/// Returns what can be wrong with such a call.
fn faults<T: Real>(general: bool, in_scratch: bool, [a, b, c]: [&Matrix<T>; 3]) -> Vec<Fault> {
    let mut faults = vec![Fault::Layout, Fault::LdA, Fault::LdC, Fault::Huge];
    if !general {
        faults.push(Fault::Uplo);
    }
    if !a.is_empty() {
        faults.extend([Fault::NullA, Fault::OddA]);
    }
    if !c.is_empty() {
        faults.extend([Fault::NullC, Fault::OddC]);
    }
    if general {
        faults.push(Fault::LdB);
        if !b.is_empty() {
            faults.push(Fault::NullB);
        }
    }
    if !a.is_empty() && !c.is_empty() {
        faults.push(Fault::Overlap);
    }
    if in_scratch && !c.is_empty() {
        faults.extend([Fault::ScratchIsC, Fault::ShortScratch]);
    }
    faults
}

/// Returns the scratch of a call that has one.
fn scratch<T: Real>(
    choices: &mut Choices<'_>,
    which: Which,
    (m, n, k): (usize, usize, usize),
    params: &Params<cata_ata_params>,
) -> Option<Matrix<T>> {
    let mut len = usize::MAX;
    // SAFETY: a live struct, and a place for the length.
    let status = unsafe {
        match which {
            Which::AtaIn => T::ATA_LEN(m, n, params.pointer(), &mut len),
            Which::AtbIn => T::ATB_LEN(m, n, k, params.pointer(), &mut len),
            _ => return None,
        }
    };
    if params.refused.is_empty() {
        check_accepted("scratch_len", status);
    } else {
        check_refused("scratch_len", status, &params.refused);
        assert_eq!(len, usize::MAX);
        len = 0;
    }
    Some(Matrix::output(choices, len))
}

/// The arguments of a call, and what is wrong with them.
struct Arguments<T> {
    which: Which,
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    k: usize,
    alpha: T,
    beta: T,
    fault: Fault,
}

impl<T: Real> Arguments<T> {
    fn call(
        &self,
        a: &Matrix<T>,
        b: &Matrix<T>,
        c: &mut Matrix<T>,
        scratch: Option<&mut Matrix<T>>,
        params: *const cata_ata_params,
    ) -> cata_status {
        let &Self { which, layout, uplo, m, n, k, alpha, beta, fault } = self;
        let layout = if fault == Fault::Layout { 100 } else { layout };
        let uplo = if fault == Fault::Uplo { 0 } else { uplo };
        let m = if fault == Fault::Huge { usize::MAX } else { m };
        let short = |ld: usize, wrong: Fault| if fault == wrong { 0 } else { ld };
        let (lda, ldb) = (short(a.ld, Fault::LdA), short(b.ld, Fault::LdB));
        let ldc = short(c.ld, Fault::LdC);
        let pa = match fault {
            Fault::NullA => ptr::null(),
            Fault::OddA => odd(a.pointer()),
            _ => a.pointer(),
        };
        let pb = if fault == Fault::NullB { ptr::null() } else { b.pointer() };
        let pc = match fault {
            Fault::NullC => ptr::null_mut(),
            Fault::OddC => odd(c.pointer_mut()).cast_mut(),
            Fault::Overlap => a.pointer().cast_mut(),
            _ => c.pointer_mut(),
        };
        let (ps, len) = match scratch {
            Some(_) if fault == Fault::ScratchIsC => (pc, 1),
            Some(scratch) if fault == Fault::ShortScratch => (scratch.pointer_mut(), 0),
            Some(scratch) => (scratch.pointer_mut(), scratch.cols),
            None => (ptr::null_mut(), 0),
        };
        // SAFETY: the memory of the matrices, or arguments that must be refused before any of it is
        // written or read.
        unsafe {
            match which {
                Which::Ata => T::ATA(layout, uplo, m, n, alpha, pa, lda, beta, pc, ldc, params),
                Which::Aat => T::AAT(layout, uplo, m, n, alpha, pa, lda, beta, pc, ldc, params),
                Which::Atb => {
                    T::ATB(layout, m, n, k, alpha, pa, lda, pb, ldb, beta, pc, ldc, params)
                }
                Which::AtaIn => {
                    T::ATA_IN(layout, uplo, m, n, alpha, pa, lda, beta, pc, ldc, ps, len, params)
                }
                Which::AtbIn => T::ATB_IN(
                    layout, m, n, k, alpha, pa, lda, pb, ldb, beta, pc, ldc, ps, len, params,
                ),
            }
        }
    }
}

/// Makes a call with A in float and C in double.
pub fn mixed(choices: &mut Choices<'_>) {
    let layout = choices.pick(&[CATA_ROW_MAJOR, CATA_COL_MAJOR]);
    let uplo = choices.pick(&[CATA_BOTH, CATA_LOWER, CATA_UPPER]);
    let (m, n) = (choices.side(), choices.side());
    let (alpha, beta): (f64, f64) = (factor(choices), factor(choices));
    let mut entries = Entries::any(choices);
    let a = Matrix::<f32>::new(choices, layout, (m, n), 1, |i, j| entries.next(i, j));
    let wide = Matrix::<f64>::new(choices, layout, (m, n), 1, |i, j| a.get(i, j).into());
    let mut old = Entries::any(choices);
    let mut c = Matrix::<f64>::new(choices, layout, (n, n), 1, |i, j| old.next(i, j));
    let (params, nearness) = of_product(choices);
    let what = format!("float, double {m} x {n}, {:?}", params.value);
    // SAFETY: the matrices own their memory, which has the sides and leading dimensions passed.
    let status = unsafe {
        let (lda, ldc, pc) = (a.ld, c.ld, c.pointer_mut());
        let params = params.pointer();
        cata_ata_f32_f64(layout, uplo, m, n, alpha, a.pointer(), lda, beta, pc, ldc, params)
    };
    a.check_untouched(&what);
    if !params.refused.is_empty() {
        c.check_untouched(&what);
        return check_refused(&what, status, &params.refused);
    }
    check_accepted(&what, status);
    let factors = Factors { left: &wide, right: &wide, transposed: false };
    factors.check(&what, (alpha, beta), &c, uplo, nearness);
}
