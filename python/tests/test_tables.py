"""Tables as people have them."""

import numpy as np
import pytest

import catamaran


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
    with pytest.warns(UserWarning):
        assert catamaran.read(path, factors=["none"]).levels == {}


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
    for columns in ["z", 2, ["z"], [2], range(2, 3)]:
        assert catamaran.read(path, columns=columns).values.ravel().tolist() == [3, 7]
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
    with pytest.raises(ValueError, match="missing: 'no' is not one of"):
        catamaran.read(path, missing="no")


def test_other_formats_are_read(tmp_path):
    path = tmp_path / "a.npy"
    np.save(path, np.array([[True, False], [False, True]]))
    assert catamaran.read(path).values.tolist() == [[1, 0], [0, 1]]
    text = "%%MatrixMarket matrix coordinate complex hermitian\n2 2 2\n1 1 2 0\n2 1 0.5 -1.25\n"
    found = catamaran.read(write(tmp_path, text, "b.mtx")).values
    assert found.tolist() == [[2, 0.5 + 1.25j], [0.5 - 1.25j, 0]]
    text = "%%MatrixMarket matrix coordinate real general\n2 2 1\n2 1 5.0\n"
    sparse = catamaran.read(write(tmp_path, text, "a.mtx")).values
    assert sparse.toarray().tolist() == [[0, 0], [5, 0]]
