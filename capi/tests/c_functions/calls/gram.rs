//! Least squares, components, singular values and what else a Gram matrix in extended precision
//! gives.

use std::ptr;

use catamaran_capi::*;

use super::buffers::Matrix;
use super::choices::Choices;
use super::entries::Entries;
use super::oracle::{dot, norm};
use super::params::{Params, field};
use super::refusal::{Fault, check_accepted, check_refused};

/// A, and what is chosen for all of these functions.
struct Problem {
    layout: i32,
    m: usize,
    n: usize,
    a: Matrix<f64>,
    fault: Fault,
    /// Whether an entry is NaN or infinite.
    broken: bool,
}

impl Problem {
    fn new(choices: &mut Choices<'_>, sides: (usize, usize)) -> Self {
        let layout = choices.pick(&[CATA_ROW_MAJOR, CATA_COL_MAJOR]);
        let mut entries = match choices.one_in(8) {
            true => Entries::broken(choices),
            false => Entries::finite(choices),
        };
        let a = Matrix::<f64>::new(choices, layout, sides, 1, |i, j| entries.next(i, j));
        let (m, n) = sides;
        let broken = (0..m).any(|i| (0..n).any(|j| !a.get(i, j).is_finite()));
        let mut faults = vec![Fault::Layout, Fault::LdA];
        if !a.is_empty() {
            faults.push(Fault::NullA);
        }
        Self { layout, m, n, a, fault: Fault::pick(choices, &faults), broken }
    }

    fn layout(&self) -> i32 {
        if self.fault == Fault::Layout { 7 } else { self.layout }
    }

    fn lda(&self) -> usize {
        if self.fault == Fault::LdA { 0 } else { self.a.ld }
    }

    fn pointer(&self) -> *const f64 {
        if self.fault == Fault::NullA { ptr::null() } else { self.a.pointer() }
    }

