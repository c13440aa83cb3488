"""Every example runs and writes its picture."""

import os
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import catamaran
from conftest import ROOT

EXAMPLES = sorted(p for p in (ROOT / "python/examples").glob("*.py") if not p.name.startswith("_"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_examples(example, tmp_path):
    pytest.importorskip("matplotlib")
    picture = tmp_path / "picture.png"
    found = subprocess.run(
        [sys.executable, "-W", "error::DeprecationWarning", str(example), str(picture)],
        capture_output=True,
        text=True,
        timeout=300,
        cwd=tmp_path,
        env={**os.environ, "MPLCONFIGDIR": str(tmp_path)},
    )
    assert found.returncode == 0, found.stderr
    assert picture.stat().st_size > 10_000


def test_meshes_have_the_same_numbers_as_in_cpp(tmp_path, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    build = Path(os.environ.get("CATAMARAN_C_BUILD", target / "c-tests"))
    program = build.resolve() / "plain/tests/c/example_mesh_cpp"
    if not program.exists():
        pytest.skip(f"{program} is missing: tests/c/run.sh builds it")
    output = tmp_path / "mesh"
    told = subprocess.run(
        [program, output], check=True, capture_output=True, text=True, timeout=300
    ).stdout
    examples = ROOT / "python/examples"
    monkeypatch.syspath_prepend(str(examples))
    monkeypatch.setattr(sys, "argv", ["mesh.py", str(tmp_path / "mesh.png")])
    here = runpy.run_path(str(examples / "mesh.py"))
    assert capsys.readouterr().out.startswith(told)
    numbers = np.column_stack([here["distances"], here["vectors"]])
    there = np.loadtxt(f"{output}.csv", delimiter=",")
    np.testing.assert_allclose(numbers, there, rtol=0, atol=1e-9)
    v, f = catamaran.read_mesh(f"{output}.ply")
    np.testing.assert_allclose(here["small"].v, v, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(here["small"].f, f)


def test_there_is_an_example_for_each_chapter():
    names = {path.stem for path in EXAMPLES}
    assert names >= {
        "products",
        "spectral",
        "decimate",
        "curve",
        "unions",
        "plant",
        "slime",
        "newton",
    }
