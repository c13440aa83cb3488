"""Least squares, principal components, singular values, orthonormal bases."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse
import scipy.stats

import catamaran


def test_lstsq_is_that_of_numpy(rng):
    a, b = rng.standard_normal((80, 6)), rng.standard_normal((80, 2))
    found = catamaran.lstsq(a, b)
    x, residuals, rank, _ = np.linalg.lstsq(a, b, rcond=None)
    assert np.allclose(found.x, x, rtol=1e-12) and found.rank == rank
    assert np.allclose(found.residual_norm**2, residuals)
    assert found.degrees_of_freedom == 74 and found.digits > 15
    one = catamaran.lstsq(a, b[:, 0])
    assert one.x.shape == (6,) and np.isscalar(one.residual_norm)
    assert np.array_equal(one.predict(a), a @ one.x + one.intercept)


def test_lstsq_has_digits_where_qr_has_none():
    t = np.linspace(-8.8, -3.1, 82)
    a = np.vander(t, 11, increasing=True)
    truth = np.arange(1.0, 12.0)
    found = catamaran.lstsq(a, a @ truth, standard_errors=False)
    qr = np.linalg.lstsq(a, a @ truth, rcond=0)[0]
    ours, theirs = (np.abs(x - truth).max() for x in (found.x, qr))
    assert found.rank == 11 and ours <= theirs * 10 and found.condition > 1e12


def test_weights_ridge_and_intercept(rng):
    a, b, w = rng.standard_normal((60, 3)), rng.standard_normal(60), rng.uniform(0.5, 2, 60)
    found = catamaran.lstsq(a, b, weights=w)
    root = np.sqrt(w)
    assert np.allclose(found.x, np.linalg.lstsq(root[:, None] * a, root * b, rcond=None)[0])
    found = catamaran.lstsq(a, b, ridge=3.0)
    assert np.allclose(found.x, np.linalg.solve(a.T @ a + 3 * np.eye(3), a.T @ b))
    found = catamaran.lstsq(a, b, intercept=True)
    both = np.linalg.lstsq(np.column_stack([a, np.ones(60)]), b, rcond=None)[0]
    assert np.allclose(found.x, both[:3]) and np.isclose(found.intercept, both[3])


def test_columns_that_depend_on_others(rng):
    a = rng.standard_normal((30, 3))
    a = np.column_stack([a, a[:, 0]])
    found = catamaran.lstsq(a, a[:, 0])
    assert found.rank == 3 and len(found.dependent) == 1
    assert np.allclose(found.x, [0.5, 0, 0, 0.5], atol=1e-12)
    with pytest.raises(ValueError, match="A: column"):
        catamaran.lstsq(a, a[:, 0], rank_deficiency="refuse")


def test_pca_is_that_of_numpy(rng):
    x = rng.standard_normal((100, 5)) @ np.diag([5, 3, 2, 1, 0.5]) + 4
    found = catamaran.pca(x, 3)
    _, s, vt = np.linalg.svd(x - x.mean(axis=0), full_matrices=False)
    assert np.allclose(found.singular_values, s[:3])
    assert np.allclose(np.abs(found.components), np.abs(vt[:3]))
    assert np.allclose(found.explained_variance, s[:3] ** 2 / 99)
    assert np.allclose(found.transform(x), (x - x.mean(axis=0)) @ found.components.T)
    assert np.allclose(
        found.transform(x[::-1].astype(np.float32)), found.transform(x)[::-1], atol=1e-4
    )
    share = catamaran.pca(x, 0.8)
    assert share.explained_variance_ratio.sum() >= 0.8
    white = catamaran.pca(x, 2, whiten=True).transform(x)
    assert np.allclose(np.cov(white, rowvar=False), np.eye(2))
    scaled = catamaran.pca(x, standardize=True)
    assert np.allclose(scaled.scale, x.std(axis=0, ddof=1))
    assert np.isclose(scaled.explained_variance.sum(), 5)
    doubled = catamaran.pca(x, weights=np.full(100, 2.0))
    assert np.allclose(np.abs(doubled.components), np.abs(catamaran.pca(x).components))


def test_svd_is_that_of_numpy(rng):
    a = rng.standard_normal((50, 6))
    u, s, vh = catamaran.svd(a, compute_u=True)
    assert np.allclose(s, np.linalg.svd(a, compute_uv=False))
    assert np.allclose(u * s @ vh, a) and np.allclose(u.T @ u, np.eye(6))
    assert catamaran.svd(a).u is None


def test_small_singular_values_have_digits():
    # Exactly known: powers of two on a diagonal, rotated by a Hadamard matrix.
    s = 2.0 ** -np.array([0, 10, 20, 40])
    a = scipy.linalg.hadamard(8)[:, :4] * s
    assert np.allclose(catamaran.svd(a).s, s * np.sqrt(8), rtol=1e-14, atol=0)


def test_qr(rng):
    a = rng.standard_normal((70, 5))
    q, r = catamaran.qr(a)
    assert np.allclose(q @ r, a) and np.allclose(np.tril(r, -1), 0) and (np.diag(r) > 0).all()
    assert catamaran.orthogonality(q)[1] < 1e-15
    mass = rng.uniform(0.5, 2, 70)
    for m in (mass, scipy.sparse.diags(mass)):
        q, r = catamaran.qr(a, mass=m)
        assert np.allclose(q @ r, a) and np.allclose(q.T @ (mass[:, None] * q), np.eye(5))
    with pytest.raises(ValueError, match="depend"):
        catamaran.qr(np.column_stack([a, a[:, 0]]))


@pytest.mark.parametrize("method", ["reorthogonalized", "single_pass", "rank_revealing"])
def test_orthogonalize(rng, method):
    a = rng.standard_normal((90, 6))
    a[:, 3] = a[:, 1] - 2 * a[:, 2]
    q, r, kept = catamaran.orthogonalize(a, method=method)
    assert q.shape == (90, 5) and len(kept) == 5
    assert np.allclose(q.T @ q, np.eye(5), atol=1e-10) and np.allclose(q @ r, a, atol=1e-8)


def test_statistics_are_those_of_the_textbook(rng):
    a, w = rng.standard_normal((40, 3)), rng.integers(0, 4, 40).astype(float)
    b = a @ [1.0, 0.2, 0.0] + 3 + rng.standard_normal(40)
    found = catamaran.lstsq(a, b, weights=w, intercept=True)
    assert found.observations == np.count_nonzero(w)
    assert found.degrees_of_freedom == found.observations - 4
    x = np.column_stack([np.ones(40), a])
    inverse = np.linalg.inv(x.T @ (w[:, None] * x))
    beta = inverse @ x.T @ (w * b)
    square = (w * (b - x @ beta) ** 2).sum() / found.degrees_of_freedom
    covariance = found.covariance()
    assert np.allclose(covariance, square * inverse, rtol=1e-10)
    errors = np.sqrt(np.diag(covariance))
    t = scipy.stats.t(found.degrees_of_freedom)
    assert np.allclose(found.t_statistics, beta[1:] / errors[1:])
    assert np.allclose(found.p_values, 2 * t.sf(np.abs(found.t_statistics)), rtol=1e-9)
    assert np.isclose(found.intercept_p_values, 2 * t.sf(beta[0] / errors[0]), rtol=1e-9)
    lower, upper = found.confidence_intervals(0.9)
    assert np.allclose(upper - lower, 2 * t.ppf(0.95) * errors[1:])
    low, high = found.intercept_intervals(0.9)
    assert np.isclose(high - low, 2 * t.ppf(0.95) * errors[0])
    total = (w * (b - np.average(b, weights=w)) ** 2).sum()
    residual = square * found.degrees_of_freedom
    assert np.isclose(found.f_statistic, (total - residual) / 3 / square)
    f = scipy.stats.f.sf(found.f_statistic, 3, found.degrees_of_freedom)
    assert np.isclose(found.f_p_value, f, rtol=1e-9)
    assert np.isclose(found.residual_deviation, np.sqrt(square))
    new = rng.standard_normal((5, 3))
    rows = np.column_stack([np.ones(5), new])
    of_mean = np.sqrt(np.einsum("ij,jk,ik->i", rows, covariance, rows))
    assert np.allclose(found.prediction_errors(new), of_mean)
    both = found.prediction_errors(new, observation=True)
    assert np.allclose(both**2, of_mean**2 + square)
    lower, upper = found.prediction_intervals(new, 0.8, observation=True)
    assert np.allclose(upper - lower, 2 * t.ppf(0.9) * both)
    assert np.allclose((upper + lower) / 2, found.predict(new))
    without = catamaran.lstsq(a, b, standard_errors=False)
    for call in (without.covariance, without.confidence_intervals):
        with pytest.raises(ValueError, match="standard_errors"):
            call()
    with pytest.raises(ValueError, match="confidence"):
        found.confidence_intervals(95)
    two = catamaran.lstsq(a, np.column_stack([b, -b]), intercept=True)
    assert two.p_values.shape == (3, 2) and two.f_p_value.shape == (2,)
    assert two.prediction_errors(new).shape == (5, 2)


def test_factors_are_columns_of_zeros_and_ones(rng):
    x, b = rng.standard_normal((30, 2)), rng.standard_normal(30)
    labels = np.array(["c", "a", "b"])[rng.integers(0, 3, 30)]
    found = catamaran.lstsq(x, b, intercept=True, factors={"f": labels})
    assert found.factor_columns == ("f[b]", "f[c]") and found.left_out == ()
    design = np.column_stack([x, labels == "b", labels == "c"])
    right = catamaran.lstsq(design, b, intercept=True)
    assert np.array_equal(found.x, right.x)
    assert np.array_equal(found.p_values, right.p_values)
    assert np.allclose(found.predict(design), right.predict(design))
    # Rows without a label or a number, and a level that only they have.
    missing = labels.astype(object)
    missing[4], missing[9], x[9, 1] = None, "z", np.nan
    with pytest.raises(ValueError, match="row 4.*missing"):
        catamaran.lstsq(x, b, factors={"f": missing})
    found = catamaran.lstsq(x, b, intercept=True, factors={"f": missing}, missing="drop")
    kept = np.delete(np.arange(30), [4, 9])
    assert found.left_out == (4, 9) and found.factor_columns == ("f[b]", "f[c]")
    right = catamaran.lstsq(design[kept], b[kept], intercept=True)
    assert np.array_equal(found.x, right.x) and found.observations == 28
    numbers = catamaran.lstsq(x[kept], b[kept], factors={"n": rng.integers(8, 12, 28)})
    assert set(numbers.factor_columns) <= {"n[9]", "n[10]", "n[11]"}
    with pytest.raises(ValueError, match="two are needed"):
        catamaran.lstsq(x[kept], b[kept], factors={"f": ["one"] * 28})
    with pytest.raises(ValueError, match="missing: 'skip'"):
        catamaran.lstsq(x, b, missing="skip")


def test_categories_of_a_data_frame_keep_their_order(rng):
    class Categorical:
        """What pandas has."""

        categories = ["small", "large", "huge"]
        codes = np.array([0, 1, 0, 1, -1, 1], dtype=np.int8)

    x, b = rng.standard_normal((6, 1)), rng.standard_normal(6)
    found = catamaran.lstsq(x, b, factors={"size": Categorical()}, missing="drop")
    assert found.factor_columns == ("size[large]",) and found.left_out == (4,)


def test_labels_that_do_not_equal_themselves_are_missing(rng):
    class NA:
        """What pandas has for missing words: it is neither true nor false."""

        def __eq__(self, other):
            return self

        def __bool__(self):
            raise TypeError("ambiguous")

    labels = ["a", NA(), np.str_("b"), float("nan"), np.datetime64("NaT"), "b", "a", None]
    x, b = rng.standard_normal((8, 1)), rng.standard_normal(8)
    found = catamaran.lstsq(x, b, factors={"f": labels}, missing="drop")
    assert found.left_out == (1, 3, 4, 7) and found.factor_columns == ("f[b]",)
    words = ["a", float("nan"), "b", "b", "a", "a", "b", "a"]
    assert catamaran.lstsq(x, b, factors={"f": words}, missing="drop").left_out == (1,)


def test_predictions_take_the_labels_of_factors(rng):
    x, b = rng.standard_normal((40, 2)), rng.standard_normal(40)
    where, size = rng.choice(["b", "c", "a"], 40), rng.choice([9, 10, 8], 40)
    fit = catamaran.lstsq(x, b, intercept=True, factors={"f": where, "n": size})
    assert fit.factor_levels == (("f", ("a", "b", "c")), ("n", ("8", "9", "10")))
    new = rng.standard_normal((4, 2))
    labels = {"n": [10, 8, 9, 8], "f": ["c", "a", "b", "a"]}
    design = np.column_stack([new, [0, 0, 1, 0], [1, 0, 0, 0], [0, 0, 1, 0], [1, 0, 0, 0]])
    assert np.array_equal(fit.predict(new, factors=labels), fit.predict(design))
    sparse = scipy.sparse.csr_array(new)
    assert np.allclose(fit.predict(sparse, factors=labels), fit.predict(design))
    for call in (fit.prediction_errors, fit.prediction_intervals):
        assert np.array_equal(call(new, factors=labels), call(design))
    # A row without a label has no prediction, the others have theirs.
    some = {**labels, "f": ["c", None, "b", "a"]}
    expected = fit.predict(design)
    expected[1] = np.nan
    assert np.array_equal(fit.predict(new, factors=some), expected, equal_nan=True)


def test_rows_that_a_fit_does_not_know_are_named(rng):
    x, b = rng.standard_normal((9, 2)), rng.standard_normal(9)
    fit = catamaran.lstsq(x, b, factors={"f": list("aabbccabc")})
    for rows, labels, why in [
        (x, None, "a: expected m x 4, got 9 x 2; the labels of f go to factors"),
        (x[:, :1], {"f": list("aabbccabc")}, "a: expected m x 2, got 9 x 1"),
        (x[:1], {"f": ["d"]}, "factors: f: 'd' is not one of 'a', 'b', 'c'"),
        (x[:1], {"g": ["a"]}, "factors: the fit has f, got g"),
        (x[:2], {"f": ["a"]}, "factors: 1 labels for 2 rows"),
    ]:
        with pytest.raises(ValueError, match=why):
            fit.predict(rows, factors=labels)
    with pytest.raises(ValueError, match="a: expected m x 2, got 9 x 3"):
        catamaran.lstsq(x, b).predict(np.ones((9, 3)))
    with pytest.raises(TypeError, match="factors: expected a dict of names and labels, got str"):
        catamaran.lstsq(x, b, factors="f")


def test_a_fit_whose_rows_are_all_left_out_is_an_error():
    with pytest.raises(ValueError, match="^missing: a value is missing in each of 3 rows: none"):
        catamaran.lstsq([[1, np.nan]] * 3, np.ones(3), missing="drop")


def test_an_entry_that_is_not_finite_is_that_of_its_argument(rng):
    a, b = rng.standard_normal((6, 2)), rng.standard_normal(6)
    a[4, 1] = np.nan
    with pytest.raises(ValueError, match="^a: not finite at row 4, column 1: missing=.drop"):
        catamaran.lstsq(a, b)
    for call in (catamaran.pca, catamaran.svd, catamaran.corrcoef):
        with pytest.raises(ValueError, match="^a: not finite at row 4, column 1$"):
            call(a)
    b[3] = np.inf
    with pytest.raises(ValueError, match="^b: not finite at row 3, column 0: missing"):
        catamaran.lstsq(a[:4], b[:4])


def test_what_is_missing_in_a_table_is_that_of_its_argument(rng):
    a, b = rng.standard_normal((6, 2)), rng.standard_normal((6, 2))
    labels = {"f": list("aabbab"), "g": list("ababab")}

    def fit(a, b, g=labels["g"], missing="error"):
        factors = {**labels, "g": g}
        return catamaran.lstsq(a, b, factors=factors, missing=missing, standard_errors=False)

    bad, none = a.copy(), [*"ab", None, *"bab"]
    bad[4, 1] = np.nan
    with pytest.raises(ValueError, match="^a: a value is missing in row 4, column 1: missing=.dr"):
        fit(bad, b)
    with pytest.raises(ValueError, match="^factors: a label of g is missing in row 2: missing=.dr"):
        fit(a, b, none)
    bad = b.copy()
    bad[5, 1] = np.nan
    with pytest.raises(ValueError, match="^b: a value is missing in row 5, column 1: missing=.dr"):
        fit(a, bad)
    assert fit(a, bad, none, missing="drop").left_out == (2, 5)
    bad[5, 1] = np.inf
    with pytest.raises(ValueError, match="^b: not finite at row 5, column 1$"):
        fit(a, bad)
    with pytest.raises(ValueError, match="^b: not finite at row 5, column 1$"):
        catamaran.lstsq(a, bad, missing="drop")
    bad = a.copy()
    bad[3, 0] = -np.inf
    with pytest.raises(ValueError, match="^a: not finite at row 3, column 0$"):
        fit(bad, b)
