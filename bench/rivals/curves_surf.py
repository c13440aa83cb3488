"""Curves through unordered samples: this library beside curves-surf.

    curves_surf.py OURS THEIRS MESHES RUNS [CURVES [MESH,...]]

OURS is `catamaran`, THEIRS the program of curves-surf ("Reconstructing Curves from Sparse Samples
on Riemannian Manifolds", CGF 2024), MESHES the folder of CATAMARAN_DATA/meshes. Needs numpy and
scipy. CURVES (15) walks of the thesis' generator (section 6.4.1) and as many loops of level sets
are made on each mesh, of volume 1: those of the record curves.md but the one of a million vertices
and the lion, whose faces disagree. A curve has 25, 50 or 100 samples (in turns), evenly spaced
among its vertices and at random. Both programs get the same files; each run is a process of its
own. RUNS (.csv) gets a line for each run; curves that it has are not measured again, so that the
work can be done in parts (MESH,... selects some). The tables of all its runs are printed:

- order: per cent of the runs with one closed curve on which all samples are in their true order;
- one: per cent of the runs with one closed curve;
- mean, H: the mean distance between the curve found and the true one (both ways), and the Hausdorff
  distance, as medians over runs; H, 95 %: what 95 % of the runs stay within;
- seconds: the median of what the programs report, without reading, writing and the geodesics
  between samples (but ours with paths along edges), and of CPU time of the whole process.
"""

import csv
import json
import re
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from curve_outliers import at, is_rotation, loop
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

MESHES = {
    "torus": "torus 240 100 2 0.8",
    "knot": "knot 2 3 600 60 0.3",
    "genus 3": "genus 3 18",
    "cheese": "cheese_genus133.off.gz",
    "bunny": "ofp_bunny10k.off.gz",
    "nefertiti": "nefertiti35k.obj.gz",
    "armadillo": "armadillo43k.obj.gz",
    "elephant": "refined_elephant44k.off.gz",
}
SIZES = [25, 50, 100]
LEAST_VERTICES = 100
# Points at which the distance of two curves is measured, and those that find vertices of a loop.
PLACES = 2000
KINDS = {"walk": "walks", "loop": "level sets"}
METHODS = {
    "ours": ["--smooth"],
    "ours, single": ["--single", "--smooth"],
    "theirs": True,
    "theirs, single": False,
}
SECONDS = 300
SEED = 6


