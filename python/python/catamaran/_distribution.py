"""Detects another distribution whose files lie in the folder of this package.

PyPI's ``catamaran`` is another project that also installs a package ``catamaran``. pip overwrites
files of equal names without a warning, and removes those of both when either is uninstalled.
"""

from __future__ import annotations

import os
import sys
import warnings
from typing import Optional

NAME = "catamaran-numerics"
OTHER = "catamaran"

REMEDY = f"run `pip uninstall {OTHER} {NAME}`, then install {NAME} again"


def find_other(site: str) -> Optional[str]:
    """Returns the name of the metadata folder of the distribution ``catamaran`` in the folder
    `site`, or None.

    Lists the folder (0.4 ms for 1000 entries) because importing `importlib.metadata` takes 30 ms.
    """
    try:
        names = os.listdir(site)
    except OSError:
        # Not a folder, as in a zip file.
        return None
    for name in names:
        # The version follows the hyphen; hyphens within names of distributions become underscores.
        if name.startswith(f"{OTHER}-") and name.endswith((".dist-info", ".egg-info")):
            return name
    return None


def warn_of_other() -> None:
    """Warns the importer of this package of a distribution ``catamaran`` in the same folder."""
    site = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    other = find_other(site)
    if other is not None:
        warnings.warn(
            f"the distributions {OTHER} ({other}) and {NAME} both have files in "
            f"{os.path.join(site, 'catamaran')} and overwrite each other's: {REMEDY}",
            RuntimeWarning,
            stacklevel=3,
        )


def require_own() -> None:
    """Raises ImportError if the package ``catamaran`` that Python has imported is not this one.

    Modules that users import by their own names call this: they are still there after the other
    distribution has overwritten ``__init__.py``.
    """
    package = sys.modules["catamaran"]
    if not hasattr(package, "numpy_speedup"):
        found = getattr(package, "__file__", None) or "a folder without __init__.py"
        raise ImportError(
            f"the package catamaran ({found}) is not that of {NAME}: the distribution {OTHER} has "
            f"overwritten or removed its files: {REMEDY}",
            name="catamaran",
        )
