"""E-LOGISTICS with sensing: n cities with a truck each, one airplane, n packages that may be at several places.

With one office in each city (elog-5, elog-7) package k is at the office of city k or k + 1, and has to go to the
airport of city k + 2; the first `wide` packages may be at any office. With more offices (the huge instance) package
k is anywhere in city k, and has to go to city k + 1, the last one elsewhere in its own.
"""

from collections.abc import Iterator

import kabo

NAME = "elogistics"

PROBLEM = """\
problem: {name}_n{n}_{offices}_{wide}
domain: {home}domain.yaml
objects:
  package: [{packages}]
  city: [{cities}]
  truck: [{trucks}]
  airplane: [plane]
  airport: [{airports}]
  office:
{rooms}
initial:
  - add(Kf, position(plane) = airport_0)
{initial}
goal:
{goal}
"""


def problem(n: int, home: str = "", offices: int = 1, wide: int = 0) -> str:
    """The text of a problem with n cities and packages.

    Raises:
        kabo.InputError: fewer than three cities, no office, or more wide packages than there are.
    """
    if n < 3 or offices < 1 or not 0 <= wide <= n:
        message = (
            f"{NAME.upper()} takes 3 cities, 1 office or more, 0 to n wide packages, not {n}, {offices}, {wide}"
        )
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, message, None)])
    numbers = range(n)
    return PROBLEM.format(
        name=NAME,
        n=n,
        home=home,
        offices=offices,
        wide=wide,
        packages=", ".join(f"package_{k}" for k in numbers),
        cities=", ".join(f"city_{k}" for k in numbers),
        trucks=", ".join(f"truck_{k}" for k in numbers),
        airports=", ".join(f"airport_{k}" for k in numbers),
        rooms="\n".join(f"    - office_{k}_{i}" for k in numbers for i in range(offices)),
        initial="\n".join([*_cities(n, offices), *_packages(n, offices, wide)]),
        goal="\n".join(_goal(n, offices)),
    )


def _cities(n: int, offices: int) -> Iterator[str]:
    for k in range(n):
        places = [f"airport_{k}", *(f"office_{k}_{i}" for i in range(offices))]
        yield f"  - add(Kf, {', '.join(f'city_of({place}) = city_{k}' for place in places)})"
        yield f"  - add(Kf, home(truck_{k}) = city_{k}, position(truck_{k}) = office_{k}_{k % offices})"


def _packages(n: int, offices: int, wide: int) -> Iterator[str]:
    yield "  - forall(package p, vehicle v) add(Kf, not inside(p, v))"
    everywhere = [f"airport_{k}" for k in range(n)] + [f"office_{k}_{i}" for k in range(n) for i in range(offices)]
    for k in range(n):
        if offices > 1:
            here = [f"airport_{k}", *(f"office_{k}_{i}" for i in range(offices))]
        else:
            here = [f"office_{i % n}_0" for i in range(k, k + (n if k < wide else 2))]
        elsewhere = [place for place in everywhere if place not in here]
        yield f"  - add(Kx, {', '.join(f'at(package_{k}, {place})' for place in here)})"
        yield f"  - add(Kf, {', '.join(f'not at(package_{k}, {place})' for place in elsewhere)})"


def _goal(n: int, offices: int) -> Iterator[str]:
    for k in range(n):
        if offices == 1:
            place = f"airport_{(k + 2) % n}"
        elif k == 0:
            place = "airport_1"
        else:
            place = f"office_{min(k + 1, n - 1)}_{k % offices}"
        yield f"  - K(at(package_{k}, {place}))"
