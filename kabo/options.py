"""What a solve can be told: one table of options, the fields of `Options`.

The arguments of the commands, the fields of a request, the keys of a problem file, the header of a plan and the tables in
docs/ are made from it. To add an option: a field here, a line in `SolveOptions` for type checkers, and the place that
uses it.
"""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from math import inf
from types import NoneType
from typing import Any, Final, Literal, TypeAlias, TypedDict, TypeVar, get_args, get_type_hints

Search: TypeAlias = Literal["best", "greedy", "astar", "breadth-first", "depth-first", "iterative-deepening"]
Geometry: TypeAlias = Literal["bounding", "exact", "none"]
GeometryOrder: TypeAlias = Literal["adaptive", "lazy", "eager"]
Quality: TypeAlias = Literal["fast", "good"]

SMALLEST_EPSILON, LARGEST_EPSILON = 1e-6, 0.3  # m: the tolerances that geometric predicates can keep

_Default = TypeVar("_Default")
_Function = TypeVar("_Function", bound=Callable[..., Any])


class SolveOptions(TypedDict, total=False):
    """What somebody says to a solve; None and what is absent is left to the problem, the scene, or the default."""

    search: Search | None
    seed: int | None
    epsilon: float | None
    geometry: Geometry | None
    geometry_order: GeometryOrder
    max_expansions: int | None
    max_samples: int | None
    timeout: float | None
    quality: Quality
    memory: float | None
    certificate: bool


class ExplainOptions(TypedDict, total=False):
    """What somebody says to an explanation about looking for motions: as to a solve, and how many changes are tried."""

    seed: int | None
    epsilon: float | None
    geometry_order: GeometryOrder
    max_samples: int | None
    changes: int


@dataclass(frozen=True)
class Option:
    """One row of the table: what an option means, which values it takes, and where it may be said.

    A request of the service may say all of them. `name`, `kind` (`str`, `int`, `float` or `bool`), `choices` (empty: any
    value of the kind) and `default` follow from the field.
    """

    help: str  # with Markdown's backticks, which the command line leaves out
    at_least: float | None = None
    above: float | None = None
    at_most: float | None = None
    unit: str = ""
    commands: tuple[str, ...] = (
        "solve",
        "request",
    )  # that have it as an argument; none: every command has its own
    problem_key: str | None = None  # of a problem file's `options`, as `budget.samples`
    problem_least: int = 0  # that a problem file may say
    otherwise: str = ""  # in words: what decides if nobody says it, where that is not `default`
    in_header: Literal["always", "if not default", "never"] = (
        "never"  # of the plan, which depends on what stands there
    )
    of_geometry: bool = False  # it means nothing where no geometry is asked
    name: str = ""
    kind: type = str
    choices: tuple[str, ...] = ()
    default: Any = None

    @property
    def null_in_header(self) -> bool:
        """Whether the header of a plan may say null: where no geometry was asked, or of a budget, for no limit."""
        return self.in_header == "always" and (self.of_geometry or (self.problem_key or "").startswith("budget."))


def _option(default: _Default, help: str, **row: Any) -> _Default:
    """A field of `Options`, with its row of the table."""
    made: _Default = field(default=default, metadata={"option": Option(help, **row)})
    return made


EVERYWHERE = ("solve", "request", "explain")


