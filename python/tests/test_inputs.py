"""What does not fit is an exception with the sentence of the library; nothing crashes."""

import numpy as np
import pytest

import catamaran
from catamaran import shapes

A = np.arange(12.0).reshape(4, 3)
#: A buffer with a result and vectors of the same memory.
BUFFER = np.ones(12)
SQUARE = BUFFER[:9].reshape(3, 3)
V, F = shapes.icosphere(1)


def refused(error, match, function, *arguments, **options):
    with pytest.raises(error, match=match or None):
        function(*arguments, **options)


@pytest.mark.parametrize(
    ("a", "error", "match"),
    [
        (A.ravel(), ValueError, "a: expected an array of 2 dimensions, got 1"),
        (A[None, None], ValueError, "a: expected an array of 2 dimensions, got 4"),
        (3.0, ValueError, "a: expected an array of 2 dimensions, got 0"),
        (np.array([["x"]]), TypeError, "a: .* can't be converted to float64"),
        (np.array([[object()]]), TypeError, "a: object can't be converted to float64"),
        (A.astype(np.longdouble), TypeError, "a: .* can't be converted to float64"),
        (None, ValueError, "a: expected an array of 2 dimensions, got 0"),
    ],
)
def test_wrong_matrices(a, error, match):
    refused(error, match, catamaran.ata, a)


@pytest.mark.parametrize("options", [{"b": A}, {"weights": np.ones(4)}, {"center": True}])
def test_what_a_stack_of_matrices_does_not_take(options):
    match = "a: expected an array of 2 dimensions, got 3"
    refused(ValueError, match, catamaran.ata, A[None], **options)
    refused(ValueError, "out: not with a stack", catamaran.ata, A[None], out=SQUARE[None])
    refused(ValueError, match, catamaran.ata, A[None] + 1j)


@pytest.mark.parametrize(
    ("options", "error", "match"),
    [
        ({"uplo": "up"}, ValueError, "uplo: 'up' is not one of 'both', 'lower', 'upper'"),
        ({"scheme": "x"}, ValueError, "scheme: 'x' is not one of 'auto'"),
        ({"scheme": "winograd", "reproducible": True}, ValueError, "scheme: only the exact scheme"),
        ({"accuracy": "x"}, ValueError, "accuracy: 'x' is not one of"),
        ({"accuracy": 0.5}, ValueError, "accuracy: the error factor must be finite and at least 1"),
        ({"accuracy": []}, TypeError, "accuracy: expected a word or a number"),
        ({"threads": 0}, ValueError, "threads: must be at least 1"),
        ({"threads": -1}, ValueError, "threads: must be at least 1"),
        ({"threads": "x"}, TypeError, "threads: 'str' object"),
        ({"threads": 2.5}, TypeError, "threads: 'float' object"),
        ({"threads": 2**70}, ValueError, "threads: "),
        ({"uplo": 3}, TypeError, "uplo: 'int' object"),
        ({"scheme": None}, TypeError, "scheme: 'None"),
        ({"reproducible": "x"}, TypeError, "reproducible: 'str' object"),
        ({"weights": np.ones(3)}, ValueError, "weights: expected 4 x 1, got 3 x 1"),
        ({"weights": [1, 2, np.nan, 3]}, ValueError, "weights: not finite at row 2"),
        ({"weights": np.ones((4, 1))}, ValueError, "weights: expected an array of 1 dimension,"),
        ({"center": np.ones(4)}, ValueError, "center: expected 3 x 1, got 4 x 1"),
        ({"center": "median"}, ValueError, "center: 'median' is not one of"),
        ({"weights": [1, -1, 1, -1], "center": True}, ValueError, "weights"),
        ({"out": np.zeros((2, 2))}, ValueError, r"out: expected shape \(3, 3\)"),
        ({"out": np.zeros((3, 3), np.float32)}, TypeError, "out: expected float64, got float32"),
        ({"out": [[0.0] * 3] * 3}, TypeError, "out: expected a numpy array"),
        ({"out": np.broadcast_to(np.zeros(3), (3, 3))}, ValueError, "out: read-only"),
        ({"out": A[:3, :3]}, ValueError, "out: shares memory"),
        ({"out": SQUARE, "weights": BUFFER[5:9]}, ValueError, "out: shares memory"),
        ({"out": SQUARE, "center": BUFFER[6:9]}, ValueError, "out: shares memory"),
        ({"weights": np.ma.masked_equal(np.arange(4.0), 2)}, ValueError, "weights: 1 entries are"),
        ({"b": np.ones((3, 2))}, ValueError, "B: expected 4 x 2, got 3 x 2"),
        ({"b": np.ones((4, 2)), "center": True}, ValueError, "b: weights and center"),
        ({"dtype": np.int32}, TypeError, "dtype"),
        ({"progress": 3}, TypeError, "progress: expected a callable"),
    ],
)
def test_wrong_options(options, error, match):
    refused(error, match, catamaran.ata, A, **options)


