"""A slow and obvious judge of plans: sets of whole worlds, one history after the other, without any code of kabo's.

A world is a dictionary: atom or term (name, argument, …) to its value. Every combination of values is written down; the
plan is walked as a tree; K of a claim is looked up in every world that agrees with what was observed. It knows the
language's formulas and the plan's nodes, nothing else, and judges finite problems without update rules and procedures.
"""

from itertools import product

from kabo.language import formulas as f
from kabo.language.problem import Problem
from kabo.plan import Plan, ValueOf

MOST = 600  # worlds; brute force is slow


class Unjudged(Exception):
    """The problem has what this oracle does not know, or too many worlds for it."""


class Refused(Exception):
    """The plan is wrong."""


# --------------------------------------------------------------------------------------------------------- language
def everything(problem: Problem) -> dict:
    """Every atom and term with its values."""
    result = {}
    for name, kinds in problem.domain.predicates.items():
        for arguments in product(*map(problem.of_type, kinds)):
            result[(name, *arguments)] = (False, True)
    for name, function in problem.domain.functions.items():
        for arguments in product(*map(problem.of_type, function.arguments)):
            values = problem.values_of(name)
            if values is None:
                raise Unjudged
            result[(name, *arguments)] = values
    return result


def bindings(problem: Problem, variables, binding: dict):
    for values in product(*(problem.of_type(v.type) for v in variables)):
        yield {**binding, **{v.name: value for v, value in zip(variables, values, strict=True)}}


def key(thing, binding: dict):
    return (
        thing.predicate if isinstance(thing, f.Atom) else thing.function,
        *(plain(a, binding) for a in thing.arguments),
    )


def plain(term, binding: dict):
    value = binding.get(term.name, term.name)
    if isinstance(value, ValueOf):
        raise Unjudged
    return value


def read(text: str):
    name, _, arguments = text.partition("(")
    return (name, *arguments.rstrip(")").split(", ")) if arguments else (name,)


def value(term, world: dict, binding: dict):
    if isinstance(term, f.Application):
        return world[key(term, binding)]
    if not isinstance(term, f.Constant | f.Variable):
        raise Unjudged
    found = binding.get(term.name, term.name)
    return world[read(found.term)] if isinstance(found, ValueOf) else found


def true(claim, world: dict, binding: dict) -> bool:
    if isinstance(claim, f.Literal):
        return world[key(claim.atom, binding)] is claim.positive
    if claim.operator not in ("=", "!="):
        raise Unjudged
    return (value(claim.left, world, binding) == value(claim.right, world, binding)) is (claim.operator == "=")


def facts(fact, problem: Problem, binding: dict):
    """The single claims of a fact, each with its binding, in groups: conjunctions together."""
    if isinstance(fact, f.FactForall | f.ExactlyOne):
        for more in bindings(problem, fact.variables, binding):
            yield from facts(fact.body, problem, more)
    else:
        parts = fact.parts if isinstance(fact, f.FactAll) else (fact,)
        yield [(part, binding) for part in parts]


# ------------------------------------------------------------------------------------------------------------ belief
class Belief:
    """Pairs of worlds, now and at the start; what will be known; which `always` goals were broken."""

    def __init__(self, pairs, whether=frozenset(), whole=frozenset(), broken=frozenset()):
        self.pairs = list(
            {(frozenset(now.items()), frozenset(first.items())): (now, first) for now, first in pairs}.values()
        )
        self.whether, self.whole, self.broken = frozenset(whether), frozenset(whole), frozenset(broken)

    def possible(self, symbol) -> set:
        return {now[symbol] for now, _ in self.pairs}

    def holds(self, formula, problem: Problem, binding: dict, at_start: bool = False) -> bool:
        def ask(part, more=None):
            return self.holds(part, problem, binding if more is None else more, at_start)

        match formula:
            case f.Know(claim):
                return all(true(claim, first if at_start else now, binding) for now, first in self.pairs)
            case f.KnowWhether(thing) | f.KnowValue(thing):
                symbol = key(thing, binding)
                if at_start:
                    same = all(now[symbol] == first[symbol] for now, first in self.pairs)
                    return len({first[symbol] for _, first in self.pairs}) == 1 or (
                        same and symbol in self.whether
                    )
                return symbol in self.whether or len(self.possible(symbol)) == 1
            case f.Truth(answer):
                return answer
            case f.Not(body):
                return not ask(body)
            case f.And(parts):
                return all(map(ask, parts))
            case f.Or(parts):
                return any(map(ask, parts))
            case f.Xor(first, second):
                return ask(first) != ask(second)
            case f.Forall(variables, body):
                return all(ask(body, more) for more in bindings(problem, variables, binding))
            case f.Exists(variables, body):
                return any(ask(body, more) for more in bindings(problem, variables, binding))
            case f.Temporal(kind="initially", body=body):
                return self.holds(body, problem, binding, True)
            case f.Temporal(kind="always"):
                return id(formula) not in self.broken
        raise Unjudged


