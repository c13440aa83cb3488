"""The types of options know the words that the library takes."""

import re
import subprocess
import sys
from typing import get_args, get_type_hints

import numpy as np
import pytest

import catamaran
from catamaran import _words, shapes

A = np.arange(12.0).reshape(4, 3)
V, F = shapes.icosphere(1)

# A call with a word that does not exist, for each type of words.
CALLS = {
    "Accuracy": lambda word: catamaran.ata(A, accuracy=word),
    "Boundary": lambda word: catamaran.laplacian(V, F, boundary=word),
    "DistanceMethod": lambda word: catamaran.distances(V, F, [0], method=word),
    "FileFormat": lambda word: catamaran.read("a.csv", format=word),
    "Gradient": lambda word: catamaran.newton(size=2, gradient=word),
    "Kind": lambda word: catamaran.laplacian(V, F, kind=word),
    "MassKind": lambda word: catamaran.laplacian(V, F, mass=word),
    "MeshFormat": lambda word: catamaran.mesh_to_bytes(V, F, word),
    "Method": lambda word: catamaran.orthogonalize(A, method=word),
    "MissingCells": lambda word: catamaran.read("a.csv", missing=word),
    "MissingRows": lambda word: catamaran.lstsq(A, A[:, 0], missing=word),
    "Mode": lambda word: catamaran.curve(V, F, [0, 1], mode=word),
    "RankDeficiency": lambda word: catamaran.lstsq(A, A[:, 0], rank_deficiency=word),
    "Reduction": lambda word: catamaran.decimate(V, F, 12, method=word),
    "Refinement": lambda word: catamaran.functional_map((V, F), (V, F), k=3, refine=word),
    "Scheme": lambda word: catamaran.ata(A, scheme=word),
    "Side": lambda word: catamaran.enclosed_faces(V, F, [[0, 1]], side=word),
    "Sums": lambda word: catamaran.Accumulator(3, kind=word),
    "Triangle": lambda word: catamaran.ata(A, uplo=word),
    "Weld": lambda word: catamaran.repair(V, F, weld=word),
}


@pytest.mark.parametrize("name", _words.__all__)
def test_the_words_of_a_type_are_those_that_an_error_lists(name):
    with pytest.raises(ValueError, match="is not one of") as raised:
        CALLS[name]("strasen")
    listed = re.findall("'([a-z0-9_]+)'", str(raised.value).split("is not one of")[1])
    words = getattr(_words, name)
    if name == "Accuracy":
        words = get_args(words)[0]
    assert sorted(get_args(words)) == sorted(listed)


def test_options_with_words_have_their_types():
    assert get_type_hints(catamaran.ata)["scheme"] is _words.Scheme
    assert get_type_hints(catamaran.laplacian.__wrapped__)["kind"] is _words.Kind


def test_a_type_checker_refuses_words_and_takes_meshes(tmp_path):
    pytest.importorskip("mypy")
    code = """
import numpy as np
import catamaran

a = np.eye(3)
mesh = catamaran.shapes.icosphere(1)
v, f = mesh
catamaran.ata(a, scheme="kgp", accuracy=8.0)
catamaran.decimate(mesh, 12, method="uniform").mesh.to_trimesh()
catamaran.decimate(v, f, 12)
catamaran.laplacian(v=v, f=f, kind="tufted").stiffness
catamaran.eigsh(mesh, k=3).values
catamaran.count_below(mesh, 3.0)
mesh.compare((v, f)).out
catamaran.ata(a, scheme="strasen")
catamaran.decimate(mesh, 12, method="unifrm")
catamaran.laplacian(v, f, kind="x")
catamaran.count_below(mesh, "3")
"""
    script = tmp_path / "use.py"
    script.write_text(code)
    command = [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", str(script)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=600)
    lines = {int(line) for line in re.findall(r"use.py:(\d+): error", done.stdout)}
    first = code.splitlines().index('catamaran.ata(a, scheme="strasen")') + 1
    assert lines == {first, first + 1, first + 2, first + 3}, done.stdout + done.stderr
