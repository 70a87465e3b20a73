"""Whether kabo's knowledge is complete for a task; only then does an exhausted search prove that there is no plan.

kabo's knowledge records what is known of each atom and term, and of some sets of claims that exactly one or at least one
holds; it does not reason by cases. Nothing is lost where the unknown consists of independent sets of claims that unit
propagation decides, and where no action ties such sets together or changes one of them while it is unknown (the "simple"
contingent problems of Bonet and Geffner 2011, after Palacios and Geffner 2009). Whatever breaks this is a *gap*, which
is reported with its place. Gaps are found without search, on an upper bound of all belief states, and only where they
could matter for the goal.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from operator import attrgetter

from kabo.knowledge.closure import Closure
from kabo.knowledge.completeness.beliefs import Beliefs, tangled
from kabo.knowledge.completeness.constructs import Constructs
from kabo.knowledge.entries import Entry
from kabo.knowledge.facts import AtomBits, Claim
from kabo.knowledge.grounding.problem import ground_whole
from kabo.knowledge.grounding.schemas import ActionInstance
from kabo.knowledge.queries import bits_of, split, union
from kabo.language.formulas import Place
from kabo.language.problem import Problem

MAX_TRIED_ATOMS = 7  # atoms tied together by clauses for which every combination of truth values is tried
MAX_NAMED = 4  # atoms that the text of a gap names


@dataclass(frozen=True)
class Gap:
    """A construct or fact that kabo's knowledge cannot represent: its place in the files, and its description."""

    place: Place | None
    text: str

    def __str__(self) -> str:
        where = "" if self.place is None else f"{self.place.file}:{self.place.line}:{self.place.column}: "
        return f"{where}{self.text}"


@dataclass(frozen=True)
class Verdict:
    """What an exhausted search proves.

    With `impossible` the goal is out of reach regardless of the gaps. Otherwise an exhausted search proves that
    there is no plan if `gaps` is empty.
    """

    impossible: bool
    gaps: tuple[Gap, ...]

    @property
    def is_proof(self) -> bool:
        """Whether an exhausted search proves that there is no plan."""
        return self.impossible or not self.gaps


def verdict_of(problem: Problem) -> Verdict:
    """The verdict on an exhausted search: whether it proves that there is no plan, and the gaps that prevent this.

    Raises:
        InputError: the problem uses something that kabo does not support, its initial knowledge contradicts
            itself, or its update rules do not reach a fixpoint.
    """
    whole = ground_whole(problem, by_layers=False)
    beliefs = Beliefs(whole)
    goal = beliefs.condition_of(problem.goal, {}) if problem.domain.worldly else None
    parts = [part.query for part in whole.goal]
    if goal is None:
        impossible = not all(query.possible(beliefs.ones, beliefs.zeros) for query in parts)
    else:
        impossible = not beliefs.possible(goal)
    reads = union(query.reads for query in parts)
    if impossible or not beliefs.unknown:
        return Verdict(impossible, ())
    return Verdict(impossible, tuple(_Gaps(beliefs, reads).found()))