def always(formula) -> list:
    """Every `always` in a goal."""
    if isinstance(formula, f.Temporal):
        return [formula] if formula.kind == "always" else []
    if isinstance(formula, f.Forall | f.Exists) and always(formula.body):
        raise Unjudged
    inner = getattr(formula, "parts", None) or [
        getattr(formula, name) for name in ("body", "first", "second") if hasattr(formula, name)
    ]
    return [one for part in inner for one in always(part)]


# ------------------------------------------------------------------------------------------------------------- start
def start(problem: Problem) -> Belief:
    if problem.domain.update_rules:
        raise Unjudged
    ranges, clauses, whether, told, completes = everything(problem), [], set(), {}, []
    for effect in problem.initial:
        if not isinstance(effect, f.Change) or effect.operation != "add":
            raise Unjudged
        groups = [group for fact in effect.facts for group in facts(fact, problem, {})]
        if effect.database == "Kf":
            for group in groups:
                for claim, binding in group:
                    narrow(claim, binding, ranges, everything(problem), told)
        elif effect.database in ("Kx", "Kor"):
            clauses.append((effect.database, [each for group in groups for each in group]))
        elif effect.database == "LCW":
            completes += groups
        elif effect.database in ("Kw", "Kv"):
            for group in groups:
                for thing, binding in group:
                    atom = thing.atom if isinstance(thing, f.Literal) else thing.term
                    whether.add(key(atom, binding))
        else:
            raise Unjudged
    before = [
        w for w in (dict(zip(ranges, v, strict=True)) for v in product(*ranges.values())) if fits(clauses, w)
    ]
    clauses += [("not all", group) for group in completes if not all(agrees("all", group, w) for w in before)]
    pairs = []
    for values in product(*ranges.values()):
        world = dict(zip(ranges, values, strict=True))
        if fits(clauses, world):
            pairs.append((world, world))
    if not pairs:
        raise Refused("no world")
    return Belief(pairs, {s for s in whether if len(ranges[s]) > 1})


def narrow(claim, binding: dict, ranges: dict, before: dict, told: dict) -> None:
    if isinstance(claim, f.Literal):
        symbol = key(claim.atom, binding)
        ranges[symbol], told[symbol] = (claim.positive,), claim.positive
        return
    symbol, other = key(claim.left, binding), plain(claim.right, binding)
    if claim.operator == "=":
        ranges[symbol], told[symbol] = (other,), other
    elif ranges[symbol] == (other,) and told.get(symbol) == other:
        del told[symbol]
        ranges[symbol] = tuple(v for v in before[symbol] if v != other)
    else:
        ranges[symbol] = tuple(v for v in ranges[symbol] if v != other)


def fits(clauses, world: dict) -> bool:
    return all(agrees(kind, claims, world) for kind, claims in clauses)


def agrees(kind: str, claims, world: dict) -> bool:
    holding = [true(claim, world, binding) for claim, binding in claims]
    return {"Kx": sum(holding) == 1, "Kor": any(holding), "all": all(holding), "not all": not all(holding)}[kind]


# ----------------------------------------------------------------------------------------------------------- actions
def flat(effects, belief: Belief, problem: Problem, binding: dict):
    """The effects that fire, quantifiers and conditions on knowledge resolved."""
    for effect in effects:
        if isinstance(effect, f.ForEach):
            for more in bindings(problem, effect.variables, binding):
                yield from flat(effect.effects, belief, problem, more)
        elif isinstance(effect, f.Conditional):
            if belief.holds(effect.condition, problem, binding):
                yield from flat(effect.updates, belief, problem, binding)
        else:
            yield effect, binding


