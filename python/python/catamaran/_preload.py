"""Starts Python with ``libcatamaran_blas.so`` in ``LD_PRELOAD``.

The public names are in ``catamaran.preload``, which the package does not import: ``python -m``
warns of a module that is imported before it is run.
"""

from __future__ import annotations

import ctypes
import os
import sys
from typing import List, MutableMapping, NoReturn, Optional

NAME = "libcatamaran_blas.so"


def find_library() -> str:
    """Returns the path of ``libcatamaran_blas.so``, or its name if the loader finds it by that.

    Raises
    ------
    OSError
        Says where it was looked for.
    """
    given = os.environ.get("CATAMARAN_BLAS_LIBRARY")
    if given:
        if not os.path.isfile(given):
            raise FileNotFoundError(f"CATAMARAN_BLAS_LIBRARY: there is no file {given}")
        return os.path.abspath(given)
    folders = [
        os.path.dirname(os.path.abspath(__file__)),
        os.path.join(sys.prefix, "lib"),
        os.path.expanduser("~/.local/lib"),
    ]
    for folder in folders:
        if os.path.isfile(os.path.join(folder, NAME)):
            return os.path.join(folder, NAME)
    try:
        ctypes.CDLL(NAME)
    except OSError as error:
        raise FileNotFoundError(
            f"{NAME} is neither in CATAMARAN_BLAS_LIBRARY, nor in {', '.join(folders)}, nor in the "
            f"path of the loader: build it by scripts/build-blas {sys.prefix}"
        ) from error
    return NAME


def is_preloaded(environment: Optional[MutableMapping[str, str]] = None) -> bool:
    """Returns whether the library is in ``LD_PRELOAD`` already."""
    found = (os.environ if environment is None else environment).get("LD_PRELOAD", "")
    names = found.replace(":", " ").split()
    given = os.environ.get("CATAMARAN_BLAS_LIBRARY")
    return any(os.path.basename(name) == NAME or name == given for name in names)


def _run(arguments: List[str]) -> NoReturn:
    """Replaces this process by Python with the library."""
    if not sys.platform.startswith("linux"):
        raise OSError(f"LD_PRELOAD is for Linux, and this is {sys.platform}")
    environment = dict(os.environ)
    earlier = environment.get("LD_PRELOAD", "")
    library = find_library()
    environment["LD_PRELOAD"] = f"{library} {earlier}".strip()
    sys.stdout.flush()
    sys.stderr.flush()
    os.execve(sys.executable, [sys.executable, *arguments], environment)


def numpy_speedup(mode: Optional[str] = None) -> None:
    """Starts this program again with Catamaran's BLAS under numpy; to be called first of all.

    Returns at once when the library is loaded already, so that the program goes on. In an
    interactive session, and under debuggers, there is no program to start again: use
    ``python -m catamaran.preload``.

    Parameters
    ----------
    mode : {"auto", "reproducible", "max", "off"}, optional
        What ``CATAMARAN_BLAS`` becomes.

    Raises
    ------
    OSError
        When the library is not found.
    RuntimeError
        When there is no program to start again.
    """
    if is_preloaded():
        return
    if not sys.argv or not sys.argv[0] or hasattr(sys, "ps1"):
        raise RuntimeError("there is no program to start again: use python -m catamaran.preload")
    if mode is not None:
        if mode not in ("auto", "reproducible", "max", "off"):
            raise ValueError(f"mode: '{mode}' is not one of 'auto', 'reproducible', 'max', 'off'")
        os.environ["CATAMARAN_BLAS"] = mode
    # Options of the interpreter and a module instead of a script are in orig_argv.
    _run(sys.orig_argv[1:])


def main(arguments: Optional[List[str]] = None) -> int:
    """Runs ``python -m catamaran.preload`` with these arguments."""
    arguments = sys.argv[1:] if arguments is None else arguments
    if not arguments or arguments[0] in ("-h", "--help"):
        print(
            "usage: python -m catamaran.preload SCRIPT.py [ARGUMENTS]\n"
            "       python -m catamaran.preload -m MODULE [ARGUMENTS]\n"
            "       python -m catamaran.preload -c CODE",
            file=sys.stderr,
        )
        return 0 if arguments else 2
    try:
        _run(arguments)
    except OSError as error:
        print(f"catamaran.preload: {error}", file=sys.stderr)
        return 1
