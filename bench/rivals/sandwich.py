"""Least squares with two factors from a file, reading included, beside polars and tabmat.

    sandwich.py make FILE ROWS LEVELS       writes 5 columns of numbers, factors f and g, and y
    sandwich.py race FILE PROGRAM [TIMES]   runs `PROGRAM lstsq` and the rival by turns
    sandwich.py rival FILE                  prints the coefficients of the numbers by the rival

FILE ends in .parquet or .csv. The rival forms A^T A about the mean by tabmat's sandwich, of dense
and categorical blocks, and solves in float64. A race prints seconds and MB of each process.
"""

import json
import os
import subprocess
import sys
import tempfile
import time

NUMBERS = [f"x{i}" for i in range(5)]
FACTORS = ["f", "g"]


def make(path, rows, levels):
    import numpy as np
    import polars

    rng = np.random.default_rng(0)
    columns = {name: rng.standard_normal(rows) for name in NUMBERS}
    columns |= {name: rng.integers(0, levels, rows).astype(np.int32) for name in FACTORS}
    columns["y"] = sum(columns.values()) + rng.standard_normal(rows)
    frame = polars.DataFrame(columns)
    if path.endswith(".csv"):
        frame.write_csv(path)
    else:
        frame.write_parquet(path, compression="snappy")


def rival(path):
    import numpy as np
    import polars
    from scipy.linalg import solve
    from tabmat import CategoricalMatrix, DenseMatrix, SplitMatrix

    frame = polars.read_csv(path) if path.endswith(".csv") else polars.read_parquet(path)
    dense = DenseMatrix(np.asfortranarray(frame.select(NUMBERS).to_numpy()))
    factors = [CategoricalMatrix(frame[name].to_numpy(), drop_first=True) for name in FACTORS]
    a, y = SplitMatrix([dense, *factors]), frame["y"].to_numpy(writable=True)
    ones = np.ones(len(y))
    sums = a.transpose_matvec(ones)
    gram = a.sandwich(ones) - np.outer(sums, sums) / len(y)
    x = solve(gram, a.transpose_matvec(y) - sums * y.mean(), assume_a="pos")
    print(json.dumps(x[: len(NUMBERS)].tolist()))


def run(command):
    """Seconds, MB at the peak, and the output of a process."""
    start = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        text = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{command}: {process.returncode}")
    return time.perf_counter() - start, usage.ru_maxrss / 1024, text


def race(path, program, times):
    with tempfile.TemporaryDirectory() as folder:
        output = os.path.join(folder, "x.json")
        options = ["--by-column", "y", "--intercept", "-o", output, "--force"]
        ours = [program, "lstsq", path, *options]
        for name in FACTORS:
            ours += ["--factor", name]
        for _ in range(times):
            seconds, megabytes, _ = run(ours)
            print(f"catamaran      {seconds:7.2f} s {megabytes:7.0f} MB", flush=True)
            seconds, megabytes, text = run([sys.executable, __file__, "rival", path])
            print(f"polars, tabmat {seconds:7.2f} s {megabytes:7.0f} MB", flush=True)
        with open(output) as file:
            found = json.load(file)
    x = dict(zip(found["columns"], found["targets"][0]["x"]))
    print("largest difference", max(abs(x[name] - y) for name, y in zip(NUMBERS, json.loads(text))))


task, path, *others = sys.argv[1:]
if task == "make":
    make(path, int(others[0]), int(others[1]))
elif task == "race":
    race(path, others[0], int(others[1]) if len(others) > 1 else 3)
else:
    rival(path)