    /// Returns the names of what must be refused.
    fn refused(&self, more: &[&'static str]) -> Vec<&'static str> {
        let mut names: Vec<_> = self.fault.names().iter().chain(more).copied().collect();
        if self.broken {
            names.extend(["a", "column"]);
        }
        names
    }

    fn column(&self, j: usize) -> impl Iterator<Item = f64> + Clone + '_ {
        (0..self.m).map(move |i| self.a.get(i, j))
    }

    fn size(&self) -> f64 {
        norm((0..self.n).map(|j| norm(self.column(j))))
    }

    fn output(&self, choices: &mut Choices<'_>, sides: (usize, usize)) -> Matrix<f64> {
        Matrix::new(choices, self.layout, sides, 1, |_, _| f64::NAN)
    }
}

/// Makes a call of one of the functions.
pub fn call(choices: &mut Choices<'_>) {
    match choices.below(6) {
        0 => least_squares(choices),
        1 => components(choices),
        2 => singular_values(choices),
        3 => extended(choices),
        4 => correlation(choices),
        _ => orthogonality(choices),
    }
}

fn gram_params(choices: &mut Choices<'_>) -> Params<cata_gram_params> {
    let threads = choices.pick(&[1, 0, 3]);
    let (progress, progress_user) = (None, ptr::null_mut());
    let value = cata_gram_params { struct_size: 0, threads, progress, progress_user };
    Params::new(choices, value, None)
}

fn least_squares(choices: &mut Choices<'_>) {
    let (m, n, k) = (choices.side(), choices.below(20), 1 + choices.below(3));
    let problem = Problem::new(choices, (m, n));
    let mut numbers = choices.rng();
    let b = Matrix::<f64>::new(choices, problem.layout, (m, k), 1, |_, _| numbers.normal());
    let mut x = problem.output(choices, (n, k));
    let mut refused = None;
    let r = &mut refused;
    let bad = [-1.0, f64::NAN, f64::INFINITY];
    let value = cata_lstsq_params {
        struct_size: 0,
        threads: choices.pick(&[1, 0, 3]),
        progress: None,
        progress_user: ptr::null_mut(),
        ridge: field(choices, "ridge: ", &[0.0, 0.0, 0.5], &bad, r),
        intercept: field(choices, "params.intercept: ", &[0, 1], &[2, -1], r),
        refuse_dependent: field(choices, "params.refuse_dependent: ", &[0], &[2, -1], r),
        confidence: 0.0,
    };
    let params = Params::new(choices, value, refused);
    let mut norms = Matrix::<f64>::output(choices, k);
    let mut constants = Matrix::<f64>::output(choices, k);
    // SAFETY: all fields may be 0.
    let mut result: cata_lstsq_result = unsafe { std::mem::zeroed() };
    result.struct_size = size_of::<cata_lstsq_result>();
    result.residual_norms = norms.pointer_mut();
    result.intercepts = constants.pointer_mut();
    let what = format!("lstsq {m} x {n}, {k}, {value:?}, {:?}", problem.fault);
    // SAFETY: the memory of the matrices, or arguments that must be refused.
    let status = unsafe {
        let (pa, pb, px) = (problem.pointer(), b.pointer(), x.pointer_mut());
        let (layout, lda) = (problem.layout(), problem.lda());
        cata_lstsq(
            layout,
            m,
            n,
            k,
            pa,
            lda,
            pb,
            b.ld,
            ptr::null(),
            px,
            x.ld,
            &mut result,
            params.pointer(),
        )
    };
    problem.a.check_untouched(&what);
    b.check_untouched(&what);
    let names = problem.refused(&params.refused);
    if !names.is_empty() {
        x.check_untouched(&what);
        norms.check_untouched(&what);
        constants.check_untouched(&what);
        return check_refused(&what, status, &names);
    }
    check_accepted(&what, status);
    x.check_changes(&what, |_, _| true);
    check_solution(&what, &problem, &b, &x, (&constants, &norms), &value);
}

/// The gradient of the minimized sum is 0 up to rounding.
fn check_solution(
    what: &str,
    problem: &Problem,
    b: &Matrix<f64>,
    x: &Matrix<f64>,
    (constants, norms): (&Matrix<f64>, &Matrix<f64>),
    params: &cata_lstsq_params,
) {
    let &Problem { m, n, ref a, .. } = problem;
    for t in 0..b.cols {
        let constant = constants.get(0, t);
        assert!(params.intercept == 1 || constant == 0.0, "{what}: constant {constant}");
        let residual = |i: usize| {
            let row = (0..n).map(|j| (a.get(i, j), x.get(j, t)));
            dot(row.chain([(constant, 1.0), (-1.0, b.get(i, t))]))
        };
        let residuals: Vec<f64> = (0..m).map(residual).collect();
        let sizes = (0..n).map(|j| norm(problem.column(j)) * x.get(j, t).abs());
        // With an intercept digits are lost to the mean.
        let size = sizes.sum::<f64>()
            + constant.abs() * (m as f64).sqrt()
            + norm(residuals.iter().copied());
        let bound = 1e-10 * size;
        let length = norm(residuals.iter().copied());
        let got = norms.get(0, t);
        assert!((got - length).abs() <= bound, "{what}: |r| is {length}, not {got}, {bound}");
        for j in 0..n {
            let force = dot(residuals.iter().copied().zip(problem.column(j)));
            let gradient = force + params.ridge * x.get(j, t);
            let most = bound * norm(problem.column(j)) + 1e-11 * params.ridge * x.get(j, t).abs();
            assert!(gradient.abs() <= most, "{what}: gradient {j} of {t} is {gradient}, {most}");
        }
        if params.intercept == 1 && m > 0 {
            let sum: f64 = residuals.iter().sum();
            assert!(sum.abs() <= bound * (m as f64).sqrt(), "{what}: residuals sum to {sum}");
        }
    }
}

fn components(choices: &mut Choices<'_>) {
    let (m, n) = (choices.side(), choices.below(20));
    let problem = Problem::new(choices, (m, n));
    let count = choices.below(n + 2);
    let mut refused = None;
    let flags = [2, -1];
    let value = cata_pca_params {
        struct_size: 0,
        threads: choices.pick(&[1, 0, 3]),
        progress: None,
        progress_user: ptr::null_mut(),
        standardize: field(choices, "params.standardize: ", &[0, 1], &flags, &mut refused),
    };
    let params = Params::new(choices, value, refused);
    let mut found = problem.output(choices, (count, n));
    let [mut variances, mut ratios, mut values] =
        [(); 3].map(|()| Matrix::<f64>::output(choices, count));
    let [mut mean, mut scale] = [(); 2].map(|()| Matrix::<f64>::output(choices, n));
    let what = format!("pca {m} x {n}, {count}, {value:?}, {:?}", problem.fault);
    // SAFETY: the memory of the matrices, or arguments that must be refused.
    let status = unsafe {
        let (layout, lda, pa) = (problem.layout(), problem.lda(), problem.pointer());
        let (pc, ldc) = (found.pointer_mut(), found.ld);
        let [v, r, s]: [*mut f64; 3] =
            [&mut variances, &mut ratios, &mut values].map(Matrix::pointer_mut);
        let (mean, scale) = (mean.pointer_mut(), scale.pointer_mut());
        cata_pca(layout, m, n, pa, lda, count, pc, ldc, v, r, s, mean, scale, params.pointer())
    };
    problem.a.check_untouched(&what);
    let mut names = problem.refused(&params.refused);
    if m < 2 {
        names.push("m: ");
    }
    if count > n {
        names.push("count: ");
    }
    if !names.is_empty() {
        found.check_untouched(&what);
        [&variances, &ratios, &values, &mean, &scale].iter().for_each(|x| x.check_untouched(&what));
        return check_refused(&what, status, &names);
    }
    check_accepted(&what, status);
    found.check_changes(&what, |_, _| true);
    check_components(&what, &problem, &found, [&variances, &values, &mean, &scale]);
}

/// Components are eigenvectors of the covariance matrix.
fn check_components(
    what: &str,
    problem: &Problem,
    found: &Matrix<f64>,
    [variances, values, mean, scale]: [&Matrix<f64>; 4],
) {
    let &Problem { m, n, ref a, .. } = problem;
    let centred = |j: usize| {
        let middle = mean.get(0, j);
        (0..m).map(move |i| (a.get(i, j) - middle) / scale.get(0, j))
    };
    let x: Vec<Vec<f64>> = (0..n).map(|j| centred(j).collect()).collect();
    for j in 0..n {
        let most = problem.column(j).fold(0.0_f64, |most, x| most.max(x.abs()));
        let exact = dot(problem.column(j).map(|x| (x, 1.0))) / m as f64;
        let error = (mean.get(0, j) - exact).abs();
        assert!(error <= 1e-14 * most, "{what}: mean {j} is off by {error}");
    }
    let lost = (0..n).map(|j| {
        let most = problem.column(j).fold(0.0_f64, |most, x| most.max(x.abs()));
        most / scale.get(0, j)
    });
    let size = norm(x.iter().flatten().copied()) + 1e-3 * lost.sum::<f64>();
    for k in 0..found.rows {
        let (variance, value) = (variances.get(0, k), values.get(0, k));
        let scores: Vec<f64> =
            (0..m).map(|i| dot((0..n).map(|j| (x[j][i], found.get(k, j))))).collect();
        for j in 0..n {
            let image = dot(x[j].iter().copied().zip(scores.iter().copied()));
            let error = (image - value * value * found.get(k, j)).abs();
            let bound = 1e-11 * size * size;
            assert!(error <= bound, "{what}: component {k} is off by {error} of {bound}");
        }
        let expected = value * value / (m - 1) as f64;
        assert!((variance - expected).abs() <= 1e-12 * expected, "{what}: {variance} {expected}");
    }
}

fn singular_values(choices: &mut Choices<'_>) {
    let (m, n) = (choices.side(), choices.below(20));
    let problem = Problem::new(choices, (m, n));
    let most = m.min(n);
    let params = gram_params(choices);
    let mut values = Matrix::<f64>::output(choices, most);
    let mut v = problem.output(choices, (n, most));
    let what = format!("svd {m} x {n}, {:?}", problem.fault);
    // SAFETY: the memory of the matrices, or arguments that must be refused.
    let status = unsafe {
        let (layout, lda, pa) = (problem.layout(), problem.lda(), problem.pointer());
        let (values, pv) = (values.pointer_mut(), v.pointer_mut());
        cata_svd(layout, m, n, pa, lda, values, pv, v.ld, params.pointer())
    };
    problem.a.check_untouched(&what);
    let names = problem.refused(&params.refused);
    if !names.is_empty() {
        values.check_untouched(&what);
        v.check_untouched(&what);
        return check_refused(&what, status, &names);
    }
    check_accepted(&what, status);
    v.check_changes(&what, |_, _| true);
    let size = problem.size();
    let mut squares = 0.0;
    for k in 0..most {
        let value = values.get(0, k);
        assert!(value >= 0.0 && (k == 0 || value <= values.get(0, k - 1)), "{what}: {k}: {value}");
        squares += value * value;
        let vector: Vec<f64> = (0..n).map(|j| v.get(j, k)).collect();
        let length = norm(vector.iter().copied());
        let unit = if value == 0.0 { length == 0.0 } else { (length - 1.0).abs() <= 1e-13 };
        assert!(unit, "{what}: |v_{k}| is {length} for {value}");
        let image: Vec<f64> =
            (0..m).map(|i| dot((0..n).map(|j| (problem.a.get(i, j), vector[j])))).collect();
        let error = (norm(image.iter().copied()) - value).abs();
        assert!(error <= 1e-12 * size, "{what}: value {k} = {value} is off by {error} of {size}");
    }
    let exact = size * size;
    assert!((squares - exact).abs() <= 1e-12 * exact, "{what}: {squares} is not {exact}");
}

fn extended(choices: &mut Choices<'_>) {
    let (m, n) = (choices.side(), choices.below(20));
    let problem = Problem::new(choices, (m, n));
    let params = gram_params(choices);
    let mut refused = None;
    let centering = field(choices, "centering: ", &[CATA_CENTER_NONE], &[2, -1], &mut refused);
    let mut high = problem.output(choices, (n, n));
    let mut low = problem.output(choices, (n, n));
    let mut exact = -1;
    let what = format!("gram_extended {m} x {n}, {:?}", problem.fault);
    // SAFETY: the memory of the matrices, or arguments that must be refused.
    let status = unsafe {
        let (layout, lda, pa) = (problem.layout(), problem.lda(), problem.pointer());
        let (ph, pl) = (high.pointer_mut(), low.pointer_mut());
        cata_gram_extended(
            layout,
            m,
            n,
            pa,
            lda,
            ptr::null(),
            centering,
            ph,
            high.ld,
            pl,
            low.ld,
            &mut exact,
            params.pointer(),
        )
    };
    let mut names = problem.refused(&params.refused);
    names.extend(refused);
    if !names.is_empty() {
        high.check_untouched(&what);
        low.check_untouched(&what);
        assert_eq!(exact, -1, "{what}");
        return check_refused(&what, status, &names);
    }
    check_accepted(&what, status);
    high.check_changes(&what, |i, j| i >= j);
    low.check_changes(&what, |i, j| i >= j);
    for i in 0..n {
        for j in 0..=i {
            let sum = dot(problem.column(i).zip(problem.column(j)));
            let norms = norm(problem.column(i)) * norm(problem.column(j));
            let (high, low) = (high.get(i, j), low.get(i, j));
            // What `dot` returns is rounded itself; `low` is below half a unit of `high`.
            let near = (high - sum).abs() <= 1.2e-16 * sum.abs() + 1e-21 * norms;
            let rest = low.abs() <= 1.2e-16 * high.abs();
            assert!(near && rest, "{what}: ({i}, {j}) is {high} + {low}, not {sum}");
        }
    }
}

fn correlation(choices: &mut Choices<'_>) {
    let (m, n) = (choices.side(), choices.below(20));
    let problem = Problem::new(choices, (m, n));
    let params = gram_params(choices);
    let mut c = problem.output(choices, (n, n));
    let overlap = choices.one_in(8) && !problem.a.is_empty();
    let what = format!("correlation {m} x {n}, {:?}, {overlap}", problem.fault);
    // SAFETY: the memory of the matrices, or arguments that must be refused.
    let status = unsafe {
        let (layout, lda, pa) = (problem.layout(), problem.lda(), problem.pointer());
        let place = if overlap { problem.a.pointer().cast_mut() } else { c.pointer_mut() };
        cata_gram_correlation(layout, m, n, pa, lda, place, c.ld, params.pointer())
    };
    problem.a.check_untouched(&what);
    let mut names = problem.refused(&params.refused);
    if overlap {
        names.push("c: ");
    }
    if !names.is_empty() {
        c.check_untouched(&what);
        return check_refused(&what, status, &names);
    }
    if m == 0 {
        return; // there is no mean
    }
    check_accepted(&what, status);
    c.check_changes(&what, |_, _| true);
    let mean = |j: usize| dot(problem.column(j).map(|x| (x, 1.0))) / m as f64;
    let about = |j: usize| {
        let mean = mean(j);
        problem.column(j).map(move |x| x - mean).collect::<Vec<_>>()
    };
    let columns: Vec<Vec<f64>> = (0..n).map(about).collect();
    for i in 0..n {
        for j in 0..n {
            let lengths = norm(columns[i].iter().copied()) * norm(columns[j].iter().copied());
            let sizes = norm(problem.column(i)) * norm(problem.column(j));
            let got = c.get(i, j);
            assert!(got.is_nan() || got.abs() <= 1.0, "{what}: ({i}, {j}) is {got}");
            if lengths > 1e-6 * sizes {
                let sum = dot(columns[i].iter().copied().zip(columns[j].iter().copied()));
                let exact = sum / lengths;
                assert!((got - exact).abs() <= 1e-9, "{what}: ({i}, {j}) is {got}, not {exact}");
            }
        }
    }
}

fn orthogonality(choices: &mut Choices<'_>) {
    let (m, n) = (choices.side(), choices.below(20));
    let problem = Problem::new(choices, (m, n));
    let params = gram_params(choices);
    let (mut max, mut frobenius) = (-1.0, -1.0);
    let what = format!("orthogonality {m} x {n}, {:?}", problem.fault);
    // SAFETY: the memory of the matrix and places, or arguments that must be refused.
    let status = unsafe {
        let (layout, lda, pa) = (problem.layout(), problem.lda(), problem.pointer());
        cata_gram_orthogonality(layout, m, n, pa, lda, &mut max, &mut frobenius, params.pointer())
    };
    let mut names = problem.fault.names().to_vec();
    names.extend(&params.refused);
    if problem.fault == Fault::LdA {
        names.push("ldq: ");
    }
    if problem.fault == Fault::NullA || problem.broken {
        names.extend(["q", "column"]);
    }
    if !names.is_empty() {
        assert!(max == -1.0 && frobenius == -1.0, "{what}: written");
        return check_refused(&what, status, &names);
    }
    check_accepted(&what, status);
    let (mut largest, mut squares) = (0.0_f64, 0.0);
    for i in 0..n {
        for j in 0..n {
            let one = if i == j { -1.0 } else { 0.0 };
            let entry = dot(problem.column(i).zip(problem.column(j)).chain([(one, 1.0)]));
            largest = largest.max(entry.abs());
            squares += entry * entry;
        }
    }
    let near = |got: f64, exact: f64| (got - exact).abs() <= 1e-12 * exact + 1e-20;
    let right = near(max, largest) && near(frobenius, f64::sqrt(squares));
    assert!(right, "{what}: {max}, {frobenius}, not {largest}, {}", f64::sqrt(squares));
}
