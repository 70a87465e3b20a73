"""A plan as Python source that builds a tree of py_trees, and what of such a file decides what it builds.

The file needs py_trees alone: leaves come from whoever calls `create_tree`, one for each node of the plan. On the robots
and sensors of `kabo.execution` they are `kabo.exporting.PlanLeaves`.
"""

import ast
from collections.abc import Iterator

from kabo.exporting.behavior_tree import shared_nodes
from kabo.exporting.texts import one_line
from kabo.exporting.way import refusal
from kabo.plan import Node, Plan, topological_order
from kabo.plan.description import call

MAX_LEAVES = 100_000  # of the tree in memory, in which no node has two parents

_HEAD = '''"""A plan as a tree of py_trees, made by `kabo export --to py_trees`.

`create_tree(leaf)` builds it; `leaf(node)` returns the behaviour of a node of the plan, such as `leaf("n0")`. A leaf
that senses or decides writes the outcome that it found to the blackboard, as `outcome_NODE`; with an outcome that the
plan does not have the tree fails.
"""

import operator

from py_trees.behaviours import CheckBlackboardVariableValue, Success
from py_trees.common import ComparisonExpression
from py_trees.composites import Selector, Sequence


def steps(name, *children):
    """One child after the other, remembered between ticks."""
    return Sequence(name, memory=True, children=list(children))


def cases(node, trees):
    """The tree of the outcome that the leaf of this node has written."""
    made = []
    for outcome, tree in trees.items():
        check = ComparisonExpression(f"outcome_{node}", outcome, operator.eq)
        seen = CheckBlackboardVariableValue(f"{node} is {outcome}", check)
        made.append(steps(f"{node}: {outcome}", seen, tree))
    return Selector(f"outcome of {node}", memory=True, children=made)
'''


def py_trees_source(plan: Plan, file: str) -> str:
    """The source of a plan's tree: one function for each node at which a branch begins or several meet.

    Raises:
        InputError: the tree would be too large.
    """
    leaves = _leaves_of_tree(plan)
    if leaves > MAX_LEAVES:
        message = f"the tree would have {leaves} leaves: in py_trees nodes cannot share what follows them"
        raise refusal(file, message, "export to bt, where they can")
    beginnings = dict.fromkeys([plan.root])
    shared = shared_nodes(plan)
    for node in plan.nodes.values():
        beginnings.update(dict.fromkeys(node.branches.values()))
        beginnings.update(dict.fromkeys(name for name in node.successors if name in shared))
    order = topological_order(plan) or []
    parts = [_HEAD, f"\ndef create_tree(leaf):\n    return tree_{plan.root}(leaf)\n"]
    for name in order:
        if name in beginnings:
            parts.append("\n" + "\n".join(_function(plan, name, shared)) + "\n")
    return "\n".join(parts)


def _leaves_of_tree(plan: Plan) -> int:
    """How many leaves the tree has when every branch has nodes of its own."""
    counts: dict[str, int] = {}
    for name in reversed(topological_order(plan) or []):
        counts[name] = 1 + sum(counts[after] for after in plan.nodes[name].successors)
    return counts[plan.root]


def _function(plan: Plan, name: str, shared: set[str]) -> Iterator[str]:
    yield f"def tree_{name}(leaf):"
    node = plan.nodes[name]
    if node.kind == "goal":
        yield f'    return Success("{name}: goal")'
        return
    yield "    return steps("
    yield f'        "from {name}",'
    first = True
    while True:
        node = plan.nodes[name]
        if node.kind == "goal":
            break
        if name in shared and not first:
            yield f"        tree_{name}(leaf),"
            break
        yield f'        leaf("{name}"),  # {_remark(node)}'
        if node.branches:
            trees = ", ".join(f"{outcome!r}: tree_{after}(leaf)" for outcome, after in node.branches.items())
            yield f'        cases("{name}", {{{trees}}}),'
            break
        name, first = str(node.next), False
    yield "    )"


def _remark(node: Node) -> str:
    said = call(node) if node.action is not None else "decides"
    return one_line(said if node.on is None else f"{said}, on {node.on}")


def decisive_lines(text: str) -> list[str]:
    """The statements of a source without comments and layout.

    Raises:
        ValueError: it is no Python.
    """
    try:
        return ast.unparse(ast.parse(text)).splitlines()
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise ValueError(f"it is no Python: {error}") from None
