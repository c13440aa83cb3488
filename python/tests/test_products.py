"""A^T A and A^T B beside numpy, for all kinds of arrays."""

import numpy as np
import pytest
import scipy.sparse

import catamaran

SIZES = [(0, 0), (0, 3), (3, 0), (1, 1), (7, 5), (128, 127), (257, 64), (40, 300)]


def close(found, expected, a, dtype=np.float64):
    """Whether errors are within the bound of the library, 4 m u |a_i| |a_j|."""
    assert found.dtype == expected.dtype, (found.dtype, expected.dtype)
    wide = np.complex128 if np.iscomplexobj(a) else np.float64
    norms = np.linalg.norm(np.asarray(a, dtype=wide), axis=0)
    unit = np.finfo(found.dtype).eps / 2
    bound = 16 * max(len(a), 1) * unit * np.outer(norms, norms) + np.finfo(found.dtype).tiny
    assert found.shape == expected.shape
    assert np.all(np.abs(found - expected) <= bound)


@pytest.mark.parametrize("shape", SIZES)
@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.complex128, np.complex64])
def test_ata_is_that_of_numpy(rng, shape, dtype):
    a = rng.standard_normal(shape)
    if np.issubdtype(dtype, np.complexfloating):
        a = a + 1j * rng.standard_normal(shape)
    a = a.astype(dtype)
    found = catamaran.ata(a)
    wide = np.complex128 if np.iscomplexobj(a) else np.float64
    close(found, (a.astype(wide).conj().T @ a.astype(wide)).astype(dtype), a)
    assert np.array_equal(found, found.conj().T)


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.complex128, np.complex64])
def test_atb_is_that_of_numpy(rng, dtype):
    for m, n, k in [(0, 2, 3), (5, 0, 2), (33, 17, 5), (200, 30, 40)]:
        a, b = rng.standard_normal((m, n)).astype(dtype), rng.standard_normal((m, k)).astype(dtype)
        expected = a.conj().T @ b
        found = catamaran.ata(a, b)
        assert found.dtype == dtype
        tolerance = 1e-4 if np.dtype(dtype).itemsize <= 4 or dtype == np.complex64 else 1e-12
        assert np.allclose(found, expected, atol=tolerance)


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.int32])
def test_products_of_a_stack_have_the_bytes_of_single_ones(rng, dtype):
    for count, m, n in [(0, 3, 2), (1, 5, 3), (40, 0, 3), (40, 3, 0), (40, 13, 7), (3, 200, 90)]:
        a = (100 * rng.standard_normal((count, m, n))).astype(dtype)
        for stack in (a, a[::-1], np.asfortranarray(a)):
            found = catamaran.ata(stack, alpha=0.5, uplo="lower")
            assert found.shape == (count, n, n)
            for one, matrix in zip(found, stack):
                assert np.array_equal(one, catamaran.ata(matrix, alpha=0.5, uplo="lower"))


def test_any_strides_give_the_same_bytes(rng):
    big = rng.standard_normal((60, 40))
    views = [
        big,
        np.asfortranarray(big),
        big[::-1],
        big[:, ::-1],
        big[::-2, 1::3],
        big.T,
        big.T[::-1],
    ]
    views += [np.broadcast_to(big[:1], (9, 40)), np.broadcast_to(big[:, :1], (60, 9))]
    for view in views:
        plain = np.array(view)
        assert np.allclose(catamaran.ata(view), plain.T @ plain, atol=1e-12)
    read_only = big.copy()
    read_only.flags.writeable = False
    assert np.array_equal(catamaran.ata(read_only), catamaran.ata(big))


def test_unaligned_and_foreign_numbers_are_converted(rng):
    a = rng.standard_normal((20, 4))
    record = np.zeros(20, dtype=[("flag", "i1"), ("row", "f8", 4)])
    record["row"] = a
    expected = catamaran.ata(a)
    assert np.array_equal(catamaran.ata(record["row"]), expected)
    assert np.array_equal(catamaran.ata(a.astype(">f8")), expected)
    whole = np.arange(12).reshape(4, 3)
    for kind in (np.int8, np.int32, np.int64, np.uint16, bool):
        part = whole.astype(kind)
        assert np.array_equal(catamaran.ata(part), part.astype(float).T @ part.astype(float))
    assert catamaran.ata(a.astype(np.float16)).dtype == np.float32
    assert np.array_equal(catamaran.ata([[1, 2], [3, 4]]), [[10, 14], [14, 20]])


