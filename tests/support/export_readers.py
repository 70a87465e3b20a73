"""Exports as other people's libraries read them: BehaviorTree.CPP, py_trees, PyYAML, rosbags, pydot, csv.

A walk is what a plan does for one set of outcomes: its nodes in order, without the goal.
"""

import csv
import io
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import behaviortreepy
import py_trees
import pydot
import yaml
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from kabo.plan import Plan

Walk = tuple[str, ...]
Outcomes = Mapping[str, str]
MOVEIT = """trajectory_msgs/JointTrajectory joint_trajectory
trajectory_msgs/MultiDOFJointTrajectory multi_dof_joint_trajectory
"""
STORE = get_typestore(Stores.ROS2_HUMBLE)
STORE.register(get_types_from_msg(MOVEIT, "moveit_msgs/msg/RobotTrajectory"))


def walks(plan: Plan) -> Iterator[tuple[dict[str, str], Walk]]:
    """Every branch: the outcomes of its nodes, and what it does."""
    waiting: list[tuple[str, dict[str, str], Walk]] = [(plan.root, {}, ())]
    while waiting:
        name, outcomes, walk = waiting.pop()
        node = plan.nodes[name]
        if node.kind == "goal":
            yield outcomes, walk
        for outcome, after in (node.branches or {None: node.next}).items():
            if after is not None:
                found = outcomes if outcome is None else {**outcomes, name: outcome}
                waiting.append((after, found, (*walk, name)))


def ticked_by_behavior_tree_cpp(text: str) -> Callable[[Outcomes], Walk | None]:
    """What BehaviorTree.CPP does with outcomes; None: the tree fails."""
    factory, board = behaviortreepy.BehaviorTreeFactory(), behaviortreepy.Blackboard.create()
    done: list[str] = []
    found: dict[str, str] = {}

    def leaf(node: Any) -> Any:
        done.append(node.name())
        if node.name() in found:
            board.set_string(f"outcome_{node.name()}", found[node.name()])
        return behaviortreepy.NodeStatus.SUCCESS

    for name in ("KaboAction", "KaboSense", "KaboDecide"):
        factory.register_simple_action(name, leaf)
    tree = factory.create_tree_from_text(text, board)

    def tick(outcomes: Outcomes) -> Walk | None:
        done.clear()
        found.clear()
        found.update(outcomes)
        status = tree.tick_while_running()
        return tuple(done) if status == behaviortreepy.NodeStatus.SUCCESS else None

    return tick


def ticked_by_py_trees(text: str) -> Callable[[Outcomes], Walk | None]:
    """What py_trees does with outcomes; None: the tree fails."""
    names: dict[str, Any] = {}
    exec(compile(text, "plan_tree.py", "exec"), names)
    done: list[str] = []
    found: dict[str, str] = {}

    class Leaf(py_trees.behaviour.Behaviour):
        def __init__(self, node: str) -> None:
            super().__init__(node)
            self.board = self.attach_blackboard_client(name=node)
            self.board.register_key(f"outcome_{node}", access=py_trees.common.Access.WRITE)

        def update(self) -> Any:
            done.append(self.name)
            if self.name in found:
                self.board.set(f"outcome_{self.name}", found[self.name])
            return py_trees.common.Status.SUCCESS

    tree = names["create_tree"](Leaf)

    def tick(outcomes: Outcomes) -> Walk | None:
        done.clear()
        found.clear()
        found.update(outcomes)
        py_trees.blackboard.Blackboard.storage.clear()
        tree.stop(py_trees.common.Status.INVALID)
        tree.tick_once()
        return tuple(done) if tree.status == py_trees.common.Status.SUCCESS else None

    return tick


def graph_of_dot(text: str) -> tuple[set[str], set[tuple[str, str, str]]]:
    """The nodes of a graph, and its edges with their labels, as pydot reads them."""
    (graph,) = pydot.graph_from_dot_data(text)
    nodes = {each.get_name().strip('"') for each in graph.get_nodes()} - {"node", "edge"}
    edges = {
        (
            each.get_source().strip('"'),
            each.get_destination().strip('"'),
            (each.get("label") or "").strip('"'),
        )
        for each in graph.get_edges()
    }
    return nodes, edges


_NODE = re.compile(r'(n\d+)(\["|\(\["|\{"|\(\(\(").*"[\])}]+')
_EDGE = re.compile(r'(n\d+) -->(?:\|"([^"]*)"\|)? (n\d+)')


def graph_of_mermaid(text: str) -> tuple[set[str], set[tuple[str, str, str]]]:
    """The nodes of a flowchart, and its edges with their labels; by patterns, as its own library is of JavaScript."""
    first, *lines = text.split("\n")
    assert first == "flowchart TD"
    nodes, edges = set(), set()
    for line in filter(None, map(str.strip, lines)):
        if (edge := _EDGE.fullmatch(line)) is not None:
            label = re.sub(r"#(\d+);", lambda code: chr(int(code[1])), edge[2] or "")
            edges.add((edge[1], edge[3], label))
        else:
            node = _NODE.fullmatch(line)
            assert node is not None, line
            nodes.add(node[1])
    return nodes, edges


def graph_of_plan(plan: Plan) -> tuple[set[str], set[tuple[str, str, str]]]:
    """The nodes of a plan, and its edges with outcomes."""
    edges = {
        (name, after, outcome)
        for name, node in plan.nodes.items()
        for outcome, after in (node.branches or {"": node.next}).items()
        if after is not None
    }
    return set(plan.nodes), edges


def documents(text: str) -> list[dict[str, Any]]:
    """The messages of a file, as PyYAML reads them for `ros2 topic pub`."""
    return list(yaml.load_all(text, Loader=yaml.CSafeLoader))


def message_of_rosbags(content: bytes, ros_type: str) -> Any:
    """A message as rosbags reads its bytes."""
    return STORE.deserialize_cdr(content, ros_type)


def bytes_of_rosbags(body: Mapping[str, Any], ros_type: str) -> bytes:
    """The bytes of a message as rosbags writes them, from its dictionary."""
    return bytes(STORE.serialize_cdr(_filled(body, ros_type), ros_type))


def _filled(body: Mapping[str, Any], ros_type: str) -> Any:
    import numpy as np

    kinds = dict(STORE.fielddefs[ros_type][1])
    given = {}
    for name, value in body.items():
        kind, detail = kinds[name]
        kind = kind.name if hasattr(kind, "name") else kind
        if isinstance(value, Mapping):
            given[name] = _filled(value, detail)
        elif isinstance(value, list):
            inner = detail[0]
            inner_kind = inner[0].name if hasattr(inner[0], "name") else inner[0]
            if inner_kind == "NAME" or (isinstance(inner[1], str) and "/" in inner[1]):
                given[name] = [_filled(each, inner[1]) for each in value]
            else:
                given[name] = value if inner[1][0] == "string" else np.array(value, np.float64)
        else:
            given[name] = value
    return STORE.types[ros_type](**given)


def rows_of_table(text: str) -> list[dict[str, str]]:
    """The rows of a table by their heads, as the module csv reads them."""
    return list(csv.DictReader(io.StringIO(text, newline="")))


def nodes_of_rows(rows: list[dict[str, str]]) -> Walk:
    """The nodes of a table in order, goals left out."""
    return tuple(dict.fromkeys(row["node"] for row in rows if row["action"] != "goal"))
