"""Sums over rows in blocks."""

import copy
import os
import pickle
import threading

import numpy as np
import pytest

import catamaran


def exact(columns, kind="exact", **more):
    bounds = (np.full(columns, -10.0), np.full(columns, 10.0), 10_000)
    return catamaran.Accumulator(columns, kind=kind, bounds=bounds, **more)


def test_blocks_are_the_whole(rng):
    a = rng.standard_normal((1000, 8))
    sums = catamaran.Accumulator(8)
    for block in np.array_split(a, 7):
        sums.add(block)
    assert sums.rows == 1000 and sums.weight == 1000.0
    assert np.allclose(sums.result(), a.T @ a)
    assert np.allclose(sums.result(alpha=2.0, uplo="lower"), 2 * np.tril(a.T @ a))
    sums.add(a.astype(np.float32))
    assert sums.rows == 2000


def test_float32(rng):
    a = rng.standard_normal((100, 3)).astype(np.float32)
    sums = catamaran.Accumulator(3, dtype=np.float32)
    sums.add(a[::-1])
    assert sums.result().dtype == np.float32 and np.allclose(sums.result(), a.T @ a, atol=1e-3)


def test_centre_and_weights(rng):
    a, w = rng.standard_normal((200, 4)) + 2, rng.uniform(0.5, 1.5, 200)
    sums = catamaran.Accumulator(4, center=True)
    sums.add(a)
    assert np.allclose(sums.mean, a.mean(axis=0)) and np.allclose(
        sums.cov(), np.cov(a, rowvar=False)
    )
    sums = catamaran.Accumulator(4, center=True)
    sums.add(a[:50], w[:50])
    sums.add(a[50:], w[50:])
    x = a - (w @ a) / w.sum()
    assert np.allclose(sums.result(), x.T @ (w[:, None] * x))


@pytest.mark.parametrize("kind", ["exact", "extended"])
def test_exact_sums_know_no_order_and_forget(rng, kind):
    a = rng.standard_normal((500, 5))
    one, other, less = exact(5, kind), exact(5, kind), exact(5, kind)
    one.add(a)
    for block in np.array_split(a[::-1], 9):
        other.add(block)
    assert np.array_equal(one.result(), other.result())
    one.remove(a[100:])
    less.add(a[:100])
    assert np.array_equal(one.result(), less.result()) and one.rows == 100
    other.merge(one)
    assert other.rows == 600 and one.rows == 100
    other.merge(other)
    assert other.rows == 1200


def test_files_pickles_and_copies(rng, tmp_path):
    a = rng.standard_normal((60, 4))
    sums = exact(4)
    sums.add(a)
    path = tmp_path / "sums"
    sums.save(path)
    for again in (
        catamaran.Accumulator.load(path),
        pickle.loads(pickle.dumps(sums)),
        copy.copy(sums),
    ):
        assert np.array_equal(again.result(), sums.result())
        again.add(a)
        assert again.rows == 120 and sums.rows == 60
    with pytest.raises(FileNotFoundError, match="nowhere"):
        catamaran.Accumulator.load(tmp_path / "nowhere")
    path.write_bytes(path.read_bytes()[:-3])
    with pytest.raises(OSError, match="sums"):
        catamaran.Accumulator.load(path)


def test_least_squares_and_components_of_extended_sums(rng):
    a = rng.standard_normal((300, 4))
    b = a @ [1.0, 2.0, 3.0, 4.0] + 7
    sums = exact(5, "extended", center=True)
    rows = np.column_stack([a, b / 10])
    sums.add(rows)
    found = sums.lstsq(1, intercept=True)
    assert np.allclose(found.x[:, 0] * 10, [1, 2, 3, 4]) and np.allclose(found.intercept * 10, 7)
    assert np.allclose(sums.pca(2).components, catamaran.pca(rows, 2).components)
    parts, is_exact = sums.extended()
    assert len(parts) == 3 and is_exact in (True, False)


def test_errors(rng):
    sums = exact(3)
    with pytest.raises(ValueError, match="rows: expected 3 columns, got 2"):
        sums.add(np.zeros((4, 2)))
    with pytest.raises(ValueError, match="bound"):
        sums.add(np.full((1, 3), 11.0))
    sums.add(np.ones((1, 3)))  # of use still
    with pytest.raises(ValueError):
        sums.remove(np.ones((5, 3)))
    with pytest.raises(ValueError, match="exact"):
        catamaran.Accumulator(3).remove(np.ones((1, 3)))
    with pytest.raises(ValueError, match="float32 and float64"):
        sums.merge(catamaran.Accumulator(3, dtype=np.float32))
    with pytest.raises(ValueError, match="bounds: exact sums need them"):
        catamaran.Accumulator(3, kind="exact")
    with pytest.raises(ValueError, match="largest_weight: applies to sums with bounds"):
        catamaran.Accumulator(3, largest_weight=2.0)
    with pytest.raises(ValueError, match="'nice' is not one of"):
        catamaran.Accumulator(3, kind="nice")
    with pytest.raises(ValueError, match="no extended precision"):
        sums.lstsq()


