"""Checks of products, other BLAS libraries, rows of files."""

import pickle
from pathlib import Path

import numpy as np
import pytest
import scipy
import scipy.sparse

import catamaran

# That of scipy's wheels has 32-bit integers.
LIBRARIES = sorted(Path(scipy.__file__).parents[1].glob("scipy.libs/libscipy_openblas-*.so"))


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_products_pass_and_wrong_ones_do_not(kind, rng):
    a = rng.standard_normal((300, 40)).astype(kind)
    weights = rng.standard_normal(300)
    cases = [
        {},
        {"alpha": 0.25},
        {"uplo": "lower"},
        {"weights": weights},
        {"center": True},
        {"center": a[0]},
    ]
    for options in cases:
        c = catamaran.ata(a, **options)
        found = catamaran.verify(a, c, **options)
        assert found and found.passed and 0 <= found.residual <= found.tolerance, options
        assert found.false_accept_probability == 2.0**-20
        c[7, 3] += 1 + abs(c[7, 3])
        assert not catamaran.verify(a, c, **options), options
    assert catamaran.verify(a, catamaran.ata(a, dtype=np.float64), rounds=3, seed=5)


def test_products_of_other_rows_are_checked(rng):
    dense = rng.standard_normal((80, 12)) * (rng.random((80, 12)) < 0.3)
    sparse = scipy.sparse.csr_array(dense)
    c = catamaran.ata(sparse)
    assert catamaran.verify(sparse, c) and catamaran.verify(dense[::-1], c)
    assert not catamaran.verify(sparse, 2 * c)
    for wrong, match in [
        ({"c": c[:3]}, "C: expected 12 x 12, got 3 x 12"),
        ({"c": c, "rounds": 0}, "rounds"),
        ({"c": c, "uplo": "x"}, "uplo: 'x' is not one of"),
        ({"c": c, "center": "median"}, "center: 'median' is not one of"),
        ({"c": c, "weights": np.ones(3)}, "weights: expected 80 x 1, got 3 x 1"),
    ]:
        with pytest.raises(ValueError, match=match):
            catamaran.verify(dense, **wrong)
    dense[5, 2] = np.nan
    with pytest.raises(ValueError, match="not finite at row 5"):
        catamaran.verify(dense, c)


def test_another_blas_computes_the_leaves(rng):
    if not LIBRARIES:
        pytest.skip("scipy comes without OpenBLAS")
    a = rng.standard_normal((400, 90))
    c = catamaran.ata(a, backend=LIBRARIES[0])
    assert np.allclose(c, a.T @ a) and catamaran.verify(a, c)
    assert np.allclose(catamaran.ata(a, a[:, :5], backend=str(LIBRARIES[0])), a.T @ a[:, :5])
    plan = catamaran.plan(5000, 400, backend=LIBRARIES[0])
    assert repr(pickle.loads(pickle.dumps(plan))) == repr(plan)


def test_a_blas_that_is_none_is_named(tmp_path):
    a = np.eye(3)
    with pytest.raises(RuntimeError, match="libnowhere.so"):
        catamaran.ata(a, backend=tmp_path / "libnowhere.so")
    with pytest.raises(TypeError):
        catamaran.ata(a, backend=3)


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_rows_of_a_file_are_added(kind, tmp_path, rng):
    a = rng.standard_normal((5000, 6)).astype(kind)
    path, weights = tmp_path / "a.npy", rng.random(5000)
    for stored in (a, np.asfortranarray(a), a.astype(">f8")):
        np.save(path, stored)
        sums, right = catamaran.Accumulator(6, center=True), catamaran.Accumulator(6, center=True)
        sums.add_file(path)
        sums.add_file(str(path), weights)
        right.add(a)
        right.add(a, weights)
        assert sums.rows == 10_000 and np.isclose(sums.weight, right.weight)
        assert np.allclose(sums.result(), right.result()) and np.allclose(sums.mean, right.mean)
    single = catamaran.Accumulator(6, dtype=np.float32)
    single.add_file(path)
    assert np.allclose(single.result(), a.T @ a, rtol=1e-4, atol=0.05)


def test_files_that_do_not_fit_leave_the_sums_as_they_were(tmp_path):
    sums = catamaran.Accumulator(3)
    sums.add(np.eye(3))
    np.save(tmp_path / "wide.npy", np.ones((4, 5)))
    np.save(tmp_path / "words.npy", np.array([["u", "v", "w"]]))
    (tmp_path / "text.npy").write_text("1 2 3\n")
    with pytest.raises(FileNotFoundError, match="none.npy"):
        sums.add_file(tmp_path / "none.npy")
    with pytest.raises(ValueError, match="rows: expected 3 columns, got 5"):
        sums.add_file(tmp_path / "wide.npy")
    for name in ("words.npy", "text.npy"):
        with pytest.raises(OSError, match=name):
            sums.add_file(tmp_path / name)
    np.save(tmp_path / "a.npy", np.ones((4, 3)))
    with pytest.raises(ValueError, match="weights: expected 4 of them, got 2"):
        sums.add_file(tmp_path / "a.npy", [1.0, 2.0])
    assert np.array_equal(sums.result(), np.eye(3)) and sums.rows == 3
