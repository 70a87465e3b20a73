"""Writes every problem file under domains/ by the rule beside it: `python -m scripts.generate_problems`."""

import importlib.util
from collections.abc import Iterator
from pathlib import Path

DOMAINS = Path(__file__).resolve().parent.parent / "domains"
SIZES = {
    "bartender": {"four_bottles": 4},
    "force_sensing": {f"n{n}": n for n in range(1, 11)},
    "stacked": {f"n{n}": n for n in range(2, 21)},
}


def problems() -> Iterator[tuple[Path, str]]:
    """Every problem file of the repository and its text."""
    for domain, sizes in SIZES.items():
        specification = importlib.util.spec_from_file_location(domain, DOMAINS / domain / "generate.py")
        assert specification is not None and specification.loader is not None
        rule = importlib.util.module_from_spec(specification)
        specification.loader.exec_module(rule)
        for name, n in sizes.items():
            yield DOMAINS / domain / f"{name}.yaml", rule.problem(n)


def main() -> None:
    """The command."""
    for path, text in problems():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