def test_overlapping_elements_of_out():
    memory = np.zeros(8)
    out = np.lib.stride_tricks.as_strided(memory, (3, 3), (8, 8))
    refused(ValueError, "out: some of its elements are the same memory", catamaran.ata, A, out=out)
    unaligned = (
        np.frombuffer(bytearray(8 * 9 + 1), dtype=np.uint8)[1:].view(np.float64).reshape(3, 3)
    )
    refused(ValueError, "out: not aligned", catamaran.ata, A, out=unaligned)
    assert np.array_equal(catamaran.ata(unaligned), np.zeros((3, 3)))


def test_masked_entries_are_refused_by_name():
    masked = np.ma.masked_greater(A, 9)
    for call in (
        catamaran.ata,
        catamaran.cov,
        catamaran.corrcoef,
        catamaran.pca,
        catamaran.svd,
        lambda a: catamaran.lstsq(a, A[:, 0]),
        catamaran.lstsq(A[:, :2], A[:, 2]).predict,
    ):
        refused(ValueError, "a: 2 entries are masked", call, masked)
    refused(ValueError, "b: 2 entries are masked", catamaran.lstsq, A, masked)
    refused(ValueError, "rows: 2 entries", catamaran.Accumulator(3).add, masked)
    refused(ValueError, "v: [0-9]+ entries", catamaran.laplacian, np.ma.masked_equal(V, V.max()), F)
    # A mask without entries hides nothing.
    assert np.array_equal(catamaran.ata(np.ma.masked_array(A)), catamaran.ata(A))


def test_options_of_dictionaries_are_named():
    refused(TypeError, "^ridge: ", catamaran.lstsq, A, A[:, 0], ridge="x")
    refused(TypeError, "^rank_deficiency: ", catamaran.lstsq, A, A[:, 0], rank_deficiency=1)
    refused(TypeError, "^k: ", catamaran.eigsh, V, F, "x")
    refused(ValueError, "^k: ", catamaran.eigsh, V, F, -1)
    refused(TypeError, "^lloyd: ", catamaran.decimate, V, F, 12, lloyd=1.5)
    refused(TypeError, "^open: ", catamaran.curve, V, F, [0, 1], open=3)
    refused(TypeError, "^loss: ", catamaran.wilt, catamaran.grow_plant(20), loss="x")
    refused(TypeError, "^agents: ", catamaran.slime, V, F, 1, agents="x")
    refused(ValueError, "^iterations: ", catamaran.newton, size=4, iterations=-1)
    refused(ValueError, "^skip: ", catamaran.read, "a.csv", skip=-1)
    refused(ValueError, "^separator: ", catamaran.read, "a.csv", separator=";;")
    refused(TypeError, "^n_components: ", catamaran.pca, A, "x")
    for call in (
        lambda threads: catamaran.lstsq(A, A[:, 0], threads=threads),
        lambda threads: catamaran.pca(A, threads=threads),
        lambda threads: catamaran.eigsh(V, F, 3, threads=threads),
        lambda threads: catamaran.shape_dna(V, F, 3, threads=threads),
        lambda threads: catamaran.decimate(V, F, 12, threads=threads),
    ):
        refused(TypeError, "^threads: 'str' object", call, "x")


