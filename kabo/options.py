"""The options of a solve: one table, the fields of `Options`.

The arguments of commands, the fields of requests, the keys of problem files, the header of plans and the tables in
docs/ are generated from this table. To add an option, add a field to `Options` and a line to `SolveOptions`, which
type checkers read, and use the option as `run.options.<name>`.
"""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from math import inf
from types import NoneType
from typing import Any, Final, Literal, TypeAlias, TypedDict, TypeVar, get_args, get_type_hints

from kabo.errors import did_you_mean
from kabo.given import refuse, require_choice, require_flag, require_number

Search: TypeAlias = Literal["best", "greedy", "astar", "breadth-first", "depth-first", "iterative-deepening"]
Geometry: TypeAlias = Literal["bounding", "exact", "none"]
GeometryOrder: TypeAlias = Literal["adaptive", "lazy", "eager"]
Quality: TypeAlias = Literal["fast", "good"]

SMALLEST_EPSILON, LARGEST_EPSILON = 1e-6, 0.3  # m: the tolerances that geometric predicates can keep
LARGEST_CLEARANCE = 0.3  # m
MOST_WORKERS = 1000  # processes

_Default = TypeVar("_Default")
_Function = TypeVar("_Function", bound=Callable[..., Any])


class SolveOptions(TypedDict, total=False):
    """Options that a caller gives to a solve; absent ones are taken from problem, scene or defaults."""

    search: Search | None
    seed: int | None
    epsilon: float | None
    clearance: float | None
    geometry: Geometry | None
    geometry_order: GeometryOrder
    max_expansions: int | None
    max_samples: int | None
    timeout: float | None
    quality: Quality
    memory: float | None
    certificate: bool


class ExplainOptions(TypedDict, total=False):
    """Options that a caller gives to an explanation: options for motions, and the number of changes to try."""

    seed: int | None
    epsilon: float | None
    clearance: float | None
    geometry_order: GeometryOrder
    max_samples: int | None
    changes: int


SOLVING = ("solve", "request")
EVERYWHERE = (*SOLVING, "explain")
WITHOUT_PROBLEM = ("motion", "task plan")  # commands that take a scene alone, in which no problem gives options


@dataclass(frozen=True)
class Option:
    """One row of the table: what an option means, which values it takes, and where it can be given.

    A request of the service can give every option. `name`, `kind` (`str`, `int`, `float` or `bool`), `choices` (empty: any
    value of the kind) and `default` follow from the field.
    """

    help: str  # in Markdown; the command line leaves the backticks out
    at_least: float | None = None
    above: float | None = None
    at_most: float | None = None
    unit: str = ""
    commands: tuple[str, ...] = SOLVING  # that have it as an argument; none if every command has one of this name
    problem_key: str | None = None  # where a problem file's `options` give it, as `budget.samples`
    problem_least: int = 0  # the least number that a problem file may give
    otherwise: str = ""  # a description of the default, where that is not a fixed value
    in_header: Literal["always", "if not default", "never"] = "never"  # of plans that depend on it
    of_geometry: bool = False  # without effect where no geometry is asked
    name: str = ""
    kind: type = str
    choices: tuple[str, ...] = ()
    default: Any = None

    @property
    def null_in_header(self) -> bool:
        """Whether the option may be null in a plan file: without geometry, or as a budget without a limit."""
        return self.in_header == "always" and (self.of_geometry or (self.problem_key or "").startswith("budget."))

    def require(self, given: object) -> Any:
        """A value that a caller gives for the option, as an `int` or a `float` if it is a number.

        Raises:
            ArgumentError: it is none that the option takes.
        """
        if self.choices:
            require_choice(self.name, given, self.choices)
        elif self.kind is bool:
            require_flag(self.name, given)
        else:
            least = -inf if self.at_least is None else self.at_least
            most = inf if self.at_most is None else self.at_most
            bounds: dict[str, Any] = {"above": self.above, "unit": self.unit, "whole": self.kind is int}
            return require_number(self.name, given, least, most, **bounds, endless=self.at_most is None)
        return given


def _option(default: _Default, help: str, **row: Any) -> _Default:
    """A field of `Options`, with its row of the table."""
    made: _Default = field(default=default, metadata={"option": Option(help, **row)})
    return made


@dataclass(frozen=True)
class Options:
    """The options of one run, each with its final value; the fields of this class are the table of options."""

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
    clearance: float = _option(
        0.0,
        "the distance in metres that bodies keep from each other, unless their contact is permitted; `3mm` is read, too. "
        "What the scene says is `uncertain` is kept besides",
        at_least=0.0,
        at_most=LARGEST_CLEARANCE,
        unit="m",
        commands=(*EVERYWHERE, *WITHOUT_PROBLEM),
        problem_key="clearance",
        in_header="if not default",
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
    def of(cls, *sources: Mapping[str, Any]) -> "Options":
        """The options of a run: each as the first of the sources gives it, otherwise its default.

        Raises:
            ArgumentError: there is no option of such a name, or it takes no such value.
        """
        chosen: dict[str, Any] = {}
        for one in sources:
            if unknown := one.keys() - OPTIONS.keys():
                name = min(unknown)
                refuse(name, f"solve() got an unexpected keyword argument {name!r}", did_you_mean(name, OPTIONS))
            chosen = {name: value for name, value in one.items() if value is not None} | chosen
        return cls(**{name: OPTIONS[name].require(value) for name, value in chosen.items()})

    def written(self) -> dict[str, str | float | int | None]:
        """The options on which the plan depends, in the form in which they are stored in the plan's file."""
        header: dict[str, str | float | int | None] = {}
        for name, option in OPTIONS.items():
            value = None if option.of_geometry and self.geometry == "none" else getattr(self, name)
            if option.in_header == "always" or (
                option.in_header == "if not default" and value not in (None, option.default)
            ):
                header[name] = value
        return header


def _table() -> dict[str, Option]:
    """The rows of the table by name, completed by what follows from their fields."""
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


def require_clearance(clearance: float) -> float:
    """The clearance [m] that a caller gives, if it is one.

    Raises:
        ArgumentError: it is not from 0 to `LARGEST_CLEARANCE`.
    """
    return float(OPTIONS["clearance"].require(clearance))


def require_epsilon(epsilon: float | None) -> None:
    """Checks an epsilon that a caller gives [m]; None is the scene's.

    Raises:
        ArgumentError: it is not from `SMALLEST_EPSILON` to `LARGEST_EPSILON`.
    """
    if epsilon is not None:
        OPTIONS["epsilon"].require(epsilon)


def require_seed(seed: int) -> int:
    """The seed that a caller gives, if it is one.

    Raises:
        ArgumentError: it is no whole number from 0 on.
    """
    return int(OPTIONS["seed"].require(seed))


def require_workers(workers: int) -> int:
    """The number of processes that a caller gives.

    Raises:
        ArgumentError: it is no whole number from 1 to `MOST_WORKERS`.
    """
    return int(require_number("workers", workers, 1, MOST_WORKERS, whole=True))


def takes_options(function: _Function) -> _Function:
    """Gives a function that takes `**options` a signature and a docstring that list each option by its name.

    Type checkers know the options from `SolveOptions`; the signature is for `help` and for editors that inspect
    it.
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