def test_triangles_alpha_and_beta(rng):
    a = rng.standard_normal((30, 6))
    full = catamaran.ata(a)
    assert np.array_equal(catamaran.ata(a, uplo="lower"), np.tril(full))
    assert np.array_equal(catamaran.ata(a, uplo="upper"), np.triu(full))
    c = rng.standard_normal((6, 6))
    c = c + c.T
    out = c.copy()
    assert catamaran.ata(a, out=out, alpha=-2.0, beta=0.5) is out
    assert np.allclose(out, -2 * a.T @ a + 0.5 * c)
    # Only what is wanted is written.
    out = np.full((6, 6), np.nan)
    catamaran.ata(a, out=out, uplo="lower")
    assert np.isnan(out[np.triu_indices(6, 1)]).all() and not np.isnan(np.tril(out)).any()


def test_out_of_any_strides(rng):
    a = rng.standard_normal((30, 6))
    memory = np.zeros((12, 18))
    for out in (memory[::2, ::3], memory[:6, :6].T, memory[5::-1, 5::-1]):
        catamaran.ata(a, out=out)
        assert np.array_equal(out, catamaran.ata(a))


def test_out_in_a_disjoint_part_of_a_buffer(rng):
    buffer = rng.standard_normal((9, 16))
    a, out = buffer[:, ::2][:, :6], buffer[:6, 1::2][:, :6]
    before = buffer.copy()
    expected = catamaran.ata(a.copy())
    assert catamaran.ata(a, out=out) is out and np.array_equal(out, expected)
    out[...] = before[:6, 1::2][:, :6]
    # Nothing between the entries is written.
    assert np.array_equal(buffer, before)
    halves = rng.standard_normal((8, 8))
    expected = halves[:, :4].T @ halves[:, :4]
    assert np.allclose(catamaran.ata(halves[:, :4], out=halves[:4, 4:]), expected)
    # One element in common is enough.
    with pytest.raises(ValueError, match="out: shares memory"):
        catamaran.ata(halves[:, :4], out=halves[4:, 3:7])


def test_weights_and_centres(rng):
    a, w = rng.standard_normal((300, 7)) + 5, rng.uniform(0.1, 2, 300)
    assert np.allclose(catamaran.ata(a, weights=w), a.T @ (w[:, None] * a))
    x = a - a.mean(axis=0)
    assert np.allclose(catamaran.ata(a, center=True), x.T @ x)
    x = a - (w @ a) / w.sum()
    assert np.allclose(catamaran.ata(a, weights=w, center="mean"), x.T @ (w[:, None] * x))
    row = rng.standard_normal(7)
    assert np.allclose(catamaran.ata(a, center=row), (a - row).T @ (a - row))
    assert np.allclose(catamaran.ata(a, weights=w[::-1]), a.T @ (w[::-1, None] * a))
    wide = catamaran.ata(a.astype(np.float32), dtype=np.float64)
    rounded = a.astype(np.float32).astype(float)
    assert wide.dtype == np.float64 and np.allclose(wide, rounded.T @ rounded, rtol=1e-14)


def test_sparse_is_dense(rng):
    a = scipy.sparse.random(200, 30, density=0.05, random_state=1)
    dense = a.toarray()
    for form in (a.tocsr(), a.tocsc(), a.tocoo()):
        assert np.allclose(catamaran.ata(form), dense.T @ dense)
    w = rng.uniform(size=200)
    assert np.allclose(catamaran.ata(a.tocsr(), weights=w), dense.T @ (w[:, None] * dense))
    row = rng.standard_normal(30)
    for center in (True, row):
        for weights in (None, w):
            expected = catamaran.ata(dense, weights=weights, center=center)
            found = catamaran.ata(a, weights=weights, center=center)
            assert np.allclose(found, expected, rtol=1e-14)


