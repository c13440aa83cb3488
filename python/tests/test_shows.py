"""Results as tables and as plots."""

import numpy as np
import pytest

import catamaran
from catamaran import shapes


def test_least_squares_print_as_a_table(rng):
    a = rng.standard_normal((50, 2))
    b = a @ [2.0, -3.0] + 5 + 0.01 * rng.standard_normal(50)
    fit = catamaran.lstsq(a, b, intercept=True, factors={"g": ["x", "y"] * 25})
    lines = str(fit).splitlines()
    assert "50 observations, rank 3, 46 degrees of freedom" in lines[0] and "R^2" in lines[1]
    assert lines[2].split() == ["column", "coefficient", "standard", "error", "t", "p"]
    names = [line.split()[0] for line in lines[3:]]
    assert names == ["intercept", "0", "1", "g[y]"]
    found = [float(line.split()[1]) for line in lines[3:]]
    assert np.allclose(found, [fit.intercept, *fit.x], rtol=1e-5)
    errors = [float(line.split()[2]) for line in lines[3:]]
    assert np.allclose(errors, [fit.intercept_errors, *fit.standard_errors], rtol=1e-5)
    both = str(catamaran.lstsq(a, np.column_stack([b, -b]), standard_errors=False))
    assert "target 0: " in both and "target 1: " in both and "standard" not in both
    assert repr(fit) == "LeastSquares(50 observations, rank 3)"
    # A constant alone.
    lines = str(catamaran.lstsq(a[:, :0], b, intercept=True)).splitlines()
    assert len(lines) == 4 and lines[3].split()[0] == "intercept"


def test_components_print_as_a_table_that_leaves_out_its_middle(rng):
    found = catamaran.pca(rng.standard_normal((90, 30)))
    lines = str(found).splitlines()
    assert len(lines) == 2 + 20 + 1 and lines[12].split() == ["..."] * 4
    assert lines[-1].split()[0] == "30" and float(lines[-1].split()[3]) == 1
    assert "%" in lines[0]


def test_tables_print_their_names(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("x,y\n1,2\n4,5\n")
    lines = str(catamaran.read(path)).splitlines()
    assert lines[0].split() == ["x", "y"] and lines[2].split() == ["4", "5"]


def test_results_plot_themselves(rng):
    pytest.importorskip("matplotlib").use("Agg")
    import matplotlib.pyplot as plt

    v, f = mesh = shapes.icosphere(1)
    a = rng.standard_normal((30, 3))
    pairs = catamaran.eigsh(mesh, k=4)
    curve = catamaran.curve(v, f, [0, 1, 2]).curves[0]
    basis = catamaran.Eigenbasis(mesh, k=7)
    results = [
        catamaran.pca(a),
        catamaran.lstsq(a, a[:, :2]),
        catamaran.lstsq(a, a[:, 0], standard_errors=False),
        pairs,
        mesh,
        curve,
        catamaran.functional_map(basis, basis, k=6, refine="none"),
        catamaran.slime(mesh, 1, agents=10, size=160),
        catamaran.newton(size=6),
        catamaran.wilt(catamaran.grow_plant(20), frames=2),
    ]
    for result in results:
        ax = result.plot()
        ax.figure.canvas.draw()
        assert ax.has_data(), type(result)
        plt.close(ax.figure)
    ax = plt.figure().add_subplot(projection="3d")
    assert mesh.plot(pairs.vectors[:, 1], ax=ax) is ax
    colours = ax.collections[0].get_array()
    assert np.allclose(colours, pairs.vectors[f, 1].mean(axis=1))
    # The heights of bars are the shares.
    found = results[0]
    heights = [bar.get_height() for bar in found.plot().patches]
    assert np.allclose(heights, found.explained_variance_ratio)
    with pytest.raises(ValueError, match="plot: only the points of a plane"):
        catamaran.newton(size=4, power=2, volume=True).plot()
    plt.close("all")


def test_a_plane_is_drawn_with_the_largest_y_at_the_top():
    pytest.importorskip("matplotlib").use("Agg")
    import matplotlib.pyplot as plt

    # The root i, of number 0, is that of the upper half, whose rows are the first.
    found = catamaran.newton(roots=[1j, -1j], size=6)
    assert (found.roots[:3] == 0).all() and (found.roots[3:] == 3).all()
    ax = found.plot()
    assert np.array_equal(ax.images[0].get_array(), found.roots)
    first, last = ax.transData.transform([[0, 0], [0, 5]])[:, 1]
    assert first > last
    plt.close(ax.figure)
