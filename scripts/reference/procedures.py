"""The tasks of the library as procedures: signature, parameters with their meaning, stages, and what refuses them."""

import re
from pathlib import Path
from typing import Any

import yaml

from kabo.geometry_server import REASONS
from scripts.reference.markdown import code, plain, table

LIBRARY = Path(__file__).resolve().parent.parent.parent / "kabo" / "tasks" / "library"

#: What each reason of a refusal means; a reason without a meaning stops the script.
MEANINGS = {
    "out_of_reach": "no configuration of the robot reaches the pose, whatever stands around it",
    "collision": "every configuration that was found collides; the refusal names the pairs",
    "constraint": "a constraint of the scene, a grasp family or a stage cannot be kept; the comment says which",
    "no_path": "both ends are free, but no path between them was found; the refusal names the pairs",
    "empty_family": "no grasp or placement family fits the robot, the object and the region",
    "hidden": "something stands between the camera and the object; the refusal names it",
    "out_of_view": "the object is outside of the camera's field of view, or too near or too far",
    "not_explored": "a model has no trials in these cases",
    "nothing_valid": "a model believes no parameters to be valid",
    "out_of_range": "the nearest outcome that a model expects is farther from the wanted one than the tolerance",
}
#: What properties of the library's tasks mean wherever the file says nothing else.
USUAL = {
    "robot": "the robot that moves",
    "object": "the object that is handled",
    "this": "the body that is picked",
    "other": "the body that it is put on",
    "other_robot": "the second robot",
    "receiver": "the robot that takes the object",
    "region": "where the object is put",
    "grasp": "a grasp family of the object's model",
    "placement": "a placement family of the object's model",
    "keep": "a motion constraint that is kept all along the way",
}


def sections() -> str:
    """What refuses procedures, and a section for each of the library."""
    reasons = table(("reason", "means"), [(code(each), MEANINGS[each]) for each in REASONS])
    procedures = [section(path) for path in sorted(LIBRARY.glob("*.yaml"))]
    return "\n\n" + "\n\n".join([*procedures, "## Why a procedure is refused", reasons]) + "\n\n"


def section(path: Path) -> str:
    """The section of one procedure."""
    text = path.read_text()
    task = yaml.safe_load(text)
    said = heading(text)
    properties: dict[str, dict[str, Any]] = task.get("properties", {})
    rows = [
        (code(name), code(each["type"]), default(each), meaning(text, name)) for name, each in properties.items()
    ]
    given = ", ".join(
        name + (f" = {each['default'] or '…'}" if "default" in each else "") for name, each in properties.items()
    )
    parts = [
        f"## {task['name']}",
        f"`{task['name']}({given})`",
        said,
        table(("parameter", "type", "default", "meaning"), rows),
        "```text\n" + "\n".join(tree(task["stages"], 0)) + "\n```",
    ]
    return "\n\n".join(parts)


def heading(text: str) -> str:
    """What the comment at the beginning of a task file says, as a sentence."""
    lines = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# "))
    said = re.sub(r"^\w+\([^)]*\): ?", "", " ".join(lines))
    return plain(said[:1].upper() + said[1:])


def default(declared: dict[str, Any]) -> str:
    """The default of a parameter."""
    if "default" not in declared:
        return "must be given"
    return code(declared["default"]) if declared["default"] not in ("", None) else "none"


def meaning(text: str, name: str) -> str:
    """What a parameter means: the comment beside it in the file, else what the name usually means."""
    found = re.search(rf"^  {name}: .*?# (.*)$", text, flags=re.MULTILINE)
    if found is None and name not in USUAL:
        raise SystemExit(f"{LIBRARY}: say behind `{name}:` what it means, `# …`")
    return plain(found[1] if found else USUAL[name])


def tree(stages: list[dict[str, Any]], depth: int) -> list[str]:
    """The stages as an indented tree: name and type."""
    lines = []
    for stage in stages:
        lines.append(
            f"{'  ' * depth}{stage['name']}  {stage['stage']}"
            if "stage" in stage
            else f"{'  ' * depth}{stage['name']}"
        )
        inner = [*stage.get("stages", []), *([stage["wrapped"]] if "wrapped" in stage else [])]
        lines += tree(inner, depth + 1)
    return lines
