"""Whatever is changed in a plan's file: the verifier answers, and does not call right what moves differently."""

import json
import os
import tempfile
from functools import cache
from pathlib import Path

from hypothesis import event, given, settings
from hypothesis import strategies as st

from kabo.errors import InputError
from kabo.plan import plan_from_json, plan_to_json
from kabo.verify import verify_plan
from tests.verify.counter import Counter, load

EXAMPLES = settings(max_examples=max(30, round(600 * float(os.environ.get("KABO_PROPERTY_SCALE", "0.1")))))
TEXTS = st.sampled_from(
    [
        "",
        "x",
        "n0",
        "n3",
        "arm",
        "gate",
        "mug",
        "table",
        "world",
        "arm.palm",
        "arm.left",
        "upright",
        "full(mug)",
        "tray",
    ]
    + ["take", "weigh", "put", "x", "finger", "swing", "plate"]
)
NUMBERS = st.sampled_from([0.0, 1.0, -1.0, 0.3, 1e9, 1e-3, -0.79, 0.02])
ANYTHING = st.sampled_from([None, True, [], {}, "x", 7, ["mug", "table"], {"x": 0}])


# Changes here change nothing that moves or is known: texts for people, what made the plan.
HARMLESS = {"stage", "procedure", "options", "problem", "certificate"}


@cache
def counter() -> tuple[Counter, tempfile.TemporaryDirectory]:
    folder = tempfile.TemporaryDirectory()
    return load(Path(folder.name)), folder  # the folder must live as long as the problem


def places(value, path=()):
    """Every place in a JSON value."""
    yield path
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for step, one in inner:
        yield from places(one, (*path, step))


@EXAMPLES
@given(data=st.data())
def test_no_change_of_one_value_makes_the_verifier_fail_or_see_what_is_not_there(data):
    here, _ = counter()
    value = json.loads(plan_to_json(here.plan))
    path = data.draw(st.sampled_from([p for p in places(value) if p and not HARMLESS & set(p)]))
    inner = value
    for step in path[:-1]:
        inner = inner[step]
    before, whole = inner[path[-1]], inner.copy()
    fitting = TEXTS if isinstance(before, str) else NUMBERS if isinstance(before, float) else ANYTHING
    after = data.draw(fitting)
    inner[path[-1]] = after
    try:
        plan = plan_from_json(json.dumps(value).encode())
    except InputError:
        event("refused by the reader")
        return
    report = verify_plan(here.problem, plan)
    if not report.ok:
        event("not verified")
        return
    event("verified")
    what = f"{path}: {before} -> {after}"
    nothing_changed = plan_to_json(plan) == plan_to_json(here.plan)
    fewer_contacts = "allowed_contacts" in path
    later = "times" in path  # waiting, or moving more slowly, is no fault
    another_way = "waypoints" in path and path[-2] not in (
        0,
        len(value["nodes"][path[1]]["motion"][path[3]]["waypoints"]) - 1,
    )
    same_rotation = "quaternion" in path and isinstance(whole, list) and inner == [-each for each in whole]
    assert nothing_changed or fewer_contacts or later or another_way or same_rotation, what
