"""The instances of `knowledge.py`: how each is generated, what it must reach, what its family's published one has.

Bounds of plan sizes are the sizes of the best published or measured plans for the instance of that name; they count
the goal node, as kabo does, so each is one more than in tables that do not. Seconds are grounding and search
together, on one core, without loading the files and without compiling.
"""

import importlib.util
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

DOMAINS = Path(__file__).resolve().parent.parent / "domains"


@dataclass(frozen=True)
class Instance:
    """One problem and its bounds; None where nothing is demanded."""

    name: str
    family: str
    settings: Mapping[str, Any]
    seconds: float | None = None
    nodes: int | None = None
    actions: int | None = None  # the length that is optimal
    options: Mapping[str, Any] = field(default_factory=dict)
    published: tuple[int, int, int] | None = None  # objects, unknown atoms, sensing actions: at least these

    def text(self) -> str:
        """The problem file; it leads to the domain by its absolute path."""
        specification = importlib.util.spec_from_file_location(self.family, DOMAINS / self.family / "generate.py")
        assert specification is not None and specification.loader is not None
        rule = importlib.util.module_from_spec(specification)
        specification.loader.exec_module(rule)
        text: str = rule.problem(**self.settings, home=f"{DOMAINS / self.family}/")
        return text


def _stacked(n: int, seconds: float | None, search: str | None = None, best: bool = True) -> Instance:
    # The problem file asks for breadth-first search.
    options = {"search": "best"} if search is None else {"search": search, "max_expansions": 10**9}
    name = f"stacked-{n}" + (f" {search}" if search else "")
    return Instance(name, "stacked", {"n": n}, seconds, 2 * n if best else None, 2 * n - 1, options)


INSTANCES = (
    _stacked(8, 1.0, "breadth-first"),
    _stacked(9, 6.0, "breadth-first"),
    _stacked(10, 60.0, "breadth-first"),
    _stacked(10, 30.0, "astar"),
    _stacked(12, None, "astar"),
    _stacked(20, 0.3),
    _stacked(30, None),
    _stacked(40, 3.0),
    Instance("force-10", "force_sensing", {"n": 10}, None, 51),
    Instance("force-20", "force_sensing", {"n": 20}, None, 101),
    Instance("force-50", "force_sensing", {"n": 50}, 0.1, 251),
    Instance("bartender-4", "bartender", {"n": 4}, None, 25),
    Instance("bartender-8", "bartender", {"n": 8}, None, 49),
    Instance("bartender-12", "bartender", {"n": 12}, None, 73),
    Instance("bartender-30", "bartender", {"n": 30}, 1.0, 181),
    Instance("unix-1", "unix", {"n": 1}, None, 18, published=(8, 4, 7)),
    Instance("unix-2", "unix", {"n": 2}, None, 49, published=(16, 12, 15)),
    Instance("unix-3", "unix", {"n": 3}, None, 112, published=(32, 28, 31)),
    Instance("unix-4", "unix", {"n": 4}, 0.2, 239, published=(64, 60, 63)),
    Instance("unix-4 anywhere", "unix", {"n": 4, "anywhere": True}, None, 239, published=(64, 60, 63)),
    Instance("ebtcs-10", "btcs", {"n": 10}, None, 21, published=(12, 10, 10)),
    Instance("ebtcs-30", "btcs", {"n": 30}, None, 61, published=(32, 30, 30)),
    Instance("ebtcs-70", "btcs", {"n": 70}, 0.6, 141, published=(72, 70, 70)),
    Instance("doors-5", "doors", {"n": 5}, None, 53, published=(25, 10, 80)),
    Instance("doors-9", "doors", {"n": 9}, None, 209, published=(81, 36, 288)),
    Instance("doors-15", "doors", {"n": 15}, 0.2, 638, published=(225, 105, 840)),
    Instance("wumpus-5", "wumpus", {"n": 5}, None, 96, published=(25, 38, 50)),
    Instance("wumpus-10", "wumpus", {"n": 10}, 0.6, 1599, published=(100, 98, 200)),
    Instance("wumpus-20", "wumpus", {"n": 20}, 60.0, 23857, published=(400, 218, 800)),
    Instance("cballs-4-1", "coloured_balls", {"n": 4, "balls": 1}, None, 78, published=(25, 16, 20)),
    Instance("cballs-4-3", "coloured_balls", {"n": 4, "balls": 3}, 0.2, 895, published=(27, 48, 60)),
    Instance("cballs-10-2", "coloured_balls", {"n": 10, "balls": 2}, 5.0, 2897, published=(110, 200, 208)),
    Instance("ctp-5", "canadian_traveller", {"n": 5}, None, 16, published=(16, 10, 20)),
    Instance("ctp-10", "canadian_traveller", {"n": 10}, None, 31, published=(31, 20, 40)),
    Instance("ctp-20", "canadian_traveller", {"n": 20}, 0.1, 61, published=(61, 40, 80)),
    Instance("medpks-10", "medicate", {"n": 10}, None, 22, published=(22, 11, 11)),
    Instance("medpks-99", "medicate", {"n": 99}, None, 200, published=(200, 100, 100)),
    Instance("medpks-199", "medicate", {"n": 199}, 10.0, 400, published=(400, 200, 200)),
    Instance("clog-7", "logistics", {"n": 3, "wide": 1}, 0.2, 146, published=(16, 7, 27)),
    Instance("clog-huge", "logistics", {"n": 5, "offices": 4}, 60.0, None, published=(41, 25, 150)),
    Instance("elog-5", "elogistics", {"n": 3}, None, 147, published=(16, 6, 27)),
    Instance("elog-7", "elogistics", {"n": 3, "wide": 1}, None, 179, published=(16, 7, 27)),
    Instance("bomb-20", "bomb_in_the_toilet", {"n": 20}, None, 40, 39),
    Instance("bomb-20-4", "bomb_in_the_toilet", {"n": 20, "toilets": 4}, None, 37, 36),
    Instance("safes-10", "safes", {"n": 10}),
    Instance("safes-10 with note", "safes", {"n": 10, "note": True}),
    Instance("poisonous-liquid-4", "poisonous_liquid", {"n": 4}),
    Instance("painted-doors-3", "painted_doors", {"n": 3}),
    Instance("asking-bartender-10", "asking_bartender", {"n": 10}),
    Instance("rovers-8", "rovers", {"n": 8}),
    Instance("grid-5-2", "grid", {"n": 5, "shapes": 2}),
)
