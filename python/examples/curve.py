"""A closed curve through samples without an order, over a torus."""

import numpy as np
from _picture import draw, panels, save

import catamaran
from catamaran import shapes

v, f = shapes.torus(60, 30)
rng = np.random.default_rng(2)
# Vertices near a curve that winds around the tube, shuffled.
around = np.linspace(0, 2 * np.pi, 24, endpoint=False)
tube = 0.9 * np.sin(3 * around) + 1.2
goal = np.column_stack(
    [
        (2 + 0.8 * np.cos(tube)) * np.cos(around),
        (2 + 0.8 * np.cos(tube)) * np.sin(around),
        0.8 * np.sin(tube),
    ]
)
samples = np.unique(np.linalg.norm(v[None] - goal[:, None], axis=2).argmin(axis=1))
rng.shuffle(samples)

figure, axes = panels(2)
for axis, smooth in zip(axes, (False, True)):
    found = catamaran.curve(v, f, samples, smooth=smooth)
    how = "straight over faces" if smooth else "along edges"
    length = sum(curve.length for curve in found.curves)
    draw(axis, v, f, title=f"{how}: length {length:.2f}", view=(55, -60))
    for curve in found.curves:
        points = np.vstack([curve.points, curve.points[:1]])
        axis.plot(*points.T, color="crimson", linewidth=2.5, zorder=10)
    axis.scatter(*v[samples].T, color="black", s=14, zorder=11, depthshade=False)
print(found.outcome)
save(figure, __file__)