class _Gaps:
    """The gaps of one problem; `relevant` are the groups and `acting` the actions that may matter for its goal."""

    def __init__(self, beliefs: Beliefs, goal: int) -> None:
        self.beliefs, self.whole = beliefs, beliefs.whole
        self.instances = [
            instance for instance in self.whole.instances if beliefs.possible(beliefs.conditions_of(instance))
        ]
        self.relevant = beliefs.names(goal)
        self.acting: list[ActionInstance] = []
        for rule in self.whole.rules:
            self.relevant |= beliefs.names(rule.condition.reads | rule.make | rule.clear)
        for monitor in self.whole.closure.monitors:
            self.relevant |= beliefs.names(monitor.condition.reads)
        self._spread()
        self.open = beliefs.unknown & self.relevant
        self.constructs = Constructs(beliefs.compiler, self.open)

    def found(self) -> list[Gap]:
        """The gaps in the order of the files, one for each place."""
        gaps: dict[Place | None, Gap] = {}
        for gap in self._all() if self.open else ():
            gaps.setdefault(gap.place, gap)
        order = attrgetter("file", "line", "column")
        return sorted(gaps.values(), key=lambda gap: order(gap.place) if gap.place else ("", 0, 0))

    def _all(self) -> Iterator[Gap]:
        for instance in self.acting:
            yield from self._worlds(instance)
            yield from self._changes(instance)
            yield from self._choices(instance)
        yield from self._goal_choices()
        yield from self._clauses()
        yield from self._rules()
        for construct in self.constructs.of({instance.name for instance in self.acting}):
            yield Gap(construct.place, construct.text)

    # ---------------------------------------------------------------------------------------------- what matters
    def _spread(self) -> None:
        """Collects the relevant groups: those that the goal or a relevant action reads, and those linked to them."""
        waiting, size = list(self.instances), -1
        while size != (size := len(self.acting) + self.relevant.bit_count()):
            self.relevant = self.beliefs.links.closed(self.relevant)
            still: list[ActionInstance] = []
            for instance in waiting:
                (self.acting if self._matters(instance) else still).append(instance)
            waiting = still
            for instance in self.acting:
                self.relevant |= self._read_groups(instance)

    def _matters(self, instance: ActionInstance) -> bool:
        return instance.call is not None or bool(self._brought_about(instance) & self.relevant)

    def _brought_about(self, instance: ActionInstance) -> int:
        beliefs, found = self.beliefs, 0
        for update in instance.plain:
            if not update.static and update.condition.possible(beliefs.ones, beliefs.zeros):
                found |= beliefs.names(update.touch | update.writes)
                found |= update.assignment.bits.whether if update.assignment else 0
                found |= update.entry.whether if update.entry else 0
                entries = (e for e in self.whole.closure.propagators if isinstance(e, Entry))
                found |= union(m.group.whether for e in entries if e.active & update.make for m in e.members)
        for group, _, _ in self._outcomes(instance):
            found |= group
        return found

    def _read_groups(self, instance: ActionInstance) -> int:
        """The groups that decide whether the action is applicable and which relevant effects it has."""
        beliefs = self.beliefs
        names = beliefs.names(beliefs.conditions_of(instance).reads)
        contested = self.whole.actions[self._number[id(instance)]].effects.contested
        for update in instance.plain:
            written = beliefs.names(update.touch | update.writes)
            if contested or written & self.relevant or update.assignment or update.entry:
                names |= beliefs.names(update.reads)
        for group, causes, reads in self._outcomes(instance):
            if contested or (group | causes) & self.relevant:
                names |= group | reads
        return names

    @cached_property
    def _number(self) -> dict[int, int]:
        return {id(instance): number for number, instance in enumerate(self.whole.instances)}

    def _outcomes(self, instance: ActionInstance) -> Iterator[tuple[int, int, int]]:
        """For each outcome of a world effect: its group, the groups that may be unknown in its condition, all it reads."""
        for world in instance.worlds:
            causes = self.beliefs.causes(world, instance)
            if causes is None:
                continue
            reads = self.beliefs.names(world.condition.reads) | self.beliefs.claimed(world)
            for outcome in world.effect.outcomes:
                made = self.beliefs.outcome(world, outcome)
                if made is not None:
                    yield (made.group if isinstance(made, Claim) else made).whether, causes, reads

    # --------------------------------------------------------------------------------------------------- effects
    def _worlds(self, instance: ActionInstance) -> Iterator[Gap]:
        """Gaps by conditional effects whose condition may be unknown."""
        for world in instance.worlds:
            causes = (self.beliefs.causes(world, instance) or 0) & self.open
            if causes:
                what = f'what `when` does in action "{instance.name}" depends on what may be unknown'
                yield Gap(world.effect.place, f"{what}: {self._named(causes)}")

    def _changes(self, instance: ActionInstance) -> Iterator[Gap]:
        """Gaps by changes of groups that are known only through entries, and by entries that an action adds."""
        certain = union(self.beliefs.names(u.touch) for u in instance.plain if u.is_certain)
        for name in bits_of(self._touched(instance, self._broken)):
            if not self._is_lossless(name, certain):
                action = f'action "{instance.name}" may change {self._named(name)} while it is unknown'
                place = self.constructs.change(instance.name, name)
                yield Gap(place, f"{action}, and tied to others by what is known of several together")
        for update in instance.plain:
            for entry in self._added(update.make):
                members = union(member.group.whether for member in entry.members)
                if members & self.open:
                    action = f'action "{instance.name}" adds knowledge of several together'
                    place = self.constructs.change(instance.name, members, together=True)
                    yield Gap(place, f"{action}: {self._named(members)}")

    def _touched(self, instance: ActionInstance, broken: set[Entry]) -> int:
        """The groups that the action may change while they are unknown.

        Where a precondition requires that a member of a Kx entry is known to hold, all its members are known, unless the
        entry is in `broken`.
        """
        beliefs, found = self.beliefs, 0
        condition = beliefs.conditions_of(instance).plain
        touched = [(beliefs.names(u.touch), u.condition) for u in instance.plain if u.is_possible]
        touched += [(group, condition) for group, _, _ in self._outcomes(instance)]
        for names, under in touched:
            holds = split(condition)[1] | split(under)[1]
            unknown = beliefs.unknown_under(names & self.open, condition, under)
            for entry, members in beliefs.entries.items() if unknown else ():
                if entry.exactly and entry not in broken and any(member.holds & holds for member in members):
                    unknown &= ~union(member.group.whether for member in members)
            found |= unknown
        return found

    @cached_property
    def _broken(self) -> set[Entry]:
        """The entries that are lost because an action may change a member of them while it is unknown."""
        broken: set[Entry] = set()
        while True:
            touched = union(self._touched(instance, broken) for instance in self.acting)
            found = {
                entry
                for entry, members in self.beliefs.entries.items()
                if any(member.group.whether & touched for member in members)
            }
            if found <= broken:
                return broken
            broken |= found

    def _added(self, made: int) -> Iterator[Entry]:
        for entry in self.whole.closure.propagators:
            if isinstance(entry, Entry) and entry.active & made:
                yield entry

    def _is_lossless(self, name: int, certain: int) -> bool:
        """Whether nothing is lost about the linked groups when this group changes; `certain` are groups that change, too.

        Nothing is lost, either, where nothing can ever be learned about any of them.
        """
        if not self.beliefs.links.closed(name) & self.beliefs.learnt:
            return True
        about = [
            (entry, members)
            for entry, members in self.beliefs.entries.items()
            if any(member.group.whether == name for member in members)
        ]
        if not about:
            return True
        entry, members = about[0]
        others = union(member.group.whether for member in members) & ~(name | certain)
        return len(about) == 1 and (not entry.exactly or others.bit_count() <= 1)

    # ----------------------------------------------------------------------------------------------- disjunctions
    def _choices(self, instance: ActionInstance) -> Iterator[Gap]:
        if self.beliefs.conditions_of(instance).choices:
            where = f'the precondition of action "{instance.name}"'
            yield from self._tied(self.constructs.choices(instance), where)

    def _goal_choices(self) -> Iterator[Gap]:
        yield from self._tied(self.constructs.goal_choices(), "the goal")

    def _tied(self, choices: Iterable[tuple[Place | None, Sequence[int]]], where: str) -> Iterator[Gap]:
        """Gaps by disjunctions with dependent parts: the disjunction may be known to hold while none of its parts is."""
        for place, parts in choices:
            seen = 0
            for reads in parts:
                names = self.beliefs.names(reads) & self.beliefs.unknown
                tied = self.beliefs.links.closed(names)
                if seen & tied:
                    every = union(self.beliefs.names(each) for each in parts) & self.beliefs.unknown
                    yield Gap(place, f"{where} asks for one of several that may be unknown: {self._named(every)}")
                    break
                seen |= tied

    # ---------------------------------------------------------------------------------------------------- clauses
    def _clauses(self) -> Iterator[Gap]:
        """Gaps by entries with consequences that unit propagation does not find."""
        entries = {e: m for e, m in self.beliefs.entries.items() if any(x.group.whether & self.open for x in m)}
        left = tangled(entries.values())
        while left:
            some = _connected(left & -left, entries.values())
            left &= ~some
            members = {e: m for e, m in entries.items() if any(x.group.whether & some for x in m)}
            if not _propagates(members):
                place = self.constructs.together(some)
                yield Gap(place, f"what is known of several together overlaps: {self._named(some)}")

    def _rules(self) -> Iterator[Gap]:
        for rule in self.whole.rules:
            names = self.beliefs.names(rule.condition.reads) & self.open
            if names:
                yield Gap(rule.place, f"an update rule depends on what may be unknown: {self._named(names)}")

    def _named(self, names: int) -> str:
        texts = self.beliefs.texts(names)
        more = f" and {len(texts) - MAX_NAMED} more" if len(texts) > MAX_NAMED else ""
        return ", ".join(texts[:MAX_NAMED]) + more


