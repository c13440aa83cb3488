"""Runs Python with Catamaran's BLAS under numpy, scipy and whatever else multiplies matrices.

``python -m catamaran.preload script.py`` starts the script with ``libcatamaran_blas.so`` in
``LD_PRELOAD``; `numpy_speedup` does the same for the program that calls it. The library is looked
for

1. where the environment variable ``CATAMARAN_BLAS_LIBRARY`` says,
2. in the folder of this package,
3. where ``scripts/build-blas`` puts it: ``lib`` of the Python environment, or of ``~/.local``,
4. in the path of the loader.

``CATAMARAN_BLAS`` = auto, reproducible, max or off says what the library does, and
``CATAMARAN_BLAS_VERBOSE=1`` makes it tell at the end what it did.
"""

import sys

from ._distribution import require_own
from ._preload import NAME, find_library, is_preloaded, main, numpy_speedup

require_own()

__all__ = ["NAME", "find_library", "is_preloaded", "main", "numpy_speedup"]

if __name__ == "__main__":
    sys.exit(main())
