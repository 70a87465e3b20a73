"""Laws of the imports: effects mean in kabo what they mean in PDDL, and no text leads to anything but an InputError."""

import tempfile
from functools import cache
from itertools import product
from pathlib import Path

from hypothesis import assume, event, given
from hypothesis import strategies as st

from kabo.errors import InputError
from kabo.language import check_files, load_problem
from tests.language.meaning import after, holds, parsed, true_in, world_after
from tests.language.samples import CLG, LOGISTICS, PKS_TYPED, PKS_UNTYPED
from tests.language.written import assert_as_written

OBJECTS = ("a", "b", "c")
ATOMS = st.sampled_from(["(p {0})", "(p {1})", "(p a)", "(r)", "(q {0} {1})", "(q {1} b)", "(q {0} {0})"])


def terms(depth: int) -> st.SearchStrategy[tuple[str, str]]:
    """Two terms that are in scope below `depth` quantifiers."""
    names = st.sampled_from(["?x", "?y", "a", *(f"?z{n}" for n in range(depth))])
    return st.tuples(names, names)


def atoms(depth: int) -> st.SearchStrategy[str]:
    """An atom as text."""
    return st.builds(lambda form, pair: form.format(*pair), ATOMS, terms(depth))


@cache
def conditions(depth: int, size: int) -> st.SearchStrategy[str]:
    """A condition as text."""
    equal = st.builds("(= {0[0]} {0[1]})".format, terms(depth))
    simple = st.one_of(atoms(depth), equal, st.builds("(not {})".format, st.one_of(atoms(depth), equal)))
    if size == 0:
        return simple
    inner = conditions(depth, size - 1)
    below = conditions(depth + 1, size - 1)
    return st.one_of(
        simple,
        st.builds("({} {} {})".format, st.sampled_from(["and", "or", "imply"]), inner, inner),
        st.builds("(not {})".format, inner),
        st.builds(f"({{}} (?z{depth}) {{}})".format, st.sampled_from(["forall", "exists"]), below),
    )


@cache
def effects(depth: int, size: int) -> st.SearchStrategy[str]:
    """An effect as text."""
    literal = st.one_of(atoms(depth), st.builds("(not {})".format, atoms(depth)))
    if size == 0:
        return literal
    inner = effects(depth, size - 1)
    return st.one_of(
        literal,
        st.builds("(and {} {})".format, inner, inner),
        st.builds("(and {} {} {})".format, inner, inner, inner),
        st.builds("(when {} {})".format, conditions(depth, 1), inner),
        st.builds(f"(forall (?z{depth}) {{}})".format, effects(depth + 1, size - 1)),
    )


def texts(precondition: str, effect: str, initial: str) -> tuple[str, str]:
    """A domain of one action, and a problem."""
    domain = f"""(define (domain d) (:predicates (p ?x) (q ?x ?y) (r))
        (:action act :parameters (?x ?y) :precondition {precondition} :effect {effect}))"""
    return domain, f"""(define (problem one) (:domain d) (:objects a b c) (:init {initial}) (:goal (r)))"""


ALL_ATOMS = [("r", ()), *(("p", (x,)) for x in OBJECTS), *(("q", pair) for pair in product(OBJECTS, repeat=2))]
STATES = st.frozensets(st.sampled_from(ALL_ATOMS))


def loaded(folder: str, domain: str, problem: str):
    """The problem of two texts."""
    (Path(folder) / "domain.pddl").write_text(domain)
    (Path(folder) / "problem.pddl").write_text(problem)
    return load_problem(Path(folder) / "problem.pddl")


@given(
    condition=st.just("()") | conditions(0, 2),
    effect=effects(0, 3),
    states=st.lists(STATES, min_size=4, max_size=4),
)
def test_classical_actions_do_what_they_do_in_pddl(condition, effect, states):
    """Preconditions hold in the same states, effects lead to the same states, and never contradict themselves."""
    with tempfile.TemporaryDirectory() as folder:
        problem = loaded(folder, *texts(condition, effect, ""))
        assert_as_written(problem, Path(folder) / "yaml")
    action = problem.domain.actions["act"]
    for state, (x, y) in product(states, product(OBJECTS, repeat=2)):
        mine, theirs = {"x": x, "y": y}, {"?x": x, "?y": y}
        expected = true_in(parsed(condition)[0], state, theirs, OBJECTS)
        assert all(holds(each, state, mine, problem) for each in action.preconditions) == expected
        if expected:
            assert world_after(problem, "act", state, mine) == after(parsed(effect)[0], state, theirs, OBJECTS)