class Surface:
    """A mesh of volume 1 in a file, and its graph."""

    def __init__(self, program, source, meshes, folder):
        self.path = str(Path(folder) / "mesh.obj")
        shape = source.split()
        made = len(shape) > 1
        make = [program, "generate", *shape] if made else [program, "mesh", str(meshes / source)]
        make += ["-o", self.path, "--force", "--quiet"]
        subprocess.run(make, check=True, stdout=subprocess.DEVNULL)
        rows = [line.split() for line in open(self.path)]
        v = np.array([row[1:4] for row in rows if row[:1] == ["v"]], float)
        corners = [[c.split("/")[0] for c in row[1:4]] for row in rows if row[:1] == ["f"]]
        self.f = np.array(corners, int) - 1
        a, b, c = (v[self.f[:, k]] for k in range(3))
        self.v = v / np.cbrt(abs((a * np.cross(b, c)).sum() / 6))
        with open(self.path, "w") as file:
            file.writelines(f"v {x!r} {y!r} {z!r}\n" for x, y, z in self.v.tolist())
            file.writelines(f"f {i} {j} {k}\n" for i, j, k in (self.f + 1).tolist())
        ends = np.unique(np.sort(self.f[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0)
        self.graph = self.graph_of(np.vstack([ends, ends[:, ::-1]]))

    def graph_of(self, ends):
        i, j = ends.T
        lengths = np.linalg.norm(self.v[i] - self.v[j], axis=1)
        return coo_matrix((lengths, (i, j)), shape=(len(self.v),) * 2).tocsr()

    def around(self, i):
        return self.graph.indices[self.graph.indptr[i] : self.graph.indptr[i + 1]]

    def walk(self, rng):
        """The vertices of a closed walk of section 6.4.1 of the thesis; None where it fails."""
        start = at = int(rng.integers(len(self.v)))
        height = dijkstra(self.graph, indices=start)
        curve = [start]
        while len(up := [u for u in self.around(at) if height[u] > height[at]]):
            at = int(rng.choice(up))
            curve.append(at)
        top, away = height[at], dijkstra(self.graph, indices=at)
        for _ in range(int(rng.integers(len(curve) // 4, len(curve) + 1))):
            ahead = [u for u in self.around(at) if away[u] > away[at] and u not in curve]
            if not ahead:
                break
            at = int(min(ahead, key=lambda u: abs(height[u] - top)))
            curve.append(at)
        ends = np.column_stack(self.graph.nonzero())
        free = ~np.isin(ends, np.setdiff1d(curve, [start, at])).any(axis=1)
        _, before = dijkstra(self.graph_of(ends[free]), indices=at, return_predecessors=True)
        if before[start] < 0:
            return None
        back = [int(before[start])]
        while back[-1] != at:
            back.append(int(before[back[-1]]))
        return curve + back[-2::-1]

    def curve(self, kind, rng):
        """The vertices of a closed curve in order, and the points of the curve."""
        while True:
            if kind == "walk":
                vertices = self.walk(rng)
                points = None if vertices is None else self.v[vertices]
            elif (points := loop(self.v, self.f, rng)) is None:
                vertices = None
            else:
                places, _ = at(points, np.arange(PLACES) / PLACES)
                _, vertices = cKDTree(self.v).query(places)
                _, first = np.unique(vertices, return_index=True)
                vertices = vertices[np.sort(first)]
            if vertices is not None and len(vertices) >= LEAST_VERTICES:
                return np.array(vertices), points


def samples(curve, count, even, rng):
    """Samples of a curve in order."""
    n = len(curve)
    if even:
        return curve[np.arange(count) * n // count]
    return curve[np.sort(rng.choice(n, count, replace=False))]


def dense(polygons):
    """Points of polylines, at equal distances."""
    pieces = []
    for points in polygons:
        length = np.r_[0, np.linalg.norm(np.diff(points, axis=0), axis=1).cumsum()]
        pieces.append((points, length))
    gap = sum(length[-1] for _, length in pieces) / PLACES
    found = []
    for points, length in pieces:
        places = np.arange(0, length[-1] + gap / 2, gap or 1)
        found.append(np.stack([np.interp(places, length, points[:, k]) for k in range(3)], axis=1))
    return np.vstack(found)


def apart(truth, found):
    """The mean distance (both ways) and the Hausdorff distance of two sets of points."""
    ahead, _ = cKDTree(found).query(truth)
    back, _ = cKDTree(truth).query(found)
    return (ahead.mean() + back.mean()) / 2, max(ahead.max(), back.max())


def ours(program, surface, samples_file, options, folder):
    """The orders of the closed curves found, their points, and the seconds that it took."""
    result = folder / "ours.json"
    command = [program, "curve", surface.path, "--samples", str(samples_file), "-o", str(result)]
    command += ["--force", "--json", *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
    if done.returncode:
        raise ValueError(done.stderr)
    records = map(json.loads, done.stdout.splitlines())
    seconds = next(r["seconds"] for r in records if r["record"] == "samples")
    curves = json.load(open(result))["curves"]
    orders = [curve["order"] for curve in curves if curve["closed"]]
    points = [np.array(curve["points"]) for curve in curves]
    return orders, [np.vstack([p, p[:1]]) for p in points], seconds


def theirs(program, surface, samples_file, several, folder):
    """The same of curves-surf, whose lines between samples come in the order of its cycles."""
    settings = folder / "settings.json"
    prefix = str(folder / "theirs-")
    content = {"mesh": surface.path, "samples": str(samples_file), "output_prefix": prefix}
    settings.write_text(json.dumps({**content, "multi_components": several}))
    cycles = Path(prefix + "cycles.obj")
    cycles.unlink(missing_ok=True)
    command = [program, str(settings)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
    if done.returncode:
        raise ValueError(f"exit {done.returncode}: {done.stderr}")
    seconds = float(re.search(r"Elapsed time is (\S+)", done.stdout)[1])
    rows = [line.split() for line in open(cycles)]
    v = np.array([row[1:] for row in rows if row[:1] == ["v"]], float)
    linked = {int(row[1]) for row in rows if row[:1] == ["l"]}
    cuts = [0] + [i for i in range(1, len(v) + 1) if i not in linked]
    lines = [v[a:b] for a, b in zip(cuts, cuts[1:])]
    given = np.loadtxt(samples_file, dtype=int)
    _, first = cKDTree(surface.v[given]).query([line[0] for line in lines])
    _, last = cKDTree(surface.v[given]).query([line[-1] for line in lines])
    orders, own = [], []
    for a, b in zip(first.tolist(), last.tolist()):
        own.append(a)
        if b == own[0]:
            orders.append(own)
            own = []
    return orders, lines, seconds


def run(programs, surface, method, truth, samples_file, mixed, folder):
    """Order, one, mean, H, seconds, CPU seconds of the process, and curves (0 where it failed).

    The samples of the file are numbers `mixed` of the true order.
    """
    which, program = (ours, programs[0]) if method.startswith("ours") else (theirs, programs[1])
    start = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        orders, lines, seconds = which(program, surface, samples_file, METHODS[method], folder)
    except (ValueError, TypeError, OSError, subprocess.TimeoutExpired) as failure:
        print(f"  {method}: {failure}", file=sys.stderr)
        return [0, 0, np.inf, np.inf, np.nan, np.nan, 0]
    end = resource.getrusage(resource.RUSAGE_CHILDREN)
    whole = end.ru_utime - start.ru_utime + end.ru_stime - start.ru_stime
    one = len(orders) == 1
    right = one and is_rotation(mixed[orders[0]], len(mixed))
    return [int(right), int(one), *apart(truth, dense(lines)), seconds, whole, len(orders)]


def measure(programs, surface, kind, number, folder):
    """A row for each sampling and method: even, samples, method, and numbers of the run."""
    rng = np.random.default_rng([SEED, list(KINDS).index(kind), number])
    curve, points = surface.curve(kind, rng)
    truth = dense([np.vstack([points, points[:1]])])
    count = SIZES[number % len(SIZES)]
    for even in (True, False):
        given, mixed = samples(curve, count, even, rng), rng.permutation(count)
        file = folder / "samples.txt"
        file.write_text("".join(f"{v}\n" for v in given[mixed]))
        for method in METHODS:
            numbers = run(programs, surface, method, truth, file, mixed, folder)
            yield [int(even), count, method, *(f"{x:.6g}" for x in numbers)]


def read(runs):
    """The runs of the file: (mesh, kind, number), then even, samples, method, and numbers."""
    with open(runs, newline="") as file:
        for mesh, kind, number, even, count, method, *numbers in csv.reader(file):
            numbers = np.array(numbers, float)
            yield (mesh, kind, int(number)), even == "1", int(count), method, numbers


def add(programs, meshes, names, curves, runs):
    """Measures the curves that the file does not have, and adds them to it."""
    runs.touch()
    known = {curve for curve, *_ in read(runs)}
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            every = [(name, kind, i) for kind in KINDS for i in range(curves)]
            if not (missing := [curve for curve in every if curve not in known]):
                continue
            surface = Surface(programs[0], MESHES[name], Path(meshes), folder)
            for curve in missing:
                of = measure(programs, surface, *curve[1:], Path(folder))
                rows = [[*curve, *row] for row in of]
                with open(runs, "a", newline="") as file:
                    csv.writer(file, lineterminator="\n").writerows(rows)
                print(*curve, file=sys.stderr)


def cells(of):
    """The cells of a table for these runs."""
    order, one, mean, far, seconds, whole, _ = of.T
    far95 = np.sort(far)[int(np.ceil(0.95 * len(far))) - 1]
    numbers = [f"{100 * order.mean():.1f}", f"{100 * one.mean():.1f}"]
    numbers += [f"{np.median(mean):.4f}", f"{np.median(far):.3f}", f"{far95:.3f}"]
    return numbers + [f"{np.nanmedian(seconds):.3f}", f"{np.nanmedian(whole):.2f}"]


def only(all_runs, methods):
    """How many runs only the first of two methods has in order, and only the second."""
    right = [{(c, e): n[0] > 0 for c, e, _, m, n in all_runs if m == method} for method in methods]
    first, second = (sum(a[k] and not b[k] for k in a) for a, b in (right, right[::-1]))
    return f"{first} : {second}"


def tables(all_runs):
    """The tables: by kind, sampling and number of samples, and by mesh."""
    head = "order | one | mean | H | H, 95 % | seconds | CPU seconds |"
    won = []
    for kind, title in KINDS.items():
        for even in (True, False):
            samples_are = "even" if even else "random"
            yield f"**{title.capitalize()}, {samples_are} samples**\n"
            yield f"| samples | runs | method | {head}\n|{'---|' * 10}"
            for count in SIZES:
                own = [r for r in all_runs if (r[0][1], r[1], r[2]) == (kind, even, count)]
                for method in METHODS if own else ():
                    of = np.array([numbers for *_, m, numbers in own if m == method])
                    yield f"| {count} | {len(of)} | {method} | {' | '.join(cells(of))} |"
                two = [("ours", "theirs"), ("ours, single", "theirs, single")]
                counts = " | ".join(only(own, methods) for methods in two)
                won.append(f"| {title} | {samples_are} | {count} | {counts} |")
            yield ""
    yield "**Runs in order by ours only : by theirs only**\n"
    yield "| curves | sampling | samples | default | single |\n|---|---|---|---|---|"
    yield from won
    yield "\n**By mesh**, all runs\n"
    yield f"| mesh | method | {head}\n|{'---|' * 9}"
    for name in dict.fromkeys(curve[0] for curve, *_ in all_runs):
        for method in METHODS:
            of = np.array([n for curve, *_, m, n in all_runs if (curve[0], m) == (name, method)])
            yield f"| {name} | {method} | {' | '.join(cells(of))} |"
    yield "\n**All runs**\n"
    yield f"| method | failed | most curves | {head}\n|{'---|' * 10}"
    for method in METHODS:
        of = np.array([numbers for *_, m, numbers in all_runs if m == method])
        found = f"{(of[:, 6] == 0).sum()} | {of[:, 6].max():.0f}"
        yield f"| {method} | {found} | {' | '.join(cells(of))} |"


def main(our_program, their_program, meshes, runs, curves="15", names=",".join(MESHES)):
    add((our_program, their_program), meshes, names.split(","), int(curves), Path(runs))
    print("\n".join(tables(list(read(runs)))))


if __name__ == "__main__":
    main(*sys.argv[1:])
