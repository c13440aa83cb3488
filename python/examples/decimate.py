"""Uniform decimation: exactly n vertices, nearly equal triangles, and where they are."""

import numpy as np
from _picture import draw, panels, save

import catamaran
from catamaran import shapes

v, f = shapes.terrain(50, 50, 3)
small = catamaran.decimate(v, f, 300)
# A function on the small mesh, carried back to the large one.
wave = np.sin(4 * small.v[:, 0] / np.ptp(small.v[:, 0]) * np.pi)
carried = small.weights @ wave

figure, axes = panels(3)
view = (45, -60)
draw(axes[0], v, f, lines=True, title=f"{len(v):,} vertices", view=view)
draw(axes[1], small.v, small.f, lines=True, title=f"{len(small.v)} vertices", view=view)
draw(axes[2], v, f, carried, title="a function carried back by weights", view=view)
save(figure, __file__)
