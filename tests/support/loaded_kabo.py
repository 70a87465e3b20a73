"""Loads, when it is imported, what most commands of kabo need: modules, libraries, and the kernels of a small problem."""

from pathlib import Path
from tempfile import TemporaryDirectory

import kabo
from kabo.cli.main import main

PROBLEM = Path(kabo.__file__).parents[1] / "domains" / "stacked" / "n2.yaml"


def _load() -> None:
    with TemporaryDirectory() as folder:
        plan = str(Path(folder) / "plan.json")
        kabo.solve(kabo.load_problem(PROBLEM), workers=1).plan.save(plan)
        main(["check", str(PROBLEM)])
        main(["verify", str(PROBLEM), plan])
        main(["view", "--no-open", plan, "-o", str(Path(folder) / "plan.html")])


_load()
