"""Laws of explorations over spaces, options and trials of any kind: bounds, determinism, files, and refusals."""

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from kabo.errors import InputError
from kabo.exploration import (
    Exploration,
    ExplorationError,
    Journal,
    NoParametersError,
    Space,
    Validity,
    load_exploration,
)
from tests.support.small_explorations import exploration, tell_random

names = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=6)
seeds = st.integers(-(2**63), 2**63 - 1)


@st.composite
def bounds(draw: st.DrawFn) -> tuple[float, float]:
    """Bounds of any size: around zero, far from it, hardly apart."""
    low = draw(st.sampled_from([0.0, 1.0, -1e-9, 1e9])) * draw(st.floats(-1.0, 1.0))
    high = low + draw(st.sampled_from([1e-12, 1e-3, 1.0, 360.0, 1e15])) * draw(st.floats(0.1, 1.0))
    return (low, high) if low < high else (low, math.nextafter(low, math.inf))


@st.composite
def explorations(draw: st.DrawFn, most: int = 25) -> Exploration:
    """An exploration of any space with up to `most` trials, whose validity and outcomes follow no law."""
    space = Space(
        draw(st.dictionaries(names, bounds(), min_size=1, max_size=6)),
        draw(st.dictionaries(names, st.lists(names, min_size=1, max_size=3, unique=True), max_size=2)),
    )
    options = Validity(draw(st.floats(0.01, 10)), draw(st.floats(0.01, 10)), draw(st.floats(1e-9, 1 - 1e-9)))
    outcomes = draw(st.lists(names, min_size=1, max_size=3, unique=True))
    budget = draw(st.none() | st.floats(1e-6, 1 - 1e-6))
    middle = {name: min(low + (high - low) / 2, high) for name, (low, high) in space.parameters.items()}
    start = draw(st.sampled_from([None, middle]))
    found = Exploration(space, outcomes, seed=draw(seeds), validity=options, invalid_budget=budget, start=start)
    generator = np.random.default_rng(draw(st.integers(0, 2**32)))
    size = 10.0 ** draw(st.integers(-30, 90))
    for _ in range(draw(st.integers(0, most))):
        at = space.rounded(generator.random((1, len(space.names))))[0][0]
        valid = bool(generator.random() < 0.7)
        values = {name: float(size * generator.normal()) for name in outcomes} if valid else None
        case = space.all_cases[int(generator.integers(len(space.all_cases)))]
        found.tell(case, space.named(at), valid, values, "" if valid else "no")
    return found


def again(found: Exploration) -> Exploration:
    """The same exploration, made anew and told the same."""
    other = Exploration(
        found.space,
        found.outcomes,
        seed=found.seed,
        validity=found.validity_options,
        invalid_budget=found.invalid_budget,
        start=found.start,
    )
    for trial in found.trials:
        other.tell(trial.case, trial.parameters, trial.valid, trial.outcomes, trial.reason)
    return other


@given(explorations())
def test_a_question_is_within_bounds_admissible_and_the_same_again(found):
    for case in found.space.all_cases:
        try:
            asked = found.ask(case)
        except NoParametersError as error:
            event(error.reason)
            with pytest.raises(NoParametersError):
                again(found).ask(case)
            continue
        assert found.space.checked(asked.parameters) == asked.parameters
        assert asked.validity == pytest.approx(found.validity(case, [asked.parameters])[0], abs=1e-9)
        explored = any(each.valid for each in found.trials_of(case))
        event("among candidates" if explored else "start")
        if explored and found.invalid_budget is None:
            assert asked.validity > found.validity_options.alpha
        assert again(found).ask(case) == asked


@given(explorations(), st.floats(1e-6, 1 - 1e-6), st.data())
def test_what_is_inferred_is_within_bounds_admissible_and_as_predicted(found, alpha, data):
    values = st.sampled_from(["least", "most"]) | st.floats(-1e100, 1e100)
    target = {name: data.draw(values) for name in data.draw(st.sets(st.sampled_from(found.outcomes), min_size=1))}
    try:
        offers = found.alternatives(target, alpha=alpha, count=3)
    except NoParametersError as error:
        event(error.reason)
        assert error.reason != "out_of_range"
        return
    assert again(found).alternatives(target, alpha=alpha, count=3) == offers
    for offer in offers:
        assert found.space.checked(offer.parameters) == offer.parameters
        assert offer.validity > alpha
        assert all(np.isfinite([*offer.expected.values(), *offer.deviation.values()]))
        assert min(offer.deviation.values()) > 0
        for name, (mean, deviation) in found.predict(offer.case, [offer.parameters]).items():
            assert offer.expected[name] == pytest.approx(mean[0], rel=1e-6, abs=1e-6 * deviation[0])


@given(explorations())
def test_a_file_gives_the_same_exploration(tmp_path_factory, found):
    path = tmp_path_factory.mktemp("models") / "model.jsonl"
    found.save(path)
    loaded = load_exploration(path)
    assert loaded.text == found.text
    assert loaded.trials == found.trials
    assert (loaded.header, loaded.space, loaded.digest) == (found.header, found.space, found.digest)


