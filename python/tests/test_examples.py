"""Every example runs and writes its picture."""

import os
import subprocess
import sys

import pytest

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
