"""Grasp families of holds that were observed in a run: planner and verifier take each for the same."""

from dataclasses import replace

import numpy as np
import pytest

import kabo
from kabo.plan import Plan
from kabo.plan.writing import rounded_state
from kabo.scene import attachment
from kabo.scene.transforms import transform
from tests.planner.gantry import gantry_problem


# ------------------------------------------------------------------------------------------------ holds in a run
@pytest.mark.parametrize("size", [5e-5, 3e-4, 7e-4, 9.99e-4, 1.001e-3, 1.2e-3, 2e-3])
@pytest.mark.parametrize(
    ("kind", "way"),
    [
        ("shifted", (1.0, 0.0, 0.0)),
        ("shifted", (1.0, 1.0, 1.0)),
        ("shifted", (0.0, -1.0, 1.0)),
        ("turned", (0.0, 0.0, 1.0)),  # a gantry tilts nothing back
    ],
)
def test_a_hold_that_was_observed_is_named_as_the_verifier_takes_it(
    gantry_case: tuple[kabo.Problem, Plan], kind: str, size: float, way: tuple[float, float, float]
) -> None:
    """Between what a planned hold may be off and what the verifier grants, plans were made that it refused."""
    problem, plan = gantry_case
    held = kabo.after(problem, plan, [(plan.root, None)])
    assert held.geometry is not None
    own = held.geometry.objects["cube"]
    (x, y, z), half = (size * each / float(np.linalg.norm(way)) for each in way), 0.5
    if kind == "shifted":
        moved = replace(own, position=(own.position[0] + x, own.position[1] + y, own.position[2] + z))
    else:
        turned = transform((0, 0, 0), own.quaternion) @ transform(
            (0, 0, 0), (half * x, half * y, half * z, float(np.sqrt(1.0 - (half * size) ** 2)))
        )
        found = attachment(own.parent, turned)
        moved = replace(own, quaternion=found.quaternion)
    start = kabo.after(problem, plan, [(plan.root, None)], objects={"cube": moved})
    rest = kabo.solve(problem, start=start, timeout=20.0).plan
    assert rest is not None and rest.start == rounded_state(start.geometry)
    report = kabo.verify(problem, rest, start=start)
    assert report.ok, report


@pytest.fixture(scope="module")
def gantry_case(tmp_path_factory: pytest.TempPathFactory) -> tuple[kabo.Problem, Plan]:
    problem = gantry_problem(tmp_path_factory.mktemp("gantry"), things={"cube": (0.2, 0.0, 0.02)})
    plan = kabo.solve(problem).plan
    assert plan is not None
    return problem, plan
