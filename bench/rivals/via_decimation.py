"""Transfer between two poses of a generated figure, through decimations and in full.

    via_decimation.py CATAMARAN CELLS[,CELLS...] HOW[,HOW...]

CATAMARAN is the program, CELLS the resolution of `generate figure`, HOW the vertices of
--via-decimation or `full`. Both poses have the same vertices, so the right value of each function
is known. The functions are the coordinates of the first pose, the landmarks seven vertices far from
each other, refined by ZoomOut to 50 eigenfunctions. Needs numpy. Prints a table: seconds of the
process, and the relative error of x, y and z over the vertices, in per cent.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

LANDMARKS = 7


def landmarks(points):
    """Indices of points far from each other."""
    chosen = [int(points[:, 2].argmax())]
    distance = np.full(len(points), np.inf)
    while len(chosen) < LANDMARKS:
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
        chosen.append(int(distance.argmax()))
    return chosen


def prepare(program, cells, folder):
    """The points of the first pose, and the arguments of `transfer` that name the files."""
    meshes = [str(folder / f"{cells}-{pose}.obj") for pose in (0.1, 0.9)]
    for path, pose in zip(meshes, ("0.1", "0.9")):
        subprocess.run(
            [program, "generate", "figure", cells, pose, "-o", path, "--force", "--quiet"], check=True
        )
    with open(meshes[0]) as file:
        points = np.array([line.split()[1:4] for line in file if line.startswith("v ")], float)
    functions, pairs = (str(folder / name) for name in ("f.csv", "pairs.csv"))
    np.savetxt(functions, points, delimiter=",", fmt="%.17g")
    np.savetxt(pairs, np.array([landmarks(points)] * 2).T, delimiter=",", fmt="%d")
    return points, [*meshes, "--functions", functions, "--landmarks", pairs]


def measure(program, points, arguments, how, folder):
    """The seconds, and the error of each coordinate in per cent."""
    output = str(folder / "g.npy")
    call = [program, "transfer", *arguments, "--zoom", "50", "-o", output, "--force", "--quiet"]
    call += [] if how == "full" else ["--via-decimation", how]
    start = time.perf_counter()
    subprocess.run(call, check=True)
    seconds = time.perf_counter() - start
    error = np.linalg.norm(np.load(output) - points, axis=0)
    return seconds, 100 * error / np.linalg.norm(points, axis=0)


def main(program, cells, hows):
    print("| vertices | through | seconds | x | y | z | mean |\n|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for count in cells.split(","):
            points, arguments = prepare(program, count, folder)
            for how in hows.split(","):
                seconds, error = measure(program, points, arguments, how, folder)
                errors = " | ".join(f"{e:.2f}" for e in (*error, error.mean()))
                print(f"| {len(points)} | {how} | {seconds:.1f} | {errors} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
