"""PAINTED DOORS: n doors, exactly one of them red at the start; in the end all are blue."""

import kabo

PROBLEM = """\
problem: painted_doors_n{n}
domain: {home}domain.yaml
objects:
  door: [{doors}]
initial:
  - forall(door d) add(Kf, not open(d))
  - add(Kx, {red})
goal:
  - exists(door d) (initially(K(colour_of(d) = red)) and K(open(d)))
  - forall(door d) K(colour_of(d) = blue)
  - forall(door d) (initially(K(colour_of(d) = red)) xor K(not open(d)))
"""


def problem(n: int, home: str = "") -> str:
    """The text of a problem with n doors.

    Raises:
        kabo.InputError: fewer than two doors.
    """
    if n < 2:
        raise kabo.InputError(
            [kabo.Diagnostic(__file__, 1, 1, f"PAINTED DOORS takes 2 doors or more, not {n}", None)]
        )
    doors = [f"door_{k}" for k in range(1, n + 1)]
    return PROBLEM.format(
        n=n, home=home, doors=", ".join(doors), red=", ".join(f"colour_of({door}) = red" for door in doors)
    )
