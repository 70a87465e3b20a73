"""An explanation of why there is no plan, in the view document: its words, and the samples of each refused call."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from kabo.tasks.files.describing import said
from kabo.viewer.content.document import View
from kabo.viewer.content.films import flat_state

if TYPE_CHECKING:
    from kabo.scene import Scene

Given = Mapping[str, Any]


def explanation_view(explanation: Given, scene: "Scene | None") -> View:
    """The part `explanation` of a view document, of the JSON of `kabo explain`; samples only with the scene.

    Raises:
        TypeError: something is of another kind than `kabo explain` writes.
        KeyError: a key is missing, or a sample names a robot, joint or object that is not in the scene.
    """
    knowledge = explanation.get("knowledge", {})
    return {
        "verdict": explanation["verdict"],
        "summary": _sentences(explanation["summary"]),
        "goals": _sentences(knowledge.get("unreachable_goals", [])),
        "start": _sentences(explanation.get("start", [])),
        "calls": [_call(each, scene) for each in explanation.get("procedures", [])],
        "changes": [_change(each, scene) for each in explanation["counterfactuals"]],
        "useless": _sentences([*knowledge.get("unused_actions", []), *knowledge.get("never_known", [])]),
        "unfinished": _sentences(explanation.get("unfinished", [])),
    }


def _sentences(value: Any) -> list[str]:
    if not isinstance(value, list) or not all(isinstance(each, str) for each in value):
        raise TypeError("a list of sentences")
    return value


# ----------------------------------------------------------------------------------------------------- refused calls
def _call(call: Given, scene: "Scene | None") -> dict[str, Any]:
    names = set() if scene is None else {*scene.robots, *scene.bodies, *scene.regions}
    return {
        "text": f"{call['procedure']}({', '.join(call['arguments'])})",
        "refused": sum(row["count"] for row in call["failures"]),
        "attempts": call["calls"],
        "needed": call.get("needed", False),
        "things": [name for name in call["arguments"] if name in names],
        "failures": [_failure(row) for row in call["failures"]],
        "measures": [each["said"] for each in call.get("measures", []) if "said" in each],
        "without": [[body, count] for body, count in call.get("without", {}).items()],
        "samples": [] if scene is None else [_sample(each, scene) for each in call.get("samples", [])],
    }


def _failure(row: Given) -> dict[str, Any]:
    """A row of refused attempts in words: why, between what, how far, and whether epsilon alone decides."""
    text = row.get("said") or said(row["reason"])
    if row["missing"] is not None:
        text += f" by {row['missing']:.3f} m"
    if row["between"]:
        text += f": {row['between'][0]} and {row['between'][1]}"
    if row["because_of_epsilon"]:
        text += f" ({row['because_of_epsilon']} only because of epsilon)"
    return {"reason": row["reason"], "count": row["count"], "between": row["between"], "text": text}


def _sample(sample: Given, scene: "Scene") -> dict[str, Any]:
    return {
        "failure": sample["failure"],
        "state": flat_state(sample["state"], scene),
        "between": sample["between"],
    }


# ----------------------------------------------------------------------------------------------------------- changes
def _change(tried: Given, scene: "Scene | None") -> dict[str, Any]:
    change = tried["change"]
    return {
        "text": tried.get("said") or _words(change),
        "result": _result(tried),
        "solved": tried["result"] == "solved",
        "scene": None if scene is None else _in_scene(change, scene),
    }


def _words(change: Given) -> str:
    ((kind, value),) = change.items()
    return f"without {value}" if kind == "remove" else f"with {kind.replace('_', ' ')} {value}"


def _result(tried: Given) -> str:
    if tried["result"] == "solved":
        return f"a plan of {tried['plan_actions']} action{'' if tried['plan_actions'] == 1 else 's'}"
    words = {"no_plan": "there is proven to be no plan either", "exhausted": "no plan was found either"}
    return words.get(tried["result"], f"not tried: {tried.get('why', 'there was no time')}")


def _in_scene(change: Given, scene: "Scene") -> dict[str, Any] | None:
    """How a change is drawn: a body that fades, the links of a robot that stand elsewhere, a region that grows."""
    match change:
        case {"remove": body}:
            return {"remove": body}
        case {"move_base": {"robot": robot, "by": by}} if robot in scene.robots:
            return {"robot": robot, "by": _three(by)}
        case {"larger_floor": {"region": region, "by": by}} if region in scene.regions:
            return {"region": region, "grow": float(by)}
    return None


def _three(by: Sequence[float]) -> list[float]:
    return [float(value) for value in by]
