"""Writes every problem file under domains/ by the rule beside it: `python -m scripts.generate_problems`."""

import importlib.util
from collections.abc import Iterator
from pathlib import Path
from typing import Any

DOMAINS = Path(__file__).resolve().parent.parent / "domains"
SIZES: dict[str, dict[str, dict[str, Any]]] = {
    "asking_bartender": {"n3": {"n": 3}},
    "assembly": {"gearbox": {"n": 1}, "two_gearboxes": {"n": 2}},
    "bartender": {"four_bottles": {"n": 4}},
    "bomb_in_the_toilet": {"n3": {"n": 3}, "n4_two_toilets": {"n": 4, "toilets": 2}},
    "btcs": {"n4": {"n": 4}},
    "circular_rearrange": {f"n{n}": {"n": n} for n in range(2, 7)},
    "canadian_traveller": {"n3": {"n": 3}},
    "coloured_balls": {"n3_1": {"n": 3}, "n4_2": {"n": 4, "balls": 2}},
    "doors": {"n3": {"n": 3}, "n5": {"n": 5}},
    "elogistics": {"n3": {"n": 3}, "n3_wide": {"n": 3, "wide": 1}},
    "force_sensing": {f"n{n}": {"n": n} for n in range(1, 11)},
    "grid": {"n3": {"n": 3}},
    "inspection": {"three_boxes": {"n": 3}, "three_boxes_covered": {"n": 3, "covered": True}},
    "logistics": {"n3": {"n": 3}, "n3_wide": {"n": 3, "wide": 1}},
    "medicate": {"n5": {"n": 5}},
    "painted_doors": {"n3": {"n": 3}},
    "poisonous_liquid": {"n2": {"n": 2}},
    "rovers": {"n4": {"n": 4}},
    "safes": {"n3": {"n": 3}, "n3_with_note": {"n": 3, "note": True}},
    "stacked": {f"n{n}": {"n": n} for n in range(2, 21)},
    "unix": {"n1": {"n": 1}, "n2": {"n": 2}},
    "waiter": {"two_cups": {"n": 2}, "four_cups": {"n": 4}},
    "wumpus": {"n4": {"n": 4}, "n5": {"n": 5}},
}


def problems() -> Iterator[tuple[Path, str]]:
    """Every problem file of the repository and its text."""
    for domain, sizes in SIZES.items():
        specification = importlib.util.spec_from_file_location(domain, DOMAINS / domain / "generate.py")
        assert specification is not None and specification.loader is not None
        rule = importlib.util.module_from_spec(specification)
        specification.loader.exec_module(rule)
        for name, size in sizes.items():
            yield DOMAINS / domain / f"{name}.yaml", rule.problem(**size)


def main() -> None:
    """The command."""
    for path, text in problems():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
