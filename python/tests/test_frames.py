"""Data frames, and arrays that only export DLPack."""

from types import SimpleNamespace

import catamaran
import numpy as np
import pytest
from catamaran._frames import refuse_other_rows

FRAMES = [("pandas", "DataFrame"), ("polars", "DataFrame"), ("pyarrow", "table")]


class Table:
    """What pyarrow's tables have; no array of all rows can be made of it."""

    def __init__(self, columns, sizes=None):
        self.columns = columns
        self.column_names = [f"c{j}" for j in range(len(columns))]
        self.schema = SimpleNamespace(types=[column.dtype for column in columns])
        self.shape = (len(columns[0]), len(columns))
        self.sizes = [] if sizes is None else sizes

    def slice(self, first, count):
        self.sizes.append(count)
        return Table([column[first : first + count] for column in self.columns], self.sizes)

    def __array__(self, dtype=None, copy=None):
        raise AssertionError("copied as a whole")


class Exported:
    """An array that only exports DLPack."""

    def __init__(self, array):
        self.array = array

    def __dlpack__(self, **options):
        return self.array.__dlpack__(**options)

    def __dlpack_device__(self):
        return self.array.__dlpack_device__()


def test_columns_of_a_frame_become_numbers_block_by_block(rng):
    m = 400_000
    columns = [rng.standard_normal(m), rng.integers(0, 9, m), rng.standard_normal(m) < 0.5]
    a, b, table = np.column_stack(columns).astype(float), rng.standard_normal(m), Table(columns)
    found, right = catamaran.lstsq(table, b, intercept=True), catamaran.lstsq(a, b, intercept=True)
    assert np.array_equal(found.x, right.x) and np.array_equal(found.p_values, right.p_values)
    assert np.array_equal(catamaran.pca(table, 2).components, catamaran.pca(a, 2).components)
    assert np.array_equal(catamaran.svd(table).s, catamaran.svd(a).s)
    assert max(table.sizes) < m


def test_a_large_frame_is_never_an_array_of_all_rows(rng):
    m, n = 5000, 2000
    columns = [rng.integers(-3, 4, m).astype(np.float32) for _ in range(n)]
    c = catamaran.ata(Table(columns), uplo="lower")
    assert c.dtype == np.float32 and c[0, 0] == columns[0] @ columns[0]
    assert c[n - 1, 5] == columns[n - 1] @ columns[5]
    weights = rng.integers(0, 3, m).astype(float)
    wide = catamaran.ata(Table(columns[:2] * 1000), weights=weights, dtype=np.float64)
    assert wide.dtype == np.float64 and wide[1, 0] == (weights * columns[1]) @ columns[0]


def test_a_column_without_numbers_is_named():
    table = Table([np.zeros(3), np.array(["u", "v", "w"])])
    with pytest.raises(TypeError, match="a: column c1 has <U1, where numbers are needed"):
        catamaran.pca(table)


def test_an_exception_of_a_frame_is_raised_as_it_is(rng):
    class Gone(Exception):
        pass

    class Vanishing(Table):
        def slice(self, first, count):
            if first > 0:
                raise Gone("the file is gone", first)
            return super().slice(first, count)

    m = 400_000
    table = Vanishing([rng.standard_normal(m) for _ in range(3)])
    calls = [
        lambda: catamaran.lstsq(table, np.ones(m)),
        lambda: catamaran.pca(table),
        lambda: catamaran.svd(table),
        lambda: catamaran.qr(table),
        lambda: catamaran.corrcoef(table),
        lambda: catamaran.lstsq(table, np.ones(m), missing="drop"),
    ]
    for call in calls:
        with pytest.raises(Gone) as raised:
            call()
        assert raised.value.args[0] == "the file is gone"


def test_results_keep_the_names_of_columns(rng):
    columns = [rng.standard_normal(60), rng.standard_normal(60)]
    a, b, table = np.column_stack(columns), rng.standard_normal(60), Table(columns)
    fit = catamaran.lstsq(table, b, factors={"region": ["u", "v"] * 30}, intercept=True)
    assert fit.feature_names == ("c0", "c1") and fit.factor_columns == ("region[v]",)
    rows = [line.split()[0] for line in str(fit).splitlines()[3:]]
    assert rows == ["intercept", "c0", "c1", "region[v]"]
    assert catamaran.lstsq(table, b).feature_names == ("c0", "c1")
    assert catamaran.pca(table).feature_names == ("c0", "c1")
    assert catamaran.lstsq(a, b).feature_names == catamaran.pca(a).feature_names == ()


def test_other_calls_take_frames_too(rng):
    columns = [rng.standard_normal(60), rng.integers(0, 9, 60)]
    a, b, table = np.column_stack(columns), rng.standard_normal(60), Table(columns)
    assert np.array_equal(catamaran.corrcoef(table), catamaran.corrcoef(a))
    assert np.array_equal(catamaran.cov(table), catamaran.cov(a))
    assert np.array_equal(catamaran.ata(table), catamaran.ata(a))
    assert np.array_equal(catamaran.ata(table, table), catamaran.ata(a, a))
    sums, right = catamaran.Accumulator(2), catamaran.Accumulator(2)
    sums.add(table)
    right.add(a)
    assert np.array_equal(sums.result(), right.result())
    assert np.array_equal(catamaran.lstsq(a, b).predict(table), catamaran.lstsq(a, b).predict(a))


