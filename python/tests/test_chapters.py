"""Decimation, curves, unions, plants, textures."""

import os
import pickle
import warnings

import numpy as np
import pytest

import catamaran
from catamaran import shapes

igl = pytest.importorskip("igl")


def test_decimation_keeps_topology_and_says_where_things_are():
    v, f = shapes.genus(2, 10)
    found = catamaran.decimate(v, f, 400)
    assert found.v.shape == (400, 3) and igl.euler_characteristic(
        found.f
    ) == igl.euler_characteristic(f)
    origin = found.origin
    places = (v[f[origin.face]] * origin.barycentric[:, :, None]).sum(axis=1)
    assert np.abs(places - found.v).max() < 0.1 * np.ptp(v)
    assert found.weights.shape == (len(v), 400) and np.allclose(found.weights.sum(axis=1), 1)
    assert np.abs(found.weights @ found.v - v).max() < 0.2 * np.ptp(v)
    literal = catamaran.decimate(v, f, 100, method="thesis")
    assert len(literal.v) == 100
    with pytest.raises(ValueError):
        catamaran.decimate(v, f, 2)


def test_decimation_to_an_error():
    v, f = shapes.icosphere(4)
    found = catamaran.decimate(v, f, error=0.03)
    assert found.difference((v, f)).hausdorff_bound <= 0.03
    assert len(catamaran.decimate(v, f, error=0.1).v) < len(found.v) < 500
    again = catamaran.decimate(v, f, len(found.v))
    assert np.array_equal(again.v, found.v) and np.array_equal(again.f, found.f)
    with pytest.raises(ValueError, match="^error: "):
        catamaran.decimate(v, f, error=-1.0)
    for both in ({}, {"n": 100, "error": 0.1}):
        with pytest.raises(TypeError, match="either n or error"):
            catamaran.decimate(v, f, **both)


def test_locked_vertices_of_a_decimation_are_its_first():
    v, f = shapes.icosphere(4)
    locked = [300, 7, 2000]
    found = catamaran.decimate(v, f, 100, locked=locked)
    assert np.array_equal(found.v[:3], v[locked])
    mask = np.isin(np.arange(len(v)), locked)
    assert np.array_equal(catamaran.decimate(v, f, 100, locked=mask).v[:3], v[mask])
    with pytest.raises(ValueError, match="^locked: "):
        catamaran.decimate(v, f, 100, locked=[len(v)])
    with pytest.raises(TypeError, match="^locked: "):
        catamaran.decimate(v, f, 100, locked=[1.5])
    for wrong in (mask[:-1], np.append(mask, False), mask[:, None], mask[None]):
        with pytest.raises(ValueError, match=r"^locked: expected a mask of shape \(2562,\), got"):
            catamaran.decimate(v, f, 100, locked=wrong)
    v, f = shapes.icosphere(0)
    with pytest.warns(UserWarning, match="30 edges between locked vertices"):
        catamaran.decimate(v, f, 400, locked=range(12))


def test_a_density_brings_vertices_where_it_is_large():
    v, f = shapes.icosphere(5)
    density = np.where(v[:, 0] > 0, 9.0, 1.0)
    found = catamaran.decimate(v, f, 1000, density=density)
    share = np.mean(found.v[:, 0] > 0)
    assert 0.8 < share < 0.93
    same = catamaran.decimate(v, f, 1000, density=np.full(len(v), 3))
    assert np.array_equal(same.v, catamaran.decimate(v, f, 1000).v)
    assert len(catamaran.decimate(v, f, 1000, curvature=16).v) == 1000
    density[5] = 0
    with pytest.raises(ValueError, match="^density: must be .* finite, is 0e0 at vertex 5"):
        catamaran.decimate(v, f, 1000, density=density)
    with pytest.raises(ValueError, match="^density: must be one for each of "):
        catamaran.decimate(v, f, 1000, density=[1.0, 2.0])
    with pytest.raises(ValueError, match="^curvature: must be from 1"):
        catamaran.decimate(v, f, 1000, curvature=0.5)


def test_farthest_points_are_far():
    v, f = shapes.icosphere(4)
    found = catamaran.farthest_points(v, f, 12, first=3, return_cells=True)
    assert found.samples[0] == 3 and len(set(found.samples)) == 12
    assert (
        np.array_equal(np.unique(found.cells), np.arange(12))
        or np.isin(found.cells, found.samples).all()
    )
    assert (found.distances[found.samples] == 0).all()
    d = np.linalg.norm(v[found.samples][:, None] - v[found.samples], axis=2) + 9 * np.eye(12)
    assert d.min() > 0.7


