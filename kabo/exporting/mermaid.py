"""A plan as a flowchart in Mermaid's language, which GitHub, GitLab and many editors draw in Markdown files."""

from kabo.exporting.texts import one_line
from kabo.plan import Node, Plan, topological_order
from kabo.plan.description import call

MAX_LABEL_CHARACTERS = 60
_SHAPES = {"action": ("[", "]"), "sense": ("([", "])"), "branch": ("{", "}"), "goal": ("(((", ")))")}


def mermaid(plan: Plan) -> str:
    """The flowchart: actions are boxes, sensing actions have round ends, decisions are diamonds, goals circles."""
    lines = ["flowchart TD"]
    for name in topological_order(plan) or plan.nodes:
        node = plan.nodes[name]
        begin, end = _SHAPES[node.kind]
        lines.append(f"  {name}{begin}{_quoted(*_label(name, node))}{end}")
        if node.branches:
            lines += [f"  {name} -->|{_quoted(outcome)}| {after}" for outcome, after in node.branches.items()]
        elif node.next is not None:
            lines.append(f"  {name} --> {node.next}")
    return "\n".join(lines) + "\n"


def _label(name: str, node: Node) -> list[str]:
    if node.kind == "goal":
        return ["goal"]
    if node.kind == "branch":
        return [f"{name}: {node.on}"]
    lines = [f"{name}: {call(node)}"]
    if node.on is not None:
        lines.append(f"senses {node.on}")
    if node.delivers:
        lines.append(f"delivers {', '.join(node.delivers)}")
    return lines


def _quoted(*lines: str) -> str:
    """Lines as one string of Mermaid, in which every character that could mean something is written by its number."""
    return '"' + "<br/>".join(map(_escaped, lines)) + '"'


def _escaped(line: str) -> str:
    line = one_line(line)
    cut = line if len(line) <= MAX_LABEL_CHARACTERS else f"{line[: MAX_LABEL_CHARACTERS - 1]}…"
    return "".join(each if each.isalnum() or each in " _-=(),.:…" else f"#{ord(each)};" for each in cut)
