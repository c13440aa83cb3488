"""A plant that is not watered: its water, and how it bends."""

import matplotlib.pyplot as plt
import numpy as np
from _picture import draw, save

import catamaran

plant = catamaran.grow_plant(250, seed=4)
found = catamaran.wilt(plant, 120, frames=8, loss=200)
print(found)

figure = plt.figure(figsize=(11.5, 3.8))
frames = (0, 4, 8)
for i, frame in enumerate(frames):
    axes = figure.add_axes([0.2 * i - 0.02, 0.0, 0.25, 0.9], projection="3d")
    v, f = found.mesh(frame, thinnest=0.002)
    per_face = len(f) // len(plant)
    segment = np.minimum(np.arange(len(f)) // per_face, len(plant) - 1)
    relative = (found.water[frame] / found.full_water)[segment]
    colors = plt.get_cmap("RdYlGn")(relative)
    draw(axes, v, f, colors=colors, title=f"after {found.hours[frame]:.0f} hours", view=(8, -60))
axes = figure.add_axes([0.68, 0.16, 0.3, 0.72])
axes.plot(found.hours, 1e3 * found.water.sum(axis=1), "o-", color="steelblue")
axes.set(xlabel="hours", ylabel="water, g", ylim=(0, None))
axes.grid(alpha=0.3)
save(figure, __file__)
