"""Whether a robot may place a body anywhere: what is proven out of reach is neither drawn nor projected."""

from dataclasses import replace

import numpy as np
import pytest

from kabo.geometry_server import GeometryServer, Situation
from kabo.geometry_server.candidates import Stream
from kabo.geometry_server.context import ProcedureContext
from kabo.geometry_server.destinations import Destination
from kabo.geometry_server.placement_check import may_place, places
from kabo.geometry_server.reachability import grasp_missing
from tests.geometry_server.conftest import scene_of

SCENE = scene_of("circular_rearrange/n3.yaml")
NEAR = {"left": "loc_1", "right": "loc_3"}
FAR = {"left": "loc_3", "right": "loc_1"}


def fresh(seed: int = 0) -> ProcedureContext:
    """A context in which nothing is known of the scene."""
    return GeometryServer(replace(SCENE, memory={}), seed=seed).context()


def may(robot: str, region: str, context: ProcedureContext) -> bool:
    """Whether a robot may place o1 in a region of the table."""
    place, now = Destination("table", SCENE.regions[region]), Situation.of(SCENE.start)
    return may_place(context, SCENE.robots[robot], SCENE.bodies["o1"], place, now)


@pytest.mark.parametrize("robot", ["left", "right"])
def test_no_grasp_is_sampled_where_all_are_proven_out_of_reach(
    robot: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sampling there found nothing, either, and took most of the time of the checks before a search."""
    sampled: list[Stream] = []
    for name in ("draws", "batch"):
        own = getattr(Stream, name)

        def noted(stream: Stream, *given: object, own: object = own) -> object:
            sampled.append(stream)
            return own(stream, *given)  # type: ignore[operator]

        monkeypatch.setattr(Stream, name, noted)
    context = fresh()
    assert not may(robot, FAR[robot], context)
    assert not sampled
    assert may(robot, NEAR[robot], context)
    assert sampled


@pytest.mark.parametrize("robot", ["left", "right"])
def test_the_answer_is_that_of_sampling_everywhere(robot: str, monkeypatch: pytest.MonkeyPatch) -> None:
    regions = ("loc_1", "loc_2", "loc_3")
    found = [may(robot, region, fresh(7)) for region in regions]
    name = f"{may_place.__module__}.{grasp_missing.__name__}"
    monkeypatch.setattr(name, lambda *_: 0.0)  # as if nothing were proven
    assert [may(robot, region, fresh(7)) for region in regions] == found


def test_another_seed_draws_other_places() -> None:
    """No grasp found is no proof: whoever tries again with another seed gets another chance."""
    place, now = Destination("table", SCENE.regions["loc_1"]), Situation.of(SCENE.start)
    found = [list(places(fresh(seed), SCENE.bodies["o1"], place, now)) for seed in (1, 2, 1)]
    assert found[0] and np.array_equal(found[0], found[2])
    assert not np.array_equal(found[0], found[1])


def test_all_robots_are_asked_about_the_same_places(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are sampled once, as they do not depend on the robot."""
    from kabo.geometry_server import placement_check  # noqa: PLC0415 - its function is replaced

    made: list[str] = []
    places = placement_check.places

    def noted(context: ProcedureContext, body: object, *others: object) -> object:
        made.append(str(body))
        return places(context, body, *others)  # type: ignore[arg-type]

    monkeypatch.setattr(placement_check, "places", noted)
    context = fresh()
    for robot in ("left", "right"):
        may(robot, "loc_2", context)
    assert len(made) == 1
