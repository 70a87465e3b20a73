"""Writes the rooms of kabo into CONTRIBUTING.md and docs/pictures/architecture.svg, from pyproject.toml and docstrings.

    python -m scripts.rooms

The order is that of the import contracts: what stands above imports what stands below, never the other way round. What
a room is for is the first line of its `__init__.py`. Folders of kernels are left out: they belong to their room.
"""

import ast
import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib  # import-linter brings it along

ROOT = Path(__file__).resolve().parent.parent
PAGE, PICTURE = ROOT / "CONTRIBUTING.md", ROOT / "docs" / "pictures" / "architecture.svg"
BEGIN, END = "<!-- rooms: python -m scripts.rooms writes from here -->\n", "<!-- to here -->\n"
TOP = "kabo"
JUDGE = "kabo.verify"

WIDTH, MARGIN, GAP, PAD = 980, 14, 10, 8  # of the picture, in pixels
TITLE, CHIP = 22, 20  # heights of a room's name, and of a row of its sub-rooms
LETTER, BOLD, PLAIN = (
    6.7,
    8.0,
    6.2,
)  # widths of letters: of sub-rooms' names, of rooms' names, of what they are for
INK, LINE, ROOM, JUDGED, INNER = "#1f2933", "#7b8794", "#ffffff", "#fdf1dc", "#eef2f7"


@dataclass(frozen=True)
class Room:
    """A package or module, what it is for, and the rooms in it from top to bottom."""

    name: str  # dotted, below kabo
    purpose: str
    inner: "tuple[Room, ...]"
    is_file: bool

    @property
    def label(self) -> str:
        """The name as a path: `planner/search`, `errors.py`."""
        return self.name.replace(".", "/") + (".py" if self.is_file else "")


def contracts() -> list[dict[str, Any]]:
    """The import contracts of pyproject.toml."""
    found: list[dict[str, Any]] = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"][
        "contracts"
    ]
    return found


def layers(container: str) -> list[list[str]]:
    """The modules of a container from top to bottom; those that share a layer stand in one list."""
    for contract in contracts():
        if contract["type"] == "layers" and container in contract.get("containers", ()):
            return [re.split(r" [|:] ", each.strip("()")) for each in contract["layers"]]
    return []


def purpose(path: Path) -> str:
    """The first line of a module's docstring, without "The … room:"."""
    first = (ast.get_docstring(ast.parse(path.read_text())) or "").split("\n")[0]
    first = re.sub(r"^(The [\w ]+ room|[A-Z]\w+): ", "", first)
    return first[:1].upper() + first[1:]


def room(name: str) -> Room:
    """The room of a dotted name below kabo."""
    path = ROOT / TOP / name.replace(".", "/")
    if not path.is_dir():
        return Room(name, purpose(path.with_suffix(".py")), (), True)
    packages = {each.parent.name for each in path.glob("*/__init__.py")} - {"kernels"}
    order = [each for row in layers(f"{TOP}.{name}") for each in row if each in packages]
    inner = [*order, *sorted(packages - set(order))]
    return Room(name, purpose(path / "__init__.py"), tuple(room(f"{name}.{each}") for each in inner), False)


def house() -> list[list[Room]]:
    """All rooms from top to bottom; those of one layer know nothing of each other."""
    return [[room(each) for each in row if each != "__main__"] for row in layers(TOP) if row != ["__main__"]]


def judged() -> set[str]:
    """The rooms whose code the verifier must not share."""
    (found,) = (each for each in contracts() if each["type"] == "forbidden" and each["source_modules"] == [JUDGE])
    return {each.removeprefix(f"{TOP}.") for each in found["forbidden_modules"]}


def table() -> str:
    """The table of CONTRIBUTING.md, and the contracts beside the layers."""
    lines = ["| room | what it is for |", "|---|---|"]

    def add(each: Room, depth: int) -> None:
        lines.append(f"| {'&emsp;' * depth}`{each.label}` | {each.purpose} |")
        for inner in each.inner:
            add(inner, depth + 1)

    for row in house():
        for each in row:
            add(each, 0)
    rules = [each["name"] for each in contracts() if each["type"] == "forbidden"]
    return "\n".join([*lines, "", "Besides:", "", *(f"- {rule};" for rule in rules[:-1]), f"- {rules[-1]}.", ""])


