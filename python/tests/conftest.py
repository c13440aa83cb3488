"""What tests share: random numbers, and real inputs through CATAMARAN_DATA (default ../shared)."""

import os
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def rng():
    """Random numbers, the same in every run."""
    return np.random.default_rng(27)


def data(name):
    """Returns the path of a real input, or skips the test; with CATAMARAN_REQUIRE_DATA it must be
    there."""
    path = Path(os.environ.get("CATAMARAN_DATA", ROOT.parent / "shared")) / name
    if path.exists():
        return path
    skipped = os.environ.get("CATAMARAN_SKIPPED")
    if skipped:
        with open(skipped, "a") as report:
            print(f"{path}: missing", file=report)
    if os.environ.get("CATAMARAN_REQUIRE_DATA"):
        pytest.fail(f"{path} is missing")
    pytest.skip(f"{path} is missing")
