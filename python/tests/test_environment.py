"""The caller's rounding mode, and the threads of the process."""

import ctypes
import os
import subprocess
import sys

import numpy as np
import pytest

import catamaran

# Upward, downward and toward zero, as fenv.h has them on x86-64.
MODES = [0x800, 0x400, 0xC00]

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux") or os.uname().machine != "x86_64",
    reason="numbers of fenv.h on x86-64 Linux",
)


def results():
    """Bytes of results of all kinds, of inputs that no rounding mode changes."""
    numbers = np.random.default_rng(5).integers(-1000, 1000, (400, 200))
    a = numbers / 1024.0
    few, targets = np.ascontiguousarray(a[:, :6]), a[:, 6]
    weights = np.arange(1.0, 401.0)
    vertices, faces = catamaran.shapes.icosphere(2)
    vertices = np.round(vertices * 1024) / 1024
    accumulator = catamaran.Accumulator(6, center=True)
    accumulator.add(few)
    other = catamaran.Accumulator(6, center=True)
    other.add(few[::-1] * 3.0)
    accumulator.merge(other)
    basis = catamaran.Eigenbasis(vertices, faces, 5)
    found = [
        catamaran.ata(a),
        catamaran.ata(a, threads=4),
        catamaran.ata(a, reproducible=True),
        catamaran.ata(a, scheme="rxtx"),
        catamaran.ata(few),
        catamaran.cov(few, fweights=weights),
        catamaran.lstsq(few, targets).x,
        catamaran.lstsq(few, targets).predict(few),
        catamaran.svd(few).s,
        catamaran.svd(few, compute_u=True).u,
        catamaran.pca(few, 2).components,
        accumulator.cov(),
        accumulator.result(alpha=0.3),
        *catamaran.eigsh(vertices, faces, 5)[:2],
        *basis.split(vertices),
        *basis.heat_kernel_signature(3),
        *basis.wave_kernel_signature(3),
        catamaran.decimate(vertices, faces, 40).carried(faces, vertices),
    ]
    return [np.asarray(x).tobytes() for x in found]


def set_mode(mode):
    assert ctypes.CDLL("libm.so.6").fesetround(mode) == 0


@pytest.mark.parametrize("mode", MODES)
def test_the_mode_of_the_caller_never_enters_a_result(mode):
    """The first calls of a process, and later ones."""
    script = f"""
import ctypes
from test_environment import results, set_mode
libm = ctypes.CDLL("libm.so.6")
set_mode({mode})
first = results()
assert libm.fegetround() == {mode}
set_mode(0)
nearest = results()
set_mode({mode})
later = results()
set_mode(0)
assert [x == y for x, y in zip(first, nearest)] == [True] * len(first)
assert [x == y for x, y in zip(later, nearest)] == [True] * len(first)
"""
    done = run(script)
    assert done.returncode == 0, done.stderr


def run(script, **variables):
    environment = {k: v for k, v in os.environ.items() if not k.endswith("_NUM_THREADS")}
    folder = os.path.dirname(__file__)
    return subprocess.run(
        [sys.executable, "-c", script],
        env={**environment, "PYTHONPATH": folder, "OPENBLAS_NUM_THREADS": "1", **variables},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


COUNT = """
import os
import time
import numpy as np
import catamaran
before = len(os.listdir("/proc/self/task"))
a = np.random.default_rng(1).standard_normal((600, 300))
for _ in range(20):
    catamaran.ata(a)
    catamaran.ata(a, reproducible=True)
time.sleep(0.1)  # threads of their own calls are still on the system's list when they have ended
print(len(os.listdir("/proc/self/task")) - before)
"""


def threads_started(**variables):
    done = run(COUNT, **variables)
    assert done.returncode == 0, done.stderr
    return int(done.stdout), done.stderr


@pytest.mark.parametrize("name", ["OMP_NUM_THREADS", "CATAMARAN_NUM_THREADS", "RAYON_NUM_THREADS"])
def test_variables_limit_the_threads(name):
    assert threads_started(**{name: "1"}) == (0, "")


def test_threadpoolctl_limits_calls_that_name_no_threads():
    threadpoolctl = pytest.importorskip("threadpoolctl")
    own = [found for found in threadpoolctl.threadpool_info() if found["prefix"] == "_catamaran"]
    assert [found["internal_api"] for found in own] == ["catamaran"]
    assert own[0]["version"] == catamaran.__version__
    assert own[0]["num_threads"] == catamaran._catamaran.get_num_threads() >= 1
    limited = "from threadpoolctl import threadpool_limits\nthreadpool_limits(1)\n"
    done = run(COUNT.replace("before =", limited + "before ="))
    assert done.returncode == 0 and int(done.stdout) == 0, done.stderr
    a = np.random.default_rng(2).standard_normal((500, 90))
    expected = catamaran.ata(a)
    for limit in (1, 2, 10_000):
        with threadpoolctl.threadpool_limits(limit, user_api="blas"):
            assert np.array_equal(catamaran.ata(a), expected)
    assert catamaran._catamaran.get_num_threads() == own[0]["num_threads"]


def test_threads_are_kept_between_calls():
    cores = len(os.sched_getaffinity(0))
    started, _ = threads_started()
    assert started == cores - 1


def test_a_number_of_threads_that_is_none_is_named():
    _, errors = threads_started(CATAMARAN_NUM_THREADS="many")
    assert errors.count("CATAMARAN_NUM_THREADS=many: must be a number from 1") == 1


def test_processes_forked_again_and_again_compute():
    script = """
import multiprocessing
import numpy as np
import catamaran

a = np.random.default_rng(1).standard_normal((600, 300))
expected = catamaran.ata(a, threads=3)

def inner(queue):
    queue.put(np.array_equal(catamaran.ata(a, threads=3), expected))

def outer(queue):
    assert np.array_equal(catamaran.ata(a, threads=2), expected)
    child = multiprocessing.get_context("fork").Process(target=inner, args=(queue,))
    child.start()
    child.join(60)
    assert child.exitcode == 0

context = multiprocessing.get_context("fork")
queue = context.Queue()
children = [context.Process(target=outer, args=(queue,)) for _ in range(4)]
for child in children:
    child.start()
assert all(queue.get(timeout=60) for _ in children)
for child in children:
    child.join(60)
    assert child.exitcode == 0
assert np.array_equal(catamaran.ata(a, threads=3), expected)
"""
    done = run(script)
    assert done.returncode == 0, done.stderr
