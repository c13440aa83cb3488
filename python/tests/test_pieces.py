"""Meshes of several components: warnings, welded vertices, refusals."""

import warnings

import numpy as np
import pytest

import catamaran
from catamaran import shapes


def split(v, f):
    """The mesh with three vertices of its own for each face, as readers split it at seams."""
    return v[f].reshape(-1, 3), np.arange(3 * len(f)).reshape(-1, 3)


def beside(*meshes):
    """The meshes as one, without a common vertex."""
    starts = np.cumsum([0] + [len(v) for v, _ in meshes])
    v = np.concatenate([v + [10 * i, 0, 0] for i, (v, _) in enumerate(meshes)])
    return v, np.concatenate([f + start for start, (_, f) in zip(starts, meshes)])


def uneven(v, f):
    """The mesh with vertices moved, so that no two triangles have the same eigenvalues."""
    return v * (1 + 0.05 * np.sin(1.7 * np.arange(len(v))))[:, None], f


WHOLE = uneven(*shapes.torus(10, 6))
PIECES = split(*WHOLE)
COUNT = len(WHOLE[1])

# Every function that takes a spectrum of (v, f).
CALLS = {
    "eigsh": lambda mesh, **how: catamaran.eigsh(*mesh, 5, **how).values,
    "shape_dna": lambda mesh, **how: catamaran.shape_dna(*mesh, COUNT + 3, **how),
    "Eigenbasis": lambda mesh, **how: catamaran.Eigenbasis(*mesh, COUNT + 3, **how).values,
    "eigenproducts": lambda mesh, **how: catamaran.eigenproducts(*mesh, COUNT + 3, 1, **how).r,
    "functional_map": lambda mesh, **how: (
        catamaran.functional_map(
            mesh, mesh, landmarks=[[0, 0], [40, 40]], k=COUNT + 3, refine="none", **how
        ).map
    ),
    "transfer": lambda mesh, **how: catamaran.transfer(
        mesh, mesh, mesh[0][:, 0], k=COUNT + 3, order=1, **how
    ),
}


@pytest.mark.parametrize("name", CALLS)
def test_components_are_said_and_welding_joins_them(name):
    message = f"{COUNT} components.*weld=True joins them into 1"
    with pytest.warns(UserWarning, match=message) as said:
        CALLS[name](PIECES)
    # At the line of the caller, not within the package.
    assert all(warning.filename == __file__ for warning in said)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        if name == "eigsh":
            CALLS[name](PIECES, weld=True)
            CALLS[name](WHOLE)
        if name == "Eigenbasis":
            catamaran.Eigenbasis(*PIECES, 5, weld=True)
            catamaran.Eigenbasis(*WHOLE, 5)


def test_fewer_functions_than_components_are_refused():
    few = "too few, 3 or more are enough"
    three = beside(*(uneven(*shapes.icosphere(1)) for _ in range(3)))
    with pytest.raises(ValueError, match=f"k: 3 components, .*: 2 eigenfunctions, .* {few}$"):
        catamaran.Eigenbasis(*three, 2)
    with pytest.raises(ValueError, match=f"{few}$"):
        catamaran.eigenproducts(*three, 1)
    with pytest.warns(UserWarning, match="3 components: 3 eigenvalues are zero, one for each$"):
        basis = catamaran.Eigenbasis(*three, 8)
    with pytest.raises(ValueError, match=few):
        catamaran.transfer(basis, basis, three[0], k=1)
    with pytest.raises(ValueError, match=few):
        catamaran.functional_map(basis, basis, landmarks=[[0, 0], [9, 9]], k=(2, 1))
    with pytest.raises(ValueError, match=f"{COUNT} or more .*weld=True joins them into 1"):
        catamaran.Eigenbasis(*PIECES, 5)


def test_welded_meshes_have_the_spectrum_of_the_whole_with_a_row_for_each_vertex():
    values, vectors = catamaran.eigsh(*WHOLE, 6)
    found = catamaran.eigsh(*PIECES, 6, weld=True)
    assert np.allclose(found.values, values, rtol=1e-9, atol=1e-9)
    assert found.vectors.shape == (3 * COUNT, 6)
    # Vertices in one place have one value.
    corners = WHOLE[1].ravel()
    first = np.unique(corners, return_index=True)[1]
    assert (found.vectors == found.vectors[first[corners]]).all()

    basis = catamaran.Eigenbasis(*PIECES, 6, weld=True)
    gram = basis.functions.T @ basis.mass @ basis.functions
    assert np.allclose(gram, np.eye(6), atol=1e-9)
    dna = [catamaran.shape_dna(*WHOLE, 6), catamaran.shape_dna(*PIECES, 6, weld=True)]
    assert np.allclose(*dna, rtol=1e-9, atol=1e-9)

    stiffness, mass, kept = catamaran.laplacian(*PIECES, weld=True)
    assert stiffness.shape == (len(WHOLE[0]),) * 2
    assert sorted(corners[kept]) == list(range(len(WHOLE[0])))
    assert np.isclose(mass.sum(), catamaran.laplacian(*WHOLE).mass.sum())


