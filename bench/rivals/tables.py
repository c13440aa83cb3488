"""Tables in files, reading included: A^T A and least squares, beside frames of Python.

    tables.py make FILE ROWS [LEVELS]             20 columns of numbers; with LEVELS, five, two
                                                  factors f and g of so many levels, and y
    tables.py race FILE PROGRAM [TIMES [RECORD]]  runs `PROGRAM` and the rivals by turns
    tables.py rival NAME FILE                     prints the sums or coefficients of a rival

FILE ends in .parquet (or .zstd.parquet) or .csv. Without factors the task is A^T A, of which pandas
and polars read the table and numpy forms the product. With factors it is least squares with an
intercept, where the rival forms A^T A about the mean by tabmat's sandwich, of dense and categorical
blocks, and solves in float64. A race prints, and writes to RECORD, seconds and MB of each process:
the median of TIMES (5), and the largest relative difference of a result from ours.
"""

import csv
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

FACTORS = ["f", "g"]


def make(path, rows, levels):
    import numpy as np
    import polars

    rng = np.random.default_rng(0)
    count = 5 if levels else 20
    columns = {f"x{i}": rng.standard_normal(rows) for i in range(count)}
    if levels:
        columns |= {name: rng.integers(0, levels, rows).astype(np.int32) for name in FACTORS}
        columns["y"] = sum(columns.values()) + rng.standard_normal(rows)
    frame = polars.DataFrame(columns)
    if path.endswith(".csv"):
        frame.write_csv(path)
    else:
        frame.write_parquet(path, compression="zstd" if ".zstd." in path else "snappy")


def is_csv(path):
    return path.endswith(".csv")


def pandas_gram(path):
    import pandas

    a = (pandas.read_csv(path) if is_csv(path) else pandas.read_parquet(path)).to_numpy()
    return a.T @ a


def polars_gram(path):
    import polars

    a = (polars.read_csv(path) if is_csv(path) else polars.read_parquet(path)).to_numpy()
    return a.T @ a


def tabmat_fit(path):
    import numpy as np
    import polars
    from scipy.linalg import solve
    from tabmat import CategoricalMatrix, DenseMatrix, SplitMatrix

    frame = polars.read_csv(path) if is_csv(path) else polars.read_parquet(path)
    numbers = [name for name in frame.columns if name.startswith("x")]
    dense = DenseMatrix(np.asfortranarray(frame.select(numbers).to_numpy()))
    factors = [CategoricalMatrix(frame[name].to_numpy(), drop_first=True) for name in FACTORS]
    a, y = SplitMatrix([dense, *factors]), frame["y"].to_numpy(writable=True)
    ones = np.ones(len(y))
    sums = a.transpose_matvec(ones)
    gram = a.sandwich(ones) - np.outer(sums, sums) / len(y)
    x = solve(gram, a.transpose_matvec(y) - sums * y.mean(), assume_a="pos")
    return x[: len(numbers)]


RIVALS = {"pandas": pandas_gram, "polars": polars_gram, "tabmat": tabmat_fit}


def has_factors(path):
    import polars

    scan = polars.scan_csv(path) if is_csv(path) else polars.scan_parquet(path)
    return "f" in scan.collect_schema().names()


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


def race(path, program, times, record):
    import numpy as np

    folder = tempfile.mkdtemp()
    if has_factors(path):
        output = os.path.join(folder, "x.json")
        ours = [program, "lstsq", path, "--by-column", "y", "--intercept"]
        ours += [argument for name in FACTORS for argument in ("--factor", name)]
        names = ["tabmat"]
    else:
        output = os.path.join(folder, "c.npy")
        ours = [program, "ata", path]
        names = ["pandas", "polars"]
    commands = {"catamaran": [*ours, "-o", output, "--force", "--quiet"]}
    commands |= {name: [sys.executable, __file__, "rival", name, path] for name in names}
    found = {name: [] for name in commands}
    for _ in range(times):
        for name, command in commands.items():
            found[name].append(run(command))
    if output.endswith(".npy"):
        result = np.load(output)
    else:
        with open(output) as file:
            fit = json.load(file)
        result = np.array([x for name, x in zip(fit["columns"], fit["targets"][0]["x"])
                           if name.startswith("x")])
    rows = [["file", "contender", "repetitions", "median_s", "best_s", "peak_mb", "difference"]]
    for name, runs in found.items():
        seconds = [run[0] for run in runs]
        difference = 0.0
        if name != "catamaran":
            other = np.array(json.loads(runs[-1][2]))
            difference = abs(other - result).max() / abs(result).max()
        rows.append([os.path.basename(path), name, times, f"{statistics.median(seconds):.3f}",
                     f"{min(seconds):.3f}", f"{max(run[1] for run in runs):.0f}",
                     f"{difference:.1e}"])
    for row in rows:
        print("".join(f"{field!s:>16}" for field in row))
    if record:
        fresh = not os.path.exists(record)
        with open(record, "a", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(rows if fresh else rows[1:])


task, path, *others = sys.argv[1:]
if task == "make":
    make(path, int(others[0]), int(others[1]) if len(others) > 1 else 0)
elif task == "race":
    times = int(others[1]) if len(others) > 1 else 5
    race(path, others[0], times, others[2] if len(others) > 2 else None)
else:
    print(json.dumps(RIVALS[path](others[0]).tolist()))
