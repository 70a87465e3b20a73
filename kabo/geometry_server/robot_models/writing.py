"""The text of a scene with one robot, as `kabo robot` writes it: every value with where it comes from."""

import json
import os
import re
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server.robot_models.model import AlwaysPair, RobotModel
from kabo.geometry_server.robot_models.self_contacts import SAMPLES, TOLD_SAMPLES
from kabo.language.robot_files.packages import SCHEME

WIDTH = 115
_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_./-]*")
_WORDS_OF_YAML = frozenset(("y", "n", "yes", "no", "on", "off", "true", "false", "null"))
SHARE = "share"  # the folder of an installed package's data


def robot_scene_text(model: RobotModel, folder: Path | None) -> str:
    """The scene file (YAML) of a robot.

    Args:
        model: the robot.
        folder: of the file to write; paths are written relative to it. None: they are written in full.
    """
    package, urdf = _path(model.urdf, folder)
    packages = {} if package is None else {package: "installed"}
    lines = [f"scene: {model.name}", f"epsilon: {model.epsilon:g}"]
    if packages:
        lines.append(f"packages: {_flow(packages)}")
    lines += ["", "robot_models:", f"  {model.name}_model:", f"    urdf: {_word(urdf)}"]
    if model.srdf is not None:
        lines.append(f"    srdf: {_word(_path(model.srdf, folder)[1])}")
    contacts = *_contacts(model), *_often(model)
    for block in (_geometry(model), _joints(model), _tool(model), _gripper(model), _home(model), contacts):
        lines += [f"    {line}".rstrip() for line in block]
    lines += [
        "",
        "robots:",
        f"  {model.name}:",
        f"    model: {model.name}_model",
        "    base: {position: [0, 0, 0]}",
    ]
    return "\n".join(lines) + "\n"


def _path(path: Path, folder: Path | None) -> tuple[str | None, str]:
    """The installed package in which a file lies, if it does, and how the file is written."""
    full = path.absolute()
    for parent in full.parents:
        if parent.parent.name == SHARE and "cmeel.prefix" in parent.parts:
            return parent.name, f"{SCHEME}{parent.name}/{full.relative_to(parent).as_posix()}"
    return None, str(full) if folder is None else os.path.relpath(full, folder.absolute())


# ------------------------------------------------------------------------------------------------------- entries
def _geometry(model: RobotModel) -> Iterator[str]:
    if model.visual:
        yield from _comment(
            f"These links have no collision geometry; their visual one is used: {', '.join(model.visual)}."
        )
    if model.hulls:
        for why, links in model.hull_reasons.items():
            yield from _comment(f"Taken as hulls, {why}: {', '.join(links)}.")
        yield from _comment("Hollows of hulls count as filled; close a mesh to have it taken as it is.")
        yield from _list("hulls", list(model.hulls))


def _joints(model: RobotModel) -> Iterator[str]:
    if model.others:
        ends = ", ".join(other.tool for other in model.others)
        yield from _comment(f"Other joints stand at zero. Another arm: kabo robot --tip LINK; they end at {ends}.")
    yield from _list("joints", list(model.hand.arm))


def _tool(model: RobotModel) -> Iterator[str]:
    gripper = model.gripper
    if gripper is None:
        point, approach, closing = _vector(np.zeros(3)), _vector(np.eye(3)[2]), _vector(np.eye(3)[1])
        yield from _comment(
            "No gripper was found: the point and the axes are the frame's, which may not point outwards. To grasp, add"
            " gripper: {urdf: FILE, mount: LINK, open: …, closed: …, touch_links: […]}, and put the tool on its palm."
        )
    else:
        point, approach, closing = (_vector(each) for each in (gripper.point, gripper.approach, gripper.closing))
        if gripper.opening is not None:
            yield from _comment("tcp: the middle between the fingers' ends, measured on the meshes.")
        else:
            yield from _comment(
                "tcp: the middle of all fingers, and a direction guessed from it; such a hand is not measured. Put the"
                " point to where an object is held, and let approach point away from the palm."
            )
    yield "tool:"
    yield f"  frame: {_word(model.hand.tool)}"
    yield "  features:"
    yield f"    tcp: {{point: {_numbers(point)}}}"
    yield f"    approach: {{line: {{through: {_numbers(point)}, along: {_numbers(approach)}}}}}"
    yield f"    closing: {{line: {{through: {_numbers(point)}, along: {_numbers(closing)}}}}}"


