"""UNIX (unix-n): a complete binary tree of directories, n + 1 levels below its root, and a file in the lower n."""

from collections.abc import Iterator

import kabo

MOST = 9  # 2047 directories

PROBLEM = """\
problem: unix_n{n}{suffix}
domain: {home}domain.yaml
objects:
  file: [my_file]
  directory:
    - {directories}
initial:
  - add(Kf, here = d1)
{initial}
goal:
  - K(contains(d1, my_file))
"""


def problem(n: int, home: str = "", anywhere: bool = False) -> str:
    """The text of a problem; d1 is the root, and the children of dk are those numbered 2 k and 2 k + 1.

    Files are moved to a directory above, or with `anywhere` to any other.

    Raises:
        kabo.InputError: no level below that of the children of the root, or too many.
    """
    if not 1 <= n <= MOST:
        message = f"UNIX takes 1 to {MOST} levels below the children of the root, not {n}"
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, message, None)])
    numbers = range(1, 2 ** (n + 2))
    lines = [f"  - add(Kf, child(d{k}, d{2 * k}), child(d{k}, d{2 * k + 1}))" for k in numbers if 2 * k in numbers]
    lines += [f"  - add(Kf, {', '.join(targets)})" for targets in _allowed(numbers, anywhere)]
    lines.append("  - add(Kf, not contains(d1, my_file), not contains(d2, my_file), not contains(d3, my_file))")
    lines.append(f"  - add(Kx, {', '.join(f'contains(d{k}, my_file)' for k in numbers[3:])})")
    return PROBLEM.format(
        n=n,
        suffix="_anywhere" if anywhere else "",
        home=home,
        directories="\n    - ".join(f"d{k}" for k in numbers),
        initial="\n".join(lines),
    )


def _allowed(numbers: range, anywhere: bool) -> Iterator[list[str]]:
    """Where a file in each directory may be moved to."""
    for k in numbers:
        above = [k >> levels for levels in range(1, k.bit_length())]
        targets = [other for other in numbers if other != k] if anywhere else above
        if targets:
            yield [f"allowed(d{k}, d{target})" for target in targets]
