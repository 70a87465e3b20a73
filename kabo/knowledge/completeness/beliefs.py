"""An upper bound of all belief states of a problem: what may be true, and what any reasoner may come to know.

The delete relaxation of `reachability.py` bounds what *kabo* may come to know. The bound computed here concerns an
agent that keeps the set of all possible worlds. So what such an agent cannot know is proven to be out of reach,
even where kabo's own knowledge is incomplete, and `gaps.py` looks for incompleteness only in what is possible for
such an agent.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from kabo.knowledge.binding import Binding
from kabo.knowledge.closure import Rule
from kabo.knowledge.entries import Entry
from kabo.knowledge.facts import AtomBits, Claim, ConjunctionBits, Group, NumberBits, TermBits, open_entries
from kabo.knowledge.grounding.effects import WorldUpdate
from kabo.knowledge.grounding.problem import Grounding, conjuncts
from kabo.knowledge.grounding.schemas import ActionInstance
from kabo.knowledge.progression import Update
from kabo.knowledge.queries import Query, bits_of, conjunction, union
from kabo.language.formulas import And, Comparison, Exists, Forall, Formula, Know, Or
from kabo.language.formulas import Claim as ClaimFormula


@dataclass(frozen=True)
class Condition:
    """A query on knowledge, and disjunctions about the world; a disjunction holds if one of its parts does."""

    plain: Query
    choices: tuple[Query, ...] = ()

    @property
    def reads(self) -> int:
        """All bits on which the condition depends."""
        return self.plain.reads | union(choice.reads for choice in self.choices)


class Beliefs:
    """The bits that can be 1, those that can be 0, the groups that can be unknown, and how these may depend on each other.

    A group is named by its `whether` bit. `links` joins groups where knowing one may reveal something of the other:
    the members of an entry, and the groups that a world effect ties together while its condition is unknown.
    """

    def __init__(self, whole: Grounding) -> None:
        self.whole, self.compiler = whole, whole.compiler
        self.groups = {group.whether: group for group in self.compiler.fluents}
        self._home = {bit: group.whether for group in self.groups.values() for bit in bits_of(group.mask)}
        self._names: dict[int, int] = {}  # answers of `names`, since actions share many updates
        self.ones, self.zeros = whole.initial, ~whole.initial
        self.unknown = union(name for name, group in self.groups.items() if not _is_known(group, whole.initial))
        self.links = Links()
        self.entries: dict[Entry, tuple[Claim, ...]] = {}  # entries that a state may have, with the members left
        self.conditions = [self.condition(instance) for instance in whole.instances]
        self.learnt = 0  # groups about which something may be learned
        self._start()
        self._grow()

    # ------------------------------------------------------------------------------------------------ questions
    def names(self, mask: int) -> int:
        """The groups to which some bits of `mask` belong."""
        found = self._names.get(mask)
        if found is None:
            found = self._names[mask] = union({self._home[bit] for bit in bits_of(mask) if bit in self._home})
        return found

    def texts(self, names: int) -> list[str]:
        """The text of each group, in the order in which the files mention them first."""
        return [self.groups[name].text for name in bits_of(names)]

    def possible(self, condition: Condition) -> bool:
        """Whether the condition can hold in some belief state."""
        return condition.plain.possible(self.ones, self.zeros) and all(
            choice.possible(self.ones, self.zeros) or self.names(choice.reads) & self.unknown
            for choice in condition.choices
        )

    def unknown_under(self, names: int, *queries: Query) -> int:
        """The subset of the groups that may be unknown in a state where all queries hold."""
        found = 0
        for name in bits_of(names & self.unknown):
            mask = self.groups[name].mask
            ones, zeros = self.ones & ~mask, self.zeros | mask
            if all(query.possible(ones, zeros) for query in queries):
                found |= name
        return found

    def condition(self, instance: ActionInstance) -> Condition:
        """The preconditions of a ground action as a `Condition`."""
        domain = self.compiler.problem.domain
        formulas = domain.actions[instance.name].preconditions
        if not domain.worldly or not any(_has_choice(formula) for formula in formulas):
            return Condition(instance.precondition)
        return self.condition_of(formulas, {name: str(value) for name, value in instance.arguments.items()})

    def condition_of(self, formulas: Iterable[Formula], binding: Binding) -> Condition:
        """The conjunction of formulas about the world, as a `Condition`."""
        plain: list[Query] = []
        choices: list[Query] = []
        for formula, bound in conjuncts(self.compiler, tuple(formulas), binding):
            query = self.compiler.query(formula, bound)
            (choices if isinstance(formula, Or | Exists) else plain).append(query)
        return Condition(conjunction(plain), tuple(choices))

    def causes(self, world: WorldUpdate, instance: ActionInstance) -> int | None:
        """The groups in a world effect's condition that may be unknown; None if the effect never happens."""
        if not world.condition.possible(self.ones, self.zeros):
            return None
        known = [self.compiler.query(Know(claim), world.binding) for claim in world.effect.conditions]
        reads = union(self.names(query.reads) for query in known)
        open_ = self.unknown_under(
            reads, instance.precondition if not self._worldly(instance) else world.condition
        )
        for query in known:
            if not self.names(query.reads) & open_ and not query.possible(self.ones, self.zeros):
                return None
        return open_

    def claimed(self, world: WorldUpdate) -> int:
        """The mask of groups (atoms and terms) that occur in the condition of a world effect."""
        claims = (self.compiler.query(Know(claim), world.binding) for claim in world.effect.conditions)
        return union(self.names(query.reads) for query in claims)

    def _worldly(self, instance: ActionInstance) -> bool:
        return bool(self.conditions_of(instance).choices)

    def conditions_of(self, instance: ActionInstance) -> Condition:
        """The condition under which a ground action is applicable."""
        return self._by_instance[id(instance)]

    # ------------------------------------------------------------------------------------------------- fixpoint
    def _start(self) -> None:
        self._by_instance = {id(d): c for d, c in zip(self.whole.instances, self.conditions, strict=True)}
        initial = self.whole.initial
        for propagator in self.whole.closure.propagators:
            if isinstance(propagator, Entry) and (not propagator.active or propagator.active & initial):
                self._bind(propagator, initial)
        for name in bits_of(open_entries(initial, self.compiler.fluents.whether)):
            self._find_out(name)
        self.learnt |= tangled(self.entries.values())

    def _bind(self, entry: Entry, state: int = 0) -> None:
        """Records an entry without the members that are known to be false in the state."""
        members = tuple(member for member in entry.members if not state & member.fails)
        if entry in self.entries or any(state & member.holds for member in members) or _is_range(members, state):
            return
        self.entries[entry] = members
        self.links.join(member.group.whether for member in members)

    def _grow(self) -> None:
        while True:
            before = self.ones, self.zeros, self.unknown, self.learnt, len(self.entries), self.links.joints
            for instance, condition in zip(self.whole.instances, self.conditions, strict=True):
                if self.possible(condition):
                    self._act(instance)
            for rule in self.whole.rules:
                self._follow(rule)
            for monitor in self.whole.closure.monitors:
                self.zeros |= monitor.held
            self._learn()
            if before == (self.ones, self.zeros, self.unknown, self.learnt, len(self.entries), self.links.joints):
                return

    def _follow(self, rule: Rule) -> None:
        open_ = self.names(rule.condition.reads) & self.unknown
        if open_ or rule.condition.possible(self.ones, self.zeros):
            self.ones, self.zeros = self.ones | rule.make, self.zeros | rule.clear
        if open_:
            groups = open_ | self.names(rule.make | rule.clear)
            self.links.join(bits_of(groups))
            self.learnt |= groups

    def _act(self, instance: ActionInstance) -> None:
        for update in instance.plain:
            if not update.static and update.condition.possible(self.ones, self.zeros):
                self._update(update)
        for world in instance.worlds:
            self._happen(world, instance)

    def _update(self, update: Update) -> None:
        self.ones, self.zeros = self.ones | update.make, self.zeros | update.clear
        for name in bits_of(self.names(update.touch & (update.clear | update.make))):
            group = self.groups[name]
            known = _known_bits(group)
            if known & update.clear and not known & update.make:
                self.unknown |= name
                self.links.join([name, *bits_of(self.names(update.condition.reads) & self.unknown)])
        if update.assignment is not None:
            bits, value = update.assignment.bits, update.assignment.value
            self.ones, self.zeros = self.ones | bits.mask, self.zeros | bits.mask
            if value.asks or self.names(value.reads) & self.unknown:
                self.unknown |= bits.whether
                self.links.join([bits.whether, *bits_of(self.names(value.reads) & self.unknown)])
        if update.entry is not None:
            self._find_out(update.entry.whether)
        for entry in self.whole.closure.propagators:
            if isinstance(entry, Entry) and entry.active & update.make:
                self._bind(entry)
                self.learnt |= union(member.group.whether for member in entry.members)

    def _find_out(self, name: int) -> None:
        """Records that the truth or value of a group may become known."""
        group = self.groups[name]
        if isinstance(group, ConjunctionBits):
            self.ones |= name
            self._bind(self.compiler.entry(False, [part.denied for part in group.parts]))
            self.learnt |= union(part.group.whether for part in group.parts)
        self.learnt |= name

    def _happen(self, world: WorldUpdate, instance: ActionInstance) -> None:
        open_ = self.causes(world, instance)
        if open_ is None:
            return
        for outcome in world.effect.outcomes:
            made = self.outcome(world, outcome)
            if isinstance(made, Claim):
                self.ones, self.zeros = self.ones | made.makes, self.zeros | made.group.mask
            elif made is not None:
                self.ones, self.zeros = self.ones | made.mask, self.zeros | made.mask
            if made is not None and open_:
                group = made.group if isinstance(made, Claim) else made
                self.unknown |= group.whether
                self.links.join([group.whether, *bits_of(open_)])

    def outcome(self, world: WorldUpdate, outcome: ClaimFormula) -> Claim | NumberBits | None:
        """The claim that a world effect makes true, or the number that it assigns; None if it can have no effect."""
        if isinstance(outcome, Comparison) and self.compiler.is_number(outcome.left):
            reads = self.names(self.compiler.query(Know(outcome), world.binding).reads)
            group = next((self.groups[name] for name in bits_of(reads)), None)
            return group if isinstance(group, NumberBits) else None
        claim = self.compiler.claim(outcome, world.binding)
        return claim if isinstance(claim, Claim) and claim.group in self.compiler.fluents else None

    def _learn(self) -> None:
        """Records that learning about one group may reveal everything about the groups linked to it."""
        told = self.links.closed(self.learnt)
        self.learnt |= told
        mask = union(self.groups[name].mask for name in bits_of(told & self.unknown))
        self.ones, self.zeros = self.ones | mask, self.zeros | mask


