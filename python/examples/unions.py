"""The spectrum of the union of two parts from the spectra of the parts."""

import matplotlib.pyplot as plt
import numpy as np
from _picture import draw, save

import catamaran
from catamaran import shapes

v, f = shapes.figure(16)
middle = np.median(v[:, 2])
masks = {"upper part": v[:, 2] > middle - 0.25, "lower part": v[:, 2] < middle + 0.25}


def part(mask):
    """Returns the faces whose corners are all in the mask, as a mesh of its own."""
    used, faces = np.unique(f[mask[f].all(axis=1)], return_inverse=True)
    return v[used], faces.reshape(-1, 3)


parts = [part(mask) for mask in masks.values()]
found = catamaran.union_spectrum(parts)
print("out-of-distribution score", round(found.ood_score, 2))

figure = plt.figure(figsize=(10.5, 3.8))
for i, (name, mesh) in enumerate(zip(masks, parts)):
    axes = figure.add_axes([0.22 * i, 0.02, 0.24, 0.86], projection="3d")
    draw(axes, *mesh, title=name, margin=1.0, view=(10, -75))
axes = figure.add_axes([0.54, 0.16, 0.44, 0.74])
numbers = np.arange(1, 21)
for name, values, marker in zip(masks, found.parts, "^v"):
    axes.plot(numbers, values, marker=marker, markersize=4, linewidth=1, label=name)
axes.plot(numbers, found.union, "o-", color="black", markersize=4, label="union, predicted")
axes.set(xlabel="number", ylabel="Dirichlet eigenvalue", xticks=[1, 5, 10, 15, 20])
axes.grid(alpha=0.3)
axes.legend(fontsize=8)
save(figure, __file__)