def test_rows_of_sparse_matrices_are_those_of_dense_ones(rng):
    a = scipy.sparse.random(300, 12, density=0.2, random_state=2, format="csc")
    dense, b, w = a.toarray(), rng.standard_normal(300), rng.uniform(1, 2, 300)
    assert np.array_equal(catamaran.lstsq(a, b).x, catamaran.lstsq(dense, b).x)
    fit, expected = (catamaran.lstsq(x, b, weights=w, intercept=True) for x in (a, dense))
    assert np.array_equal(fit.x, expected.x) and np.allclose(fit.predict(a), fit.predict(dense))
    factors = {"g": ["x", "y", "z"] * 100}
    found = [catamaran.lstsq(x, b, factors=factors).x for x in (a, dense)]
    assert np.array_equal(*found)
    pcs, expected = catamaran.pca(a, 3), catamaran.pca(dense, 3)
    assert np.array_equal(pcs.components, expected.components)
    assert np.array_equal(pcs.transform(a), expected.transform(dense))
    assert np.allclose(catamaran.cov(a), np.cov(dense, rowvar=False), rtol=1e-12)
    assert np.allclose(
        catamaran.cov(a.T, rowvar=True, aweights=w), catamaran.cov(dense, aweights=w)
    )
    assert np.array_equal(catamaran.corrcoef(a), catamaran.corrcoef(dense))
    u, s, vh = catamaran.svd(a, compute_u=True)
    assert np.allclose(u @ np.diag(s) @ vh, dense)
    q, r = catamaran.qr(a)
    assert np.allclose(q @ r, dense) and catamaran.orthogonality(q)[1] < 1e-12
    # Four rows of two numbers are no sparse matrix.
    rows = ((1.0, 2.0), (3.0, 4.0), (5.0, 6.0), (7, 8))
    assert np.array_equal(catamaran.svd(rows).s, catamaran.svd(np.array(rows)).s)


def test_results_do_not_depend_on_threads(rng):
    a = rng.standard_normal((700, 300))
    expected = catamaran.ata(a, threads=1)
    for threads in (2, 3, None):
        assert np.array_equal(catamaran.ata(a, threads=threads), expected)
    exact = catamaran.ata(a, reproducible=True)
    # Of the order of the rows neither, as long as bounds of columns decide.
    assert np.array_equal(
        catamaran.ata(a, weights=np.ones(700), reproducible=True),
        catamaran.ata(a[::-1], weights=np.ones(700), reproducible=True),
    )
    assert np.allclose(exact, expected)


@pytest.mark.parametrize(
    "scheme", ["auto", "float", "classical", "ata2", "winograd", "rxtx", "kgp", "kgp3", "exact"]
)
def test_schemes(rng, scheme):
    a = rng.standard_normal((400, 200))
    assert np.allclose(catamaran.ata(a, scheme=scheme), a.T @ a, atol=1e-10)


def test_accuracy(rng):
    a = rng.standard_normal((100, 20))
    for accuracy in ("default", "max", "classical", "fast", 8.0, 8):
        assert np.allclose(catamaran.ata(a, accuracy=accuracy), a.T @ a)


def test_covariance_is_that_of_numpy(rng):
    x = rng.standard_normal((50, 4)) + 3
    f, w = rng.integers(1, 5, 50), rng.uniform(0.5, 2, 50)
    for ddof in (0, 1):
        for more in ({}, {"fweights": f}, {"aweights": w}, {"fweights": f, "aweights": w}):
            expected = np.cov(x, rowvar=False, ddof=ddof, **more)
            assert np.allclose(catamaran.cov(x, ddof=ddof, **more), expected, rtol=1e-12)
    assert np.allclose(catamaran.cov(x.T, rowvar=True), np.cov(x.T))
    assert np.allclose(catamaran.corrcoef(x), np.corrcoef(x, rowvar=False))
    assert np.allclose(catamaran.corrcoef(x.T, rowvar=True), np.corrcoef(x.T))


def test_plans_say_what_runs():
    found = catamaran.plan(5000, 400, reproducible=True)
    assert found.is_exact and found.scheme == "exact" and found.isa
    assert "A 5000 x 400" in repr(found)
    assert "A^T B" in repr(catamaran.plan(500, 40, 30, dtype=np.float32))


def test_forked_processes_have_threads_of_their_own(rng):
    import multiprocessing

    a = rng.standard_normal((900, 400))
    expected = catamaran.ata(a, threads=2)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        found = pool.map_async(catamaran.ata, [a, a]).get(timeout=60)
    assert all(np.array_equal(c, expected) for c in found)
