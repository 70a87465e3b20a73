"""Laws of the plan room: a file says all of a plan, equal plans have equal bytes, sharing changes no branch."""

import random

from hypothesis import event, given
from hypothesis import strategies as st

from kabo.motion import Trajectory
from kabo.plan import (
    Node,
    ObjectPose,
    Plan,
    PlanBuilder,
    Segment,
    StateChange,
    ValueOf,
    describe,
    plan_from_json,
    plan_statistics,
    plan_to_json,
)

NAMES = st.sampled_from(["arm", "cup", "left_hand", "o1"])
NUMBERS = st.floats(-10, 10).map(lambda x: round(x, 9) + 0.0)
POSES = st.builds(
    ObjectPose, NAMES, st.tuples(*[st.floats(-5, 5).map(lambda x: x + 0.0)] * 3), st.just((0.0, 0.0, 0.0, 1.0))
)
CHANGES = st.builds(
    StateChange,
    st.dictionaries(NAMES, st.dictionaries(NAMES, NUMBERS), min_size=1, max_size=2),
    st.dictionaries(NAMES, POSES),
)
PAIRS = st.tuples(NAMES, NAMES)
TEXT = st.text(max_size=8)


@st.composite
def trajectories(draw, joints, waypoints, begin, end):
    """Any polynomials between two times in microseconds, rounded as in files; they follow no path."""
    inner = draw(st.sets(st.integers(begin + 1, end - 1), max_size=2)) if end - begin > 1 else set()
    knots = [begin, *sorted(inner), end]
    polynomial = st.lists(st.floats(-1e3, 1e3).map(lambda x: round(x, 12) + 0.0), max_size=5).map(ending_in_one)
    pieces = tuple(tuple(draw(polynomial) for _ in joints) for _ in knots[1:])
    deviation = draw(st.integers(0, 10**8)) / 1e9
    return Trajectory(joints, waypoints, tuple(t / 1e6 for t in knots), pieces, deviation)


def ending_in_one(coefficients):
    return (*coefficients, 1.0)


@st.composite
def segments(draw):
    count, width = draw(st.integers(2, 4)), draw(st.integers(1, 3))
    rows = st.tuples(*[NUMBERS] * width)
    times = sorted(draw(st.lists(st.integers(0, 10**7), min_size=count, max_size=count)))
    joints, waypoints = tuple(f"j{i}" for i in range(width)), tuple(draw(rows) for _ in range(count))
    timed = times[-1] > times[0] and draw(st.booleans())
    return Segment(
        robot=draw(NAMES),
        joints=joints,
        waypoints=waypoints,
        times=tuple(t / 1e6 for t in times),
        procedure=draw(TEXT),
        stage=draw(st.none() | TEXT),
        attach=tuple(draw(st.lists(PAIRS, max_size=1))),
        detach=tuple(draw(st.lists(NAMES, max_size=1))),
        allowed_contacts=tuple(draw(st.lists(PAIRS, max_size=2))),
        constraint=draw(st.none() | NAMES),
        trajectory=draw(trajectories(joints, waypoints, times[0], times[-1])) if timed else None,
    )


ARGUMENTS = st.dictionaries(NAMES, st.one_of(TEXT, NUMBERS, st.builds(ValueOf, TEXT)), max_size=2)


@st.composite
def trees(draw, levels=3):
    """A plan as a tree of plain tuples, nothing shared: (fields of the node, outcome -> tree)."""
    if levels == 0 or (levels < 3 and draw(st.integers(0, 3)) == 0):
        return ("goal", {}, {})
    kind = draw(st.sampled_from(["action", "sense", "delivers", "branch"]))
    # Few different names, so that equal continuations are frequent.
    fields = {} if kind == "branch" else {"action": draw(st.sampled_from("ab")), "arguments": draw(ARGUMENTS)}
    if kind != "branch" and draw(st.integers(0, 3)) == 0:
        fields |= {"motion": (draw(segments()),), "after": draw(CHANGES)}
        fields |= {"overlap": draw(st.sampled_from([0.0, 0.25, 1.5]))}
    if kind in ("action", "delivers"):
        fields |= {"delivers": ("p(x)",)} if kind == "delivers" else {}
        return ("sense" if kind == "delivers" else kind, fields, {"": draw(trees(levels - 1))})
    outcomes = draw(st.sampled_from([("false", "true"), ("red", "amber", "blue")]))
    fields["on"] = draw(st.sampled_from(["p(x)", "colour(x)"]))
    return kind, fields, {outcome: draw(trees(levels - 1)) for outcome in outcomes}


