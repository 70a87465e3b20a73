"""Writes a plan as a graph for Graphviz: one box for each action, outcomes on the edges, shared nodes once."""

from kabo.plan.description import call
from kabo.plan.plan import Node, Plan
from kabo.plan.statistics import topological_order

MAX_LABEL_CHARACTERS = 60  # characters of a line in a box or on an edge

_SHAPES = {"action": "box", "sense": "ellipse", "branch": "diamond", "goal": "doublecircle"}


def plan_to_dot(plan: Plan) -> str:
    """The plan in Graphviz's language DOT, such as for `dot -Tsvg`; nodes are called as in the plan.

    Actions are boxes, sensing actions ellipses, decisions on what is known diamonds, and the goal is a double circle.
    """
    lines = [
        f"digraph {_quoted(plan.problem)} {{",
        '  node [fontname="sans-serif", fontsize=11];',
        '  edge [fontname="sans-serif", fontsize=10];',
    ]
    names = topological_order(plan)
    for name in names if names is not None else plan.nodes:  # a plan with a cycle is drawn, too
        node = plan.nodes[name]
        lines.append(f"  {_quoted(name)} [shape={_SHAPES[node.kind]}, label={_quoted(*_label(name, node))}];")
        if node.branches:
            lines += [
                f"  {_quoted(name)} -> {_quoted(to)} [label={_quoted(outcome)}];"
                for outcome, to in node.branches.items()
            ]
        elif node.next is not None:
            lines.append(f"  {_quoted(name)} -> {_quoted(node.next)};")
    return "\n".join([*lines, "}"]) + "\n"


def _label(name: str, node: Node) -> list[str]:
    """The lines in the shape of a node."""
    if node.kind == "goal":
        return ["goal"]
    if node.kind == "branch":
        return [name, f"{node.on}?"]
    lines = [f"{name}: {call(node)}"]
    if node.on is not None:
        lines.append(f"senses {node.on}")
    if node.delivers:
        lines.append(f"delivers {', '.join(node.delivers)}")
    return lines


def _quoted(*lines: str) -> str:
    r"""Lines as one string of DOT, in which only `"` and `\` have a meaning; long lines are cut."""
    cut = (each if len(each) <= MAX_LABEL_CHARACTERS else f"{each[: MAX_LABEL_CHARACTERS - 1]}…" for each in lines)
    text = "\\n".join(each.replace("\\", "\\\\").replace('"', '\\"') for each in cut)
    return f'"{text}"'