@dataclass(frozen=True)
class Options:
    """The options of one run, all decided; and the table of what can be said."""

    search: Search = _option(
        "best",
        "how to search for a plan; `astar` finds one of least cost",
        commands=EVERYWHERE,
        problem_key="search",
        in_header="always",
    )
    seed: int = _option(
        0,
        "the seed of all random samples",
        at_least=0,
        commands=EVERYWHERE,
        problem_key="seed",
        in_header="always",
    )
    epsilon: float | None = _option(
        None,
        "tolerance of geometric predicates in metres",
        at_least=SMALLEST_EPSILON,
        at_most=LARGEST_EPSILON,
        unit="m",
        commands=EVERYWHERE,
        problem_key="epsilon",
        otherwise="the scene's",
        in_header="always",
        of_geometry=True,
    )
    geometry: Geometry = _option(
        "bounding",
        "how bodies are checked; `bounding`: convex parts that enclose them, motions are proven; `exact`: the original "
        "meshes, motions are proven by their distances; `none`: every procedure succeeds, without a motion",
        problem_key="geometry",
        in_header="always",
    )
    geometry_order: GeometryOrder = _option(
        "adaptive",
        "when procedures are asked; `lazy`: along a finished plan; `eager`: when the search expands the node behind "
        "one; `adaptive`: lazily, until too many are refused",
        in_header="always",
        of_geometry=True,
    )
    max_expansions: int = _option(
        2_000_000,
        "the most search nodes that are expanded",
        at_least=0,
        commands=EVERYWHERE,
        problem_key="budget.expansions",
        problem_least=1,
        in_header="always",
    )
    max_samples: int = _option(
        5_000_000,
        "the most samples that procedures draw",
        at_least=0,
        commands=EVERYWHERE,
        problem_key="budget.samples",
        problem_least=1,
        in_header="always",
    )
    timeout: float = _option(
        600.0,
        "seconds after which the run gives up",
        at_least=0,
        unit="s",
        commands=(),
        problem_key="budget.seconds",
    )
    quality: Quality = _option(
        "fast",
        "`fast`: the motion as it was found; `good`: refined afterwards, shorter, smoother, with both arms at once",
        in_header="if not default",
        of_geometry=True,
    )
    memory: float = _option(
        inf,
        "bytes that the run may hold before it gives up",
        above=0,
        commands=(),
        otherwise="half of what there is",
    )
    certificate: bool = _option(True, "include proofs that motions are collision-free")

    @classmethod
    def of(cls, *said: Mapping[str, Any]) -> "Options":
        """The options as the first says them who says anything of each; the defaults, where nobody does.

        Raises:
            TypeError: there is no option of such a name.
        """
        chosen: dict[str, Any] = {}
        for one in said:
            if unknown := one.keys() - OPTIONS.keys():
                raise TypeError(f"solve() got an unexpected keyword argument {min(unknown)!r}")
            chosen = {name: value for name, value in one.items() if value is not None} | chosen
        return cls(**chosen)

    def written(self) -> dict[str, str | float | int | None]:
        """The options as the plan keeps them: what it depends on."""
        header: dict[str, str | float | int | None] = {}
        for name, option in OPTIONS.items():
            value = None if option.of_geometry and self.geometry == "none" else getattr(self, name)
            if option.in_header == "always" or (
                option.in_header == "if not default" and value not in (None, option.default)
            ):
                header[name] = value
        return header


def _table() -> dict[str, Option]:
    """The rows, by name, with what follows from the fields."""
    hints, rows = get_type_hints(Options), {}
    for each in fields(Options):
        hint = hints[each.name]
        if NoneType in get_args(hint):
            (hint,) = (kind for kind in get_args(hint) if kind is not NoneType)
        choices = get_args(hint)  # of a Literal; none of others
        kind = str if choices else hint
        row: Option = each.metadata["option"]
        rows[each.name] = replace(row, name=each.name, kind=kind, choices=choices, default=each.default)
    return rows


OPTIONS: Final[Mapping[str, Option]] = _table()
SEARCHES: Final[tuple[Search, ...]] = get_args(Search)
GEOMETRIES: Final[tuple[Geometry, ...]] = get_args(Geometry)
GEOMETRY_ORDERS: Final[tuple[GeometryOrder, ...]] = get_args(GeometryOrder)
QUALITIES: Final[tuple[Quality, ...]] = get_args(Quality)


def takes_options(function: _Function) -> _Function:
    """Gives a function that takes `**options` a signature and a docstring in which each of them has its name.

    Type checkers know them from `SolveOptions`; this is for `help` and for editors that look at run time.
    """
    own, hints = inspect.signature(function), get_type_hints(SolveOptions)
    parameters = [each for each in own.parameters.values() if each.kind is not inspect.Parameter.VAR_KEYWORD]
    for name, option in OPTIONS.items():
        default = None if NoneType in get_args(hints[name]) else option.default
        parameters.append(
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=hints[name])
        )
    told = "".join(f"        {name}: {option.help}.\n" for name, option in OPTIONS.items())
    function.__doc__ = f"{function.__doc__ or ''}\n    Options:\n{told}"
    setattr(function, "__signature__", own.replace(parameters=parameters))  # noqa: B010  no attribute that mypy knows
    return function
