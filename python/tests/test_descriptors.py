"""Descriptors of vertices, coefficients, maps of products, spectra between spectra."""

import numpy as np
import pytest

import catamaran
from catamaran import shapes

FIGURE = shapes.figure(5)


def test_global_point_signatures_are_scaled_functions():
    basis = catamaran.Eigenbasis(FIGURE, k=9)
    found = basis.global_point_signature()
    assert np.allclose(found, basis.functions[:, 1:] / np.sqrt(basis.values[1:]))


def test_one_coefficient_is_changed(rng):
    basis = catamaran.Eigenbasis(FIGURE, k=9)
    f = rng.standard_normal((len(FIGURE.v), 2))
    change = basis.functions.T @ (basis.mass @ (basis.add_coefficient(f, 4, 0.3) - f))
    assert np.allclose(change, np.outer(np.arange(9) == 4, [0.3, 0.3]))
    assert basis.add_coefficient(f[:, 0], 4, 0.3).shape == (len(FIGURE.v),)
    with pytest.raises(ValueError, match="index: 9 is not one of the 9 functions"):
        basis.add_coefficient(f, 9, 0.3)


def test_shot_does_not_change_under_motions(rng):
    mesh = shapes.terrain(20, 20, 3)
    v, f = mesh
    radius = 4 * np.sqrt(mesh.area / len(f))
    found = catamaran.shot(v, f, radius)
    norms = np.linalg.norm(found, axis=1)
    assert found.shape == (len(v), 352) and np.all(np.isclose(norms, 1) | (norms == 0))
    assert norms.mean() > 0.9
    # A rotation and another scale; few axes are so near to a tie that rounding decides.
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    moved = catamaran.shot(3 * v @ turn.T + 1, f, 3 * radius)
    same = np.abs(moved - found).max(axis=1) < 1e-6
    assert same.mean() > 0.9
    with pytest.raises(ValueError, match="radius"):
        catamaran.shot(v, f, 0.0)


def test_rings_have_the_means_of_functions():
    mesh = shapes.grid(10, 10)
    x = mesh.v[:, 0]
    found = catamaran.geodesic_rings(mesh, np.column_stack([x, 1 - x]), 0.35, 3)
    shares, means = found[:, ::3], found[:, 1::3]
    assert found.shape == (len(mesh.v), 9) and np.allclose(shares.sum(axis=1), 1)
    assert np.allclose(means + found[:, 2::3], 1)
    # By the definition: distances along edges, thirds of areas, two rings for each vertex.
    v = 60
    place = catamaran.distances(mesh, [v], method="edges") / 0.35 * 3 - 0.5
    areas = np.where(place <= 2.5, mesh.vertex_areas, 0.0)
    below = np.floor(np.where(areas > 0, place, 0.0))
    sums = np.zeros((3, 2))
    for ring, part in ((below, 1 - (place - below)), (below + 1, place - below)):
        ring = np.clip(ring, 0, 2).astype(int)
        for i in np.flatnonzero(areas):
            sums[ring[i]] += areas[i] * part[i] * np.array([1, x[i]])
    assert np.allclose(shares[v], sums[:, 0] / areas.sum(), atol=1e-6)
    assert np.allclose(means[v], sums[:, 1] / sums[:, 0], atol=1e-6)
    with pytest.raises(ValueError, match="rings: must be at least 1"):
        catamaran.geodesic_rings(mesh, x, 0.3, 0)
    with pytest.raises(ValueError, match="functions: expected 121 x 1, got 3 x 1"):
        catamaran.geodesic_rings(mesh, x[:3], 0.3, 2)


@pytest.mark.parametrize("all_products", [False, True])
@pytest.mark.parametrize("method", ["single_pass", "reorthogonalized"])
def test_maps_of_products_carry_products(method, all_products):
    v, f = FIGURE
    source, target = catamaran.Eigenbasis(v, f, 6), catamaran.Eigenbasis(2 * v, f, 6)
    # The exact map of functions with the same values, up to signs.
    c = target.functions.T @ (target.mass @ source.functions)
    o = catamaran.product_map(source, target, c, method=method, all_products=all_products)
    ours, theirs = (
        catamaran.eigenproducts(basis, order=2, method=method).functions
        for basis in (source, target)
    )
    assert o.shape == (theirs.shape[1], ours.shape[1])
    assert np.allclose(theirs @ o, ours, atol=1e-6 * np.abs(ours).max())
    # Fewer functions than the bases have.
    few = catamaran.product_map(source, target, c[:4, :5], method=method)
    assert few.shape[0] <= 10 and few.shape[1] <= 15
    with pytest.raises(ValueError, match="functional map: expected 6 x 6"):
        catamaran.product_map(source, target, np.eye(7))


def test_spectra_lie_between_spectra():
    one, other = 40.0 * np.arange(1, 21), 30.0 * np.arange(2, 22)
    for t in (0.0, 0.25, 1.0):
        found = catamaran.interpolate_spectra(one, other, t)
        assert np.allclose(found, (1 - t) * one + t * other)
    for wrong, match in [
        ((one, other, 1.5), r"t: must be in \[0, 1\], is 1.5"),
        ((one[::-1], other, 0.5), "first: must ascend"),
        ((one, other[:5], 0.5), "second"),
    ]:
        with pytest.raises(ValueError, match=match):
            catamaran.interpolate_spectra(*wrong)
