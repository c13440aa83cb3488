"""Errors of curves through samples with noise and outliers, without and with --drop-outliers.

    curve_outliers.py PROGRAM MESHES [CURVES [RECORD]]

PROGRAM is `catamaran`, MESHES the folder of CATAMARAN_DATA/meshes. Needs numpy. Each curve is the
longest loop of a level set of a wiggly function on a mesh, with 50 samples: even (jittered by up to
a fifth of their distance) or random along the loop. Noise moves each sample by a normal deviate in
each coordinate, in units of the mean distance between samples along the curve, and to the nearest
vertex. Outliers are random vertices, in per cent of the samples. CURVES (5) are made for each mesh,
sampling and level. The tables, which go to RECORD (.md) too, have

- found: per cent of the outliers that are dropped;
- lost: per cent of the samples of the curve that are dropped;
- order: per cent of the curves whose samples that stay are in order, without the outliers;
- mean, far, missed: the mean distance between the curve found and the true one (both ways), the
  largest distance of a point of the curve found from the true curve, and of the true curve from the
  one found, as medians over curves, in units of the mean distance between samples.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

MESHES = [
    "ofp_bunny10k.off.gz",
    "lionstatue32k.obj.gz",
    "nefertiti35k.obj.gz",
    "armadillo43k.obj.gz",
    "refined_elephant44k.off.gz",
]
SAMPLES = 50
# Noise, and per cent of outliers.
LEVELS = [
    *((0.0, outliers) for outliers in (0, 2, 5, 10, 20, 30)),
    *((noise, 0) for noise in (0.1, 0.2, 0.4, 0.8)),
    (0.2, 10),
]
FEWEST_CROSSINGS = 60
SEED = 6


def read(program, path, folder):
    """The mesh as .obj, its vertices and its faces."""
    obj = str(Path(folder) / "mesh.obj")
    command = [program, "mesh", str(path), "-o", obj, "--force", "--quiet"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    rows = [line.split() for line in open(obj)]
    v = np.array([row[1:4] for row in rows if row[:1] == ["v"]], float)
    f = np.array([[c.split("/")[0] for c in row[1:4]] for row in rows if row[:1] == ["f"]], int)
    return obj, v, f - 1


def loop(v, f, rng):
    """The longest loop of a random level set, as points; None where it is short."""
    x = (v - v.mean(axis=0)) / np.ptp(v, axis=0).max()
    along, across = rng.normal(size=(2, 3))
    along /= np.linalg.norm(along)
    across /= np.linalg.norm(across)
    phase = 2 * np.pi * (x @ across) * rng.uniform(1, 4) + rng.uniform(0, 6)
    height = x @ along + 0.08 * np.sin(phase)
    height -= np.quantile(height, rng.uniform(0.15, 0.85))
    above = height[f] > 0
    links = {}
    for face, sides in zip(f, above):
        if sides.all() or not sides.any():
            continue
        edges = [
            tuple(sorted((face[i], face[(i + 1) % 3])))
            for i in range(3)
            if sides[i] != sides[(i + 1) % 3]
        ]
        links.setdefault(edges[0], []).append(edges[1])
        links.setdefault(edges[1], []).append(edges[0])
    seen, longest = set(), []
    for start in links:
        if start in seen:
            continue
        seen.add(start)
        chain = [start]
        while ahead := [edge for edge in links[chain[-1]] if edge not in seen]:
            chain.append(ahead[0])
            seen.add(ahead[0])
        if start in links[chain[-1]] and len(chain) > len(longest):
            longest = chain
    if len(longest) < FEWEST_CROSSINGS:
        return None
    a, b = np.array(longest).T
    share = (height[a] / (height[a] - height[b]))[:, None]
    return v[a] + share * (v[b] - v[a])


def at(points, places):
    """Points of a closed polygon at these shares of its length, and the length."""
    points = np.vstack([points, points[:1]])
    length = np.r_[0, np.linalg.norm(np.diff(points, axis=0), axis=1).cumsum()]
    found = [np.interp(places * length[-1], length, points[:, k]) for k in range(3)]
    return np.stack(found, axis=1), length[-1]


def nearest(of, to):
    """The distance of each point to the nearest one of others, and that one."""
    square = ((of[:, None] - to[None]) ** 2).sum(axis=2)
    return np.sqrt(square.min(axis=1)), square.argmin(axis=1)


def case(v, f, even, noise, outliers, rng):
    """Samples in any order, those of them that are outliers, the order of the others, the curve."""
    while True:
        points = loop(v, f, rng)
        if points is None:
            continue
        places = np.arange(SAMPLES) + rng.uniform(-0.2, 0.2, SAMPLES)
        places = places / SAMPLES % 1 if even else np.sort(rng.uniform(size=SAMPLES))
        samples, length = at(points, places)
        gap = length / SAMPLES
        _, samples = nearest(samples + noise * gap * rng.normal(size=samples.shape), v)
        _, first = np.unique(samples, return_index=True)
        samples = samples[np.sort(first)]
        if len(samples) >= 0.8 * SAMPLES:
            break
    count = round(outliers / 100 * len(samples))
    strays = rng.choice(np.setdiff1d(np.arange(len(v)), samples), count, replace=False)
    mixed = rng.permutation(len(samples) + count)
    curve, _ = at(points, np.linspace(0, 1, 1000, endpoint=False))
    return np.r_[samples, strays][mixed], mixed, len(samples), curve, gap


def is_rotation(order, n):
    """Whether numbers are those of a cycle, up to rotation and direction."""
    steps = np.diff(np.r_[order, order[:1]])
    return any((sign * steps < 0).sum() <= 1 for sign in (1, -1)) and len(set(order)) == n


def reconstruct(program, obj, cases, drop, folder):
    """For each case the curve found: its order, its points, the samples that were dropped."""
    samples, result = Path(folder) / "samples.txt", Path(folder) / "curves.json"
    with open(samples, "w") as file:
        for i, (vertices, *_) in enumerate(cases):
            file.write(f"curve {i} single\n" + "".join(f"{v}\n" for v in vertices))
    command = [program, "curve", obj, "--samples", str(samples), "-o", str(result), "--force"]
    command += ["--quiet", "--no-steiner"] + ["--drop-outliers"] * drop
    subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    content = json.load(open(result))
    starts = np.r_[0, np.cumsum([len(vertices) for vertices, *_ in cases])]
    curves = {int(curve["name"]): curve for curve in content["curves"]}
    dropped = np.array(content.get("outliers", []), int)
    for i in range(len(cases)):
        own = dropped[(dropped >= starts[i]) & (dropped < starts[i + 1])] - starts[i]
        order = np.array(curves[i]["order"]) - starts[i]
        yield order, np.array(curves[i]["points"]), own


def measure(program, meshes, curves):
    """A row of numbers for each curve of each sampling, level and method."""
    rows = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in MESHES:
            obj, v, f = read(program, Path(meshes) / name, folder)
            rng = np.random.default_rng(SEED)
            for even in (True, False):
                for noise, outliers in LEVELS:
                    cases = [case(v, f, even, noise, outliers, rng) for _ in range(curves)]
                    for drop in (False, True):
                        found = reconstruct(program, obj, cases, drop, folder)
                        for (_, mixed, n, curve, gap), (order, points, own) in zip(cases, found):
                            stray = mixed >= n
                            stay = [i for i in mixed[order] if i < n]
                            far, _ = nearest(points, curve)
                            missed, _ = nearest(curve, points)
                            rows.setdefault((even, noise, outliers, drop), []).append((
                                stray[own].sum(), stray.sum(), (~stray[own]).sum(), n,
                                is_rotation(stay, n - (~stray[own]).sum()),
                                (far.mean() + missed.mean()) / 2 / gap,
                                far.max() / gap, missed.max() / gap,
                            ))
            print(name, file=sys.stderr)
    return {key: np.array(of, float) for key, of in rows.items()}


def table(rows, even):
    """The numbers of a sampling, without the option and with it."""
    yield f"**{'Even' if even else 'Random'} samples**, all samples taken, and `--drop-outliers`\n"
    yield "| noise | outliers, % | found | lost | order | mean | far | missed |"
    yield "|---|---|---|---|---|---|---|---|"
    for noise, outliers in LEVELS:
        all_of, drop = (rows[even, noise, outliers, with_option] for with_option in (False, True))
        found, strays, lost, samples = drop[:, :4].sum(axis=0)
        cells = [f"{100 * found / strays:.0f}" if strays else "", f"{100 * lost / samples:.1f}"]
        cells.append(", ".join(f"{100 * of[:, 4].mean():.0f}" for of in (all_of, drop)))
        for k in (5, 6, 7):
            cells.append(", ".join(f"{np.median(of[:, k]):.2f}" for of in (all_of, drop)))
        yield f"| {noise} | {outliers} | {' | '.join(cells)} |"
    yield ""


def main(program, meshes, curves="5", record=None):
    rows = measure(program, meshes, int(curves))
    count = len(next(iter(rows.values())))
    text = [
        "# Chapter 6: curves through samples with noise and outliers\n",
        f"{count} curves in each row, {SAMPLES} samples each; what the columns are is in",
        "`bench/rivals/curve_outliers.py`.\n",
        *table(rows, True),
        *table(rows, False),
    ]
    print("\n".join(text))
    if record:
        Path(record).write_text("\n".join(text))


if __name__ == "__main__":
    main(*sys.argv[1:])
