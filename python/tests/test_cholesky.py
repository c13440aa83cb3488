"""Sparse Cholesky factorizations: solutions, selected rows, other values, refusals."""

import numpy as np
import pytest
from scipy import sparse

import catamaran


def grid(side):
    """The Laplacian of a square grid."""
    path = sparse.diags(
        [[-1.0] * (side - 1), [1.0] + [2.0] * (side - 2) + [1.0], [-1.0] * (side - 1)],
        [-1, 0, 1],
    )
    one = sparse.eye(side)
    return (sparse.kron(path, one) + sparse.kron(one, path)).tocsr()


@pytest.mark.parametrize("kind", ["csr", "csc", "coo"])
def test_solutions_satisfy_their_equations(rng, kind):
    a = (grid(23) + sparse.eye(23 * 23)).asformat(kind)
    factors = catamaran.cholesky(a)
    assert factors.shape == (529, 529) and factors.entries >= 529 and len(factors.held) == 0
    for shape in [(529,), (529, 1), (529, 11), (529, 0)]:
        b = rng.standard_normal(shape)
        x = factors.solve(b)
        assert x.shape == shape
        assert np.allclose(a @ x, b, atol=1e-12)
    assert np.array_equal(factors.solve(np.asfortranarray(b)), x)
    assert "529 x 529" in repr(factors)
    assert 0 < factors.weakest[1] <= 1 + 1e-12


def test_triangles_and_threads_change_nothing(rng):
    a, b = grid(17) + sparse.eye(289), rng.standard_normal((289, 3))
    expected = catamaran.cholesky(a, threads=1).solve(b)
    assert np.array_equal(catamaran.cholesky(a, threads=3).solve(b), expected)
    lower, upper = sparse.tril(a), sparse.triu(a)
    assert np.array_equal(catamaran.cholesky(lower, triangle="lower").solve(b), expected)
    assert np.array_equal(catamaran.cholesky(upper, triangle="upper").solve(b), expected)


def test_any_order_has_the_same_solution(rng):
    a, b = grid(17) + sparse.eye(289), rng.standard_normal(289)
    expected = catamaran.cholesky(a).solve(b)
    factors = catamaran.cholesky(a, order=rng.permutation(289))
    assert np.allclose(factors.solve(b), expected, atol=1e-12)
    assert factors.entries > catamaran.cholesky(a).entries
    with pytest.raises(ValueError, match="order: must have every row once, but entry 1 is 0"):
        catamaran.cholesky(a, order=np.zeros(289, dtype=int))


def test_selected_rows_are_those_of_all(rng):
    factors = catamaran.cholesky(grid(17), semidefinite=True)
    b = rng.standard_normal((289, 9))
    b -= b.mean(axis=0)
    x = factors.solve(b)
    rows = np.array([288, 3, 3, factors.held[0]])
    assert np.array_equal(factors.solve(b, rows=rows), x[rows])
    assert np.array_equal(factors.solve(b[:, 0], rows=[7]), x[[7], 0])
    assert np.allclose(grid(17) @ x, b, atol=1e-11)
    assert (x[factors.held] == 0).all()


def test_other_values_in_the_same_places(rng):
    a, b = grid(13) + sparse.eye(169), rng.standard_normal(169)
    factors = catamaran.cholesky(a)
    expected = factors.solve(b)
    with pytest.raises(ValueError, match=r"A: not positive definite \(elimination fails at row"):
        factors.refactor(-a)
    with pytest.raises(ValueError, match="A: not factorized"):
        factors.solve(b)
    factors.refactor(2 * a)
    assert np.allclose(2 * factors.solve(b), expected)
    factors.refactor(a)
    assert np.array_equal(factors.solve(b), expected)
    corners = sparse.coo_matrix(([1.0, 1.0], ([0, 168], [168, 0])), a.shape)
    with pytest.raises(ValueError, match="is not in the pattern that was analysed"):
        factors.refactor(a + corners)


def test_arguments_at_fault_are_named():
    a = grid(5) + sparse.eye(25)
    with pytest.raises(TypeError, match="a: expected a matrix of scipy.sparse"):
        catamaran.cholesky(np.eye(3))
    with pytest.raises(TypeError, match="a: complex"):
        catamaran.cholesky(1j * a)
    with pytest.raises(ValueError, match="triangle: 'left' is not one of"):
        catamaran.cholesky(a, triangle="left")
    with pytest.raises(ValueError, match="tolerance: must be from 0 to 0.01"):
        catamaran.cholesky(a, tolerance=1.0)
    with pytest.raises(ValueError, match="A: not symmetric"):
        catamaran.cholesky(sparse.tril(a))
    with pytest.raises(ValueError, match="A: expected 5 x 5, got 5 x 25"):
        catamaran.cholesky(a.tocsr()[:5])
    with pytest.raises(ValueError, match="A: not positive definite .*semidefinite"):
        catamaran.cholesky(sparse.csr_array(np.array([[1.0, -1.0], [-1.0, 1.0]])))
    factors = catamaran.cholesky(a)
    with pytest.raises(ValueError, match="B: expected 25 x 1, got 24 x 1"):
        factors.solve(np.ones(24))
    with pytest.raises(ValueError, match="rows: row 25 is out of range"):
        factors.solve(np.ones(25), rows=[25])
    with pytest.raises(ValueError, match="rows: -1 is not the number of a row"):
        factors.solve(np.ones(25), rows=[-1])
    with pytest.raises(ValueError, match="B: not finite at row 3, column 0"):
        factors.solve(np.where(np.arange(25) == 3, np.nan, 1.0))


def test_progress_is_told_and_may_stop():
    told = []
    a = grid(40) + sparse.eye(1600)
    factors = catamaran.cholesky(a, progress=lambda done, total: told.append((done, total)))
    assert told[-1] == (1000, 1000)
    factors.refactor(a, progress=lambda done, total: told.append((done, total)))
    factors.solve(np.ones(1600), progress=lambda done, total: told.append((done, total)))
    assert told[-1] == (1000, 1000)

    def stop(done, total):
        raise KeyError("enough")

    with pytest.raises(KeyError):
        catamaran.cholesky(a, progress=stop)