def test_numbers_of_numpy_are_integers():
    two, three = np.int32(2), np.uint8(3)
    assert np.array_equal(catamaran.ata(A, threads=np.int64(1)), catamaran.ata(A))
    assert catamaran.pca(A, np.int64(1)).components.shape == (1, 3)
    assert catamaran.eigsh(V, F, three).values.shape == (3,)
    assert catamaran.newton(size=np.int16(8)).roots.shape == (8, 8)
    assert catamaran.transfer((V, F), (V, F), V[:, 0], k=three, order=two).shape == (42,)
    source = catamaran.Eigenbasis(V, F, np.int64(5))
    known = {"functions": (V, V), "signatures": False, "refine": "none"}
    found = catamaran.functional_map(source, source, k=three, **known)
    assert found.map.shape == (4, 4)
    assert catamaran.decimate(V, F, np.int64(20), relaxation=two).v.shape == (20, 3)


def test_what_the_points_of_a_fractal_do_not_take_is_refused():
    grid = {"size": 4, "center": (0.0, 1.0), "extent": 2.0, "volume": True}
    for name, given in grid.items():
        match = f"^{name}: not together with points"
        refused(ValueError, match, catamaran.newton, [[1.0, 0.0, 0.0]], **{name: given})
    match = "^center: not together with volume"
    refused(ValueError, match, catamaran.newton, size=4, volume=True, center=(1.0, 0.0))
    match = r"^size: a volume needs the same number along each side, got \(4, 2\)"
    refused(ValueError, match, catamaran.newton, size=(4, 2), volume=True)


def test_weights_of_a_covariance_are_named():
    for name in ("fweights", "aweights"):
        for wrong, why in (
            (np.ones(3), r"expected shape \(4,\), got \(3,\)"),
            (np.ones((4, 1)), r"expected shape \(4,\), got \(4, 1\)"),
            ([1.0, 2.0, np.nan, 3.0], "not finite at row 2"),
            ([1.0, np.inf, 2.0, 3.0], "not finite at row 1"),
            (np.ma.masked_equal(np.arange(4.0), 2), "1 entries are masked"),
        ):
            refused(ValueError, f"^{name}: {why}", catamaran.cov, A, **{name: wrong})
    refused(ValueError, "^aweights: ", catamaran.cov, A, fweights=np.ones(4), aweights=np.ones(3))


def test_complex_matrices_have_no_weights():
    refused(TypeError, "a: complex", catamaran.ata, A + 1j, weights=np.ones(4))


def test_non_finite_numbers():
    bad = A.copy()
    bad[2, 1] = np.nan
    # Products have them where the classical algorithm has.
    assert np.isnan(catamaran.ata(bad)[1]).all() and not np.isnan(catamaran.ata(bad)[0, 0])
    refused(ValueError, "not finite at row 2, column 1", catamaran.lstsq, bad, A[:, 0])
    refused(ValueError, "not finite", catamaran.pca, bad)
    refused(ValueError, "not finite", catamaran.svd, bad)


def test_wrong_least_squares():
    refused(ValueError, "B: expected 4 x 1, got 3 x 1", catamaran.lstsq, A, np.ones(3))
    refused(
        ValueError, "weight 1 .* is negative", catamaran.lstsq, A, A[:, 0], weights=[1, -2, 1, 1]
    )
    refused(ValueError, "ridge", catamaran.lstsq, A, A[:, 0], ridge=-1.0)
    refused(ValueError, "must be at most 3", catamaran.pca, A, 7)
    refused(ValueError, "a share must be in", catamaran.pca, A, 1.5)
    refused(ValueError, "a variance needs more than 1", catamaran.pca, A[:1])
    refused(TypeError, "a: complex128 can't be converted", catamaran.lstsq, A + 1j, A[:, 0])
    refused(ValueError, "rows: expected 2 x 3, got 2 x 2", catamaran.pca(A).transform, A[:2, :2])


def test_empty_matrices():
    assert catamaran.ata(np.zeros((0, 0))).shape == (0, 0)
    assert catamaran.ata(np.zeros((0, 3)), np.zeros((0, 2))).shape == (3, 2)
    assert np.array_equal(catamaran.ata(np.zeros((0, 3)), center=True), np.zeros((3, 3)))
    assert catamaran.svd(np.zeros((4, 0))).s.shape == (0,)