def _connected(name: int, entries: Iterable[tuple[Claim, ...]]) -> int:
    found, before = name, 0
    while found != before:
        before = found
        for members in entries:
            groups = union(member.group.whether for member in members)
            found |= groups if groups & found else 0
    return found


def _propagates(entries: dict[Entry, tuple[Claim, ...]]) -> bool:
    """Whether unit propagation finds every consequence, whatever becomes known; tried out if the atoms are few."""
    groups = list(
        {member.group.whether: member.group for members in entries.values() for member in members}.values()
    )
    atoms = [group for group in groups if isinstance(group, AtomBits)]
    if len(atoms) > MAX_TRIED_ATOMS or len(atoms) < len(groups):
        return False
    closure = Closure([Entry(entry.exactly, members) for entry, members in entries.items()])
    worlds = []
    for values in product((False, True), repeat=len(atoms)):
        state = union(atom.claim(value).makes for atom, value in zip(atoms, values, strict=True))
        if all(_holds(entry, members, state) for entry, members in entries.items()):
            worlds.append(state)
    for known in product((None, False, True), repeat=len(atoms)):
        state = union(a.claim(v).makes for a, v in zip(atoms, known, strict=True) if v is not None)
        possible = [world for world in worlds if not state & ~world]
        follows = closure.complete(state, -1)
        if (follows is None) != (not possible):
            return False
        if follows is not None and any(_common(possible) & ~follows & atom.mask for atom in atoms):
            return False
    return True


def _common(worlds: Sequence[int]) -> int:
    found = -1
    for world in worlds:
        found &= world
    return found


def _holds(entry: Entry, members: tuple[Claim, ...], world: int) -> bool:
    true = sum(1 for member in members if world & member.holds)
    return true == 1 if entry.exactly else true > 0