@given(explorations(), st.data())
def test_a_file_cut_anywhere_keeps_all_whole_lines(tmp_path_factory, found, data):
    path = tmp_path_factory.mktemp("models") / "model.jsonl"
    content = found.text.encode()
    length = data.draw(st.integers(content.index(b"\n") + 1, len(content)))
    path.write_bytes(content[:length])
    kept = content[:length].count(b"\n") - 1
    assert Journal.resume(path).exploration.trials == found.trials[:kept]
    assert path.read_bytes() == content[: content[:length].rfind(b"\n") + 1]


@given(st.data())
def test_a_damaged_file_is_read_or_refused_with_its_place(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("models") / "model.jsonl"
    content = bytearray(MODEL)
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content) - 1))
        kind = data.draw(st.sampled_from(["change", "remove", "add", "copy"]))
        if kind == "change":
            content[at] = data.draw(st.integers(0, 255))
        elif kind == "remove":
            del content[at : at + data.draw(st.integers(1, 20))]
        elif kind == "add":
            content[at:at] = data.draw(
                st.sampled_from([b"NaN", b"1e999", b"null", b"[", b"{}", b"true", b"\n", b'"', b"-"])
            )
        else:
            content[at:at] = content[at : at + data.draw(st.integers(1, 60))]
    path.write_bytes(content)
    try:
        loaded = load_exploration(path)
    except InputError as error:
        (found,) = error.diagnostics
        event(found.message.split(":")[0][:30])
        assert 1 <= found.line <= content.count(b"\n") + 1
        assert "Traceback" not in str(error)
        assert len(str(error)) < 1_000
    else:
        event("read")
        path.write_text(loaded.text)
        assert load_exploration(path).trials == loaded.trials


def model() -> bytes:
    found = exploration(2, ("torque", "noise"), cases={"bar": ["steel", "wood"]}, start={"a": 0.5, "b": 0.0})
    tell_random(found, 4, case={"bar": "steel"})
    return found.text.encode()


MODEL = model()
PIECES = [b"NaN", b"1e999", b"null", b"[", b"{}", b"true", b"\n", b'"', b"-", b"\\ud800"]

junk: st.SearchStrategy[Any] = st.recursive(
    st.none()
    | st.booleans()
    | st.floats()
    | st.integers()
    | st.text(max_size=4)
    | st.sampled_from(["bar", "steel", "a", "b", "torque", "least", "deviation", "\ud800", b"steel", 10**400, 1j]),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["a", "b", "bar", "torque", "noise", "x", 3]), inner, max_size=3)
        | st.tuples(inner, inner)
    ),
    max_leaves=6,
)
FOUND = exploration(2, ("torque", "noise"), cases={"bar": ["steel", "wood"]}, start={"a": 0.5, "b": 0.0})
tell_random(FOUND, 6, case={"bar": "steel"}, spread=0.3)
GOOD: dict[str, Any] = {
    "case": {"bar": "steel"},
    "where": {"bar": "steel"},
    "parameters": {"a": 0.5, "b": 0.0},
    "valid": True,
    "outcomes": {"torque": 1.0, "noise": 2.0},
    "reason": "",
    "alpha": 0.7,
    "points": [{"a": 0.5, "b": 0.0}],
    "target": {"torque": 1.0},
    "tolerance": None,
    "count": 2,
}
METHODS = {
    "checked_trial": ("case", "parameters", "valid", "outcomes", "reason"),
    "ask": ("case", "alpha"),
    "validity": ("case", "points"),
    "predict": ("case", "points"),
    "infer": ("target", "where", "alpha", "tolerance"),
    "alternatives": ("target", "where", "alpha", "tolerance", "count"),
    "leave_one_out": ("case",),
    "trials_of": ("case",),
}


@given(st.data())
def test_arguments_of_any_kind_are_understood_or_refused_in_one_sentence(data):
    method = data.draw(st.sampled_from(sorted(METHODS)))
    spoilt = data.draw(st.sets(st.sampled_from(METHODS[method]), min_size=1))
    arguments = [data.draw(junk) if name in spoilt else GOOD[name] for name in METHODS[method]]
    before = FOUND.digest
    try:
        getattr(FOUND, method)(*arguments)
        event("understood")
    except ExplorationError as error:
        event("refused")
        assert len(str(error)) < 1_500
        str(error).encode()
    assert FOUND.digest == before


@given(st.data())
def test_spaces_and_explorations_of_any_kind_are_made_or_refused_in_one_sentence(data):
    keywords = ("seed", "validity", "invalid_budget", "start", "retry", "units", "name")
    spoilt = data.draw(st.sets(st.sampled_from(keywords), max_size=2))
    try:
        space = Space(
            data.draw(st.just({"a": (0, 1)}) | junk), data.draw(st.just({}) | junk), data.draw(st.just({}) | junk)
        )
        made = Exploration(
            space, data.draw(st.just(["torque"]) | junk), **{name: data.draw(junk) for name in spoilt}
        )
    except ExplorationError as error:
        event("refused")
        assert len(str(error)) < 1_500
        str(error).encode()
    else:
        event("made")
        assert json.loads(made.text)["outcomes"].keys() == set(made.outcomes)
        made.digest.encode()
