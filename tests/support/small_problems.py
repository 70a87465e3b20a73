"""Small problems for tests of the knowledge planner: built in Python, or drawn at random by hypothesis."""

from pathlib import Path

from hypothesis import strategies as st

from kabo.language import formulas as f
from kabo.language.problem import Action, Domain, Function, Parameter, Problem

# ------------------------------------------------------------------------------------------------ short spellings
X, Y = f.Constant("x"), f.Constant("y")


def atom(name, *arguments):
    return f.Atom(name, tuple(f.Constant(a) if isinstance(a, str) else a for a in arguments))


def lit(name, *arguments, positive=True):
    return f.Literal(atom(name, *arguments), positive)


def no(name, *arguments):
    return lit(name, *arguments, positive=False)


def app(name, *arguments):
    return f.Application(name, atom("_", *arguments).arguments)


def value(value):
    return (
        value
        if not isinstance(value, str | int | float)
        else (f.Constant(value) if isinstance(value, str) else f.Number(float(value)))
    )


def cmp(left, operator, right):
    return f.Comparison(operator, value(left), value(right))


def know(claim):
    return f.Know(claim)


def add(*facts, to="Kf"):
    return f.Change("add", to, tuple(facts))


def delete(*facts, of="Kf"):
    return f.Change("del", of, tuple(facts))


def when(condition, *updates):
    return f.Conditional(condition, tuple(updates))


def var(name, kind="thing"):
    return f.Variable(name, kind)


def action(name, *, parameters=(), pre=(), effects=(), sense=(), geometry=None):
    declared = tuple(Parameter(parameter.name, parameter.type) for parameter in parameters)
    return Action(name, declared, tuple(pre), geometry, tuple(effects), tuple(sense), f.Number(1.0))


def problem(
    *,
    actions=(),
    initial=(),
    goal=(),
    predicates=None,
    functions=(),
    objects=None,
    update_rules=(),
):
    domain = Domain(
        name="small",
        types={"thing": None},
        constants={},
        predicates={"p": ("thing",), "q": (), "r": (), **(predicates or {})},
        functions={function.name: function for function in functions},
        update_rules=tuple(update_rules),
        actions={a.name: a for a in actions},
    )
    objects = {"x": "thing", "y": "thing"} if objects is None else objects
    path = Path("small.yaml")
    return Problem("small", domain, objects, tuple(initial), tuple(goal), {}, None, path, {})


COLOUR = Function("colour", (), values=("u", "v", "w"))
FUEL = Function("fuel", ())
BELOW = Function("below", ("thing",), value_type="thing")

# ------------------------------------------------------------------------------------------------ random problems
VALUES = st.sampled_from(["u", "v", "w"])


@st.composite
def atoms(draw, names):
    """p of one of the names at hand, or q."""
    name = draw(st.sampled_from([*names, None]))
    return f.Atom("q") if name is None else f.Atom("p", (name,))


@st.composite
def queries(draw, names, depth=2):
    """A formula over p, q and colour."""
    kinds = ["literal"] * 4 + ["whether", "value", "equal", "different"] + ["compound"] * (2 if depth else 0)
    kind = draw(st.sampled_from(kinds))
    if kind == "literal":
        return f.Know(f.Literal(draw(atoms(names)), draw(st.booleans())))
    if kind == "whether":
        return f.KnowWhether(draw(atoms(names)))
    if kind == "value":
        return f.KnowValue(app("colour"))
    if kind in ("equal", "different"):
        return know(cmp(app("colour"), "=" if kind == "equal" else "!=", draw(VALUES)))
    return draw(compounds(names, depth - 1))


@st.composite
def compounds(draw, names, depth):
    kind = draw(st.sampled_from(["not", "and", "or", "xor", "forall", "exists"]))
    if kind in ("forall", "exists"):
        z = f.Variable(f"z{depth}", "thing")
        body = draw(queries([*names, z], depth))
        return (f.Forall if kind == "forall" else f.Exists)((z,), body)
    one = draw(queries(names, depth))
    if kind == "not":
        return f.Not(one)
    two = draw(queries(names, depth))
    return f.Xor(one, two) if kind == "xor" else (f.And if kind == "and" else f.Or)((one, two))


@st.composite
def changes(draw, names):
    """An update of Kf, Kw or Kv."""
    kind = draw(
        st.sampled_from(["add"] * 4 + ["del", "del", "add value", "del value", "add Kw", "add Kv", "del Kw"])
    )
    if kind in ("add", "del"):
        return f.Change(kind, "Kf", (f.Literal(draw(atoms(names)), draw(st.booleans())),))
    if kind.endswith("value"):
        return f.Change(kind[:3], "Kf", (cmp(app("colour"), "=", draw(VALUES)),))
    if kind == "add Kv":
        return f.Change("add", "Kv", (f.TermFact(app("colour")),))
    return f.Change(kind[:3], "Kw", (f.Literal(draw(atoms(names))),))


@st.composite
def effects(draw, names):
    """An update, conditional and quantified or not."""
    kind = draw(st.sampled_from(["plain", "plain", "conditional", "forall"]))
    if kind == "plain":
        return draw(changes(names))
    if kind == "conditional":
        return f.Conditional(draw(queries(names, 1)), (draw(changes(names)),))
    z = f.Variable("e", "thing")
    inner = [*names, z]
    body = draw(changes(inner))
    conditional = draw(st.booleans())
    return f.ForEach((z,), (f.Conditional(draw(queries(inner, 1)), (body,)) if conditional else body,))


