"""WUMPUS (wumpus-n): an n by n grid with one dangerous cell of each pair beside the diagonal."""

from collections.abc import Iterable, Iterator

import kabo

Cell = tuple[int, int]

PROBLEM = """\
problem: wumpus_n{n}
domain: {home}domain.yaml
objects:
  cell:
{cells}
initial:
  - add(Kf, position = c1_1, gold(c{n}_{n}), not treasure)
{adjacent}
{dangers}
goal:
  - K(treasure)
"""


def problem(n: int, home: str = "") -> str:
    """The text of a problem; the cell of column x and row y is cx_y.

    Of the cells (k, k - 1) and (k - 1, k) one is safe, for k from 3 to n; the other holds a wumpus or a pit, or both.

    Raises:
        kabo.InputError: a grid without a dangerous cell.
    """
    if n < 3:
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, f"WUMPUS takes 3 columns or more, not {n}", None)])
    cells = [(x, y) for x in range(1, n + 1) for y in range(1, n + 1)]
    return PROBLEM.format(
        n=n,
        home=home,
        cells="\n".join(f"    - {_name(cell)}" for cell in cells),
        adjacent="\n".join(
            f"  - add(Kf, {', '.join(f'adjacent({_name(cell)}, {_name(other)})' for other in _around(cell, n))})"
            for cell in cells
        ),
        dangers="\n".join(_dangers(cells, n)),
    )


def _dangers(cells: list[Cell], n: int) -> Iterator[str]:
    pairs = [((k, k - 1), (k - 1, k)) for k in range(3, n + 1)]
    suspects = [cell for pair in pairs for cell in pair]
    for cell in cells:
        if cell not in suspects:
            yield _known([f"safe({_name(cell)})", f"not wumpus({_name(cell)})", f"not pit({_name(cell)})"])
    for first, second in pairs:
        yield f"  - add(Kx, safe({_name(first)}), safe({_name(second)}))"
    for cell in suspects:
        yield from _equivalent(f"safe({_name(cell)})", [f"wumpus({_name(cell)})", f"pit({_name(cell)})"], "not ")
    for cell in cells:
        near = [other for other in _around(cell, n) if other in suspects]
        for sign, cause in (("stench", "wumpus"), ("breeze", "pit")):
            if near:
                yield from _equivalent(f"{sign}({_name(cell)})", [f"{cause}({_name(other)})" for other in near])
            else:
                yield _known([f"not {sign}({_name(cell)})"])


def _equivalent(sign: str, causes: list[str], negation: str = "") -> Iterator[str]:
    """`sign` holds (with `negation`: does not hold) exactly when one of the causes does."""
    positive, negative = (f"not {sign}", sign) if negation else (sign, f"not {sign}")
    if len(causes) == 1:
        yield f"  - add(Kx, {negative}, {causes[0]})"
        return
    yield f"  - add(Kor, {negative}, {', '.join(causes)})"
    for cause in causes:
        yield f"  - add(Kor, {positive}, not {cause})"


def _known(facts: Iterable[str]) -> str:
    return f"  - add(Kf, {', '.join(facts)})"


def _around(cell: Cell, n: int) -> list[Cell]:
    x, y = cell
    return [(i, j) for i, j in ((x - 1, y), (x, y - 1), (x, y + 1), (x + 1, y)) if 1 <= i <= n and 1 <= j <= n]


def _name(cell: Cell) -> str:
    return f"c{cell[0]}_{cell[1]}"
