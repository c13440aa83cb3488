"""A slime mould that grows over a torus, and the texture it leaves."""

import matplotlib.pyplot as plt
import numpy as np
from _picture import draw, save

import catamaran
from catamaran import shapes


def torus(around, tube):
    """Returns a torus and the texture coordinates of the corners of its faces."""
    v, f = shapes.torus(around, tube)
    places = np.stack([f // tube / around, f % tube / tube], axis=-1)
    # Faces across the seams go on beyond it.
    places += places.max(axis=1, keepdims=True) - places > 0.5
    return v, f, places


v, f, places = torus(60, 30)
uv = places / (1 + 1 / np.array([60, 30]))  # all within 0 to 1
found = catamaran.slime(v, f, 150, agents=8000, size=288, seed=1, uv=uv)
texture = found.texture[0]
size = len(texture)

# The picture has more triangles, each with the texel at its middle.
fine_v, fine_f, fine = torus(150, 75)
middle = fine.mean(axis=1) / (1 + 1 / np.array([60, 30]))
texels = (middle * size).astype(int).clip(0, size - 1)
shade = texture[texels[:, 1], texels[:, 0]]

figure = plt.figure(figsize=(10, 4.2))
axes = figure.add_axes([0.0, 0.0, 0.42, 0.92], projection="3d")
colors = plt.get_cmap("magma")(shade / shade.max())
draw(axes, fine_v, fine_f, colors=colors, title="150 steps on a torus", view=(45, -60))
axes = figure.add_axes([0.42, 0.1, 0.25, 0.8])
axes.imshow(texture, cmap="magma", origin="lower")
axes.set_axis_off()
axes.set_title("its texture", fontsize=10)
axes = figure.add_axes([0.74, 0.18, 0.24, 0.64])
axes.plot(100 * found.coverage[:, 0])
axes.set(xlabel="step", ylabel="mean pheromone, %", ylim=(0, None))
axes.grid(alpha=0.3)
save(figure, __file__)
