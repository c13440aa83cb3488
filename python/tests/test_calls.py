"""Progress, exceptions in callbacks, Ctrl-C, threads, and the end of the interpreter."""

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest

import catamaran


def run(code, **more):
    """Starts Python with this code."""
    return subprocess.Popen(
        [sys.executable, "-c", "import numpy as np, catamaran, sys\n" + textwrap.dedent(code)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **more,
    )


def test_progress_ends_at_the_total(rng):
    told = []
    a = rng.standard_normal((2000, 500))
    expected = catamaran.ata(a)
    found = catamaran.ata(a, progress=lambda done, total: told.append((done, total)))
    assert np.array_equal(found, expected)
    assert told[-1] == (1000, 1000)
    assert all(0 <= a <= b for (a, _), (b, _) in zip(told, told[1:]))


def test_progress_bars_of_tqdm(rng):
    tqdm = pytest.importorskip("tqdm").tqdm
    with open(os.devnull, "w") as nowhere:
        for total in (None, 10):
            with tqdm(total=total, file=nowhere) as bar:
                catamaran.ata(rng.standard_normal((2000, 300)), progress=bar)
                assert bar.n == bar.total == (total or 1000)


def test_every_chapter_tells_its_progress():
    v, f = catamaran.shapes.icosphere(2)
    a = np.random.default_rng(0).standard_normal((50, 4))
    calls = [
        lambda progress: catamaran.ata(a, a, progress=progress),
        lambda progress: catamaran.cov(a, progress=progress),
        lambda progress: catamaran.lstsq(a, a[:, 0], progress=progress),
        lambda progress: catamaran.pca(a, progress=progress),
        lambda progress: catamaran.svd(a, progress=progress),
        lambda progress: catamaran.qr(a, progress=progress),
        lambda progress: catamaran.Accumulator(4).add(a, progress=progress),
        lambda progress: catamaran.eigsh(v, f, 3, progress=progress),
        lambda progress: catamaran.decimate(v, f, 40, progress=progress),
        lambda progress: catamaran.farthest_points(v, f, 4, progress=progress),
        lambda progress: catamaran.curve(v, f, [0, 5, 9], progress=progress),
        lambda progress: catamaran.slime(v, f, 2, agents=10, size=160, progress=progress),
        lambda progress: catamaran.newton(size=8, progress=progress),
        lambda progress: catamaran.eigenproducts(v, f, 3, progress=progress),
        lambda progress: catamaran.transfer((v, f), (v, f), v, k=3, progress=progress),
        lambda progress: catamaran.draw(v, f, [([0, 5, 9], {})], progress=progress),
        lambda progress: catamaran.shot(v, f, 0.5, progress=progress),
        lambda progress: catamaran.cloud_laplacian(v, progress=progress),
        lambda progress: catamaran.isosurface(np.ones((2, 2, 2)), progress=progress),
    ]
    for call in calls:
        told = []
        call(lambda done, total: told.append(done))
        assert told[-1] == 1000
    # Bases of meshes come first.
    told = []
    catamaran.transfer((v, f), (v, f), v, k=3, progress=lambda done, total: told.append(done))
    assert {300, 600, 1000} <= set(told)


def test_an_exception_in_a_callback_ends_the_call():
    class Stop(Exception):
        pass

    def stop(done, total):
        raise Stop(f"at {done}")

    a = np.ones((60_000, 1500))
    with pytest.raises(Stop) as raised:
        catamaran.ata(a, scheme="exact", threads=1, progress=stop)
    assert int(str(raised.value).split()[1]) < 1000
    # The last call of a callback, too.
    with pytest.raises(Stop, match="at 1000"):
        catamaran.ata(np.ones((3, 3)), progress=lambda d, t: stop(d, t) if d == t else None)
    with pytest.raises(SystemExit):
        catamaran.ata(a[:20_000], scheme="exact", threads=1, progress=lambda d, t: sys.exit(3))


def test_the_interpreter_runs_on_meanwhile(rng):
    a = np.ones((20_000, 1000))
    steps = 0
    options = {"scheme": "exact", "threads": 1}
    worker = threading.Thread(target=catamaran.ata, args=(a,), kwargs=options)
    worker.start()
    while worker.is_alive():
        steps += 1
        time.sleep(0.001)
    worker.join()
    assert steps > 10


def test_many_threads_call_at_once(rng):
    a = rng.standard_normal((500, 200))
    expected, found = catamaran.ata(a), []
    workers = [threading.Thread(target=lambda: found.append(catamaran.ata(a))) for _ in range(6)]
    [worker.start() for worker in workers]
    [worker.join() for worker in workers]
    assert len(found) == 6 and all(np.array_equal(c, expected) for c in found)


def test_ctrl_c_ends_a_call():
    process = run("""
        import signal
        # Ignored in background jobs of shells.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        a = np.ones((60_000, 1500))
        try:
            def tell(done, total):
                print("started", flush=True)
            catamaran.ata(a, scheme="exact", threads=1, progress=tell)
        except KeyboardInterrupt:
            print("interrupted")
            print(catamaran.ata(np.eye(2)))
    """)
    assert process.stdout.readline() == "started\n"
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert "interrupted" in out and "[0. 1.]" in out and process.returncode == 0, err


# None of these reports progress while it factorizes, flips edges or solves for pairs.
LONG = {
    "shape_dna": "catamaran.shape_dna(v, f, 100, threads=1)",
    "eigsh": "catamaran.eigsh(v, f, 60, threads=1)",
    "eigenproducts": "catamaran.eigenproducts(v, f, 60, 1, threads=1)",
    "laplacian": "catamaran.laplacian(v, f, kind='tufted', threads=1)",
    "decimate": "catamaran.decimate(v, f, 20_000, threads=1)",
    "farthest_points": "catamaran.farthest_points(v, f, 50_000)",
    "eigsh_dense": "catamaran.eigsh(*catamaran.shapes.grid(33, 33), 1000, threads=1)",
}


@pytest.mark.parametrize("call", LONG)
def test_an_exception_ends_long_calls_before_they_are_done(call):
    v, f = catamaran.shapes.icosphere(7)
    names = {"catamaran": catamaran, "v": v, "f": f}
    told = []

    def stop(done, total):
        told.append(done)
        raise KeyboardInterrupt

    code = LONG[call][:-1] + ", progress=stop)"
    with pytest.raises(KeyboardInterrupt):
        eval(code, names | {"stop": stop})
    assert len(told) == 1 and told[0] < 1000


def test_the_end_of_the_interpreter_waits_for_no_daemon():
    process = run("""
        import threading, time
        a = np.ones((60_000, 3000))
        call = lambda: catamaran.ata(a, scheme="exact", threads=1)
        threading.Thread(target=call, daemon=True).start()
        time.sleep(0.3)
        print("ends", flush=True)
    """)
    out, err = process.communicate(timeout=60)
    assert out == "ends\n" and process.returncode == 0, (process.returncode, err)
    assert err == ""


def test_a_wrong_limit_on_instruction_sets_is_an_error_of_the_import():
    wrong = run("", env={**os.environ, "CATAMARAN_ISA": "avx3"})
    text = wrong.communicate(timeout=60)[1]
    assert wrong.returncode == 1
    names = "portable, neon, dotprod, i8mm, avx2, avxvnni, avx512, vnni or amx"
    assert f"CATAMARAN_ISA: must be {names}" in text, text


def test_reproducible_bytes_are_the_same_within_every_limit():
    code = """
        a = np.random.default_rng(3).standard_normal((90, 70))
        for n in (3, 70):
            print(catamaran.ata(a[:, :n], reproducible=True).tobytes().hex())
    """
    found = set()
    for isa in ("", "portable", "avx2", "avxvnni", "avx512"):
        child = run(code, env={**os.environ, "CATAMARAN_ISA": isa})
        found.add(child.communicate(timeout=60)[0])
        assert child.returncode == 0
    assert len(found) == 1
