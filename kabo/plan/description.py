"""Writes a plan as indented text, with every node once; where branches join, there is a reference."""

from collections.abc import Iterator

from kabo.plan.plan import Learned, Node, Plan, ValueOf


def describe(plan: Plan) -> str:
    """The plan as text, one line for each node; later occurrences of a shared node are references."""
    shown: set[str] = set()
    lines: list[str] = []
    width = max((len(name) for name in plan.nodes), default=2)
    # What is still to be written, the next on top: a node's id, its indentation, the outcome that leads to it.
    stack: list[tuple[str, int, str | None]] = [(plan.root, 0, None)]
    while stack:
        name, depth, outcome = stack.pop()
        if outcome is not None:
            lines.append(f"{'':{width}}  {'  ' * (depth - 1)}{outcome}:")
        indentation = "  " * depth
        node = plan.nodes.get(name)
        if node is None:
            lines.append(f"{'':{width}}  {indentation}-> {name}, which is missing")
        elif name in shown and node.kind != "goal":
            lines.append(f"{'':{width}}  {indentation}-> {name}")
        else:
            shown.add(name)
            lines.append(f"{name:<{width}}  {indentation}{_line(node)}")
            stack.extend(reversed(list(_following(node, depth))))
    return "\n".join(lines) + "\n"


def call(node: Node) -> str:
    """The action of a node as text: `pick_up(o=bottle_1, r=left)`."""
    if node.action is None:
        return node.kind
    values = (f"{name}={_value(value)}" for name, value in node.arguments.items())
    return f"{node.action}({', '.join(values)})"


def _following(node: Node, depth: int) -> Iterator[tuple[str, int, str | None]]:
    if not node.branches and node.next is not None:
        yield node.next, depth, None
    for outcome in sorted(node.branches, key=lambda o: {"false": 0, "true": 1}.get(o, 0)):
        yield node.branches[outcome], depth + 1, outcome


def _line(node: Node) -> str:
    if node.kind == "goal":
        return "goal"
    if node.kind == "branch":
        return f"branch on {node.on}"
    text = call(node)
    if node.on is not None:
        text += f"  senses {node.on}"
    if node.delivers:
        text += f"  delivers {', '.join(node.delivers)}"
    if node.motion:
        seconds = f"{max(segment.times[-1] for segment in node.motion):.1f} s"
        text += f"  [{seconds}, begins {node.overlap:.1f} s early]" if node.overlap else f"  [{seconds}]"
    return text + "".join(f"  [{_learned(each)}]" for each in node.learned)


def described_validity(validity: float) -> str:
    """A probability as text, such as `0.97`; never 1, because a model that has learned is never certain."""
    text = f"{validity:.3g}"
    return "over 0.999" if text == "1" else text


def _learned(learned: Learned) -> str:
    """What was learned as text: `learned along=0.01, valid at 0.97`."""
    parameters = ", ".join(f"{name}={value:.4g}" for name, value in learned.parameters.items())
    return f"learned {parameters}, valid at {described_validity(learned.validity)}"


def _value(value: str | float | ValueOf) -> str:
    if isinstance(value, ValueOf):
        return f"value of {value.term}"
    return value if isinstance(value, str) else f"{value:g}"