def test_curves_are_closed_and_smooth_ones_shorter():
    v, f = shapes.torus(40, 20)
    found = catamaran.curve(v, f, [0, 400, 200, 600, 100, 700])
    smooth = catamaran.curve(v, f, [0, 400, 200, 600, 100, 700], smooth=True)
    assert found.complete and found.curves[0].closed and len(found.left_out) == 0
    assert smooth.curves[0].length <= found.curves[0].length * (1 + 1e-12)
    assert catamaran.curve(v, f, [0, 100, 200], open=True).curves[0].closed is False
    with pytest.raises(ValueError):
        catamaran.curve(v, f, [0, 10**6, 3])


def test_points_of_curves_are_on_faces_of_the_mesh_that_was_given():
    v, f = shapes.torus(40, 20)
    samples = [0, 405, 210, 600, 113, 700]
    curves = catamaran.curve(v, f, samples, smooth=True).curves
    drawn = catamaran.draw(v, f, [(samples, {}), ([3, 205, 611], {})], smooth=True)
    for layer in drawn.layers:
        curves = curves + layer.curves
    for one in curves:
        where = (one.barycentric[:, :, None] * v[f[one.faces]]).sum(axis=1)
        assert np.allclose(where, one.points, atol=1e-12)
        assert (one.barycentric >= 0).all()
        # Some points are on edges.
        assert (one.barycentric.max(axis=1) < 0.999).any()


def test_outliers_are_dropped_on_request():
    v, f = shapes.torus(40, 20)
    ring = [40 * ((7 * i) % 20) for i in range(20)]
    # A vertex of the inner equator.
    stray = ring[:9] + [210] + ring[9:]
    alone = catamaran.curve(v, f, ring, drop_outliers=True)
    found = catamaran.curve(v, f, stray, drop_outliers=True)
    assert len(alone.outliers) == 0 and list(found.outliers) == [9] and found.complete
    assert np.array_equal(found.curves[0].path, alone.curves[0].path)
    layers = catamaran.draw(v, f, [(stray, {"drop_outliers": True}), (stray, {})]).layers
    assert [len(layer.outliers) for layer in layers] == [1, 0]
    with pytest.raises(ValueError, match="drop_outliers"):
        catamaran.curve(v, f, stray, drop_outliers=True, mode="faithful")


def test_signatures_know_poses():
    one, bent, other = shapes.figure(16), shapes.figure(16, 0.6), shapes.torus()
    dna = [catamaran.shape_dna(*mesh, 10) for mesh in (one, bent, other)]
    assert np.linalg.norm(dna[0] - dna[1]) < 0.2 * np.linalg.norm(dna[0] - dna[2])


def test_metrics_know_shapes_that_deformations_hide(tmp_path):
    def dna(radius, factor):
        v, f = shapes.torus(24, 12, 2.0, radius)
        return catamaran.shape_dna(v * [1, 1, factor], f, 6)

    factors = (0.8, 0.95, 1.1, 1.25)
    spectra = [dna(radius, factor) for radius in (0.6, 0.68) for factor in factors]
    names = ["thin"] * 4 + ["thick"] * 4
    with pytest.raises(ValueError, match="at least 13 identities, are of 2"):
        catamaran.RetrievalMetric.fit(spectra, names)
    metric = catamaran.RetrievalMetric.fit(spectra, names, poses_only=True, spectrum="of tori")
    queries = [dna(0.6, 1.18), dna(0.68, 0.9)]
    found = metric.distances(queries, spectra)
    assert found.shape == (2, 8) and metric.k == 6
    assert found[0, :4].max() < found[0, 4:].min() and found[1, 4:].max() < found[1, :4].min()
    # The nearest spectrum by Euclidean distance may be that of the other shape.
    assert np.linalg.norm(queries[0] - spectra, axis=1).argmin() >= 4
    metric.save(tmp_path / "m.json")
    again = pickle.loads(pickle.dumps(metric))
    for copy in (catamaran.RetrievalMetric.load(tmp_path / "m.json"), again):
        assert np.array_equal(copy.distances(queries, spectra), found)
        assert copy.spectrum == "of tori"
    with pytest.raises(ValueError, match="query: expected 6 x 1, got 5 x 1"):
        metric.distances([queries[0][:5]], spectra)
    (tmp_path / "m.json").write_text("{}")
    with pytest.raises(OSError, match="not a metric"):
        catamaran.RetrievalMetric.load(tmp_path / "m.json")


