"""Eigenpairs in slices and in two levels, counts of eigenvalues, operators on functions."""

import numpy as np
import pytest
import scipy.sparse

import catamaran
from catamaran import shapes

TORUS = shapes.torus(40, 20)
SPHERE = shapes.icosphere(3)


def test_slices_are_the_pairs_one_after_the_other():
    exact = catamaran.eigsh(TORUS, k=120)
    stiffness, mass, _ = catamaran.laplacian(TORUS)
    for matrices in (TORUS, (stiffness, mass)):
        slices = []
        take = lambda values, vectors: slices.append((values, vectors))
        found = catamaran.eigsh(*matrices, k=120, memory=2_600_000, sink=take)
        assert len(slices) > 1 and found.vectors.shape == (len(TORUS.v), 0)
        values = np.concatenate([values for values, _ in slices])
        vectors = np.hstack([vectors for _, vectors in slices])
        assert np.array_equal(found.values, values)
        assert np.allclose(values, exact.values, atol=1e-9)
        residual = stiffness @ vectors - mass @ vectors * values
        assert np.abs(residual).max() < 1e-7
        assert np.allclose(vectors.T @ mass @ vectors, np.eye(120), atol=1e-5)


def test_slices_have_rows_for_all_vertices():
    disk = shapes.disk(10, 40)
    taken = []
    how = {"k": 12, "boundary": "dirichlet"}
    catamaran.eigsh(disk, **how, memory=1 << 30, sink=lambda *pairs: taken.append(pairs))
    ((values, vectors),) = taken
    assert vectors.shape == (len(disk.v), 12) and not vectors[disk.boundary_loops[0]].any()
    assert np.allclose(values, catamaran.eigsh(disk, **how).values)


def test_an_exception_of_a_sink_ends_the_call():
    class Full(Exception):
        pass

    def full(values, vectors):
        raise Full("no place", len(values))

    with pytest.raises(Full, match="no place"):
        catamaran.eigsh(TORUS, k=8, memory=1 << 30, sink=full)
    wrong = [
        ({"memory": 1 << 30}, ValueError, "memory: together with sink"),
        ({"sink": full}, ValueError, "memory: together with sink"),
        ({"memory": 1000, "sink": full}, ValueError, "memory: must be at least"),
        ({"memory": -1, "sink": full}, ValueError, "memory: "),
    ]
    for options, error, match in wrong:
        with pytest.raises(error, match=match):
            catamaran.eigsh(TORUS, k=8, **options)


def test_pairs_of_a_coarse_mesh_are_near_and_never_too_small():
    weights = catamaran.decimate(SPHERE, 200).weights
    exact = catamaran.eigsh(SPHERE, k=9)
    found = catamaran.eigsh(SPHERE, k=9, prolongation=weights)
    assert np.all(found.values >= exact.values - 1e-9)
    assert np.allclose(found.values, exact.values, rtol=0.05, atol=1e-6)
    stiffness, mass, _ = catamaran.laplacian(SPHERE)
    assert np.allclose(found.vectors.T @ mass @ found.vectors, np.eye(9), atol=1e-8)
    same = catamaran.eigsh(stiffness, mass.diagonal(), 9, prolongation=weights)
    assert np.allclose(same.values, found.values, atol=1e-9)
    # Of joined vertices only the first one has a row in the matrices.
    v, f = SPHERE
    soup = v[f].reshape(-1, 3), np.arange(3 * len(f)).reshape(-1, 3)
    every = scipy.sparse.csr_array(weights)[f.ravel()]
    joined = catamaran.eigsh(*soup, 9, prolongation=every, weld=True)
    assert np.allclose(joined.values, found.values, rtol=1e-6, atol=1e-6)
    assert joined.vectors.shape == (3 * len(f), 9)
    for more in ({"memory": 1 << 30}, {"sink": print}):
        with pytest.raises(ValueError, match="prolongation: not together with"):
            catamaran.eigsh(SPHERE, k=3, prolongation=weights, **more)
    for wrong in (weights[:100], scipy.sparse.vstack([weights, weights[:1]])):
        with pytest.raises(ValueError, match="prolongation: expected a row for each of 642 vert"):
            catamaran.eigsh(SPHERE, k=3, prolongation=wrong)
    with pytest.raises(TypeError, match="^prolongation: expected a matrix of scipy.sparse, got nd"):
        catamaran.eigsh(SPHERE, k=3, prolongation=weights.toarray())
    with pytest.raises(TypeError, match="^prolongation: complex"):
        catamaran.eigsh(SPHERE, k=3, prolongation=1j * weights)
    with pytest.raises(ValueError, match="verify_count"):
        catamaran.eigsh(SPHERE, k=3, prolongation=weights, verify_count=True)


