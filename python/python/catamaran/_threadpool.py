"""Makes threadpoolctl limit the threads of this package, too.

``threadpool_limits(2)`` limits calls that name no number of threads, and so does
``user_api="blas"``, with which scikit-learn keeps nested parallel work from taking all cores.
"""

from __future__ import annotations

from typing import Any

from . import _catamaran

__all__ = ["register"]


def register() -> None:
    """Registers the extension as a library with threads, if threadpoolctl is installed."""
    try:
        import threadpoolctl
    except ImportError:
        return
    if not hasattr(threadpoolctl, "register"):
        # Older than 3.2.
        return
    base: Any = threadpoolctl.LibController

    class Controller(base):  # type: ignore[misc]
        """The threads of calls that name no number of them."""

        user_api = "blas"
        internal_api = "catamaran"
        filename_prefixes = ("_catamaran",)

        def get_num_threads(self) -> int:
            return _catamaran.get_num_threads()

        def set_num_threads(self, threads: int) -> None:
            _catamaran.set_num_threads(threads)

        def get_version(self) -> str:
            return _catamaran.__version__

    threadpoolctl.register(Controller)