def test_boundary_vertices_are_those_of_the_caller():
    v, f = split(*shapes.grid(6, 6))
    held = np.flatnonzero(v[:, 0] == v[:, 0].min())
    found = catamaran.eigsh(v, f, 3, boundary=held, weld=True)
    assert (found.vectors[held] == 0).all() and found.values[0] > 0
    with pytest.raises(ValueError, match="vertex"):
        catamaran.eigsh(v, f, 3, boundary=[len(v)], weld=True)


def test_a_signature_of_zeros_is_refused():
    two = beside(shapes.icosphere(1), shapes.torus(12, 8))
    with pytest.raises(ValueError, match="k: must be more than 2"):
        catamaran.shape_dna(*two, 2)
    with pytest.warns(UserWarning, match="2 components: 2 eigenvalues are zero"):
        values = catamaran.shape_dna(*two, 3)
    assert (values[:2] == 0).all() and values[2] > 0


def test_closed_components_under_dirichlet_and_loose_vertices_are_said():
    both = beside(shapes.grid(6, 6), shapes.icosphere(1))
    with pytest.warns(UserWarning, match="1 eigenvalue is zero, one for each without a vertex"):
        assert catamaran.eigsh(*both, 3, boundary="dirichlet").values[0] == 0
    grids = beside(shapes.grid(6, 6), shapes.grid(6, 6))
    with pytest.warns(UserWarning, match="2 components, whose eigenvalues are in one list"):
        assert catamaran.eigsh(*grids, 3, boundary="dirichlet").values[0] > 0
    with pytest.warns(UserWarning, match="the mesh has no boundary"):
        catamaran.eigsh(*shapes.icosphere(1), 3, boundary="dirichlet")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        catamaran.eigsh(*both, 3, sigma=5.0)
        catamaran.eigsh(*shapes.icosphere(1), 3, boundary="dirichlet", sigma=5.0)
    v, f = shapes.icosphere(1)
    v = np.vstack([v, [[9.0, 9.0, 9.0]]])
    with pytest.warns(UserWarning, match="vertices in no face: 1"):
        assert (catamaran.eigsh(v, f, 3).vectors[-1] == 0).all()
    with pytest.raises(ValueError, match=f"vertex {len(v) - 1}"):
        catamaran.Eigenbasis(v, f, 3)


def test_faces_that_repeat_another_are_said():
    v, f = shapes.icosphere(1)
    twice = np.vstack([f, f[3:5, [1, 2, 0]]])
    with pytest.warns(UserWarning, match="faces that repeat another, and add to it: 2"):
        found = catamaran.eigsh(v, twice, 3)
    assert abs(found.values[1] - catamaran.eigsh(v, f, 3).values[1]) > 1e-3
    with pytest.warns(UserWarning, match="faces that repeat another"):
        catamaran.shape_dna(v, twice, 3)


def test_components_of_a_matrix_are_said():
    stiffness, mass, _ = catamaran.laplacian(*beside(shapes.icosphere(1), shapes.icosphere(2)))
    with pytest.warns(UserWarning, match="2 eigenvalues are zero: 2 components"):
        values = catamaran.eigsh(stiffness, mass, 3).values
    assert (values[:2] == 0).all()


def test_parts_of_a_union_must_have_a_boundary():
    closed, disk = shapes.icosphere(2), shapes.disk(10, 20)
    with pytest.raises(ValueError, match="part 1: a component is closed"):
        catamaran.union_spectrum([disk, closed])
    with pytest.raises(ValueError, match="part 1: a component is closed"):
        catamaran.union_spectrum([disk, split(*closed)], weld=True)
    message = "part 1: the mesh has 2 components, whose eigenvalues are in one list"
    with pytest.warns(UserWarning, match=message):
        catamaran.union_spectrum([disk, beside(disk, disk)])
