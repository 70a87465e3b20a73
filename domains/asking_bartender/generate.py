"""A BARTENDER THAT ASKS: n guests, each of whom orders one of some drinks."""

import kabo

PROBLEM = """\
problem: asking_bartender_n{n}
domain: {home}domain.yaml
objects:
  guest: [{guests}]
  drink: [{drinks}]
initial:
  - >
    forall(guest g) add(Kf, seeks_attention(g), not greeted(g), not confirmed(g), not served(g),
                        not wished_well(g))
goal:
  - forall(guest g) (K(served(g)) and K(wished_well(g)) and Kv(in_hand_of(g)))
"""


def problem(n: int, home: str = "", drinks: int = 4) -> str:
    """The text of a problem with n guests.

    Raises:
        kabo.InputError: no guest, or no drink.
    """
    if n < 1 or drinks < 1:
        message = f"A BARTENDER THAT ASKS takes 1 guest and 1 drink or more, not {n} and {drinks}"
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, message, None)])
    return PROBLEM.format(
        n=n,
        home=home,
        guests=", ".join(f"guest_{k}" for k in range(1, n + 1)),
        drinks=", ".join(f"drink_{k}" for k in range(1, drinks + 1)),
    )
