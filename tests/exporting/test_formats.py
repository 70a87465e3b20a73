"""Every format, read back by a library that nobody here wrote; mutated files are refused, or say the same; errors."""

import random
from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

import kabo
from kabo.errors import InputError
from kabo.exporting import FORMATS, check_export, export, ros_trajectories
from kabo.plan import Node, Plan, Segment
from tests.conftest import PROPERTY_SCALE
from tests.exporting.conftest import DOMAINS, SMALL
from tests.support import export_readers as readers

GRAPHS = {"dot": readers.graph_of_dot, "mermaid": readers.graph_of_mermaid}
TREES = {"bt": readers.ticked_by_behavior_tree_cpp, "py_trees": readers.ticked_by_py_trees}
LINEAR = [to for to, form in FORMATS.items() if "branch" in form.takes]
MUTATIONS = 1000
PROBLEMS = sorted(path for path in DOMAINS.glob("*/*.yaml") if path.stem not in ("domain", "scene"))
TEXTS = 40 if PROPERTY_SCALE >= 1.0 else 6  # branches whose texts are read; trees follow all of them
# Followed in whole runs: 32 leaves and more, and plans that are only longer than those of the same domain before.
LARGEST = {f"force_sensing/n{count}" for count in range(5, 11)} | {"coloured_balls/n4_2"}
LARGEST |= {f"stacked/n{count}" for count in range(6, 21)} | {
    f"circular_rearrange/n{count}" for count in (4, 5, 6)
}
LARGEST |= {"assembly/two_gearboxes", "inspection/three_boxes_covered"}


def chosen(to: str, plan: Plan) -> dict[str, Any]:
    """The options of a format for the first branch."""
    outcomes, _ = next(readers.walks(plan))
    return {"branch": ",".join(outcomes.values())} if to in LINEAR and outcomes else {}


def meaning(to: str, text: str, plan: Plan) -> object:
    """What foreign readers make of a file."""
    if to in TREES:
        tick = TREES[to](text)
        return [tick(outcomes) for outcomes, _ in readers.walks(plan)]
    if to in GRAPHS:
        return GRAPHS[to](text)
    if to == "csv":
        return [
            {key: float(value) if "." in value else value for key, value in row.items()}
            for row in readers.rows_of_table(text)
        ]
    return readers.documents(text)