def flat(inner: tuple[Room, ...]) -> list[Room]:
    """Rooms and the rooms in them, in order."""
    return [found for each in inner for found in (each, *flat(each.inner))]


def rows_of(each: Room, width: float) -> list[list[tuple[str, float]]]:
    """The names of a room's sub-rooms with their widths, as many in a row as there is space."""
    rows: list[list[tuple[str, float]]] = []
    used = width
    for inner in flat(each.inner):
        text = inner.name.partition(".")[2].replace(".", "/")
        wide = len(text) * LETTER + 12
        if used + wide > width - 2 * PAD:
            rows.append([])
            used = 0.0
        rows[-1].append((text, wide))
        used += wide + 6
    return rows


def said(each: Room, width: float) -> str:
    """As much of what a room is for as fits beside its name: all of it, or up to a colon, semicolon or comma."""
    space = (width - 3 * PAD - len(each.label) * BOLD - 10) / PLAIN
    ends = [len(each.purpose), *(found.start() for found in reversed(list(re.finditer("[:;,]", each.purpose))))]
    return next((each.purpose[:end].rstrip(".").replace("`", "") for end in ends if end <= space), "")


def box(each: Room, x: float, y: float, size: tuple[float, float], dark: bool) -> list[str]:
    """The picture of one room."""
    width, height = size
    fill, beside = JUDGED if dark else ROOM, x + PAD + len(each.label) * BOLD + 10
    made = [
        f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="5" fill="{fill}" stroke="{LINE}"/>',
        f'<text x="{x + PAD:g}" y="{y + 16:g}" class="room">{escape(each.label)}</text>',
        f'<text x="{beside:g}" y="{y + 16:g}" class="note">{escape(said(each, width))}</text>',
    ]
    for number, row in enumerate(rows_of(each, width)):
        left, top = x + PAD, y + TITLE + 2 + number * CHIP
        for text, wide in row:
            made.append(f'<rect x="{left:g}" y="{top:g}" width="{wide:g}" height="16" rx="3" fill="{INNER}"/>')
            made.append(f'<text x="{left + 6:g}" y="{top + 12:g}" class="inner">{escape(text)}</text>')
            left += wide + 6
    return made


def picture() -> str:
    """The house as SVG: a band for each layer, every room with the rooms in it."""
    made: list[str] = []
    dark, y = judged(), float(MARGIN)
    for row in house():
        width = (WIDTH - 2 * MARGIN - GAP * (len(row) - 1)) / len(row)
        height = max(TITLE + CHIP * len(rows_of(each, width)) + 4 for each in row)
        for number, each in enumerate(row):
            made += box(each, MARGIN + number * (width + GAP), y, (width, height), each.name in dark)
        y += height + GAP
    made += [
        f'<text x="{MARGIN}" y="{y + 12:g}" class="note">Imports go down: a room may import what stands below it, '
        "never what stands above or beside it.</text>",
        f'<rect x="{MARGIN}" y="{y + 22:g}" width="14" height="12" rx="2" fill="{JUDGED}" stroke="{LINE}"/>',
        f'<text x="{MARGIN + 20}" y="{y + 32:g}" class="note">What verify judges, and therefore never imports.</text>',
    ]
    style = (
        f".room {{ font: 600 13px monospace; fill: {INK} }} .inner {{ font: 11px monospace; fill: {INK} }} "
        f".note {{ font: 12px sans-serif; fill: {INK} }}"
    )
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {y + 44:g}" width="{WIDTH}" height="{y + 44:g}">'
    background = f'<rect width="{WIDTH}" height="{y + 44:g}" fill="#f7f9fb"/>'
    return "\n".join([head, f"<style>{style}</style>", background, *made, "</svg>", ""])


def renewed(text: str) -> str:
    """The text of CONTRIBUTING.md with the rooms as they are."""
    before, _, rest = text.partition(BEGIN)
    return before + BEGIN + table() + END + rest.partition(END)[2]


def main() -> None:
    """Writes page and picture."""
    PAGE.write_text(renewed(PAGE.read_text()))
    PICTURE.write_text(picture())
    print(PAGE.relative_to(ROOT), PICTURE.relative_to(ROOT))


if __name__ == "__main__":
    main()
