"""Pictures of meshes for the examples."""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402


def output(script):
    """Returns where the picture goes: the first argument, or beside the script's name."""
    return Path(sys.argv[1]) if len(sys.argv) > 1 else Path(Path(script).stem + ".png")


def draw(
    axes,
    v,
    f,
    values=None,
    *,
    colors=None,
    cmap="viridis",
    title="",
    lines=False,
    view=(20, -60),
    margin=0.8,
):
    """Draws a mesh, with a value for each vertex or a colour for each face, lit from the camera."""
    f = np.asarray(f)
    triangles = v[f]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals / np.where(lengths > 0, lengths, 1)
    up, around = np.radians(view)
    towards = np.array([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)])
    light = 0.35 + 0.65 * np.abs(normals @ towards)
    if colors is None:
        if values is None:
            colors = np.full((len(f), 3), 0.78)
        else:
            shown = np.asarray(values)[f].mean(axis=1)
            low, high = np.min(values), np.max(values)
            colors = plt.get_cmap(cmap)((shown - low) / (high - low if high > low else 1))[:, :3]
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    lit = np.clip(colors[:, :3] * light[:, None], 0, 1)
    edges = "black" if lines else lit
    faces = Poly3DCollection(
        triangles, facecolors=lit, edgecolors=edges, linewidths=0.2 if lines else 0.3
    )
    axes.add_collection3d(faces)
    low, high = v.min(axis=0), v.max(axis=0)
    middle, half = (low + high) / 2, (high - low).max() / 2
    for name, center in zip("xyz", middle):
        getattr(axes, f"set_{name}lim")(center - margin * half, center + margin * half)
    axes.set_box_aspect((1, 1, 1))
    axes.view_init(*view)
    # What is drawn later is in front.
    axes.computed_zorder = False
    axes.set_axis_off()
    axes.set_title(title, fontsize=10)


def panels(count, width=4.0):
    """Returns a figure and axes in three dimensions, side by side."""
    figure, axes = plt.subplots(
        1, count, figsize=(width * count, width), subplot_kw={"projection": "3d"}, squeeze=False
    )
    figure.subplots_adjust(left=0, right=1, bottom=0, top=0.9, wspace=0)
    return figure, axes[0]


def save(figure, script):
    """Writes the picture."""
    path = output(script)
    figure.savefig(path, dpi=110)
    print(f"written {path}")