def test_unions_obey_domain_monotonicity():
    v, f = shapes.figure(24)
    top, bottom = v[:, 2] > np.median(v[:, 2]) - 0.2, v[:, 2] < np.median(v[:, 2]) + 0.2
    parts = []
    for mask in (top, bottom):
        inside = f[mask[f].all(axis=1)]
        used, faces = np.unique(inside, return_inverse=True)
        parts.append((v[used], faces.reshape(-1, 3)))
    found = catamaran.union_spectrum(parts)
    assert found.union.shape == (20,) and (np.diff(found.union) >= 0).all()
    assert (found.union <= np.minimum(*found.parts) * (1 + 1e-12)).all()
    again = catamaran.union_spectrum(found.parts[::-1])
    assert np.array_equal(again.union, found.union)


def test_plants_lose_water_and_bend():
    plant = catamaran.grow_plant(150, seed=3)
    found = catamaran.wilt(plant, 48, frames=4)
    total = found.water.sum(axis=1)
    assert np.allclose(found.water[0], found.full_water) and (np.diff(total) < 0).all()
    assert found.tails[-1][:, 2].max() <= found.tails[0][:, 2].max()
    v, f = found.mesh(-1)
    assert v.shape[1] == 3 and f.max() < len(v)
    saved = catamaran.wilt(plant, 48, frames=4, day_night=True, weaken={5: 0.5})
    assert saved.water[-1].sum() > found.water[-1].sum()
    with pytest.raises(ValueError, match="hours"):
        catamaran.wilt(plant, -1.0)


def test_stomata_soil_and_rewatering_balance():
    plant = catamaran.grow_plant(60, seed=3)
    open_ = catamaran.wilt(plant, 100, frames=4, loss=400)
    closed = catamaran.wilt(plant, 100, frames=4, loss=400, stomata=(0.8, 25))
    assert closed.water[-1].sum() > open_.water[-1].sum()
    leaky = catamaran.wilt(plant, 100, frames=4, loss=400, stomata=(0.8, 25, 0.2))
    assert open_.water[-1].sum() < leaky.water[-1].sum() < closed.water[-1].sum()
    # The soil is empty at first, and is watered twice; a part drains.
    pot = catamaran.wilt(plant, 100, frames=4, soil=(1.0, 0.0), rewater={25.0: 0.5, 50.0: 9.0})
    plant_, earth, lost, supplied, drained = pot.balance.T
    assert np.allclose(plant_, pot.water.sum(axis=1), rtol=0, atol=1e-12)
    assert np.allclose(plant_ + earth + lost, plant_[0] + supplied, rtol=0, atol=1e-12)
    assert earth[0] == 0 and supplied[1] == 5e-4 and np.isclose(supplied[-1] + drained[-1], 9.5e-3)
    full = catamaran.wilt(plant, 10, frames=1, soil=1.0, rewater={5.0: None})
    assert full.balance[0, 1] == 1e-3 and full.balance[-1, 4] == 0
    with pytest.raises(ValueError, match="rewater: 20 hours is after the end, 10 hours"):
        catamaran.wilt(plant, 10, soil=1.0, rewater={20.0: None})
    with pytest.raises(ValueError, match="stomata: must be 2 or 3 numbers"):
        catamaran.wilt(plant, 10, stomata=(0.8,))
    with pytest.raises(ValueError, match="soil"):
        catamaran.wilt(plant, 10, soil=(1.0, 2.0))


def test_plants_are_read_by_name_and_unit_and_their_notes_are_warnings(tmp_path):
    path = tmp_path / "plants.mtg"
    rows = "/P1\n^/E1\t10\t1\n/P2\n^/E1\t15\t4\n^<L2\t5\n"
    path.write_text(f"MTG:\nENTITY-CODE\tLength\tTopDia\n{rows}")
    with pytest.raises(OSError, match="2 plants"):
        catamaran.read_plant(path)
    with pytest.warns(UserWarning, match="plants.mtg: 1 of 2 segments have no diameter") as said:
        plant = catamaran.read_plant(path, individual="P2", unit=(0.01, 0.001))
    assert all(warning.filename == __file__ for warning in said)
    assert np.allclose(plant.tails[:, 2], [0.15, 0.2]) and np.allclose(plant.radii, 0.002)
    with pytest.raises(ValueError, match="^unit: must be positive"):
        catamaran.read_plant(path, individual="P2", unit=(0.0, 1.0))