def _gripper(model: RobotModel) -> Iterator[str]:
    gripper = model.gripper
    if gripper is None:
        return
    if gripper.opening is None:
        yield from _comment(f"The opening was not measured: {gripper.unmeasured}. Check what opens it.")
    else:
        opened, closed = (round(1000.0 * gap, 1) + 0.0 for gap in gripper.opening)
        yield from _comment(f"The fingers' ends are {opened:g} mm apart when open, {closed:g} mm when closed.")
    yield "gripper:"
    yield from (f"  {line}" for line in _list("joints", list(model.hand.joints)))
    yield from (f"  {line}" for line in _mapping("open", gripper.open))
    yield from (f"  {line}" for line in _mapping("closed", gripper.closed))
    yield from (f"  {line}" for line in _list("touch_links", list(gripper.touch_links)))


def _home(model: RobotModel) -> Iterator[str]:
    if model.home is None:
        yield from _comment(
            "No configuration without self-collision was found: write one, or allow pairs to touch."
        )
        return
    values = model.home[: model.robot.planned].tolist()
    yield from _comment(f"The links are proven to be {1000 * model.margin:.3g} mm apart there, neighbours aside.")
    if model.hulls and model.margin < model.epsilon:
        yield from _comment("That is little: a filled hollow of a hull may take the room. Then close that mesh.")
    yield "configurations:"
    yield f"  home: {_numbers(values)}"


def _contacts(model: RobotModel) -> Iterator[str]:
    if not model.always:
        if model.srdf is None:
            yield from _comment("No pair of links touches always: all but neighbours are checked.")
        return
    yield from _comment(
        "Pairs that touch always, and so can never be checked. All others but neighbours are checked."
    )
    yield "allowed_contacts:"
    for pair in model.always:
        yield f"  - [{_word(pair.first)}, {_word(pair.second)}]  # {_reason(pair)}"


def _often(model: RobotModel) -> Iterator[str]:
    """Pairs that take much of the reach, to be allowed by whoever knows that the links do not touch."""
    if not model.often:
        return
    yield from _comment(
        "Pairs that touch, or nearly, at many configurations, and so take much of the reach. If the links do not touch in "
        "truth, and only their shapes are too wide, allow them."
    )
    for (first, second), share in model.often.items():
        yield f"#   - [{_word(first)}, {_word(second)}]  # at {share:.0%} of {TOLD_SAMPLES} configurations"


def _reason(pair: AlwaysPair) -> str:
    if pair.hand:
        return "they touch, or nearly, while the gripper is open or closes, wherever the arm is"
    if pair.depth is not None:
        return f"proven: they overlap at every configuration, by {1000 * pair.depth:.2g} mm or more"
    return f"sampled: they touch, or nearly, at all of {SAMPLES} configurations"


# ---------------------------------------------------------------------------------------------------------- YAML
def _comment(text: str) -> list[str]:
    return [f"# {line}" for line in textwrap.wrap(text, WIDTH - 6)]


def _word(text: str) -> str:
    plain = _PLAIN.fullmatch(text) and text.lower() not in _WORDS_OF_YAML
    return text if plain or text.startswith(SCHEME) else json.dumps(text, ensure_ascii=False)


def _flow(values: Mapping[str, str]) -> str:
    return "{" + ", ".join(f"{_word(key)}: {_word(value)}" for key, value in values.items()) + "}"


def _list(key: str, words: Sequence[str]) -> list[str]:
    return _wrapped(f"{key}: [", ", ".join(map(_word, words)) + "]")


def _mapping(key: str, values: Mapping[str, float]) -> list[str]:
    return _wrapped(
        f"{key}: {{", ", ".join(f"{_word(name)}: {_number(value)}" for name, value in values.items()) + "}"
    )


def _wrapped(begin: str, rest: str) -> list[str]:
    if len(begin) + len(rest) <= WIDTH - 6:
        return [begin + rest]
    inner = textwrap.wrap(rest[:-1], WIDTH - 8, break_long_words=False, break_on_hyphens=False)
    return [begin, *(f"  {line}" for line in inner), rest[-1]]


def _vector(values: Array) -> tuple[float, ...]:
    return tuple(round(float(value), 6) for value in values)


def _numbers(values: Sequence[float]) -> str:
    return "[" + ", ".join(map(_number, values)) + "]"


def _number(value: float) -> str:
    return f"{value + 0.0:.10g}"