class Links:
    """Groups that may depend on each other, as disjoint sets; a group is named by its `whether` bit."""

    def __init__(self) -> None:
        self.sets: list[int] = []
        self.joints = 0  # how many times two sets were joined

    def join(self, names: Iterable[int]) -> None:
        """Joins the sets of these groups."""
        whole = union(names)
        apart = [each for each in self.sets if not each & whole]
        if len(self.sets) - len(apart) != 1 or any(whole & ~each for each in self.sets if each & whole):
            self.joints += 1
            self.sets = [*apart, whole | union(each for each in self.sets if each & whole)]

    def closed(self, names: int) -> int:
        """The given groups and all groups that may depend on them, as a mask of `whether` bits."""
        return names | union(each for each in self.sets if each & names)


def tangled(entries: Iterable[tuple[Claim, ...]]) -> int:
    """The groups connected with entries that form a cycle, where unit propagation may miss a consequence."""
    links, found, loops = Links(), 0, 0
    for members in entries:
        groups = [member.group.whether for member in members]
        whole = union(groups)
        twice = len(set(groups)) < len(groups)
        if twice or any((each & whole).bit_count() > 1 for each in links.sets):
            loops |= whole
        links.join(groups)
        found |= whole
    return links.closed(loops)


def _is_range(members: tuple[Claim, ...], state: int) -> bool:
    """Whether the members say no more than that a term has one of its possible values."""
    term = members[0].group if members else None
    if not isinstance(term, TermBits) or any(member.group is not term for member in members):
        return False
    left = {equal for value, equal in term.equal.items() if not state & term.unequal.get(value, 0)}
    return left <= {member.holds for member in members}


def _has_choice(formula: Formula) -> bool:
    match formula:
        case Or() | Exists():
            return True
        case And(parts=parts):
            return any(map(_has_choice, parts))
        case Forall(body=body):
            return _has_choice(body)
    return False


def _known_bits(group: Group) -> int:
    return group.settled if isinstance(group, TermBits) else group.known


def _is_known(group: Group, state: int) -> bool:
    if isinstance(group, AtomBits | NumberBits | TermBits):
        return bool(_known_bits(group) & state)
    return False
