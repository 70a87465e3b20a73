"""A plan as a tree for BehaviorTree.CPP, in its XML of version 4, and what of such a file decides how it is followed.

Leaves have no ports: a leaf is called like its node in the plan (`name()` in C++), and finds motion and arguments
there. `KaboSense` and `KaboDecide` write what they found to the blackboard entry `outcome_NODE`, on which the Switch
behind them branches; an outcome that the plan does not have fails. Nodes that several nodes lead to are trees of
their own, so the file is as large as the plan.
"""

from collections.abc import Iterator, Mapping
from xml.etree import ElementTree  # noqa: S405 - without a DOCTYPE there are no entities, and such files are refused
from xml.sax.saxutils import quoteattr

from kabo.exporting.texts import one_line
from kabo.plan import Node, Plan
from kabo.plan.description import call

MAIN = "kabo_plan"
LEAVES = {"action": "KaboAction", "sense": "KaboSense", "branch": "KaboDecide"}
CASES = range(2, 7)  # of the library's nodes Switch2 to Switch6
REMARKS = ("_description", "_uid", "_fullpath")  # attributes that people or editors read
MODELS = ("Action", "Condition", "Control", "Decorator", "SubTree")
MAX_DEPTH = 40  # of branches inside each other; deeper ones become trees of their own: parsers have limits, too


def behavior_tree(plan: Plan) -> str:
    """The XML file of a plan."""
    writer = _Writer(plan)
    lines = [
        f"<!-- {_comment(plan.problem)}: made by kabo export -->",
        f'<root BTCPP_format="4" main_tree_to_execute="{MAIN}">',
        *writer.trees(),
        "  <TreeNodesModel>",
        *(f'    <Action ID="{leaf}"/>' for leaf in LEAVES.values()),
        "  </TreeNodesModel>",
        "</root>",
    ]
    return "\n".join(lines) + "\n"


def shared_nodes(plan: Plan) -> set[str]:
    """The nodes, other than goals, that more than one node or outcome leads to."""
    seen: set[str] = set()
    shared: set[str] = set()
    for node in plan.nodes.values():
        for after in node.successors:
            (shared if after in seen else seen).add(after)
    return {name for name in shared if plan.nodes[name].kind != "goal"}


class _Writer:
    """Writes the trees of a plan one after the other; each names those that are still to be written."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.own = shared_nodes(plan)
        self.waiting: list[str] = []
        self.written: set[str] = set()

    def trees(self) -> Iterator[str]:
        yield from self._tree(MAIN, self.plan.root)
        while self.waiting:
            name = self.waiting.pop(0)
            yield from self._tree(name, name)

    def _tree(self, tree: str, name: str) -> Iterator[str]:
        yield f'  <BehaviorTree ID="{tree}">'
        yield from self._sequence(name, 2)
        yield "  </BehaviorTree>"

    def _sequence(self, name: str, depth: int) -> Iterator[str]:
        """The nodes from here on, up to a goal, to a branching with its cases, or to a tree of its own."""
        space = "  " * depth
        yield f"{space}<Sequence>"
        first = True
        while True:
            node = self.plan.nodes[name]
            if node.kind == "goal":
                yield f'{space}  <AlwaysSuccess name="{name}"/>'
                break
            if name in self.own and not first:
                yield f"{space}  {self._subtree(name)}"
                break
            yield f"{space}  {_leaf(name, node)}"
            if node.branches:
                yield from self._switch(name, list(node.branches.items()), depth + 1)
                break
            name, first = str(node.next), False
        yield f"{space}</Sequence>"

    def _switch(self, name: str, cases: list[tuple[str, str]], depth: int) -> Iterator[str]:
        """The cases of a branching; more than six are nested in the default of the first ones."""
        space = "  " * depth
        own, rest = cases[: CASES[-1]], cases[CASES[-1] :]
        count = max(len(own), CASES[0])
        values = [outcome for outcome, _ in own] + [own[0][0]] * (count - len(own))  # there is no Switch1
        given = "".join(f" case_{i}={quoteattr(value)}" for i, value in enumerate(values, 1))
        yield f'{space}<Switch{count} variable="{{outcome_{name}}}"{given}>'
        for _, after in own:
            yield from self._case(after, depth + 1)
        for _ in range(count - len(own)):
            yield f'{space}  <AlwaysFailure name="never"/>'
        if rest:
            yield from self._switch(name, rest, depth + 1)
        else:
            yield f'{space}  <AlwaysFailure name="{name} found what the plan does not have"/>'
        yield f"{space}</Switch{count}>"

    def _case(self, name: str, depth: int) -> Iterator[str]:
        if self.plan.nodes[name].kind == "goal":
            yield f'{"  " * depth}<AlwaysSuccess name="{name}"/>'
        elif name in self.own or depth > 2 * MAX_DEPTH:
            yield f"{'  ' * depth}{self._subtree(name)}"
        else:
            yield from self._sequence(name, depth)

    def _subtree(self, name: str) -> str:
        if name not in self.written:
            self.written.add(name)
            self.waiting.append(name)
        return f'<SubTree ID="{name}" _autoremap="true"/>'


def _leaf(name: str, node: Node) -> str:
    said = call(node) if node.action is not None else f"what is known of {node.on}"
    if node.on is not None and node.action is not None:
        said += f" senses {node.on}"
    if node.delivers:
        said += f" delivers {', '.join(node.delivers)}"
    early = f' _begins_early="{node.overlap:g}"' if node.overlap > 0.0 else ""
    return f'<{LEAVES[node.kind]} name="{name}"{early} _description={quoteattr(one_line(said))}/>'


def _comment(text: str) -> str:
    return one_line(text).replace("--", "- -").replace("--", "- -").rstrip("-")


def decisive_parts(text: str) -> list[str]:
    """What decides how a file is followed, in its order; not the layout, comments, descriptions and other remarks.

    Raises:
        ValueError: the file is no XML, or has a DOCTYPE or a namespace.
    """
    for word in ("<!DOCTYPE", "<!ENTITY", "xmlns"):
        if word in text:
            raise ValueError(f"no tree of behaviors has {word}")
    try:
        root = ElementTree.fromstring(text)  # noqa: S314 - see above
    except ElementTree.ParseError as error:
        raise ValueError(f"it is no XML: {error}") from None
    parts: list[str] = []
    stack: list[tuple[ElementTree.Element, str]] = [(root, "")]
    while stack:
        element, inside = stack.pop()
        if element.tag == "TreeNodesModel" and all(
            each.tag in MODELS and each.get("ID") and not len(each) for each in element
        ):
            continue  # for editors
        parts.append(f"{inside}<{element.tag}{_attributes(element.attrib)}> of {len(element)}")
        for words in (element.text, *(each.tail for each in element)):
            if words and words.strip():
                parts.append(f"{inside}{words.strip()}")
        deeper = inside if len(inside) > 2 * MAX_DEPTH else f"{inside} "
        stack += [(each, deeper) for each in reversed(element)]
    return parts


def _attributes(found: Mapping[str, str]) -> str:
    """The attributes in the order of their names, but for remarks."""
    return "".join(f" {key}={value!r}" for key, value in sorted(found.items()) if key not in REMARKS)
