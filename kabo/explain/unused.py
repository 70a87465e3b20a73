"""Useless parts of a problem: actions that never apply, update rules that never fire, facts that are never known."""

from collections.abc import Iterable, Iterator

from kabo.knowledge import GroundAction, Query
from kabo.knowledge.facts import AtomBits, ConjunctionBits, Group
from kabo.knowledge.grounding.effects import compile_effects
from kabo.knowledge.grounding.temporal import PREFIX
from kabo.knowledge.progression import Update
from kabo.knowledge.queries import FALSE, union
from kabo.language.formulas import Effect
from kabo.planner.proofs.mentions import condition_of, rule_name
from kabo.planner.proofs.root_causes import Kind, RootCauses
from kabo.planner.proofs.wording import MissingFact, listed


class Unused:
    """Sentences about the parts of a grounded problem that the delete relaxation cannot reach."""

    def __init__(self, causes: RootCauses) -> None:
        self.causes, self.meanings, self.mentions = causes, causes.meanings, causes.mentions
        self.whole = causes.achievers.whole
        self.ones, self.zeros = causes.achievers.ones, causes.achievers.zeros

    def actions(self) -> list[str]:
        """A sentence for each action schema, or group of similar ground instances, that is never applicable."""
        used = {action.index for action in self.whole.reach.actions}
        instances: dict[str, list[GroundAction]] = {}
        for action in self.whole.actions:
            instances.setdefault(action.name, []).append(action)
        sentences = []
        for name in self.whole.compiler.problem.domain.actions:
            if name in self.mentions.without_instance:
                sentences.append(f"{name} has no instance: {self.mentions.without_instance[name]}.")
                continue
            idle = [action for action in instances[name] if action.index not in used]
            sentences += [self._idle(group, len(instances[name])) for group in self._alike(idle)]
        return sentences

    def rules(self) -> list[str]:
        """A sentence for every update rule that never fires."""
        compiler, sentences = self.whole.compiler, []
        compiler.inferring = True
        for number, effect in enumerate(compiler.problem.domain.update_rules, start=1):
            updates = compile_effects(compiler, [effect], {})
            conditions = [update.condition for update in updates if isinstance(update, Update)]
            if not any(condition.possible(self.ones, self.zeros) for condition in conditions):
                name = rule_name(effect, number)
                sentences.append(f"{name[0].upper()}{name[1:]} never fires: {self._why_not(effect, conditions)}.")
        compiler.inferring = False
        return sentences

    def never_known(self) -> list[str]:
        """A sentence for each symbol with atoms or terms that conditions ask for but that can never be known."""
        goal = union(part.query.reads for part in self.whole.goal)
        asked = goal | union(action.reads for action in self.whole.actions)
        asked |= union(rule.condition.reads for rule in self.whole.rules)
        by_symbol: dict[str, list[Group]] = {}
        for name, _, group in self.whole.compiler.fluents.named(""):
            hidden = isinstance(group, ConjunctionBits) or name.startswith(PREFIX)
            if not hidden and group.mask & asked and not group.mask & self.ones:
                by_symbol.setdefault(name, []).append(group)
        return [*(self._unknown(found, goal) for found in by_symbol.values()), *self._unknown_symbols()]

    # ------------------------------------------------------------------------------------------------ actions
    def _alike(self, idle: Iterable[GroundAction]) -> list[list[GroundAction]]:
        groups: dict[tuple[Kind, ...], list[GroundAction]] = {}
        for action in idle:
            groups.setdefault(self.causes.kind_of_lack(action.precondition), []).append(action)
        return list(groups.values())

    def _idle(self, group: list[GroundAction], number: int) -> str:
        first = group[0]
        why = f"{self.causes.lacking(first.precondition)[0]} can never hold"
        if number == 1:
            return f"{first} can never be done: {why}."
        which = "no instance can ever" if len(group) == number else f"{len(group)} of {number} instances can never"
        said = f"{first.name}: {which} be done; for {first}, {why}"
        return f"{said}." if len(group) == 1 else f"{said}; likewise for {listed(map(str, group[1:]), 'and')}."

    # -------------------------------------------------------------------------------------------------- rules
    def _why_not(self, effect: Effect, conditions: list[Query]) -> str:
        possible = [condition for condition in conditions if condition != FALSE]
        if possible:
            for condition in possible:
                self.causes.kind_of_lack(condition)
            return f"{listed((self.causes.lacking(c)[0] for c in possible), 'and')} can never hold"
        asked = condition_of(effect)
        why = None if asked is None else self.mentions.never(asked)
        return why or "no objects fulfil its condition, and nothing changes that"

    # ---------------------------------------------------------------------------------------------- knowledge
    def _unknown(self, found: list[Group], goal: int) -> str:
        first = found[0]
        meaning = self.meanings.meaning(first.whether)
        known = "known whether" if isinstance(first, AtomBits) else "known"
        achievers = [
            achiever
            for achiever in self.causes.achievers.of(MissingFact(first.whether))
            if achiever.kind != "entry"
        ]
        if achievers:
            why = (
                f"only {listed((achiever.name for achiever in achievers), 'and')} could tell, which never happens"
            )
        else:
            why = self.causes.why_nothing(meaning)
        who = "the goal" if first.mask & goal else self._asker(first)
        names = listed((group.text for group in found), "and")
        about = "" if len(found) == 1 else f" {first.text}:"
        return f"{names} can never be {known}, needed by {who}:{about} {why}."

    def _asker(self, group: Group) -> str:
        names = [str(action) for action in self.whole.actions if action.reads & group.mask]
        return listed(names, "and", 2) if names else "an update rule"

    def _unknown_symbols(self) -> Iterator[str]:
        """Sentences about static symbols that are asked for, although nothing is known of them."""
        compiler = self.whole.compiler
        groups: dict[str, list[Group]] = {}
        for name, _, group in compiler.statics.named(""):
            groups.setdefault(name, []).append(group)
        for name, found in groups.items():
            if not any(group.mask & compiler.static for group in found):
                asked = f"{listed((group.text for group in found), 'and')} {'is' if len(found) == 1 else 'are'} asked for"
                yield f"Nothing is ever known about {name}: {asked}, not given at the start, and never told."
