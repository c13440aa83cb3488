"""Eigenfunctions, and the transfer of a function between two poses."""

import numpy as np
from _picture import draw, panels, save

import catamaran
from catamaran import shapes

source, target = shapes.figure(12), shapes.figure(12, 0.6)
values, vectors = catamaran.eigsh(*source, 8)
print("eigenvalues", np.round(values, 3))

# Vertices of the same number correspond here; functional_map finds this from landmarks.
height = source[0][:, 2]
moved = catamaran.transfer(source, target, height, k=20)

figure, axes = panels(4, 3.2)
for i, k in enumerate((2, 5)):
    draw(axes[i], *source, vectors[:, k], cmap="RdBu_r", title=f"eigenfunction {k}")
draw(axes[2], *source, height, title="a function: height")
draw(axes[3], *target, moved, title="transferred to another pose")
save(figure, __file__)
