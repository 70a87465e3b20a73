"""A plan as a picture of boxes: what stands in the box of every node, how large it is, and where it is placed.

A box has up to two lines, the action and its arguments, and below them a row of chips, one for each outcome; the edge of
an outcome leaves at its chip. Text is set in a monospaced font, so its width is known without a display.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kabo.plan import Node, Plan, ValueOf, topological_order
from kabo.viewer.content.plan.layers import Box, Layout, layered

if TYPE_CHECKING:
    from kabo.language.problem import Problem

FONT = "ui-monospace, 'DejaVu Sans Mono', Menlo, Consolas, monospace"
TITLE, TEXT, CHIP = 12.0, 11.0, 10.5  # heights of fonts [px]
CHARACTER = 0.61  # width of a character of these fonts, as a share of the height
LINE, MARGIN, CHIP_ROW, CHIP_GAP, CHIP_MARGIN = 15.0, 8.0, 20.0, 4.0, 6.0  # [px]
LONGEST = 48  # characters of a line; longer ones end in "…"


@dataclass(frozen=True)
class Chip:
    """An outcome within a box: its text, and its left end and width, measured from the left side of the box."""

    outcome: str
    x: float
    width: float


@dataclass(frozen=True)
class Card:
    """What stands in the box of a node, and how large that is."""

    lines: tuple[str, ...]
    chips: tuple[Chip, ...]
    width: float
    height: float


@dataclass(frozen=True)
class PlanPicture:
    """The cards of all nodes that the root reaches, by their ids, and where they are placed."""

    cards: Mapping[str, Card]
    layout: Layout


def plan_picture(plan: Plan) -> PlanPicture:
    """The boxes of a plan with their places.

    Raises:
        ValueError: the plan has a cycle.
    """
    order = topological_order(plan)
    if order is None:
        raise ValueError("the plan has a cycle")
    names = set(order)
    cards = {name: card_of(plan.nodes[name]) for name in order}
    successors = {name: [s for s in plan.nodes[name].successors if s in names] for name in order}
    boxes = {name: Box(card.width, card.height, _ports(card)) for name, card in cards.items()}
    return PlanPicture(cards, layered(boxes, successors))


def in_order_of_parameters(plan: Plan, problem: "Problem") -> Plan:
    """The plan with the arguments of every action in the order of its parameters; files have them by their names."""
    order = {name: [each.name for each in action.parameters] for name, action in problem.domain.actions.items()}
    return replace(plan, nodes={name: _ordered(node, order) for name, node in plan.nodes.items()})


def _ordered(node: Node, order: Mapping[str, list[str]]) -> Node:
    names = [name for name in order.get(node.action or "", ()) if name in node.arguments]
    if len(names) < len(node.arguments):
        return node
    return replace(node, arguments={name: node.arguments[name] for name in names})


def card_of(node: Node) -> Card:
    """The card of one node."""
    lines = tuple(_short(line) for line in lines_of(node))
    sizes = (TITLE, *(TEXT for _ in lines[1:]))
    widest = max(len(line) * size * CHARACTER for line, size in zip(lines, sizes, strict=True))
    widths = [len(_short(outcome)) * CHIP * CHARACTER + 2 * CHIP_MARGIN for outcome in node.branches]
    row = sum(widths) + CHIP_GAP * (len(widths) - 1) if widths else 0.0
    width = round(max(widest, row) + 2 * MARGIN, 1)
    chips, x = [], (width - row) / 2.0
    for outcome, wide in zip(node.branches, widths, strict=True):
        chips.append(Chip(_short(outcome), round(x, 1), round(wide, 1)))
        x += wide + CHIP_GAP
    height = len(lines) * LINE + MARGIN + (CHIP_ROW if chips else 0.0)
    return Card(lines, tuple(chips), width, height)


def lines_of(node: Node) -> tuple[str, ...]:
    """The text of a node: what is done, and with what."""
    if node.kind == "branch":
        return ("branch on", node.on or "")
    if node.action is None:
        return (node.kind,)
    values = ", ".join(argument_text(value) for value in node.arguments.values())
    return (node.action, values) if values else (node.action,)


def argument_text(value: str | float | ValueOf) -> str:
    """An argument as text: a name, a number, or `value of combination(vault)`."""
    if isinstance(value, ValueOf):
        return f"value of {value.term}"
    return value if isinstance(value, str) else f"{value:g}"


def _ports(card: Card) -> tuple[float, ...]:
    """Where edges leave, from the middle of the box: at the chips, or in the middle."""
    if not card.chips:
        return (0.0,)
    return tuple(chip.x + chip.width / 2.0 - card.width / 2.0 for chip in card.chips)


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else text[: LONGEST - 1] + "…"
