"""The distribution's name, and another distribution with files in the same folder."""

import os
import subprocess
import sys
from importlib.metadata import distribution
from pathlib import Path

import pytest

import catamaran
from catamaran import _distribution

PACKAGE = Path(catamaran.__file__).parent
OTHER = "catamaran-0.2.22.dist-info"
REMEDY = "pip uninstall catamaran catamaran-numerics"


def python(site, *arguments):
    """Runs Python with the folder `site` in front of all others."""
    return subprocess.run(
        [sys.executable, *arguments],
        env={**os.environ, "PYTHONPATH": str(site)},
        capture_output=True,
        text=True,
        timeout=60,
    )


def link_package(site, without=()):
    """Lays the installed package into the folder `site`, by links; returns its folder there."""
    package = site / "catamaran"
    package.mkdir()
    for path in PACKAGE.iterdir():
        if path.name not in without and path.name != "__pycache__":
            (package / path.name).symlink_to(path)
    return package


def test_the_distribution_has_its_own_name():
    found = distribution(_distribution.NAME)
    assert found.version == catamaran.__version__
    assert "catamaran/__init__.py" in map(str, found.files)
    assert _distribution.find_other(str(PACKAGE.parent)) is None


def test_without_another_distribution_the_import_is_silent(tmp_path):
    link_package(tmp_path)
    (tmp_path / "catamaran_numerics-0.1.0.dist-info").mkdir()
    (tmp_path / "fontpkg_catamaran-2.0.dist-info").mkdir()
    code = "import catamaran, catamaran.preload; print(catamaran.__file__)"
    found = python(tmp_path, "-c", code)
    assert found.stderr == ""
    assert found.stdout == f"{tmp_path}/catamaran/__init__.py\n"


@pytest.mark.parametrize("other", [OTHER, "catamaran-0.2.22-py3.11.egg-info"])
def test_another_distribution_beside_the_package_is_a_warning(tmp_path, other):
    link_package(tmp_path)
    (tmp_path / other).mkdir()
    code = "import catamaran, numpy; print(catamaran.ata(numpy.eye(2)).sum())"
    found = python(tmp_path, "-c", code)
    assert found.stdout == "2.0\n", found.stderr
    # The line of the program that imports, and what it finds.
    assert found.stderr.startswith("<string>:1: RuntimeWarning: "), found.stderr
    for part in (other, str(tmp_path / "catamaran"), REMEDY):
        assert part in found.stderr


def test_a_package_overwritten_by_the_other_distribution_is_an_error(tmp_path):
    init = link_package(tmp_path, without=["__init__.py"]) / "__init__.py"
    init.write_text('"""Another project."""\n')
    (tmp_path / OTHER).mkdir()
    for arguments in (["-c", "import catamaran.sklearn"], ["-m", "catamaran.preload", "--help"]):
        found = python(tmp_path, *arguments)
        assert found.returncode == 1
        assert "ImportError" in found.stderr, found.stderr
        for part in (str(init), _distribution.NAME, REMEDY):
            assert part in found.stderr


def test_a_package_in_a_file_has_nothing_beside_it(tmp_path):
    archive = tmp_path / "archive.zip"
    archive.write_bytes(b"")
    assert _distribution.find_other(str(archive)) is None
