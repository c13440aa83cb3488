"""No contiguous or strided float64 matrix is copied."""

import subprocess
import sys
import textwrap

import pytest

CODE = """
import resource, sys
import numpy as np, catamaran
def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024  # MiB
base = np.ones((2_000_000, 16))  # 244 MiB
a = {view}
small = a[:1000]
b = np.ones(len(a))
call = lambda a, b: {call}
call(small, b[:1000])
before = peak()
call(a, b)
print(peak() - before, a.nbytes / 2**20)
"""

VIEWS = {
    "C order": "base",
    "Fortran order": "base.reshape(16, -1).T",
    "columns left out": "base[:, ::2]",
    "negative strides": "base[::-1, ::-1]",
}


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize(
    "call",
    [
        "catamaran.ata(a)",
        "catamaran.ata(a, center=True, weights=b)",
        "catamaran.cov(a)",
        "catamaran.lstsq(a[:400_000], b[:400_000], standard_errors=False)",
        "catamaran.Accumulator(a.shape[1]).add(a)",
    ],
)
def test_matrices_are_not_copied(view, call):
    code = CODE.format(view=VIEWS[view], call=call)
    found = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, timeout=120
    )
    assert found.returncode == 0, found.stderr
    more, size = map(float, found.stdout.split())
    # Two blocks of rows, each 32 MiB at most, and the stacks of threads: a copy is 122 MiB or more.
    assert more < 100 < size, (more, size)
