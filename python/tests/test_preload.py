"""Starting Python with another library under it: any library will do."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from catamaran import _catamaran, preload

PACKAGE = Path(preload.__file__).parent

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="LD_PRELOAD")


def python(*arguments, **environment):
    clean = {
        k: v for k, v in os.environ.items() if k not in ("LD_PRELOAD", "CATAMARAN_BLAS_LIBRARY")
    }
    return subprocess.run(
        [sys.executable, *arguments],
        capture_output=True,
        text=True,
        timeout=60,
        env={**clean, **environment},
    )


def test_scripts_modules_and_code_run_with_the_library(tmp_path):
    library = _catamaran.__file__
    script = tmp_path / "script.py"
    script.write_text("import os, sys; print(os.environ['LD_PRELOAD'], sys.argv[1:])")
    for arguments in ([script, "x", "-y"], ["-c", script.read_text(), "x", "-y"]):
        found = python(
            "-m", "catamaran.preload", *map(str, arguments), CATAMARAN_BLAS_LIBRARY=library
        )
        assert found.stdout == f"{library} ['x', '-y']\n", found.stderr
        assert found.stderr == ""
    found = python("-m", "catamaran.preload", "-m", "this", CATAMARAN_BLAS_LIBRARY=library)
    assert "Zen" in found.stdout


def test_a_program_starts_itself_again(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import os, sys, catamaran\n"
        "print('start', flush=True)\n"
        "catamaran.numpy_speedup('reproducible')\n"
        "print(os.environ['LD_PRELOAD'], os.environ['CATAMARAN_BLAS'], sys.argv[1:])\n"
    )
    library = _catamaran.__file__
    found = python(str(script), "a", CATAMARAN_BLAS_LIBRARY=library)
    assert found.stdout == f"start\nstart\n{library} reproducible ['a']\n", found.stderr


def test_a_missing_library_is_an_error_that_says_where_it_was_looked_for(tmp_path):
    if any(folder.joinpath(preload.NAME).exists() for folder in (PACKAGE, Path(sys.prefix, "lib"))):
        pytest.skip("it is there")
    found = python("-m", "catamaran.preload", "-c", "print('runs')", HOME=str(tmp_path))
    assert found.returncode == 1 and found.stdout == ""
    assert "CATAMARAN_BLAS_LIBRARY" in found.stderr and "scripts/build-blas" in found.stderr
    found = python(
        "-m", "catamaran.preload", "x.py", CATAMARAN_BLAS_LIBRARY=str(tmp_path / "none.so")
    )
    assert found.returncode == 1 and "there is no file" in found.stderr
    assert python("-m", "catamaran.preload").returncode == 2


def test_the_module_runs_without_a_warning_and_has_its_names():
    found = python("-W", "error", "-m", "catamaran.preload", "--help")
    assert found.returncode == 0 and "Warning" not in found.stderr, found.stderr
    for name in preload.__all__:
        assert hasattr(preload, name)


def test_the_library_is_found_where_build_blas_puts_it(tmp_path, monkeypatch):
    installed = tmp_path / "lib" / preload.NAME
    installed.parent.mkdir()
    installed.write_bytes(b"")
    monkeypatch.delenv("CATAMARAN_BLAS_LIBRARY", raising=False)
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    if not (PACKAGE / preload.NAME).exists():
        assert preload.find_library() == str(installed)


def test_modes_and_interactive_sessions(monkeypatch):
    monkeypatch.setattr(sys, "argv", [""])
    with pytest.raises(RuntimeError, match="no program to start again"):
        preload.numpy_speedup()
    monkeypatch.setattr(sys, "argv", ["script.py"])
    with pytest.raises(ValueError, match="mode: 'fast' is not one of"):
        preload.numpy_speedup("fast")
    monkeypatch.setenv("LD_PRELOAD", f"/somewhere/{preload.NAME}")
    preload.numpy_speedup("fast")  # loaded already