def add(builder: PlanBuilder, tree) -> str:
    kind, fields, following = tree
    if kind == "goal":
        return builder.goal()
    handles = {outcome: add(builder, inner) for outcome, inner in following.items()}
    if "" in handles:
        return builder.add(Node(kind, next=handles[""], **fields))
    return builder.add(Node(kind, branches=handles, **fields))


def built(tree) -> Plan:
    builder = PlanBuilder()
    root = add(builder, tree)
    files = {"domain.yaml": "sha256:" + "0" * 64}
    options = {"search": "greedy", "seed": 0, "epsilon": 0.01, "geometry": "bounding"}
    return builder.build(root, problem="p", files=files, options=options)


def branches(tree) -> list[tuple]:
    """Every way from the root of a tree to a goal, as what is done and found on it."""
    kind, fields, following = tree
    if kind == "goal":
        return [()]
    own = (kind, repr(sorted(fields.items(), key=lambda item: item[0])))
    return [(own, outcome, *way) for outcome, inner in following.items() for way in branches(inner)]


def unfolded(plan: Plan, name: str):
    """The tree of plain tuples that a plan stands for."""
    node = plan.nodes[name]
    if node.kind == "goal":
        return ("goal", {}, {})
    fields = {} if node.action is None else {"action": node.action, "arguments": node.arguments}
    fields |= {"motion": node.motion, "after": node.after, "overlap": node.overlap} if node.motion else {}
    fields |= {"delivers": node.delivers} if node.delivers else {}
    fields |= {"on": node.on} if node.on else {}
    following = node.branches or {"": node.next}
    return node.kind, fields, {outcome: unfolded(plan, successor) for outcome, successor in following.items()}


@given(tree=trees())
def test_a_file_says_all_of_a_plan_and_its_bytes_are_stable(tree):
    plan = built(tree)
    content = plan_to_json(plan)
    again = plan_from_json(content)
    assert again == plan
    assert plan_to_json(again) == content
    shuffled = list(plan.nodes.items())
    random.Random(0).shuffle(shuffled)
    assert plan_to_json(Plan(plan.problem, plan.files, plan.options, plan.root, dict(shuffled))) == content


@given(tree=trees())
def test_sharing_changes_no_branch(tree):
    plan = built(tree)
    count = sum(1 for _ in _nodes(tree))
    event("shared" if len(plan.nodes) < count else "nothing to share")
    assert sorted(branches(unfolded(plan, plan.root))) == sorted(branches(tree))
    assert plan_statistics(plan).plan_leaves == len(branches(tree))
    assert plan_statistics(plan).plan_actions == max(
        sum(1 for part in way if isinstance(part, tuple) and part[0] != "branch") for way in branches(tree)
    )


@given(tree=trees())
def test_building_from_a_built_plan_gives_the_same_plan(tree):
    plan = built(tree)
    builder = PlanBuilder()
    handles: dict[str, str] = {}
    for name in sorted(plan.nodes, key=lambda n: int(n[1:]), reverse=True):
        _hand_over(plan, name, builder, handles)
    again = builder.build(handles["n0"], problem="p", files=plan.files, options=plan.options)
    assert plan_to_json(again) == plan_to_json(plan)
    assert len({(repr(sorted(vars(n).items(), key=str))) for n in plan.nodes.values()}) == len(plan.nodes)


@given(tree=trees())
def test_a_description_shows_every_node_once(tree):
    plan = built(tree)
    lines = describe(plan).splitlines()
    for name, node in plan.nodes.items():
        if node.kind != "goal":
            assert sum(line.split(" ")[0] == name for line in lines) == 1


def _nodes(tree):
    yield tree
    for inner in tree[2].values():
        yield from _nodes(inner)


def _hand_over(plan: Plan, name: str, builder: PlanBuilder, handles: dict[str, str]) -> None:
    if name in handles:
        return
    node = plan.nodes[name]
    for successor in node.successors:
        _hand_over(plan, successor, builder, handles)
    following = None if node.next is None else handles[node.next]
    values = {**vars(node), "next": following, "branches": {o: handles[s] for o, s in node.branches.items()}}
    handles[name] = builder.add(Node(**values))
