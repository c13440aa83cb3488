"""Results go through pickles, and so to other processes and into caches on disk."""

import pickle

import numpy as np
import pytest

import catamaran
from catamaran import shapes


def again(result):
    return pickle.loads(pickle.dumps(result))


def test_principal_components(rng):
    a = rng.standard_normal((40, 5))
    for whiten in (False, True):
        found = catamaran.pca(a, 3, whiten=whiten)
        copy = again(found)
        assert np.array_equal(copy.transform(a), found.transform(a))
        assert np.array_equal(copy.singular_values, found.singular_values) and copy.whiten == whiten
        # The rows of these scores are the nearest ones in the space of the components.
        rows = copy.inverse_transform(copy.transform(a))
        assert np.allclose(copy.transform(rows), copy.transform(a))
        across = (a - rows) @ found.components.T
        assert np.allclose(across, 0, atol=1e-12)


def test_bases_of_eigenfunctions():
    v, f = shapes.icosphere(2)
    basis = catamaran.Eigenbasis(v, f, 7)
    copy = again(basis)
    assert isinstance(copy, catamaran.Eigenbasis) and len(copy) == 7
    assert np.array_equal(copy.values, basis.values)
    assert np.array_equal(copy.functions, basis.functions)
    assert (copy.mass != basis.mass).nnz == 0
    expected = catamaran.transfer(basis, basis, v, k=6)
    assert np.array_equal(catamaran.transfer(copy, copy, v, k=6), expected)
    # Too few functions for two components are refused, before and after.
    two = np.vstack([v, v + 5]), np.vstack([f, f + len(v)])
    with pytest.warns(UserWarning, match="2 components"):
        basis = catamaran.Eigenbasis(*two, 6)
    for each in (basis, again(basis)):
        with pytest.raises(ValueError, match="2 components, each with a constant function"):
            catamaran.transfer(each, each, two[0], k=0)


def test_plans_are_made_again():
    for plan in (
        catamaran.plan(5000, 400, reproducible=True),
        catamaran.plan(700, 80, 9, dtype=np.float32, uplo="lower", accuracy=8.0, threads=1),
    ):
        copy = again(plan)
        assert repr(copy) == repr(plan) and copy.isa == plan.isa and copy.scheme == plan.scheme


def test_plants_and_their_wilting():
    plant = catamaran.grow_plant(80, seed=3)
    copy = again(plant)
    for name in ("tails", "radii", "parents", "leaves", "base"):
        assert np.array_equal(getattr(copy, name), getattr(plant, name)), name
    found, expected = catamaran.wilt(copy, 6.0, frames=2), catamaran.wilt(plant, 6.0, frames=2)
    assert np.array_equal(found.tails, expected.tails)
    for one, other in zip(again(expected).mesh(2), expected.mesh(2)):
        assert np.array_equal(one, other)


def test_tables_of_results(rng):
    a = rng.standard_normal((30, 3))
    v, f = shapes.icosphere(1)
    fit = again(catamaran.lstsq(a, a[:, 0], intercept=True))
    assert np.allclose(fit.x, [1, 0, 0]) and fit.covariance().shape == (4, 4)
    for result in (
        catamaran.svd(a),
        catamaran.eigsh(v, f, 3),
        catamaran.decimate(v, f, 20),
        catamaran.curve(v, f, [0, 1, 2]),
        catamaran.farthest_points(v, f, 3, return_cells=True),
        catamaran.newton(size=4),
        v,
    ):
        assert type(again(result)) is type(result)


def test_joblib_keeps_results(tmp_path):
    joblib = pytest.importorskip("joblib")
    calls = []

    def components(a):
        calls.append(len(a))
        return catamaran.pca(a, 1)

    kept = joblib.Memory(tmp_path, verbose=0).cache(components)
    a = np.arange(12.0).reshape(6, 2)
    first, second = kept(a), kept(a)
    assert calls == [6] and np.array_equal(first.components, second.components)
