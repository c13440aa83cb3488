"""Tables as people have them."""

import numpy as np
import pytest

import catamaran

from conftest import ROOT


def write(folder, text, name="a.csv"):
    path = folder / name
    path.write_text(text)
    return path


def test_numbers_names_and_what_was_decided(tmp_path):
    path = write(tmp_path, "ort;x;y\nUlm;1,5;2\nBonn;3,5;5\n")
    with pytest.warns(UserWarning, match="separator ;, decimal comma, header, 1 text column"):
        table = catamaran.read(path)
    assert table.names == ["x", "y"] and table.numbers == [1, 2] and table.left_out == ["ort"]
    assert np.array_equal(table.values, [[1.5, 2], [3.5, 5]])
    with pytest.warns(UserWarning):
        factors = catamaran.read(path, factors=True)
    assert factors.levels == {0: ["Bonn", "Ulm"]} and factors.values[:, 0].tolist() == [1, 0]
    with pytest.warns(UserWarning):
        named = catamaran.read(path, factors=["ort"], columns=["x", "ort"])
    assert named.levels == {1: ["Bonn", "Ulm"]}
    with pytest.raises(ValueError, match="factors: no column none is read"):
        catamaran.read(path, factors=["none"])
    for text in ["ort", "ort, y", "0,1"]:
        with pytest.warns(UserWarning):
            assert catamaran.read(path, factors=text, columns="x,ort,y").levels == named.levels
    # Tables are equal only to themselves, and can be keys.
    assert table == table and table != named and len({table, named}) == 2


def test_factors_of_a_table_go_into_least_squares(tmp_path):
    path = write(tmp_path, "ort,x,y\nUlm,1,23\nBonn,1,3\nNA,5,0\nUlm,0,20\nBonn,2,6\n")
    with pytest.warns(UserWarning):
        table = catamaran.read(path, factors=True, missing="nan")
    found = catamaran.lstsq(
        table.values[:, [1]],
        table.values[:, 2],
        intercept=True,
        factors={"ort": table.factor("ort")},
        missing="drop",
    )
    assert found.factor_columns == ("ort[Ulm]",) and found.left_out == (2,)
    assert np.allclose(found.x, [3, 20])
    for column in ("x", 1, "none", 7):
        with pytest.raises(ValueError, match="column"):
            table.factor(column)


def test_columns_are_numbers_names_ranges_or_lists(tmp_path):
    path = write(tmp_path, "x,y,z\n1,2,3\n4,5,7\n")
    for columns in ["z", 2, ["z"], [2], range(2, 3), "2", "2..3"]:
        assert catamaran.read(path, columns=columns).values.ravel().tolist() == [3, 7]
    for columns in [["z", "x"], "z,x", "2, 0"]:
        assert catamaran.read(path, columns=columns).values.tolist() == [[3, 1], [7, 4]]
    with pytest.raises(ValueError, match="0..3 ends with z, 0..2 before it"):
        catamaran.read(path, columns="x..z")
    with pytest.raises(ValueError, match="no column q"):
        catamaran.read(path, columns="q")


def test_options_decide_what_a_file_leaves_open(tmp_path):
    path = write(tmp_path, "400,410\n0.1,0.2\n0.11,0.25\n0.15,0.1\n")
    with pytest.raises(OSError, match="a.csv:1.*option `header` decides"):
        catamaran.read(path)
    assert catamaran.read(path, header=False).values.shape == (4, 2)
    path = write(tmp_path, "x,y\n1,2\nNA,3\n", "b.csv")
    with pytest.raises(OSError, match="b.csv:3: column 1 .*option `missing`"):
        catamaran.read(path)
    with pytest.warns(UserWarning, match="1 row with a missing cell left out"):
        assert catamaran.read(path, missing="drop").dropped_rows == 1
    assert np.isnan(catamaran.read(path, missing="nan").values[1, 0])
    assert np.isnan(catamaran.read(path, missing="nan", missing_words="NA").values[1, 0])
    with pytest.raises(ValueError, match="missing: 'no' is not one of"):
        catamaran.read(path, missing="no")