@pytest.mark.parametrize("kind", ["float", "exact", "extended"])
def test_a_merge_that_is_refused_changes_nothing(rng, kind):
    a = rng.integers(-9, 9, (30, 3)).astype(float)
    sums = catamaran.Accumulator(3) if kind == "float" else exact(3, kind)
    sums.add(a[:20])
    others = [
        (catamaran.Accumulator(2), "columns: 3 and 2"),
        (catamaran.Accumulator(3, center=True), "centring: "),
        (exact(3, "extended" if kind == "exact" else "exact"), "sums: "),
    ]
    if kind == "exact":
        ends = np.array([10.0, 10.0, 1e30])
        far = catamaran.Accumulator(3, kind=kind, bounds=(-ends, ends, 9))
        far.add(ends[None])
        others.append((far, "column 2: the grids are too far apart"))
    for other, why in others:
        with pytest.raises(ValueError, match=f"^accumulator: {why}"):
            sums.merge(other)
    assert sums.rows == 20 and np.array_equal(sums.result(), a[:20].T @ a[:20])
    sums.add(a[20:])
    sums.merge(sums)
    assert sums.rows == 60 and np.array_equal(sums.result(), 2 * a.T @ a)


def test_a_file_that_can_not_be_read_leaves_the_sums_as_they_were(tmp_path):
    a = np.arange(120.0).reshape(60, 2)
    path = tmp_path / "a.npy"
    np.save(path, a)

    class Weights:
        """Weights that cut the file, which is open when they are read."""

        def __array__(self, dtype=None, copy=None):
            os.truncate(path, path.stat().st_size - 8)
            return np.ones(60)

    sums = catamaran.Accumulator(2)
    sums.add(a[:3])
    with pytest.raises(OSError, match="truncated: it shrank"):
        sums.add_file(path, Weights())
    sums.add(a[3:])
    assert sums.rows == 60 and np.array_equal(sums.result(), a.T @ a)


def together(*calls):
    """Runs the calls at once and raises the error of one that fails."""
    errors, start = [], threading.Barrier(len(calls))

    def work(call):
        start.wait()
        try:
            call()
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=work, args=(call,)) for call in calls]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if errors:
        raise errors[0]


@pytest.mark.parametrize("kind", ["float", "exact"])
def test_threads_that_add_to_one_accumulator_lose_no_rows(rng, kind):
    a = rng.integers(-9, 9, (4, 20, 500, 60)).astype(float)
    more = {"bounds": (np.full(60, -10.0), np.full(60, 10.0), 10**6)} if kind == "exact" else {}
    sums = catamaran.Accumulator(60, kind=kind, **more)

    def add(blocks):
        for block in blocks:
            sums.add(block)

    together(*(lambda blocks=blocks: add(blocks) for blocks in a))
    flat = a.reshape(-1, 60)
    assert sums.rows == len(flat) and np.array_equal(sums.result(), flat.T @ flat)


def test_every_call_waits_for_those_of_other_threads(rng, tmp_path):
    a = rng.integers(-9, 9, (3000, 40)).astype(float)
    one, other = (exact(40, "extended", center=True) for _ in range(2))
    one.add(a)
    other.add(a)

    def read():
        for _ in range(5):
            assert one.rows % 3000 == 0 and one.weight == one.rows and len(one.mean) == 40
            assert "rows of 40" in repr(one)
            before = pickle.loads(pickle.dumps(one))
            assert np.array_equal(before.cov(), one.cov())
            one.save(tmp_path / f"sums{threading.get_ident()}")
            assert len(one.pca(2).components) == 2

    def change():
        for _ in range(5):
            one.add(a[:1500])
            one.remove(a[:1500])

    def read_changing():
        for _ in range(5):
            assert np.isfinite(one.cov()).all() and len(one.mean) == 40
            assert "rows of 40" in repr(one)
            assert pickle.loads(pickle.dumps(one)).rows in (3000, 4500)

    together(read, read)
    together(change, read_changing)
    # Merges in a circle, which would wait for each other with two locks.
    small = [catamaran.Accumulator(2) for _ in range(2)]
    for sums in small:
        sums.add(np.ones((1, 2)))
    together(
        lambda: [small[0].merge(small[1]) for _ in range(20)],
        lambda: [small[1].merge(small[0]) for _ in range(20)],
    )
    small[0].merge(small[0])
    together(change, change)
    assert one.rows == 3000 and np.array_equal(one.result(), other.result())


def test_a_callback_that_uses_the_accumulator_of_its_call_is_refused(rng):
    sums = catamaran.Accumulator(200)
    with pytest.raises(RuntimeError, match="in use by the call"):
        sums.add(rng.standard_normal((5000, 200)), progress=lambda done, total: sums.rows)
    assert sums.columns == 200


@pytest.mark.parametrize("kind", ["float", "exact"])
def test_components_of_sums_in_float64(rng, kind):
    a = rng.standard_normal((200, 4)) @ rng.standard_normal((4, 6))
    bounds = {"bounds": (np.full(6, -99.0), np.full(6, 99.0), 999)} if kind == "exact" else {}
    sums = catamaran.Accumulator(6, center=True, kind=kind, **bounds)
    for block in np.array_split(a, 3):
        sums.add(block)
    found, expected = sums.pca(), catamaran.pca(a, 4)
    # The rank, without components of rounding.
    assert found.components.shape == (4, 6)
    assert np.allclose(found.explained_variance, expected.explained_variance, rtol=1e-10)
    assert np.allclose(np.abs(found.components), np.abs(expected.components), atol=1e-7)
    with pytest.raises(ValueError, match="about the mean"):
        catamaran.Accumulator(6).pca()
    sums = catamaran.Accumulator(6, center=True)
    sums.add(a, np.full(200, 2.0))
    with pytest.raises(ValueError, match="weighted rows need extended sums"):
        sums.pca()
