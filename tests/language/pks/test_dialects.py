"""PKS files: both dialects, their loose markup, and what is refused by name."""

import pytest

from kabo.language.spelling import spell
from tests.language.samples import PKS_TYPED, PKS_UNTYPED
from tests.language.written import effects, initial, preconditions, read, refused, warnings
from tests.support.counted_calls import calls_made

FRAME = """<?xml version="1.0"?>
<pks><domain name="d"><symbols><predicates>{predicates}</predicates><functions>{functions}</functions>
<constants>{constants}</constants></symbols>
<actions><action name="act"><params>{params}</params><preconds>{preconds}</preconds>
<effects>{effects}</effects></action></actions></domain>
<problem name="one" domain="d"><init>{init}</init><goal>{goal}</goal><updates>{updates}</updates></problem></pks>
"""


def pks(**parts: str) -> str:
    """A file with one action, given by its parts."""
    defaults = {
        "predicates": "p/1, q/2, r/0", "functions": "f/1, n/0, m/1", "constants": "a, b", "params": "?x, ?y",
        "preconds": "", "effects": "add(Kf, r)", "init": "add(Kf, n = 1)", "goal": "K(r)", "updates": "",
    }  # fmt: skip
    return FRAME.format(**{**defaults, **parts})


def get(folder, **parts: str):
    """The problem of a file with one action."""
    return read(folder, pks(**parts), ending="xml")


def test_the_untyped_dialect(tmp_path):
    found = read(tmp_path, PKS_UNTYPED, ending="xml")
    assert found.domain.types == {"object": None}
    assert found.domain.predicates["read_note"] == ()
    assert (found.domain.functions["combo"].value_type, found.domain.functions["clicks"].value_type) == (
        "object",
        None,
    )
    assert found.objects == dict.fromkeys(["s1", "n1", "c1", "c2", "c3"], "object")
    assert preconditions(found, "read") == ["K(note(n))", "K(safe(s))", "not Kv(combo(s))"]
    assert effects(found, "dial") == ["K(combo(s) = x) => add(Kf, open(s))", "add(Kf, clicks = clicks + 1)"]
    assert initial(found) == [
        "add(Kf, safe(s1), note(n1), not open(s1), clicks = 0)", "add(Kx, combo(s1) = c1, combo(s1) = c2)",
    ]  # fmt: skip
    assert [spell(each) for each in found.goal] == [
        "K(open(s1))",
        "exists(object z) (K(safe(z)) and K(read_note))",
    ]
    assert [spell(each) for each in found.domain.update_rules] == [
        "forall(object x) (K(open(x)) => add(Kf, safe(x)))"
    ]


def test_the_typed_dialect(tmp_path):
    found = read(tmp_path, PKS_TYPED, ending="xml")
    assert found.domain.types == {"object": None, "bottle": "object", "place": "object", "robot": "object"}
    assert found.domain.predicates == {
        "empty": ("bottle",),
        "on": ("bottle", "place"),
        "holds": ("robot", "bottle"),
    }
    assert found.domain.functions["home"].value_type == "place"
    assert found.domain.functions["weight"].value_type is None
    assert found.objects == {"b1": "bottle", "b2": "bottle", "shelf": "place", "table": "place", "r": "robot"}
    assert effects(found, "grab") == [
        "add(Kf, holds(r_2, b))", "forall(place p) (K(on(b, p)) => del(Kf, on(b, p)), add(Kf, not on(b, p)))",
        "add(Kw, empty(b))",
    ]  # fmt: skip
    assert [spell(each) for each in found.goal] == [
        "forall(bottle b) (not K(empty(b)) or K(holds(r, b))) and not K(empty(b2)) xor Kw(empty(b1))"
    ]