@pytest.mark.parametrize(
    ("v", "f", "error", "match"),
    [
        (V[:, :2], F, ValueError, "v: expected 3 columns, got 2"),
        (V.ravel(), F, ValueError, "v: expected an array of 2 dimensions"),
        (V, F[:, :2], ValueError, "f: expected 3 columns, got 2"),
        (V, F.astype(float), TypeError, "f: expected integers, got float64"),
        (V, F + 1, ValueError, "face .*: vertex 42 is out of range: 42 vertices"),
        (V, F - 1, ValueError, "face .*: there is no vertex -1"),
        (V, F + 2**40, ValueError, "face 0: there is no vertex 1099511627"),
        (np.where(V == V[3, 0], np.nan, V), F, ValueError, "vertex .*: position .* is not finite"),
        (V, F[:, [0, 0, 1]], ValueError, "face 0: has the same vertex twice"),
        (V + 1j, F, TypeError, "v: complex128 can't be converted"),
    ],
)
def test_wrong_meshes(v, f, error, match):
    for function in (catamaran.laplacian, catamaran.eigsh, catamaran.shape_dna):
        refused(error, match, function, v, f)
    refused(error, match, catamaran.decimate, v, f, 12)
    refused(error, match, catamaran.farthest_points, v, f, 3)
    refused(error, match, catamaran.curve, v, f, [0, 1, 2])


def test_wrong_words_and_numbers_of_chapters():
    refused(ValueError, "kind: 'x' is not one of", catamaran.laplacian, V, F, kind="x")
    refused(ValueError, "mass: 'x' is not one of", catamaran.laplacian, V, F, mass="x")
    refused(ValueError, "boundary: 'x' is not one of", catamaran.laplacian, V, F, boundary="x")
    refused(ValueError, "", catamaran.laplacian, V, F, boundary=[99])
    refused(ValueError, "boundary: -1 is not the number", catamaran.laplacian, V, F, boundary=[-1])
    refused(ValueError, "k: ", catamaran.eigsh, V, F, 99)
    refused(ValueError, "tolerance", catamaran.eigsh, V, F, 3, tol=1.0)
    refused(ValueError, "first: -1 is not the", catamaran.farthest_points, V, F, 2, first=-1)
    refused(ValueError, "method: 'x' is not one of", catamaran.decimate, V, F, 12, method="x")
    refused(
        ValueError,
        "landmarks: expected 2 columns",
        catamaran.functional_map,
        (V, F),
        (V, F),
        landmarks=[[1, 2, 3]],
        k=3,
        refine="none",
    )
    refused(ValueError, "gradient: 'x'", catamaran.newton, gradient="x")
    refused(ValueError, "", catamaran.union_spectrum, [np.ones(3), np.ones(20)])
    flat = np.zeros((3, 3)), np.array([[0, 1, 2]])
    refused(ValueError, "face 0", catamaran.laplacian, *flat)


def test_too_little_memory():
    # Of no rows: nothing to multiply, and a result that no memory holds.
    refused(MemoryError, "", catamaran.ata, np.empty((0, 2**27)))


def test_numbers_of_vertices_may_be_none_but_no_mask():
    v, f = shapes.grid(4, 4)
    natural = catamaran.laplacian(v, f)
    assert (catamaran.laplacian(v, f, boundary=[]).stiffness != natural.stiffness).nnz == 0
    mask = v[:, 0] == 0
    held = catamaran.laplacian(v, f, boundary=np.flatnonzero(mask)).kept
    assert np.array_equal(held, np.flatnonzero(~mask))
    refused(TypeError, "^boundary: truth values", catamaran.laplacian, v, f, boundary=mask)
    refused(TypeError, "^sources: truth values", catamaran.distances, v, f, mask)
    refused(ValueError, "^start: -1 is not", catamaran.shortest_path, v, f, -1, 0)
    refused(ValueError, "^end: -1 is not", catamaran.shortest_path, v, f, 0, -1)
    refused(ValueError, "^end: there is no vertex 25", catamaran.shortest_path, v, f, 0, 25)
