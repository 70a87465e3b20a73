"""What all tests share: how hypothesis draws, how much of the long property runs is run, and which tests are quick.

`KABO_PROPERTY_SCALE` (default 0.1) scales the number of examples; 1.0 is the whole run. Draws are derandomized,
so that a red run is red again. `pytest -m quick` runs the rooms that need no kernel, less than a minute of tests.
"""

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

TESTS = Path(__file__).parent

# Every process that a test starts runs this kabo: one that is installed beside it would have its kernels to compile.
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(TESTS.parent), os.environ.get("PYTHONPATH", "")]))

QUICK = (
    "finite_domain",
    "knowledge",
    "language",
    "meshes",
    "plan",
    "scene",
    "tasks/core",
    "test_architecture.py",
    "test_errors.py",
)

PROPERTY_SCALE = float(os.environ.get("KABO_PROPERTY_SCALE", "0.1"))

settings.register_profile(
    "kabo",
    max_examples=max(20, round(1000 * PROPERTY_SCALE)),
    derandomize=True,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("kabo")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Marks the tests of quick rooms, but for those that are slow all the same; files with slow tests come first.

    Both workers take whole files in this order, so what comes last is short, and neither is idle for long at the end.
    """
    slow = {item.path for item in items if item.get_closest_marker("slow") is not None}
    items.sort(key=lambda item: item.path not in slow)
    for item in items:
        quick = any(item.path.is_relative_to(TESTS / room) for room in QUICK)
        if quick and item.get_closest_marker("slow") is None:
            item.add_marker("quick")
