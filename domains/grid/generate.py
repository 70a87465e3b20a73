"""GRID with sensing: an n by n grid, some cells of its middle column locked, and a key of every shape."""

from collections.abc import Iterator

import kabo

SHAPES = ("circle", "diamond", "square", "triangle")

PROBLEM = """\
problem: grid_n{n}_{shapes}
domain: {home}domain.yaml
objects:
  cell:
{cells}
  shape: [{names}]
  key: [{keys}]
initial:
  - add(Kf, position = c1_1, hand_empty)
{adjacent}
{locks}
{given}
goal:
  - K(position = c{n}_{n})
"""


def problem(n: int, home: str = "", shapes: int = 2) -> str:
    """The text of a problem: the whole middle column is locked, and each lock has one of the shapes.

    The cell of column x and row y is cx_y; the keys lie in the first column, from the far end on.

    Raises:
        kabo.InputError: fewer than three columns, too few rows for the keys, or no such number of shapes.
    """
    if n < 3 or not 1 <= shapes <= min(n, len(SHAPES)):
        message = f"GRID takes 3 columns or more and 1 to {len(SHAPES)} shapes, not {n} and {shapes}"
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, message, "at least as many rows as shapes")])
    cells = [f"c{x}_{y}" for x in range(1, n + 1) for y in range(1, n + 1)]
    names = SHAPES[:shapes]
    return PROBLEM.format(
        n=n,
        home=home,
        shapes=shapes,
        cells="\n".join(f"    - {cell}" for cell in cells),
        names=", ".join(names),
        keys=", ".join(f"key_{shape}" for shape in names),
        adjacent="\n".join(f"  - add(Kf, {', '.join(pairs)})" for pairs in _adjacent(n)),
        locks="\n".join(_locks(n, cells, names)),
        given="\n".join(
            f"  - add(Kf, shape_of(key_{shape}) = {shape}, lies(key_{shape}, c1_{n - k}), not held(key_{shape}))"
            for k, shape in enumerate(names)
        ),
    )


def _locks(n: int, cells: list[str], shapes: tuple[str, ...]) -> Iterator[str]:
    middle = f"c{(n + 1) // 2}_"
    for cell in cells:
        if not cell.startswith(middle):
            yield f"  - add(Kf, open({cell}))"
        else:
            yield f"  - add(Kf, has_lock({cell}), not open({cell}))"
            yield f"  - add(Kx, {', '.join(f'lock({cell}, {shape})' for shape in shapes)})"


def _adjacent(n: int) -> Iterator[list[str]]:
    """What is adjacent to each cell."""
    for x in range(1, n + 1):
        for y in range(1, n + 1):
            around = [(x - 1, y), (x, y - 1), (x, y + 1), (x + 1, y)]
            yield [f"adjacent(c{x}_{y}, c{i}_{j})" for i, j in around if 1 <= i <= n and 1 <= j <= n]
