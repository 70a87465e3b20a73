"""A plan that was edited by hand is refused before anything moves, with what is wrong in it."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from kabo.errors import InputError
from kabo.execution import KinematicRobot, KnownTruth, execute
from kabo.plan import Plan
from kabo.scene import Scene


def without(things: dict, *names: str) -> dict:
    return {name: thing for name, thing in things.items() if name not in names}


def with_start(plan: Plan, **changes: object) -> Plan:
    assert plan.start is not None
    return replace(plan, start=replace(plan.start, **changes))


def with_root(plan: Plan, **changes: object) -> Plan:
    return replace(plan, nodes={**plan.nodes, plan.root: replace(plan.nodes[plan.root], **changes)})


def taken_by(plan: Plan, parent: str) -> Plan:
    motion = tuple(
        replace(each, attach=tuple((body, parent) for body, _ in each.attach))
        for each in plan.nodes[plan.root].motion
    )
    return with_root(plan, motion=motion)


def moved_to(plan: Plan, parent: str) -> Plan:
    after = plan.nodes[plan.root].after
    assert after is not None
    objects = {name: replace(own, parent=parent) for name, own in after.objects.items()}
    return with_root(plan, after=replace(after, objects=objects))


EDITS: list[tuple[str, Callable[[Plan], Plan]]] = [
    ("does not say where mobile is", lambda p: with_start(p, robots={})),
    (
        "does not say where arm_joint_2 of mobile is",
        lambda p: with_start(p, robots={"mobile": without(p.start.robots["mobile"], "arm_joint_2")}),
    ),
    ("does not say where o1 is", lambda p: with_start(p, objects=without(p.start.objects, "o1"))),
    ("it has motions, and no `start`", lambda p: replace(p, start=None)),
    ('leads to "n77", and there is no such node', lambda p: with_root(p, next="n77")),
    ('its root "n77", and there is no such node', lambda p: replace(p, root="n77")),
    ("lead in a circle", lambda p: with_root(p, next=p.root)),
    ('no body or link "mobile.nothing"', lambda p: taken_by(p, "mobile.nothing")),
    ('no body or link "nobody.hand"', lambda p: moved_to(p, "nobody.hand")),
]


@pytest.mark.parametrize(("said", "edit"), EDITS, ids=[said for said, _ in EDITS])
def test_an_edited_plan_is_refused_before_anything_moves(
    stacked_plan: Plan, stacked_scene: Scene, said: str, edit: Callable[[Plan], Plan]
) -> None:
    plan = edit(stacked_plan)
    robot = None if plan.start is None else KinematicRobot(stacked_scene)
    with pytest.raises(InputError, match=said):
        execute(plan, stacked_scene, robot, KnownTruth())
    assert robot is None or robot.time == 0.0


def test_a_plan_without_motions_is_looked_through_as_well(stacked_plan: Plan) -> None:
    still = {name: replace(node, motion=(), after=None) for name, node in stacked_plan.nodes.items()}
    plan = replace(stacked_plan, nodes={**still, stacked_plan.root: replace(still[stacked_plan.root], next="n9")})
    with pytest.raises(InputError, match="no such node"):
        execute(replace(plan, start=None, certificate=None), None, None, KnownTruth())
