"""Eigenproducts, functional maps, transfer."""

import numpy as np
import pytest

import catamaran
from catamaran import shapes


def test_a_basis_of_products_is_orthonormal_and_larger():
    v, f = shapes.figure(16)
    basis = catamaran.Eigenbasis(v, f, 9)
    found = catamaran.eigenproducts(basis, order=2, method="reorthogonalized")
    q, mass = found.functions, basis.mass
    assert q.shape[1] > 9 and np.allclose(q.T @ mass @ q, np.eye(q.shape[1]), atol=1e-9)
    assert len(found.factors) == len(found.kept) == q.shape[1]
    # A product is the sum that R says.
    i = found.factors.index([1, 2])
    ratio = basis.functions / basis.functions[:, :1]
    product = ratio[:, 1] * ratio[:, 2]
    coefficients = q.T @ mass @ product
    assert np.allclose(q @ coefficients, product, atol=1e-8)
    assert np.allclose(found.r[:, found.kept[i]], coefficients, atol=1e-8)


def test_a_pose_is_found_from_landmarks():
    source, target = shapes.figure(8), shapes.figure(8, 0.5)
    n = len(source[0])
    corners = catamaran.farthest_points(*source, 8)
    pairs = np.column_stack([corners, corners])
    found = catamaran.functional_map(source, target, landmarks=pairs, k=10, zoom=16)
    distances = np.linalg.norm(source[0][found.points] - source[0], axis=1)
    assert found.points.shape == (n,) and np.median(distances) < 0.1 * np.ptp(source[0])
    moved = catamaran.transfer(source, target, source[0][:, 2], points=found.points, k=10)
    error = np.linalg.norm(moved - source[0][:, 2]) / np.linalg.norm(source[0][:, 2])
    assert error < 0.2


def test_a_map_is_found_without_correspondences():
    v, f = shapes.terrain(14, 14)
    order = (np.arange(len(v)) * 11) % len(v)
    assert len(np.unique(order)) == len(v)
    place = np.argsort(order)
    found = catamaran.functional_map((v, f), (3 * v[order], place[f]), k=10, zoom=30)
    assert np.mean(found.points == order) > 0.9
    # A basis has no faces, by which left and right could be told.
    basis = catamaran.Eigenbasis(v, f, 31)
    with pytest.warns(UserWarning, match="an Eigenbasis has no faces.*give landmarks"):
        fitted = catamaran.functional_map(basis, basis, k=10, zoom=30)
    assert fitted.map.shape == (31, 31)


def test_functions_alone_find_a_map():
    shape = shapes.terrain(14, 14)
    basis = catamaran.Eigenbasis(*shape, 21)
    x = shape[0]
    known = np.column_stack([x, x**2, x[:, :1] * x[:, 1:2], np.cos(3 * x)])
    found = catamaran.functional_map(
        basis, basis, functions=(known, known), k=10, signatures=True, refine="icp"
    )
    assert np.mean(found.points == np.arange(len(x))) > 0.9


def test_transfer_by_identity_is_projection():
    v, f = shapes.torus(40, 20)
    basis = catamaran.Eigenbasis(v, f, 21)
    g = catamaran.transfer(basis, basis, v, k=20, order=2)
    products = catamaran.eigenproducts(basis, order=2)
    q = products.functions
    gram = q.T @ basis.mass @ q
    projected = q @ np.linalg.solve(gram, q.T @ basis.mass @ v)
    assert g.shape == v.shape and np.allclose(g, projected, atol=1e-6)