@given(effect=effects(0, 3), states=st.lists(STATES, min_size=4, max_size=4))
def test_effects_on_an_unknown_world_do_what_they_do_in_pddl(effect, states):
    """The same for world effects, if nothing had to be left as it stands or refused."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            problem = loaded(folder, *texts("(and )", effect, "(unknown (p a)) (unknown (r))"))
        except InputError as error:
            event("refused: " + error.diagnostics[0].message.split(":")[0][:60])
            assert all("not supported" in each.message or "cases" in each.message for each in error.diagnostics)
            return
        found = check_files([Path(folder) / "problem.pddl"])
        assert_as_written(problem, Path(folder) / "yaml")
    assume(not any("may meet" in each.message for each in found))
    event("world effects: " + ("when" if "when" in effect else "none"))
    for state, (x, y) in product(states, product(OBJECTS, repeat=2)):
        expected = after(parsed(effect)[0], state, {"?x": x, "?y": y}, OBJECTS)
        assert world_after(problem, "act", state, {"x": x, "y": y}) == expected


# ------------------------------------------------------------------------------------------------------------ fuzz
SAMPLES = [("pddl", LOGISTICS), ("pddl", CLG), ("xml", PKS_UNTYPED), ("xml", PKS_TYPED)]
WORDS = ["(", ")", "((", "))", "?x", "-", "<", ">", "&", "!", "^", "=>", ";", ",", ":", "'", '"', "\n", "\0", "é",
         "(:init", "(and", "(forall", "(when", "(oneof", "(not", "either", "<goal>", "</effects>", "<!--", "-->", "K(",
         "add(Kf,", "existsK(", "1e999", "9", "&lt;", "object", "=", "(=", "total-cost", "(:types", "define"]  # fmt: skip


@st.composite
def spoiled(draw) -> tuple[str, str]:
    """A sample with pieces cut, doubled, swapped or put in."""
    ending, text = draw(st.sampled_from(SAMPLES))
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(text)))
        end = min(len(text), start + draw(st.integers(0, 30)))
        kind = draw(st.sampled_from(["cut", "truncate", "double", "swap", "put", "letters"]))
        piece = text[start:end]
        if kind == "cut":
            text = text[:start] + text[end:]
        elif kind == "truncate":
            text = text[:start]
        elif kind == "double":
            text = text[:end] + piece + text[end:]
        elif kind == "swap":
            other = draw(st.integers(0, len(text)))
            text = text[:start] + text[other : other + len(piece)] + text[end:]
        else:
            put = draw(st.sampled_from(WORDS)) if kind == "put" else draw(st.text(max_size=3))
            text = text[:start] + put + text[end:]
    return ending, text


@given(sample=spoiled())
def test_whatever_is_done_to_a_file_reading_it_ends_in_a_problem_or_in_findings_with_places(sample):
    ending, text = sample
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"file.{ending}"
        path.write_bytes(text.encode(errors="surrogatepass"))
        found = check_files([path])
        try:
            problem = load_problem(path)
        except InputError as error:
            event(f"{ending} refused")
            assert error.diagnostics
            lines = path.read_bytes().decode(errors="replace").splitlines() or [""]
            for each in error.diagnostics:
                assert each.message and each.line >= 1 and each.column >= 1
                if each.file == str(path):
                    assert each.line <= len(lines) + 1
            assert any(each.severity == "error" for each in found)
        else:
            event(f"{ending} accepted")
            assert_as_written(problem, Path(folder) / "yaml")


@given(data=st.binary(max_size=200), ending=st.sampled_from(["pddl", "xml"]))
def test_bytes_that_are_no_text_are_refused(data, ending):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"file.{ending}"
        path.write_bytes(data)
        try:
            load_problem(path)
        except InputError as error:
            assert error.diagnostics
        else:
            raise AssertionError("accepted")