def test_a_warning_says_how_many_integers_are_rounded(tmp_path):
    path = write(tmp_path, "x,id\n1,2\n2,9007199254740993\n3,9007199254740995\n")
    with pytest.warns(UserWarning, match="2 integers beyond 2.53 rounded, the first in line 3"):
        assert catamaran.read(path).values[1, 1] == 2.0**53


def test_other_formats_are_read(tmp_path):
    path = tmp_path / "a.npy"
    np.save(path, np.array([[True, False], [False, True]]))
    assert catamaran.read(path).values.tolist() == [[1, 0], [0, 1]]
    text = "%%MatrixMarket matrix coordinate complex hermitian\n2 2 2\n1 1 2 0\n2 1 0.5 -1.25\n"
    found = catamaran.read(write(tmp_path, text, "b.mtx")).values
    assert found.tolist() == [[2, 0.5 + 1.25j], [0.5 - 1.25j, 0]]
    parts = np.array([[complex(1, np.inf), complex(-0.0, 2)]])
    np.save(path, parts)
    found = catamaran.read(path).values
    assert np.array_equal(found.real, parts.real) and np.array_equal(found.imag, parts.imag)
    text = "%%MatrixMarket matrix coordinate real general\n2 2 1\n2 1 5.0\n"
    sparse = catamaran.read(write(tmp_path, text, "a.mtx")).values
    assert sparse.toarray().tolist() == [[0, 0], [5, 0]]


COLUMNAR = ROOT / "tests" / "common" / "columnar"


@pytest.mark.parametrize("kind", ["parquet", "arrow"])
def test_columnar_files_are_read(kind):
    path = COLUMNAR / f"kinds.{kind}"
    table = catamaran.read(path, columns=["i8", "bool", "d9"])
    assert table.names == ["i8", "bool", "d9"] and table.values.shape == (50, 3)
    assert table.values[3].tolist() == [-22, 1, 3.75]
    with pytest.warns(UserWarning, match="factor word of 3 levels"):
        factors = catamaran.read(path, columns=["word", "category"], factors=True)
    assert factors.levels == {0: ["w0", "w1", "w2"], 1: ["no", "yes"]}
    with pytest.raises(ValueError, match="column day has dates"):
        catamaran.read(path, columns="day")
    path = COLUMNAR / f"missing.{kind}"
    with pytest.raises(OSError, match="column x, .*a missing value in row 3"):
        catamaran.read(path, columns=["x", "y"])
    with pytest.warns(UserWarning, match="7 rows with missing cells left out"):
        assert catamaran.read(path, columns=["x", "y"], missing="drop").dropped_rows == 7


@pytest.mark.parametrize("codec", ["snappy", "gzip", "zstd", "lz4", "none"])
def test_large_files_of_pyarrow_are_read(tmp_path, rng, codec):
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    n = 100_000
    values = rng.standard_normal((n, 3))
    words = rng.integers(0, 500, n)
    columns = {"x": values[:, 0], "y": values[:, 1].astype("f4"), "z": values[:, 2]}
    table = pyarrow.table(columns | {"w": [f"w{word:03}" for word in words]})
    path = tmp_path / "a.parquet"
    parquet.write_table(table, path, compression=codec, row_group_size=30_000)
    with pytest.warns(UserWarning, match="factor w of 500 levels"):
        found = catamaran.read(path, factors=True)
    assert np.array_equal(found.values[:, 0], columns["x"])
    assert np.array_equal(found.values[:, 1], columns["y"])
    assert np.array_equal(found.values[:, 3], words)


@pytest.mark.parametrize("codec", ["lz4", "zstd", "uncompressed"])
def test_large_files_of_polars_are_read(tmp_path, rng, codec):
    polars = pytest.importorskip("polars")
    n = 100_000
    values = rng.standard_normal(n)
    frame = polars.DataFrame({"x": values, "n": [None if i % 5 == 0 else i for i in range(n)]})
    kept = np.arange(n) % 5 != 0
    for path, write in [
        (tmp_path / "a.arrow", frame.write_ipc),
        (tmp_path / "a.parquet", frame.write_parquet),
    ]:
        write(path, compression=codec)
        with pytest.warns(UserWarning, match="20000 rows with missing cells left out"):
            found = catamaran.read(path, missing="drop")
        assert np.array_equal(found.values[:, 0], values[kept])
        assert np.array_equal(found.values[:, 1], np.flatnonzero(kept))