def test_a_number_in_place_of_the_mass_is_explained():
    stiffness = catamaran.laplacian(SPHERE).stiffness
    with pytest.raises(TypeError, match=r"mass: got 10; .* keyword: eigsh\(a, k=10\)"):
        catamaran.eigsh(stiffness, 10)
    assert len(catamaran.eigsh(stiffness, k=3).values) == 3


def test_eigenvalues_below_a_value_are_counted():
    values = catamaran.eigsh(TORUS, k=60).values
    stiffness, mass, _ = catamaran.laplacian(TORUS)
    for i in (1, 5, 30, 58):
        if values[i + 1] - values[i] < 1e-6:
            i += 1
        middle = (values[i] + values[i + 1]) / 2
        assert catamaran.count_below(TORUS, middle) == i + 1
        assert catamaran.count_below(stiffness, mass, middle) == i + 1
        assert catamaran.count_below(stiffness, mass.diagonal(), middle) == i + 1
    disk = shapes.disk()
    assert catamaran.count_below(disk, 3.0, boundary="dirichlet") == 0
    v, f = SPHERE
    soup = v[f].reshape(-1, 3), np.arange(3 * len(f)).reshape(-1, 3)
    assert catamaran.count_below(*soup, 4.0, weld=True, mass="full") == 4
    with pytest.raises(ValueError, match="kind: 'x' is not one of"):
        catamaran.count_below(disk, 3.0, kind="x")
    diagonal = scipy.sparse.diags_array([1.0, 2.0, 5.0]).tocsr()
    assert catamaran.count_below(diagonal, None, 2.5) == 2
    with pytest.raises(ValueError, match="value: .*is an eigenvalue"):
        catamaran.count_below(diagonal, None, 2.0)
    with pytest.raises(ValueError, match="value: .*is not finite"):
        catamaran.count_below(diagonal, None, np.nan)


def test_the_dimension_of_the_kernel():
    v, f = SPHERE
    three = np.vstack([v, v + 5, v - 5]), np.vstack([f, f + len(v), f + 2 * len(v)])
    assert catamaran.free_components(*three) == 3
    assert catamaran.free_components(*three, boundary=[0, 1]) == 2
    soup = v[f].reshape(-1, 3), np.arange(3 * len(f)).reshape(-1, 3)
    assert catamaran.free_components(*soup) == len(f)
    assert catamaran.free_components(*soup, weld=True) == 1
    stiffness, mass, _ = catamaran.laplacian(*three)
    assert catamaran.free_components(stiffness, mass) == 3
    assert catamaran.free_components(stiffness + mass, mass) == 0


def test_clouds_have_the_spectrum_of_their_surface():
    v, f = SPHERE
    stiffness, mass, kept = catamaran.cloud_laplacian(v)
    assert np.array_equal(kept, np.arange(len(v))) and abs(stiffness - stiffness.T).max() < 1e-12
    assert abs(stiffness.sum(axis=1)).max() < 1e-10 and abs(mass.sum() / (4 * np.pi) - 1) < 0.05
    values = catamaran.eigsh(stiffness, mass, 9).values
    assert np.allclose(values, [0, 2, 2, 2, 6, 6, 6, 6, 6], atol=0.3)
    grid = shapes.grid(12, 12).v
    inside = catamaran.cloud_laplacian(grid, neighbours=12, boundary="dirichlet").kept
    rim = (grid[:, :2] == 0).any(axis=1) | (grid[:, :2] == 1).any(axis=1)
    assert np.array_equal(inside, np.flatnonzero(~rim))
    for wrong, match in [
        ({"points": v, "neighbours": 2}, "neighbours: must be at least 3"),
        ({"points": np.full((9, 3), np.nan)}, "points: not finite at row 0"),
        ({"points": v[:, :2]}, "points: expected 3 columns, got 2"),
    ]:
        with pytest.raises(ValueError, match=match):
            catamaran.cloud_laplacian(**wrong)