@pytest.mark.parametrize(
    ("query", "expected"),
    [
        ("", []), ("K(p(?x))", ["K(p(x))"]), ("!K(p(?x))", ["not K(p(x))"]), ("K(!p(?x))", ["K(not p(x))"]),
        ("K(r) ^ K(p(?x)) & K(p(?y))", ["K(r)", "K(p(x))", "K(p(y))"]), ("K(r) && K(r())", ["K(r)", "K(r)"]),
        ("K(r); K(p(a))", ["K(r)", "K(p(a))"]), ("K(r) K(p(a))", ["K(r)", "K(p(a))"]),
        ("K(r) | K(p(a)) ^ K(p(b))", ["K(r) or K(p(a)) and K(p(b))"]), ("K(r) or K(p(a))", ["K(r) or K(p(a))"]),
        ("K(r) xor Kw(p(a))", ["K(r) xor Kw(p(a))"]), ("not (K(r) and K(p(a)))", ["not (K(r) and K(p(a)))"]),
        ("Kw(p(?x)) ^ !Kw(!r)", ["Kw(p(x))", "not Kw(r)"]), ("Kv(f(?x)) ^ !Kv(n)", ["Kv(f(x))", "not Kv(n)"]),
        ("K(?x = ?y) ^ !K(?x = a)", ["K(x = y)", "not K(x = a)"]), ("?x != ?y", ["K(x != y)"]),
        ("K(!(?x = ?y))", ["K(x != y)"]), ("K(f(?x) = b) ^ K(f(?x) != ?y)", ["K(f(x) = b)", "K(f(x) != y)"]),
        ("n > 2 ^ K(n <= 1 + 2 * n)", ["K(n > 2)", "K(n <= 1 + 2 * n)"]),
        ("K(n &lt;= 2) ^ n &gt; 1 &amp; n <3", ["K(n <= 2)", "K(n > 1)", "K(n < 3)"]),
        ("K(n - 1 - 1 = -2)", ["K(n - 1 - 1 = -2)"]), ("K(p(?x) ^ !r)", ["K(p(x))", "K(not r)"]),
        ("K(q(f(?x), ?y))", ["K(q(f(x), y))"]), ("K(p(a,))", ["K(p(a))"]),
        ("(existsK(?z) K(q(?x, ?z)) & !K(?z = ?x)) ^ K(r)", ["exists(object z) (K(q(x, z)) and not K(z = x))", "K(r)"]),
        ("(forallK(?z) K(p(?z)) => K(q(?z, ?x)))", ["forall(object z) (not K(p(z)) or K(q(z, x)))"]),
        ("forallK(?z) K(p(?z)) => (K(q(?z, ?x)) ^ K(r))", ["forall(object z) (not K(p(z)) or K(q(z, x)) and K(r))"]),
        ("(existsK(?x, ?a) K(q(?x, ?a)))", ["exists(object x_2, object a_2) K(q(x_2, a_2))"]), ("true", []),
        ("Kv(a) ^ Kv(3)", []), ("<!-- K(p(?x)) -->K(r)", ["K(r)"]), ("<![CDATA[K(r) & n < 3]]>", ["K(r)", "K(n < 3)"]),
    ],
)  # fmt: skip
def test_queries(tmp_path, query, expected):
    assert preconditions(get(tmp_path, preconds=query), "act") == expected


