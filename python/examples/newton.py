"""Newton's fractal of z^5 - 1 in four dimensions, in three slices."""

import matplotlib.pyplot as plt
import numpy as np
from _picture import save

import catamaran

figure, axes = plt.subplots(1, 3, figsize=(11, 3.9), layout="constrained")
for axis, w in zip(axes, (0.0, 0.4, 0.8)):
    found = catamaran.newton(power=5, size=300, extent=1.6, w=w)
    speed = found.convergence
    share = (speed - speed.min()) / np.ptp(speed)
    colors = plt.get_cmap("turbo")((found.roots % 25) / 24.0)[..., :3]
    # The plane is `extent` wide, and row 0 has the largest y.
    axis.imshow(
        colors * (1 - 0.85 * share[..., None]), origin="upper", extent=(-0.8, 0.8, -0.8, 0.8)
    )
    axis.set_title(f"w = {w}", fontsize=10)
    axis.set(xlabel="x", ylabel="y")
save(figure, __file__)
