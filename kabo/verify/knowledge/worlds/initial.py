"""The worlds that the initial knowledge allows: known values, and groups of unknowns that entries link."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product

from kabo.language.formulas import Change, ForEach, Formula
from kabo.language.problem import Problem
from kabo.verify.knowledge.facts import Facts, truth
from kabo.verify.knowledge.ground import Binding, Entry, GroundClaim, Symbol, Value, range_of
from kabo.verify.knowledge.updates import Updates, denies_each, fired, rules_of
from kabo.verify.knowledge.worlds.world import CannotJudgeError, Group, Unknowns, World

MAX_CHOICES = 3000  # combinations of values of one group of unknowns
MAX_DECISIONS = 50_000  # values tried in the search for these combinations

Constraint = tuple[str, Entry]  # Kx or Kor, and its members


class NoWorldError(Exception):
    """The initial knowledge contradicts itself."""


@dataclass
class Start:
    """The initial belief: one world with open unknowns, the given values, and what will be known at run time."""

    unknowns: Unknowns
    world: World
    explicit: dict[Symbol, Value]
    whether: frozenset[Symbol]
    whole: frozenset[tuple[GroundClaim, ...]]


@dataclass
class _Reading:
    """The initial effects while they are read: known values, excluded values, and the entries that link unknowns."""

    problem: Problem
    known: dict[Symbol, Value] = field(default_factory=dict)
    excluded: dict[Symbol, frozenset[Value]] = field(default_factory=dict)
    whether: frozenset[Symbol] = frozenset()
    constraints: list[Constraint] = field(default_factory=list)

    @property
    def agent_knowledge(self) -> "_Reading":
        """This state, by which conditions on knowledge are evaluated."""
        return self

    def add(self, updates: Updates) -> None:
        """Adds literals, values and numbers in the order of the file."""
        for each in updates.adds:
            if each.value is None:
                raise CannotJudgeError("the initial knowledge gives a term the value of one that is not known")
            if each.positive:
                self.known[each.symbol] = each.value
                self.excluded.pop(each.symbol, None)
            elif self.known.get(each.symbol) == each.value or each.symbol not in self.known:
                self.known.pop(each.symbol, None)
                self.excluded[each.symbol] = self.excluded.get(each.symbol, frozenset()) | {each.value}
        self.constraints.extend(updates.entries)


def start_of(problem: Problem) -> Start:
    """The initial belief that the problem file describes: one world, whose open values stand for all worlds.

    Raises:
        CannotJudgeError: worlds cannot represent the initial knowledge, or there are too many of them.
        NoWorldError: no world agrees with the initial knowledge.
        NotVerifiableError: the verifier does not judge a part of it.
    """
    reading, later = _Reading(problem), Updates()
    if not all(map(_is_plain, problem.initial)):
        raise CannotJudgeError("the initial knowledge has conditions, or deletes")
    reading.known.update(_single_valued(problem))
    for rule in rules_of(problem.initial, problem, {}, _no_conditions):
        updates = fired([rule], reading)
        reading.add(updates)
        later.run_time += updates.run_time
        later.whole += updates.whole
        later.complete += updates.complete
    unknowns, world = _unknowns(problem, reading)
    denials = [("Kor", denies_each(problem, claims)) for claims in later.complete if _is_open(claims, world)]
    if denials:  # each instance not known to be true has a false part
        reading.constraints.extend(denials)
        unknowns, world = _unknowns(problem, reading)
    whether = frozenset(symbol for symbol in later.run_time if symbol not in world.known)
    return Start(unknowns, world, reading.known, whether, frozenset(later.whole))


def _is_open(claims: Iterable[GroundClaim], world: World) -> bool:
    """Whether it is unknown if all of these claims hold."""
    truths = [truth(claim, world) for claim in claims]
    return None in truths and False not in truths


def _single_valued(problem: Problem) -> Iterator[tuple[Symbol, Value]]:
    """The terms that can have one value only, with this value."""
    for name, function in problem.domain.functions.items():
        values = problem.values_of(name)
        if values is not None and len(values) == 1:
            for arguments in product(*(problem.of_type(kind) for kind in function.arguments)):
                yield (name, arguments), values[0]


def _is_plain(effect: object) -> bool:
    if isinstance(effect, ForEach):
        return all(map(_is_plain, effect.effects))
    return isinstance(effect, Change) and effect.operation == "add"


def _no_conditions(formula: Formula, problem: Problem, binding: Binding) -> Callable[[Facts], bool]:
    raise CannotJudgeError("the initial knowledge has conditions")


def _unknowns(problem: Problem, reading: _Reading) -> tuple[Unknowns, World]:
    """The groups of linked unknowns, and the world with all of them open; values common to all choices are known."""
    linked = [frozenset(claim[0] for claim in entry) for _, entry in reading.constraints]
    symbols = frozenset(reading.excluded).union(*linked) - reading.known.keys()
    groups: list[Group] = []
    known = dict(reading.known)
    excluded: dict[Symbol, frozenset[Value]] = {}
    for members, own in _apart(symbols, reading.constraints):
        choices = tuple(_choices(problem, reading, members, own))
        if not choices:
            raise NoWorldError
        open_ = []
        for position, symbol in enumerate(members):
            values = {choice[position] for choice in choices}
            if len(values) == 1:
                known[symbol] = values.pop()
            else:
                open_.append(position)
                excluded[symbol] = frozenset(range_of(problem, symbol) or ()) - values
        if open_:
            rest = tuple(tuple(choice[position] for position in open_) for choice in choices)
            groups.append(Group(tuple(members[position] for position in open_), rest))
    return Unknowns(problem, tuple(groups)), World(known, excluded, frozenset(range(len(groups))))


def _apart(
    symbols: Iterable[Symbol], constraints: list[Constraint]
) -> Iterator[tuple[list[Symbol], list[Constraint]]]:
    """The symbols in groups that no constraint links, each with its constraints; linked symbols are near each other."""
    of: dict[Symbol, list[Constraint]] = {symbol: [] for symbol in sorted(symbols, key=repr)}
    without: list[Constraint] = []
    for constraint in constraints:
        about = dict.fromkeys(claim[0] for claim in sorted(constraint[1], key=repr))
        for symbol in about:
            if symbol in of:
                of[symbol].append(constraint)
        if not any(symbol in of for symbol in about):
            without.append(constraint)
    if without:
        yield [], without
    left = dict.fromkeys(of)
    while left:
        members = [next(iter(left))]
        own: dict[Constraint, None] = {}
        for symbol in members:
            left.pop(symbol, None)
            for constraint in of[symbol]:
                if constraint not in own:
                    own[constraint] = None
                    near = sorted((claim[0] for claim in constraint[1]), key=repr)
                    members.extend(other for other in dict.fromkeys(near) if other in of and other not in members)
        yield members, list(own)


def _choices(
    problem: Problem, reading: _Reading, members: list[Symbol], constraints: list[Constraint]
) -> Iterator[tuple[Value, ...]]:
    """Every combination of values of the members that the constraints allow, found by backtracking."""
    ranges = []
    for symbol in members:
        values = range_of(problem, symbol)
        if values is None:
            raise CannotJudgeError("the initial knowledge links numbers that are not known")
        without = reading.excluded.get(symbol, ())
        ranges.append([value for value in values if value not in without])
    number = {symbol: position for position, symbol in enumerate(members)}
    due: list[list[Constraint]] = [[] for _ in members]
    for constraint in constraints:
        own = [number[claim[0]] for claim in constraint[1] if claim[0] in number]
        if not own and not _may_hold(constraint, reading.known):
            return
        for position in dict.fromkeys(own):
            due[position].append(constraint)
    values_now = dict(reading.known)
    waiting: list[Iterator[Value]] = [iter(ranges[0])] if members else []
    if not members:
        yield ()
    found = decisions = 0
    while waiting:
        position = len(waiting) - 1
        symbol = members[position]
        values_now.pop(symbol, None)
        value = next(waiting[-1], None)
        if value is None:
            waiting.pop()
            continue
        decisions += 1
        values_now[symbol] = value
        if found > MAX_CHOICES or decisions > MAX_DECISIONS:
            raise CannotJudgeError(
                f"more than {MAX_CHOICES:,} combinations of linked unknowns are possible at the start"
            )
        if not all(_may_hold(constraint, values_now) for constraint in due[position]):
            continue
        if position + 1 < len(members):
            waiting.append(iter(ranges[position + 1]))
            continue
        found += 1
        yield tuple(values_now[each] for each in members)


def _may_hold(constraint: Constraint, values: Mapping[Symbol, Value]) -> bool:
    """Whether an entry can still hold when some of the values are chosen."""
    database, entry = constraint
    holding = open_ = 0
    for symbol, value, positive in entry:
        if symbol not in values:
            open_ += 1
        elif (values[symbol] == value) is positive:
            holding += 1
    return holding + open_ > 0 and (database == "Kor" or holding <= 1)