@pytest.mark.parametrize(
    ("effect", "expected"),
    [
        ("", []), ("add(Kf, r)", ["add(Kf, r)"]), ("add(Kf, !r); del(Kf, p(?x));", ["add(Kf, not r)", "del(Kf, p(x))"]),
        ("add(Kf, r) ^ add(Kw, p(?x)) & add(Kv, f(?x))", ["add(Kf, r)", "add(Kw, p(x))", "add(Kv, f(x))"]),
        ("add(Kf, r ^ !p(?x)) del(Kw, r)", ["add(Kf, r, not p(x))", "del(Kw, r)"]),
        ("add(Kf, f(?x) = ?y), add(Kf, f(?y) != a)", ["add(Kf, f(x) = y)", "add(Kf, f(y) != a)"]),
        ("add(Kf, !(f(?y) = a))", ["add(Kf, f(y) != a)"]),
        ("n = n + 2; add(Kf, n = m(?x) * 2)", ["add(Kf, n = n + 2)", "add(Kf, n = m(x) * 2)"]),
        ("K(r) ^ K(p(?x)) => add(Kf, p(?y))^del(Kf, r)", ["K(r) and K(p(x)) => add(Kf, p(y)), del(Kf, r)"]),
        ("(K(r)) => (add(Kf, p(a)); add(Kf, p(b));) add(Kf, r)", ["K(r) => add(Kf, p(a)), add(Kf, p(b))", "add(Kf, r)"]),
        ("K(r) => K(p(?x)) => add(Kf, p(?y))", ["K(r) and K(p(x)) => add(Kf, p(y))"]),
        ("forallK(?z) K(q(?x, ?z)) => (del(Kf, q(?x, ?z)))", ["forall(object z) (K(q(x, z)) => del(Kf, q(x, z)))"]),
        ("(forallK(?z, ?w) add(Kf, !q(?z, ?w))); add(Kf, r)",
         ["forall(object z, object w) add(Kf, not q(z, w))", "add(Kf, r)"]),
        ("K(r) => forallK(?z) (K(p(?z)) => add(Kf, q(?x, ?z))) ",
         ["forall(object z) (K(r) and K(p(z)) => add(Kf, q(x, z)))"]),
        ("add(Kx, p(a) | p(b)) add(Kx, p(a), !p(b))", ["add(Kx, p(a), p(b))", "add(Kx, p(a), not p(b))"]),
        ("add(Kx, existsK(?z) p(?z))", ["add(Kx, exactly_one(object z) p(z))"]),
        ("add(Kw, p(a) ^ r) add(Kw, forallK(?z) p(?z))", ["add(Kw, p(a) and r)", "add(Kw, forall(object z) p(z))"]),
        ("add(LCW, q(?u, ?x) ^ p(?u))", ["add(LCW, forall(object u) (q(u, x) and p(u)))"]),
        ("add(LCW, p(a))", ["add(LCW, p(a))"]),
    ],
)  # fmt: skip
def test_effects(tmp_path, effect, expected):
    assert effects(get(tmp_path, effects=effect), "act") == expected


def test_goals_may_speak_of_the_start_and_of_every_state(tmp_path):
    found = get(tmp_path, goal="K0(r) ^ K*(!p(a)) ^ Kn(p(b))")
    assert [spell(each) for each in found.goal] == ["initially(K(r))", "always(K(not p(a)))", "K(p(b))"]


def test_an_empty_goal_holds_always(tmp_path):
    assert get(tmp_path, goal=" <!-- nothing --> ").goal == ()


def test_order_matters_where_updates_of_the_start_speak_of_the_same(tmp_path):
    found = get(tmp_path, init="add(Kf, r); add(Kf, p(a)); add(Kf, !r); add(Kf, p(b)); del(Kf, r)")
    assert initial(found) == ["add(Kf, r, p(a))", "add(Kf, not r, p(b))", "del(Kf, r)"]


def test_numbers_may_be_names_of_objects(tmp_path):
    found = get(tmp_path, constants="1, 2", preconds="K(p(1)) ^ K(f(2) = 1)", init="add(Kf, n = 1 + 1)")
    assert preconditions(found, "act") == ["K(p(n1))", "K(f(n2) = n1)"]


def test_types_may_be_declared(tmp_path):
    text = pks(predicates="p(thing), r/0", functions="n/0", constants="a : cup", params="?x : cup").replace(
        "<symbols>", "<types>thing, cup : thing</types><symbols>"
    )
    found = read(tmp_path, text, ending="xml")
    assert found.domain.types == {"object": None, "thing": "object", "cup": "thing"}


def test_either_quotes_and_case_of_names(tmp_path):
    text = pks(predicates="isReady/0, r/0", preconds="K(isReady)").replace('"', "'")
    assert preconditions(read(tmp_path, text, ending="xml"), "act") == ["K(is_ready)"]