def acted(problem: Problem, belief: Belief, node) -> tuple[Belief, set]:
    action, binding = problem.domain.actions[node.action], dict(node.arguments)
    for term in node.arguments.values():
        if (
            isinstance(term, ValueOf)
            and read(term.term) not in belief.whether
            and len(belief.possible(read(term.term))) > 1
        ):
            raise Refused("the value of a run-time variable")
    if not all(belief.holds(part, problem, binding) for part in action.preconditions):
        raise Refused("precondition")
    ranges = everything(problem)
    adds, deletions, whens, run_time, gone, whole, entries = [], [], [], set(), set(), set(), []
    for effect, bound in flat(action.effects, belief, problem, binding):
        if isinstance(effect, f.WorldEffect):
            whens.append((effect, bound))
            continue
        groups = [group for fact in effect.facts for group in facts(fact, problem, bound)]
        if effect.database == "Kf":
            (adds if effect.operation == "add" else deletions).extend(each for group in groups for each in group)
        elif effect.database in ("Kw", "Kv"):
            each = [one for group in groups for one in group]
            if len(each) == 1:
                thing = each[0][0].atom if isinstance(each[0][0], f.Literal) else each[0][0].term
                (run_time if effect.operation == "add" else gone).add(key(thing, each[0][1]))
            elif effect.operation == "add" and len(effect.facts) == 1:
                whole.add(tuple((key(c.atom, b), c.positive) for c, b in each))
            else:
                raise Unjudged
        elif effect.database in ("Kx", "Kor") and effect.operation == "add":
            entries.append((effect.database, [each for group in groups for each in group]))
        else:
            raise Unjudged
    run_time |= {key(thing, binding) for thing in action.sense}
    agree(adds, belief)
    pairs, disputed, worlds, changed = [], {}, 0, set()
    for now, first in belief.pairs:
        ones = {}
        for effect, bound in whens:
            if all(true(claim, now, bound) for claim in effect.conditions):
                for outcome in effect.outcomes:
                    symbol, new = written(outcome, now, bound)
                    ones.setdefault(symbol, set()).add(new)
        changed |= set(ones)
        worlds += 1
        for symbol, values in ones.items():
            given = {written(c, now, b)[1] for c, b in adds if target(c, b) == symbol and positive(c)}
            denied = {written(c, now, b)[1] for c, b in adds if target(c, b) == symbol and not positive(c)}
            if len(values | given) > 1 or values & denied:
                disputed[symbol] = disputed.get(symbol, 0) + 1
        options = {symbol: {old} for symbol, old in now.items()}
        for claim, bound in deletions:
            cease(claim, bound, now, options, belief, ranges)
        options |= ones
        for claim, bound in adds:
            symbol, new = written(claim, now, bound)
            if positive(claim):
                options[symbol] = {new}
            elif new in options[symbol]:
                rest = options[symbol] - {new} or belief.possible(symbol) - {new} or set(ranges[symbol]) - {new}
                if not rest:
                    raise Refused("no value left")
                options[symbol] = rest
        for values in product(*options.values()):
            world = dict(zip(options, values, strict=True))
            if fits(entries, world):
                pairs.append((world, first))
        if len(pairs) > MOST:
            raise Unjudged
    if worlds in disputed.values() or not pairs:
        raise Refused("not applicable")
    changed |= {target(c, b) for c, b in adds} | {target(c, b) for c, b in deletions}
    after = Belief(pairs, (), (), belief.broken)
    kept = {s for s in belief.whether if s not in changed}
    for claim, bound in adds:
        right = getattr(claim, "right", None)
        named = bound.get(right.name) if isinstance(right, f.Variable) else None
        source = (
            read(named.term)
            if isinstance(named, ValueOf)
            else key(right, bound)
            if isinstance(right, f.Application)
            else None
        )
        if (
            source is not None
            and positive(claim)
            and len(belief.possible(source)) > 1
            and source in belief.whether
        ):
            kept.add(target(claim, bound))
    new = {s for s in run_time if len(after.possible(s)) > 1}
    after.whether = frozenset((kept - gone) | new)
    after.whole = frozenset({w for w in belief.whole if not any(s in changed for s, _ in w)} | whole)
    return after, run_time | whole | (after.whether - belief.whether)


