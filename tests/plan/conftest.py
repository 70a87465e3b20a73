"""A plan with one of everything, for the tests of the plan room."""

import pytest

from kabo.plan import Learned, Node, ObjectPose, Plan, PlanBuilder, Segment, StateChange, ValueOf

HASHES = {"domain.yaml": "sha256:" + "a" * 64, "problem.yaml": "sha256:" + "b" * 64}
OPTIONS = {"search": "greedy", "seed": 3, "epsilon": 0.02, "geometry": "bounding", "max_expansions": None}


def segment(**changes) -> Segment:
    values = {
        "robot": "arm",
        "joints": ("j1", "j2"),
        "waypoints": ((0.0, 1.0), (0.5, 1.25)),
        "times": (0.0, 0.5),
        "procedure": "pick",
        "stage": "grasp/close",
        "attach": (("cup", "arm.tool"),),
        "allowed_contacts": (("arm.finger", "cup"),),
    }
    return Segment(**{**values, **changes})


@pytest.fixture
def plan() -> Plan:
    builder = PlanBuilder()
    goal = builder.goal()
    dial = builder.add(Node("action", "dial", {"c": ValueOf("combination(vault)"), "n": 2.0}, next=goal))
    choose = builder.add(Node("branch", on="open(vault)", branches={"true": goal, "false": dial}))
    read = builder.add(
        Node("sense", "read", {"s": "vault"}, delivers=("combination(vault)", "open(vault)"), next=choose)
    )
    pose = ObjectPose("arm.tool", (0.0, 0.1, 0.2), (0.0, 0.0, 0.0, 1.0))
    after = StateChange({"arm": {"j1": 0.5, "j2": 1.25}}, {"cup": pose})
    learned = Learned("model.jsonl", {"cup": "tin"}, {"along": 0.01, "force": 8.0}, 0.97, {"torque": -0.002})
    pick = Node("action", "pick", {"o": "cup"}, next=read, motion=(segment(),), after=after, learned=(learned,))
    look = builder.add(Node("sense", "look", {}, on="dark", branches={"true": goal, "false": builder.add(pick)}))
    start = StateChange(
        {"arm": {"j1": 0.0, "j2": 1.0}}, {"cup": ObjectPose("world", (1.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))}
    )
    return builder.build(look, problem="vault", files=HASHES, options=OPTIONS, start=start)