def test_problem_symbols_and_objects_add_to_the_domain(tmp_path):
    text = pks().replace("<init>", "<objects>c, d</objects><init>")
    found = read(tmp_path, text, ending="xml")
    assert list(found.objects) == ["a", "b", "c", "d"]
    assert list(found.domain.constants) == ["a", "b"]


# ------------------------------------------------------------------------------------------------ run-time variables
def test_a_parameter_that_needs_a_value_may_be_what_it_is_compared_with(tmp_path):
    found = get(tmp_path, preconds="Kv(?y) ^ K(r)", effects="K(f(?x) = ?y) => add(Kf, p(?x))")
    assert list(found.domain.actions) == ["act", "act_f"]
    assert [(each.name, each.value_of) for each in found.domain.actions["act"].parameters] == [
        ("x", None),
        ("y", None),
    ]
    x, y = found.domain.actions["act_f"].parameters
    assert (x.name, y.name, spell(y.value_of)) == ("x", "y", "f(x)")
    assert preconditions(found, "act_f") == ["K(r)"]
    assert effects(found, "act_f") == effects(found, "act") == ["K(f(x) = y) => add(Kf, p(x))"]


def test_a_parameter_that_is_compared_with_nothing_may_be_the_value_of_every_function(tmp_path):
    found = get(tmp_path, functions="f/1, g/0, n/0", preconds="Kv(?y)", effects="add(Kf, r)")
    assert list(found.domain.actions) == ["act", "act_f", "act_g"]
    assert [each.name for each in found.domain.actions["act_f"].parameters] == ["object", "x", "y"]


def test_a_parameter_inside_of_an_updated_atom_stands_for_objects_only(tmp_path):
    found = warnings(
        tmp_path, pks(functions="f/1, n/0", preconds="Kv(?y)", effects="add(Kf, p(?y))"), ending="xml"
    )
    assert [each.message for each in found] == ['"?y" cannot stand for the value of "f" here']