def test_slime_does_not_depend_on_threads():
    v, f = shapes.icosphere(2)
    one = catamaran.slime(v, f, 6, agents=2000, size=160, species=2, threads=1)
    two = catamaran.slime(v, f, 6, agents=2000, size=160, species=2, threads=2)
    assert one.texture.shape == (2, 160, 160) and np.array_equal(one.texture, two.texture)
    assert one.coverage.shape == (6, 2) and one.uv.shape == (len(f), 3, 2)
    again = catamaran.slime(v, f, 2, agents=500, size=160, uv=one.uv)
    assert again.texture.max() > 0
    with pytest.raises(ValueError, match="size"):
        catamaran.slime(v, f, 1, size=32)


def test_slime_says_that_faces_share_texture():
    v, f = shapes.icosphere(1)
    uv = np.tile([[0.1, 0.1], [0.9, 0.1], [0.1, 0.9]], (len(f), 1, 1))
    message = f"faces share texture: {len(f)} of {len(f)} triangles overlap others; without uv"
    with pytest.warns(UserWarning, match=message) as said:
        catamaran.slime(v, f, 1, agents=100, size=160, uv=uv)
    assert all(warning.filename == __file__ for warning in said)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        catamaran.slime(v, f, 1, agents=100, size=160)


def test_newton_finds_the_roots_it_is_told():
    roots = [1.0, -1.0, 1j]
    found = catamaran.newton([[x.real, x.imag, 0.0] for x in map(complex, roots)], roots=roots)
    assert np.array_equal(found.roots, [0, 4, 8])
    plane = catamaran.newton(power=4, size=(40, 30))
    assert plane.roots.shape == plane.convergence.shape == (30, 40)
    assert catamaran.newton(size=12, volume=True).roots.shape == (12, 12, 12)
    assert catamaran.newton(size=(12, 12), volume=True).roots.shape == (12, 12, 12)
    # Of z^2 + 1 the upper half of the plane belongs to i, and row 0 has the largest y.
    halves = catamaran.newton(roots=[1j, -1j], size=6)
    assert (halves.roots[:3] == 0).all() and (halves.roots[3:] == 3).all()
    moved = catamaran.newton(roots=[1j, -1j], size=6, center=(0.0, 2.0))
    assert (moved.roots == 0).all()
    # The middles of four pixels, of a plane that is 3 or 1 wide.
    corners = np.array([[-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0]])
    for more, half in (({}, 0.75), ({"extent": 1.0}, 0.25)):
        grid, listed = catamaran.newton(size=2, **more), catamaran.newton(half * corners)
        assert np.array_equal(grid.roots.ravel(), listed.roots)
        assert np.allclose(grid.convergence.ravel(), listed.convergence)
    with pytest.raises(ValueError, match="iterations"):
        catamaran.newton(size=8, iterations=0)
    with pytest.warns(UserWarning, match="of 1024 points reach no root in 2 iterations; raise"):
        catamaran.newton(size=32, iterations=2)


def test_textures_of_an_opencl_device_are_those_of_the_processor():
    mesh, how = shapes.icosphere(2), {"agents": 500, "size": 160, "species": 2}
    try:
        with pytest.raises(ValueError, match="^device: no device matches \"nowhere\""):
            catamaran.newton(size=8, device="nowhere")
    except RuntimeError as missing:
        assert not os.environ.get("CATAMARAN_REQUIRE_OPENCL"), missing
        pytest.skip(str(missing))
    here, there = (catamaran.newton(size=64, device=device) for device in ("cpu", "opencl"))
    # A GPU may round divisions otherwise, which shows at the borders of basins.
    assert (here.roots != there.roots).sum() <= 8
    here, there = (catamaran.slime(mesh, 4, device=device, **how) for device in ("cpu", "opencl"))
    assert there.texture.shape == here.texture.shape and there.texture.max() > 0
    assert np.allclose(there.coverage, here.coverage, atol=0.05)
    with pytest.raises(TypeError, match="^device: "):
        catamaran.newton(size=8, device=0)
