"""The graph of a plan as an SVG picture: the same boxes at the same places as the viewer's page draws."""

import re
from collections.abc import Iterator
from xml.sax.saxutils import escape

from kabo.plan import Node, Plan
from kabo.viewer.content.plan.boxes import (
    CHIP,
    CHIP_ROW,
    FONT,
    LINE,
    MARGIN,
    TEXT,
    TITLE,
    Card,
    plan_picture,
)
from kabo.viewer.content.plan.layers import Place, Route

PAD, HEAD = 16.0, 34.0  # around the graph, and above it for its title [px]
INK, LINE_COLOUR, PAPER = "#20242b", "#7a818b", "#ffffff"
FILLS = {"action": ("#e8f0f8", "#3f7fbf"), "sense": ("#fdf1de", "#d98a1f"), "branch": ("#f0f1f3", "#8c8f94")}
NO_CHARACTER = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # of XML 1.0
GOAL = ("#e6f4e6", "#4fa36b")


def plan_svg(plan: Plan, title: str) -> bytes:
    """The graph of a plan as an SVG file: actions blue, sensing amber, the goal green, outcomes where edges leave.

    Raises:
        ValueError: the plan has a cycle.
    """
    picture = plan_picture(plan)
    wide, high = picture.layout.width + 2 * PAD, picture.layout.height + 2 * PAD + HEAD
    wide = max(wide, 7.6 * len(title) + 2 * PAD)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_n(wide)} {_n(high)}" '
        f'width="{_n(wide)}" height="{_n(high)}" font-family="{escape(FONT)}" font-size="{_n(TEXT)}">',
        f"<title>{escape(title)}</title>",
        f'<rect width="100%" height="100%" fill="{PAPER}"/>',
        f'<text x="{_n(PAD)}" y="22" font-size="{_n(TITLE)}" font-weight="bold" fill="{INK}">{escape(title)}</text>',
        f'<g transform="translate({_n((wide - picture.layout.width) / 2.0)} {_n(PAD + HEAD)})">',
        *(_edge(route) for route in picture.layout.routes),
    ]
    for name, card in picture.cards.items():
        lines.extend(_box(name, plan.nodes[name], card, picture.layout.places[name]))
    return NO_CHARACTER.sub("\ufffd", "\n".join([*lines, "</g>", "</svg>", ""])).encode()


def _edge(route: Route) -> str:
    points = " ".join(f"{_n(x)},{_n(y)}" for x, y in route.points)
    return f'<polyline points="{points}" fill="none" stroke="{LINE_COLOUR}" stroke-width="1.2"/>'


def _box(name: str, node: Node, card: Card, place: Place) -> Iterator[str]:
    fill, border = FILLS.get(node.kind, GOAL)
    yield f'<g transform="translate({_n(place.x)} {_n(place.y)})">'
    yield f'<text y="-3" font-size="8.5" fill="{LINE_COLOUR}">{name}</text>'
    yield (
        f'<rect width="{_n(card.width)}" height="{_n(card.height)}" rx="5" fill="{fill}" stroke="{border}" '
        'stroke-width="1.2"/>'
    )
    for number, line in enumerate(card.lines):
        size, weight = (TITLE, ' font-weight="bold"') if number == 0 else (TEXT, "")
        y = MARGIN / 2.0 + LINE * (number + 0.75)
        yield (
            f'<text x="{_n(card.width / 2.0)}" y="{_n(y)}" text-anchor="middle" font-size="{_n(size)}"{weight} '
            f'fill="{INK}">{escape(line)}</text>'
        )
    top = card.height - CHIP_ROW
    for chip in card.chips:
        yield (
            f'<rect x="{_n(chip.x)}" y="{_n(top)}" width="{_n(chip.width)}" height="{_n(CHIP_ROW - 4.0)}" rx="8" '
            f'fill="{PAPER}" stroke="{border}"/>'
        )
        yield (
            f'<text x="{_n(chip.x + chip.width / 2.0)}" y="{_n(top + 11.5)}" text-anchor="middle" '
            f'font-size="{_n(CHIP)}" fill="{INK}">{escape(chip.outcome)}</text>'
        )
    yield "</g>"


def _n(value: float) -> str:
    """A number without needless digits."""
    return f"{round(value, 2):g}" if abs(value) < 1e5 else f"{value:.0f}"
