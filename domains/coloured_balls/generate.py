"""COLOURED BALLS (cballs-n-k): an n by n grid with a bin in every corner, and k balls of four colours."""

from collections.abc import Iterator

import kabo

COLOURS = ("red", "blue", "green", "purple")

PROBLEM = """\
problem: coloured_balls_n{n}_{balls}
domain: {home}domain.yaml
objects:
  ball: [{names}]
  colour: [{colours}]
  bin: [{bins}]
  cell:
{cells}
initial:
  - add(Kf, position = c{middle}_{middle})
  - forall(ball b) add(Kf, not held(b), not binned(b))
{corners}
{adjacent}
{unknown}
goal:
  - forall(ball b) K(binned(b))
"""


def problem(n: int, home: str = "", balls: int = 1) -> str:
    """The text of a problem; the cell of column x and row y is cx_y, and no ball lies in a corner.

    Raises:
        kabo.InputError: a grid of corners only, or no ball.
    """
    if n < 3 or balls < 1:
        message = f"COLOURED BALLS takes 3 columns and 1 ball or more, not {n} and {balls}"
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, message, None)])
    cells = [f"c{x}_{y}" for x in range(1, n + 1) for y in range(1, n + 1)]
    corners = ["c1_1", f"c1_{n}", f"c{n}_1", f"c{n}_{n}"]
    return PROBLEM.format(
        n=n,
        home=home,
        balls=balls,
        names=", ".join(f"ball_{k}" for k in range(1, balls + 1)),
        colours=", ".join(COLOURS),
        bins=", ".join(f"bin_{k}" for k in range(1, 5)),
        cells="\n".join(f"    - {cell}" for cell in cells),
        middle=(n + 1) // 2,
        corners="\n".join(
            f"  - add(Kf, stands(bin_{k}) = {cell}, takes(bin_{k}) = {colour})"
            for k, (cell, colour) in enumerate(zip(corners, COLOURS, strict=True), start=1)
        ),
        adjacent="\n".join(f"  - add(Kf, {', '.join(pairs)})" for pairs in _adjacent(n)),
        unknown="\n".join(_unknown(balls, cells, corners)),
    )


def _unknown(balls: int, cells: list[str], corners: list[str]) -> Iterator[str]:
    for ball in (f"ball_{k}" for k in range(1, balls + 1)):
        yield f"  - add(Kf, {', '.join(f'not lies({ball}, {cell})' for cell in corners)})"
        yield f"  - add(Kx, {', '.join(f'lies({ball}, {cell})' for cell in cells if cell not in corners)})"
        yield f"  - add(Kx, {', '.join(f'coloured({ball}, {colour})' for colour in COLOURS)})"


def _adjacent(n: int) -> Iterator[list[str]]:
    """What is adjacent to each cell."""
    for x in range(1, n + 1):
        for y in range(1, n + 1):
            around = [(x - 1, y), (x, y - 1), (x, y + 1), (x + 1, y)]
            yield [f"adjacent(c{x}_{y}, c{i}_{j})" for i, j in around if 1 <= i <= n and 1 <= j <= n]