@st.composite
def actions(draw, name):
    """An action with at most one parameter; every other one senses."""
    parameters = (f.Variable("a", "thing"),) if draw(st.booleans()) else ()
    names = [X, Y, *parameters]
    pre = draw(st.lists(queries(names, 1), max_size=2))
    if draw(st.booleans()):
        sensed = draw(st.sampled_from([f.Atom("q"), app("colour"), *(f.Atom("p", (n,)) for n in names)]))
        some = draw(st.lists(effects(names), max_size=1))
        return action(name, parameters=parameters, pre=pre, effects=some, sense=[sensed])
    return action(
        name, parameters=parameters, pre=pre, effects=draw(st.lists(effects(names), min_size=1, max_size=3))
    )


def without_opposites(initial):
    """Initial updates without single facts that exclude an earlier one: those are errors."""
    said, kept = {}, []
    for change in initial:
        (fact,) = change.facts
        key = fact.atom if isinstance(fact, f.Literal) else getattr(fact, "left", None)
        if change.database == "Kf" and change.operation == "add":
            if any(_opposite(fact, earlier) for earlier in said.get(key, ())):
                continue
            said.setdefault(key, []).append(fact)
        elif change.database == "Kf":
            said.pop(key, None)
        kept.append(change)
    return kept


def _opposite(one, other):
    if isinstance(one, f.Literal):
        return one.positive != other.positive
    same = one.right == other.right
    return same if one.operator != other.operator else one.operator == "=" and not same


@st.composite
def problems(draw):
    """At most four atoms and four actions."""
    number = draw(st.integers(1, 4))
    initial = draw(st.lists(changes([X, Y]), max_size=3))
    if draw(st.booleans()):
        initial.append(add(cmp(app("colour"), "!=", draw(VALUES))))
    return problem(
        actions=[draw(actions(f"act_{i}")) for i in range(number)],
        initial=without_opposites(initial),
        goal=draw(st.lists(queries([X, Y]), min_size=1, max_size=2)),
        functions=[COLOUR],
    )


LITERALS = [
    lit(*name, positive=sign) for name in (("p", "x"), ("p", "y"), ("q",), ("r",)) for sign in (True, False)
]
SENSED = [atom("p", "x"), atom("q"), app("colour")]


def opposite(literal):
    return f.Literal(literal.atom, not literal.positive)


@st.composite
def branching_problems(draw):
    """Problems that mostly need sensing: something is done one way if a fact holds, and another way if not."""
    literals = st.sampled_from(LITERALS)
    sensed = draw(st.sampled_from(SENSED))
    made, extra = draw(literals), draw(st.lists(literals, max_size=2))
    pre = st.lists(st.one_of(literals.map(know), literals.map(lambda one: f.Not(know(one)))), max_size=1)
    side = draw(st.sampled_from([(), (add(draw(literals)),), (delete(draw(literals)),)]))
    if isinstance(sensed, f.Application):
        ways = [know(cmp(sensed, "=", "u")), know(cmp(sensed, "!=", "u"))]
    else:
        ways = [know(f.Literal(sensed)), know(f.Literal(sensed, False))]
    schemas = [
        action("look", pre=draw(pre), effects=side, sense=[sensed]),
        action("one_way", pre=[ways[0]], effects=[add(made), *map(add, extra)]),
        action(
            "other_way",
            pre=[ways[1], *draw(pre)],
            effects=draw(st.sampled_from([(add(made),), (add(extra[0]),)])) if extra else (add(made),),
        ),
        draw(actions("more")),
        draw(actions("else")),
    ]
    order = draw(st.permutations(schemas))
    initial = [add(literal) for literal in draw(st.lists(literals, max_size=3)) if literal.atom != sensed]
    goal = [know(made), *map(know, extra[:1])]
    if draw(st.booleans()):
        goal = [f.Xor(goal[0], draw(queries([X, Y], 0))), *goal[1:]]
    return problem(actions=order, initial=without_opposites(initial), goal=goal, functions=[COLOUR])


@st.composite
def gambles(draw):
    """Games on a board: steps that are sure, and gambles whose outcome decides where one goes; circles abound.

    Every gamble senses the fact q, which going on forgets: so nodes are met again, and failures hang on ancestors.
    """
    places = [f"n{i}" for i in range(6)]
    at, place = app("at"), st.sampled_from(places)
    forget = delete(lit("q"), no("q"))
    schemas = []
    for number in range(draw(st.integers(5, 9))):
        origin = know(cmp(at, "=", draw(place)))
        if draw(st.booleans()):
            schemas.append(action(f"step_{number}", pre=[origin], effects=[add(cmp(at, "=", draw(place)))]))
            continue
        between = f"g{number}"
        throw = add(cmp(at, "=", between))
        schemas.append(action(f"throw_{number}", pre=[origin], effects=[throw], sense=[atom("q")]))
        for word, outcome in (("lucky", lit("q")), ("unlucky", no("q"))):
            there = [know(cmp(at, "=", between)), know(outcome)]
            go = [add(cmp(at, "=", draw(place))), forget]
            schemas.append(action(f"{word}_{number}", pre=there, effects=go))
    values = (*places, *(f"g{i}" for i in range(9)))
    return problem(
        actions=draw(st.permutations(schemas)),
        functions=[Function("at", (), values=values)],
        initial=[add(cmp(at, "=", "n0"))],
        goal=[know(cmp(at, "=", "n5"))],
    )
