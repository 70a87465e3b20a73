"""MEDICATE (medpks-n): a patient with one of n illnesses, or none."""

import kabo

PROBLEM = """\
problem: medicate_n{n}
domain: {home}domain.yaml
objects:
  illness: [no_illness, {illnesses}]
  colour: [no_colour, {colours}]
initial:
  - add(Kf, not dead, not sample_stained)
  - forall(illness i) add(Kf, not stained(i))
  - add(Kf, shows(no_colour, no_illness), not ill(no_illness))
{shows}
  - add(Kx, healthy, {ill})
goal:
  - K(healthy)
  - K(not dead)
"""


def problem(n: int, home: str = "") -> str:
    """The text of a problem with n illnesses and the colour that each gives to the stain.

    Raises:
        kabo.InputError: no illness.
    """
    if n < 1:
        raise kabo.InputError(
            [kabo.Diagnostic(__file__, 1, 1, f"MEDICATE takes 1 illness or more, not {n}", None)]
        )
    numbers = range(1, n + 1)
    return PROBLEM.format(
        n=n,
        home=home,
        illnesses=", ".join(f"illness_{k}" for k in numbers),
        colours=", ".join(f"colour_{k}" for k in numbers),
        shows="\n".join(f"  - add(Kf, shows(colour_{k}, illness_{k}))" for k in numbers),
        ill=", ".join(f"ill(illness_{k})" for k in numbers),
    )
