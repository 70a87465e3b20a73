"""One plan with motions, solved once for all tests of execution: two blocks that a standing arm stacks anew."""

from pathlib import Path

import pytest

import kabo
from kabo.plan import Plan
from kabo.scene import Scene

DOMAINS = Path(__file__).parents[2] / "domains"


@pytest.fixture(scope="session")
def stacked_plan() -> Plan:
    plan = kabo.solve(kabo.load_problem(DOMAINS / "stacked" / "n2.yaml")).plan
    assert plan is not None
    return plan


@pytest.fixture(scope="session")
def stacked_scene() -> Scene:
    return kabo.load_scene(DOMAINS / "stacked" / "n2.yaml")
