"""The code of the guide and of the README runs, and everything is documented."""

import inspect
import re
import shutil
import subprocess
import sys

import pytest
from conftest import ROOT

import catamaran


@pytest.mark.parametrize("page", ["python/README.md", "docs/guide/python.md"])
def test_code_runs(page):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.DOTALL)
    assert blocks
    for block in blocks:
        if "mpi4py" not in block:
            exec(block, {})
        elif shutil.which("mpirun"):
            # MPI would stay in this process.
            subprocess.run([sys.executable, "-c", block], check=True)


def test_everything_is_documented():
    for name in catamaran.__all__:
        public = getattr(catamaran, name)
        assert name == "__version__" or inspect.getdoc(public), name
        if inspect.isfunction(public) and inspect.signature(public).parameters:
            text = inspect.getdoc(public)
            assert "Examples" in text or "Parameters" in text, name


def test_the_guide_names_every_function():
    guide = (ROOT / "docs/guide/python.md").read_text()
    for name in catamaran.__all__:
        if inspect.isfunction(getattr(catamaran, name)):
            assert name in guide, name


def test_functions_say_what_they_do_in_the_third_person():
    def documented(owner):
        for name, value in vars(owner).items():
            value = getattr(value, "__func__", value)
            if inspect.isfunction(value) and not name.startswith("_") and value.__doc__:
                yield name, value.__doc__.split()[0]

    public = [getattr(catamaran, name) for name in catamaran.__all__]
    owners = [catamaran, *filter(inspect.isclass, public), *filter(inspect.ismodule, public)]
    words = [word for owner in owners for word in documented(owner)]
    assert len(words) > 100
    assert [(name, word) for name, word in words if not word.endswith("s")] == []