def follow_every_leaf(plan: Plan) -> None:
    """Asserts that trees, graphs and tables do what the plan does, on each branch."""
    ticked = [tree(export(plan, to)) for to, tree in TREES.items()]
    for outcomes, walk in readers.walks(plan):
        assert [tick(outcomes) for tick in ticked] == [walk] * len(ticked)
    for to, graph in GRAPHS.items():
        assert graph(export(plan, to)) == readers.graph_of_plan(plan)
    walks = list(islice(readers.walks(plan), 40))
    for outcomes, walk in walks[:: -(-len(walks) // TEXTS)]:  # the texts of one branch each
        branch = ",".join(outcomes.values()) or None
        rows = readers.rows_of_table(export(plan, "csv", branch=branch, rate=10.0))
        assert readers.nodes_of_rows(rows) == walk
        told = {row["node"]: row["outcome"] for row in rows if row["outcome"]}
        assert told == outcomes
        if any(plan.nodes[name].motion for name in walk):
            follow_messages(plan, branch, walk)


def follow_messages(plan: Plan, branch: str | None, walk: tuple[str, ...]) -> None:
    """Asserts that messages have the motion of a branch in its order, in YAML as in bytes."""
    moving = [name for name in walk if plan.nodes[name].motion]
    for kind in ("trajectory", "moveit"):
        messages = ros_trajectories(plan, kind, branch=branch)
        assert list(dict.fromkeys(node for each in messages for node in each.nodes)) == moving
        read = readers.documents(export(plan, kind, branch=branch))
        assert read == [each.body() for each in messages]
        first = messages[0]
        assert readers.bytes_of_rosbags(read[0], first.ros_type) == first.to_cdr()


@pytest.mark.parametrize("problem", SMALL)
def test_every_leaf_of_a_plan_is_followed_as_the_plan_says(problem: str) -> None:
    plan = kabo.solve(kabo.load_problem(DOMAINS / problem)).plan
    assert plan is not None
    follow_every_leaf(plan)


def test_motions_are_followed_as_the_plan_says(moving: Plan) -> None:
    follow_every_leaf(moving)


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    [path for path in PROBLEMS if PROPERTY_SCALE >= 1.0 or f"{path.parent.name}/{path.stem}" not in LARGEST],
    ids=str,
)
def test_every_leaf_of_every_domain_is_followed(path: Path) -> None:
    plan = kabo.solve(kabo.load_problem(path), certificate=False).plan
    assert plan is not None
    follow_every_leaf(plan)


def test_trees_fail_at_an_outcome_that_the_plan_does_not_have(moving: Plan) -> None:
    sensing = next(name for name, node in moving.nodes.items() if node.branches)
    for to, tree in TREES.items():
        assert tree(export(moving, to))({sensing: "unheard of"}) is None


def test_outcomes_beyond_six_are_nested_and_one_alone_is_a_switch_too() -> None:
    for count in (1, 2, 6, 7, 14):
        branches = {f"v{number}": f"n{number + 1}" for number in range(count)}
        nodes = {"n0": Node("sense", "look", {}, on="x", branches=branches)}
        nodes |= {f"n{number + 1}": Node("action", "act", {}, next="n99") for number in range(count)}
        follow_every_leaf(Plan("many", {}, {}, "n0", {**nodes, "n99": Node("goal")}))


def test_a_hundred_branchings_behind_each_other_are_no_trouble() -> None:
    nodes: dict[str, Node] = {"n300": Node("goal")}
    for number in range(100):
        branches = {"true": "n300", "false": f"n{number + 1}" if number < 99 else "n300"}
        nodes[f"n{number}"] = Node("sense", "look", {}, on=f"x{number}", branches=branches)
    follow_every_leaf(Plan("deep", {}, {}, "n0", nodes))


def test_a_tree_that_would_not_fit_is_refused() -> None:
    nodes: dict[str, Node] = {"n40": Node("goal")}
    for number in range(40):
        nodes[f"n{number}"] = Node(
            "sense", "look", {}, on=f"x{number}", branches={"true": f"n{number + 1}", "false": f"n{number + 1}"}
        )
    with pytest.raises(InputError, match="in py_trees nodes cannot share what follows them"):
        export(Plan("wide", {}, {}, "n0", nodes), "py_trees")
    assert len(export(Plan("wide", {}, {}, "n0", nodes), "bt")) < 20_000


def mutated(text: str, draw: random.Random) -> str:
    """A text with one fault: a character, a digit, a word, or a line that is lost, doubled, changed or exchanged."""
    lines, at = text.split("\n"), draw.randrange(len(text))
    kinds: list[Callable[[], str]] = [
        lambda: text[:at] + text[at + 1 :],
        lambda: text[:at] + draw.choice("\n \"'<>{}[]#:,-0a") + text[at + 1 :],
        lambda: text[:at],
        lambda: "\n".join(lines[: at % len(lines)] + lines[at % len(lines) + 1 :]),
        lambda: "\n".join([*lines[: at % len(lines)], lines[at % len(lines)], *lines[at % len(lines) :]]),
        lambda: _exchanged(lines, at % len(lines), draw.randrange(len(lines))),
        lambda: _digit(text, at, draw),
        lambda: text.replace("n1", "n2", 1),
    ]
    return draw.choice(kinds)()


def _exchanged(lines: list[str], first: int, second: int) -> str:
    lines = list(lines)
    lines[first], lines[second] = lines[second], lines[first]
    return "\n".join(lines)


def _digit(text: str, at: int, draw: random.Random) -> str:
    places = [place for place, each in enumerate(text) if each.isdigit()]
    place = min(places, key=lambda each: abs(each - at))
    return text[:place] + draw.choice("0123456789") + text[place + 1 :]


@pytest.mark.parametrize("to", ["bt", "py_trees", "trajectory", "moveit", "dot", "mermaid", "csv"])
def test_mutated_files_are_refused_or_say_the_same(to: str, moving: Plan) -> None:
    """What the check accepts, a foreign reader reads as it reads the file that was exported."""
    draw = random.Random(7)
    options = chosen(to, moving)
    text = export(moving, to, **options)
    assert check_export(moving, to, text, **options) is None
    expected, refused, accepted = meaning(to, text, moving), 0, 0
    for _ in range(MUTATIONS // 7 + 1):
        other = mutated(text, draw)
        if check_export(moving, to, other, **options) is not None:
            refused += 1
        else:
            accepted += 1
            assert meaning(to, other, moving) == expected
    assert refused > 60 and (accepted > 0 or to == "mermaid")


def test_faults_that_behavior_tree_cpp_accepts_are_found(moving: Plan) -> None:
    text = export(moving, "bt")
    lines = [line for line in text.split("\n") if "AlwaysFailure" not in line]
    for other in ("\n".join(lines), text.replace('BTCPP_format="4"', 'BTCPP_format="3"')):
        readers.ticked_by_behavior_tree_cpp(other)
        assert check_export(moving, "bt", other) is not None


def test_layout_and_remarks_may_differ(moving: Plan) -> None:
    text = (
        export(moving, "bt").replace("\n", "\n\n  ").replace('<KaboAction name="', '<KaboAction  _uid="3" name="')
    )
    assert check_export(moving, "bt", text.lstrip()) is None
    source = export(moving, "py_trees").replace("  # ", "  # changed: ")
    assert check_export(moving, "py_trees", source) is None


@pytest.mark.parametrize(
    ("to", "options", "said"),
    [
        ("btt", {}, 'no format "btt"\n      = did you mean "bt"'),
        ("dot", {"rate": 5.0}, "dot does not take it"),
        ("bt", {"branch": "true"}, "it is of trajectory, moveit, csv, urscript"),
        ("csv", {}, "the plan branches on full.*choose one of its 2 branches, as by --branch true"),
        ("csv", {"branch": "maybe"}, "neither a node nor an outcome"),
        ("csv", {"branch": "true,true"}, "nothing is left to observe for true"),
        ("csv", {"branch": "n2"}, "--node n2 is its motion alone"),
        ("csv", {"node": "n77"}, 'no node "n77"'),
        ("csv", {"node": "n1", "branch": "true"}, "choose a branch or one node"),
        ("trajectory", {"node": "n0", "robot": "lef"}, 'did you mean "left"'),
        ("trajectory", {"node": "n1"}, "n1 has no motion.*choose a node that moves something"),
        ("trajectory", {"node": "n0", "rate": 0.0}, "no rate"),
        ("urscript", {"node": "n0"}, "an arm of Universal Robots has shoulder_pan_joint"),
    ],
)
def test_what_cannot_be_exported_is_refused_by_name(
    to: str, options: dict[str, Any], said: str, moving: Plan
) -> None:
    with pytest.raises(InputError, match=f"(?s){said}"):
        export(moving, to, **options)


def test_plans_that_cannot_be_followed_are_refused(moving: Plan) -> None:
    lost = {**moving.nodes, "n3": Node("action", "act", {}, next="n42")}
    circle = {**moving.nodes, "n3": Node("action", "act", {}, next="n0")}
    still = Plan("still", {}, {}, "n0", {"n0": Node("action", "act", {}, next="n1"), "n1": Node("goal")})
    old = Plan("old", {}, {}, "n0", {"n0": _old(), "n1": Node("goal")})
    for nodes, said in ((lost, "n3 leads to n42, which is no node"), (circle, "has a cycle")):
        with pytest.raises(InputError, match=said):
            export(Plan("broken", {}, {}, "n0", nodes), "bt")
    with pytest.raises(InputError, match="the plan has no motion: nothing can be sent"):
        export(still, "trajectory")
    with pytest.raises(InputError, match="n0 has no trajectory"):
        export(old, "csv")


def _old() -> Node:
    segment = Segment("left", ("j",), ((0.0,), (1.0,)), (0.0, 1.0), "move")
    return Node("action", "act", {}, next="n1", motion=(segment,))
