"""DOORS (doors-n): an n by n grid whose even columns are walls with one open door each."""

from collections.abc import Iterator

import kabo

PROBLEM = """\
problem: doors_n{n}
domain: {home}domain.yaml
objects:
  cell:
{cells}
initial:
  - add(Kf, position = c1_{middle})
{adjacent}
{open}
goal:
  - K(position = c{n}_{middle})
"""


def problem(n: int, home: str = "") -> str:
    """The text of a problem; the cell of column x and row y is cx_y.

    Raises:
        kabo.InputError: a grid without a wall.
    """
    if n < 2:
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, f"DOORS takes 2 columns or more, not {n}", None)])
    columns = [[f"c{x}_{y}" for y in range(1, n + 1)] for x in range(1, n + 1)]
    return PROBLEM.format(
        n=n,
        home=home,
        middle=(n + 1) // 2,
        cells="\n".join(f"    - {cell}" for column in columns for cell in column),
        adjacent="\n".join(f"  - add(Kf, {', '.join(pairs)})" for pairs in _adjacent(n)),
        open="\n".join(_open(column, wall=x % 2 == 0) for x, column in enumerate(columns, start=1)),
    )


def _open(column: list[str], wall: bool) -> str:
    return f"  - add({'Kx' if wall else 'Kf'}, {', '.join(f'open({cell})' for cell in column)})"


def _adjacent(n: int) -> Iterator[list[str]]:
    """What is adjacent to each cell."""
    for x in range(1, n + 1):
        for y in range(1, n + 1):
            around = [(x - 1, y), (x, y - 1), (x, y + 1), (x + 1, y)]
            yield [f"adjacent(c{x}_{y}, c{i}_{j})" for i, j in around if 1 <= i <= n and 1 <= j <= n]