def positive(claim) -> bool:
    return isinstance(claim, f.Literal) or claim.operator == "="


def target(claim, binding: dict):
    return key(claim.atom if isinstance(claim, f.Literal) else claim.left, binding)


def written(claim, world: dict, binding: dict):
    if isinstance(claim, f.Literal):
        return key(claim.atom, binding), claim.positive
    return key(claim.left, binding), value(claim.right, world, binding)


def agree(adds, belief: Belief) -> None:
    """Additions that somebody who knows the belief sees to contradict each other."""
    values: dict = {}
    for claim, binding in adds:
        new = {written(claim, now, binding)[1] for now, _ in belief.pairs}
        values.setdefault((target(claim, binding), positive(claim)), []).append(new)
    for (symbol, sign), ones in values.items():
        if sign and any(len(one) > 1 or one != ones[0] for one in ones) and len(ones) > 1:
            raise Refused("two effects")
        if not sign and (symbol, True) in values and values[symbol, True][0] in [o for o in ones if len(o) == 1]:
            raise Refused("contradictory effects")


def cease(claim, binding: dict, now: dict, options: dict, belief: Belief, ranges: dict) -> None:
    symbol, old = written(claim, now, binding)
    if positive(claim):
        if now[symbol] == old:
            possible = belief.possible(symbol)
            options[symbol] = options[symbol] | (possible if len(possible) > 1 else set(ranges[symbol]))
    elif now[symbol] != old:
        options[symbol] = options[symbol] | {old}


# -------------------------------------------------------------------------------------------------------------- plans
def accepts(problem: Problem, plan: Plan) -> bool:
    """Whether the plan is right.

    Raises:
        Unjudged: the problem has what this oracle does not know.
    """
    goals = [one for goal in problem.goal for one in always(goal)]

    def watch(belief: Belief) -> Belief:
        belief.broken |= {id(goal) for goal in goals if not belief.holds(goal.body, problem, {})}
        return belief

    try:
        follow(problem, plan, plan.root, watch(start(problem)), watch)
    except Refused:
        return False
    return True


def follow(problem: Problem, plan: Plan, name: str, belief: Belief, watch) -> None:
    node = plan.nodes[name]
    if node.kind == "goal":
        if not all(belief.holds(part, problem, {}) for part in problem.goal):
            raise Refused("goal")
        return
    if node.action is not None:
        belief, delivered = acted(problem, belief, node)
        watch(belief)
        for text in (*([] if node.on is None else [node.on]), *node.delivers):
            if thing(text) not in delivered:
                raise Refused("does not sense")
    if node.on is None:
        follow(problem, plan, node.next, belief, watch)
        return
    named = thing(node.on)
    whole = isinstance(named[0], tuple)
    values = (False, True) if whole else everything(problem)[named]
    if not set(node.branches) <= set(map(spelled, values)) or not may_branch(belief, named, whole):
        raise Refused("branch")
    for one in values:
        pairs = [pair for pair in belief.pairs if outcome(named, pair[0], whole) == one]
        if not pairs:
            continue
        if spelled(one) not in node.branches:
            raise Refused("no branch")
        inside = Belief(pairs, belief.whether - {named}, belief.whole - {named}, belief.broken)
        follow(problem, plan, node.branches[spelled(one)], watch(inside), watch)


def thing(text: str):
    """An atom or term; or a conjunction, as pairs of atom and truth."""
    parts = text.split(" and ")
    if len(parts) == 1 and not text.startswith("not "):
        return read(text)
    return tuple((read(part.removeprefix("not ")), not part.startswith("not ")) for part in parts)


def spelled(value) -> str:
    return str(value).lower() if isinstance(value, bool) else value


def outcome(named, world: dict, whole: bool):
    return all(world[symbol] is sign for symbol, sign in named) if whole else world[named]


def may_branch(belief: Belief, named, whole: bool) -> bool:
    def known(symbol) -> bool:
        return symbol in belief.whether or len(belief.possible(symbol)) == 1

    if not whole:
        return known(named)
    if named in belief.whole or any(belief.possible(symbol) == {not sign} for symbol, sign in named):
        return True
    return all(known(symbol) for symbol, _ in named)