# --------------------------------------------------------------------------------------------------- what is refused
@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"preconds": "K(pp(?x))"}, 'unknown predicate "pp" in action "act"'),
        ({"preconds": "K(p(?z))"}, 'unknown variable "?z" in action "act"'),
        ({"preconds": "K(p(c))"}, 'unknown constant "c" in action "act"'),
        ({"preconds": "K(p(?x, ?y))"}, "p takes 1 argument, not 2"),
        ({"preconds": "p(?x)"}, '"p(?x)" is a claim, and a query is about knowledge'),
        ({"preconds": "reachable(?x)"}, 'the external procedure "reachable" is not supported in imported files'),
        ({"preconds": "K(f(?x) = best(?x))"},
         'unknown function "best" in action "act"; external procedures are not supported in imported files'),
        ({"preconds": "K(r | p(?x))"}, 'K of "r | p(?x)" is not supported in action "act"'),
        ({"preconds": "K0(r)"}, 'K0(…) may stand only in a goal, not in action "act"'),
        ({"preconds": "K(r, r)"}, "K(…) takes one claim, not 2"), ({"preconds": "K()"}, "K(…) takes one claim, not none"),
        ({"preconds": "K(r) ^"}, 'the text ends, expected a name, a variable, a number or a parenthesis'),
        ({"preconds": "K(r ="}, 'the text ends, expected a name, a variable, a number or a parenthesis'),
        ({"preconds": "K(r"}, 'the text ends, expected "," or ")"'), ({"preconds": "K(r) $"}, 'unexpected character "$"'),
        ({"preconds": "K(?x < ?y)"}, '"<" compares numbers, "?x" is none'),
        ({"preconds": "(existsK(?z : thing) K(p(?z)))"}, 'unknown type "thing" in action "act"'),
        ({"preconds": "(existsK(?z ?z) K(p(?z)))"}, 'the variable "?z" stands twice in this list'),
        ({"effects": "add(Kz, r)"}, 'unknown database "Kz", expected Kf, Kw, Kv, Kx, LCW'),
        ({"effects": "add(Kf)"}, "add(Kf) names no fact"),
        ({"effects": "add(Kv, r)"}, '"r" is a predicate: it is true or false, and no value'),
        ({"effects": "add(Kw, f(?x))"}, '"f" is a function, not a predicate'),
        ({"effects": "r"}, 'unexpected "r" in action "act", expected add(…) or del(…)'),
        ({"effects": "add(Kf, n < 3)"}, "a fact here has the form f = v or f != v"),
        ({"effects": "?x = 3"}, '"?x" is no function, expected one on the left of a fact'),
        ({"init": "K(r) => add(Kf, r)"}, "an effect in <init> cannot be conditional: nothing is known before"),
        ({"init": "add(Kf, p(?x))"}, 'unknown variable "?x" in <init>'),
        ({"params": "x"}, 'unexpected "x", expected a name or a variable'),
        ({"params": "?x, ?x"}, 'the variable "?x" stands twice in this list'),
        ({"predicates": "p/x"}, 'unexpected "x", expected the number of arguments of "p"'),
        ({"predicates": "p/99"}, 'unexpected "99", expected the number of arguments of "p"'),
        ({"predicates": "f/1"}, '"f" is already the name of a predicate'),
        ({"constants": "a : t, a : u"}, '"a" is declared twice, with different types'),
        ({"functions": "f(t):"}, 'unexpected "the end", expected the type of a value'),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused_with_its_place(tmp_path, parts, message):
    found = refused(tmp_path, pks(**parts), ending="xml")
    assert message in [each.message for each in found]
    assert all(each.line > 1 for each in found)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "this is no PKS file, expected <pks>, <domain> or <problem>"),
        ("<pks>", "<pks> is never closed"), ("<pks></domain>", "unexpected </domain>, expected </pks>"),
        ("</pks>", "unexpected </pks>, expected no closing tag: nothing is open"),
        ("<pks><!-- </pks>", "this comment is never closed"),
        ("<pks><action name='a'></action></pks>", "unexpected <action>, expected <domain> or <problem>"),
        ("<robot/>", "unexpected <robot>, expected <domain> or <problem>"),
        (pks().replace("preconds>", "preconditions>"), "unexpected <preconditions> in <action>"),
        (pks().replace("<actions>", "<actions>word"), 'unexpected "word" in <actions>'),
        (pks().replace("</actions>", "<!-- > --> word </actions>"), 'unexpected "word" in <actions>'),
        (pks().replace('action name="act"', "action"), 'an action needs a name: name="…"'),
        (pks().replace("<goal>K(r)</goal>", ""), "a problem needs <goal>"),
        ("<a>" * 13, "the file is refused here: elements nested deeper than 12"),
    ],
)  # fmt: skip
def test_markup_of_other_kinds_is_refused(tmp_path, text, message):
    assert message in [each.message for each in refused(tmp_path, text, ending="xml")]


def test_places_are_exact_behind_entities_and_comments(tmp_path):
    text = pks(preconds="<!-- a\n comment --> n &lt;= 3 &amp; K(pp)")
    (finding,) = refused(tmp_path, text, ending="xml")
    line = text.splitlines()[finding.line - 1]
    assert line[finding.column - 1 : finding.column - 1 + finding.length] == "pp"


@pytest.mark.parametrize(
    "text",
    ["<pks>" + "<a " * 1_000_000, "<" * 3_000_000, "<!--" * 500_000, "<pks>" + "(" * 100_000 + "</pks>",
     pks(preconds="(" * 10_000), pks(preconds="!" * 10_000), pks(preconds="K(" * 10_000), pks(effects="a=>" * 10_000),
     pks(preconds="K(r) ^ " * 20_000 + "K(r)"), pks(init="add(Kf, p(a)); " * 10_000), pks(goal="1+" * 50_000),
     '<pks a="' * 200_000],
)  # fmt: skip
def test_large_and_deep_texts_are_answered_in_calls_that_grow_no_faster_than_the_text(tmp_path, text):
    path = tmp_path / "file.xml"
    path.write_text(text)
    assert calls_made(lambda: read(tmp_path, text, ending="xml", written=False)) < 20 * len(text)
