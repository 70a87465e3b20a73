"""What refinement may change of a task's motion: strokes down to the least length that families ask for by their names."""

import pytest

from kabo.geometry_server import GeometryServer
from kabo.language.formulas import GroundCall
from kabo.planner.refine.freedom import freedoms
from kabo.tasks.procedures import GeometricProcedures
from tests.tasks.conftest import DOMAINS, scene_of

BARTENDER = "bartender/four_bottles.yaml"
PICK, PLACE = GroundCall("pick", ("left", "bottle_1")), GroundCall("place", ("left", "bottle_1", "dishwasher"))
LEAST = [
    (PICK, "grasp/approach", 0.05),
    (PICK, "grasp/lift", 0.03),
    (PLACE, "put/lower", 0.03),
    (PLACE, "put/retreat", 0.05),
]


@pytest.mark.parametrize(("call", "stage", "least"), LEAST)
def test_a_stroke_may_be_cut_to_what_the_families_ask_for_such_strokes(call, stage, least) -> None:
    server = GeometricProcedures(GeometryServer(scene_of(BARTENDER)), (DOMAINS / BARTENDER).parent)
    found = freedoms(server.stages(call), [server.scene.bodies["bottle_1"]]).of(stage)
    assert (found.kind, found.least) == ("stroke", least)