def test_arrays_that_only_export_dlpack_are_not_copied(rng):
    a = rng.standard_normal((30, 4))
    assert np.array_equal(catamaran.ata(Exported(a[::2, 1:])), catamaran.ata(a[::2, 1:]))
    out = np.zeros((4, 4))
    with pytest.raises(ValueError, match="out: shares memory"):
        catamaran.ata(Exported(out), out=out)


@pytest.mark.parametrize("name, make", FRAMES)
def test_frames_of_pandas_polars_and_pyarrow_are_rows(name, make, rng):
    x, y = rng.standard_normal(50), rng.integers(0, 9, 50)
    right = catamaran.pca(np.column_stack([x, y]))
    frame = getattr(pytest.importorskip(name), make)({"x": x, "y": y})
    found = catamaran.pca(frame)
    assert np.array_equal(found.components, right.components)
    assert found.feature_names == ("x", "y")


@pytest.mark.parametrize("name, make", FRAMES)
def test_fits_of_frames_take_columns_by_their_names(name, make, rng):
    x, y, b = rng.standard_normal(50), rng.integers(0, 9, 50), rng.standard_normal(50)
    labels, rows = np.array(["u", "v"] * 25), np.column_stack([x, y])
    module = pytest.importorskip(name)
    frame = getattr(module, make)({"x": x, "y": y})
    other = getattr(module, make)({"y": y, "f": labels, "x": x})
    fit, parts = catamaran.lstsq(frame, b, intercept=True), catamaran.pca(frame)
    assert np.array_equal(fit.predict(other), fit.predict(rows))
    assert np.array_equal(fit.predict(np.asfortranarray(rows)), fit.predict(rows))
    assert np.array_equal(fit.prediction_errors(other), fit.prediction_errors(rows))
    assert np.array_equal(parts.transform(other), parts.transform(rows))
    few = getattr(module, make)({"x": x, "z": y})
    for call in (fit.predict, parts.transform):
        with pytest.raises(ValueError, match="has no column y; the fit has x, y"):
            call(few)
    fit = catamaran.lstsq(frame, b, factors={"f": labels})
    column = other["f"] if name != "pyarrow" else other.column("f")
    assert np.array_equal(catamaran.lstsq(frame, b, factors={"f": column}).x, fit.x)
    found = fit.predict(other, factors={"f": labels})
    assert np.array_equal(found, fit.predict(rows, factors={"f": labels}))
    with pytest.raises(ValueError, match=r"no column f\[v\]; the labels of f go to factors"):
        fit.predict(frame)


class Labelled(list):
    """What pandas has: rows with labels."""

    iloc = None

    def __init__(self, *labels):
        super().__init__(labels)
        self.index = self

    def equals(self, other):
        return list(self) == list(other)


def test_rows_with_other_labels_are_refused():
    a, same, other = Labelled(3, 1, 2), Labelled(3, 1, 2), Labelled(1, 2, 3)
    refuse_other_rows(a, b=same, weights=None)
    # Lengths have an error of their own, and what has no labels has the rows as they come.
    refuse_other_rows(a, b=other[:2])
    refuse_other_rows([1, 2, 3], b=other)
    with pytest.raises(ValueError, match="weights: its index is not that of the rows"):
        refuse_other_rows(a, b=same, weights=other)


def test_a_shuffled_series_of_pandas_is_refused(rng):
    pandas = pytest.importorskip("pandas")
    a = pandas.DataFrame({"x": rng.standard_normal(9)})
    b = pandas.Series(rng.standard_normal(9))
    with pytest.raises(ValueError, match="b: its index is not that of the rows"):
        catamaran.lstsq(a, b[::-1])
    with pytest.raises(ValueError, match="weights: its index is not that of the rows"):
        catamaran.pca(a, weights=abs(b)[::-1])
    labels = pandas.Series(list("aabbaabba"))
    with pytest.raises(ValueError, match="factors: f: its index is not that of the rows"):
        catamaran.lstsq(a, b, factors={"f": labels[::-1]})
    back, sums = abs(b)[::-1], catamaran.Accumulator(1)
    for call in (
        lambda: catamaran.ata(a, a[::-1]),
        lambda: catamaran.ata(a, weights=back),
        lambda: catamaran.cov(a, aweights=back),
        lambda: catamaran.verify(a, [[1.0]], weights=back),
        lambda: sums.add(a, back),
        lambda: sums.remove(a, back),
    ):
        with pytest.raises(ValueError, match="its index is not that of the rows"):
            call()
    given = catamaran.lstsq(a, b[::-1].to_numpy()).x
    assert np.array_equal(given, catamaran.lstsq(a.to_numpy(), b.to_numpy()[::-1]).x)