def test_gradients_of_linear_functions_are_constant(rng):
    mesh = shapes.grid(5, 7)
    turned = mesh.v @ np.linalg.qr(rng.standard_normal((3, 3)))[0]
    normal = np.cross(turned[1] - turned[0], turned[8] - turned[0])
    normal /= np.linalg.norm(normal)
    slope = rng.standard_normal(3)
    along = slope - slope @ normal * normal
    found = (catamaran.gradient(turned, mesh.f) @ (turned @ slope)).reshape(-1, 3)
    assert np.allclose(found, along)
    gradient, divergence = catamaran.gradient(TORUS), catamaran.divergence(TORUS)
    assert gradient.shape == divergence.shape[::-1] == (3 * len(TORUS.f), len(TORUS.v))
    areas = scipy.sparse.diags_array(np.repeat(TORUS.face_areas, 3))
    assert abs(divergence + (areas @ gradient).T).max() < 1e-12
    assert abs(divergence @ gradient + catamaran.laplacian(TORUS).stiffness).max() < 1e-10
    flat = np.zeros((3, 3)), [[0, 1, 2]]
    with pytest.raises(ValueError, match="face 0: no gradient"):
        catamaran.gradient(*flat)


def test_energies_are_quotients(rng):
    stiffness, mass, _ = catamaran.laplacian(TORUS)
    q = rng.standard_normal((len(TORUS.v), 3))
    up, down = (q * (stiffness @ q)).sum(axis=0), (q * (mass @ q)).sum(axis=0)
    assert np.allclose(catamaran.dirichlet_energies(q, stiffness, mass), up / down)
    found = catamaran.dirichlet_energies(q[:, 0], stiffness, mass.diagonal())
    assert np.allclose(found, up[0] / down[0])
    plain = catamaran.dirichlet_energies(q, stiffness)
    assert np.allclose(plain, up / (q**2).sum(axis=0))
    assert catamaran.dirichlet_energies(np.zeros(len(q)), stiffness)[0] == 0
    with pytest.raises(ValueError, match="stiffness: expected 5 x 5"):
        catamaran.dirichlet_energies(np.ones(5), stiffness)
    with pytest.raises(TypeError, match="^stiffness: expected a matrix of scipy.sparse, got ndarr"):
        catamaran.dirichlet_energies(q, stiffness.toarray())
    with pytest.raises(TypeError, match="^stiffness: complex"):
        catamaran.dirichlet_energies(q, 1j * stiffness)
    with pytest.raises(TypeError, match="^mass: complex"):
        catamaran.dirichlet_energies(q, stiffness, 1j * mass)


def test_options_of_meshes_are_refused_for_matrices():
    stiffness, mass, _ = catamaran.laplacian(TORUS)
    calls = [
        lambda **options: catamaran.eigsh(stiffness, k=3, **options),
        lambda **options: catamaran.count_below(stiffness, mass, 1.5, **options),
    ]
    second = "mass: applies to a mesh, and a matrix is given; that of a matrix is the second"
    for call in calls:
        for given in (mass, mass.diagonal(), "full"):
            with pytest.raises(ValueError, match=second):
                call(mass=given)
        with pytest.raises(ValueError, match="kind: applies to a mesh"):
            call(kind="tufted")
    for call in (*calls, lambda **options: catamaran.free_components(stiffness, mass, **options)):
        with pytest.raises(ValueError, match="boundary: applies to a mesh"):
            call(boundary=[0, 1])
        with pytest.raises(ValueError, match="weld: applies to a mesh"):
            call(weld=True)
