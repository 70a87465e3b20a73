"""ROVERS: one rover among n places, soil, rock and a view each at one of them, and a lander beside the first."""

from collections.abc import Iterator

import kabo

KINDS = ("soil", "rock")

PROBLEM = """\
problem: rovers_n{n}
domain: {home}domain.yaml
objects:
  rover: [{names}]
  place: [{places}]
  kind: [{kinds}]
  scene: [crater]
initial:
{initial}
goal:
  - forall(kind k) K(sent_analysis(k))
  - K(sent_photograph(crater))
"""


def problem(n: int, home: str = "", rovers: int = 1) -> str:
    """The text of a problem with n places on a ring, at the first two of which the lander is in range.

    Raises:
        kabo.InputError: fewer than three places, or no rover.
    """
    if n < 3 or rovers < 1:
        message = f"ROVERS takes 3 places and 1 rover or more, not {n} and {rovers}"
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, message, None)])
    return PROBLEM.format(
        n=n,
        home=home,
        names=", ".join(f"rover_{k}" for k in range(1, rovers + 1)),
        places=", ".join(f"place_{k}" for k in range(n)),
        kinds=", ".join(KINDS),
        initial="\n".join(_initial(n, rovers)),
    )


def _initial(n: int, rovers: int) -> Iterator[str]:
    for k in range(n):
        here, there = f"place_{k}", f"place_{(k + 1) % n}"
        yield f"  - add(Kf, path({here}, {there}), path({there}, {here}))"
    for k in range(rovers):
        yield f"  - add(Kf, position(rover_{k + 1}) = place_{k % n})"
    yield "  - add(Kf, in_range(place_0), in_range(place_1))"
    yield "  - forall(rover r, kind k) add(Kf, not analysed(r, k))"
    yield "  - forall(rover r, scene s) add(Kf, not photographed(r, s))"
    yield "  - forall(kind k) add(Kf, not sent_analysis(k))"
    for kind in KINDS:
        yield f"  - add(Kx, {', '.join(f'sample({kind}, place_{k})' for k in range(n))})"
    yield f"  - add(Kx, {', '.join(f'visible(crater, place_{k})' for k in range(n))})"
