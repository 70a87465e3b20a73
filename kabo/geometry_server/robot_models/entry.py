"""From a URDF to the text of a scene in one call, and the file and the name that a user means."""

import os
from pathlib import Path
from types import NoneType

from kabo.errors import Diagnostic, InputError
from kabo.geometry_server.robot_models.model import Wishes, make_robot_model
from kabo.geometry_server.robot_models.writing import robot_scene_text
from kabo.given import require_given, require_path
from kabo.language.names import proper_name
from kabo.language.recorded_paths import installed_folder
from kabo.language.robot_files.packages import package_folder, searched_places
from kabo.options import OPTIONS

DEFAULT_EPSILON = 0.01  # [m]


def robot_scene(
    urdf: Path | str,
    *,
    srdf: Path | str | None = None,
    name: str | None = None,
    tip: str | None = None,
    group: str | None = None,
    epsilon: float = DEFAULT_EPSILON,
    folder: Path | str | None = None,
) -> str:
    """The text of a scene with one robot, as `kabo robot` writes it: joints, tool, gripper, a free home, contacts.

    Args:
        urdf: a URDF or xacro file; `package://NAME/…` is in the folder of an installed package.
        srdf: its SRDF file, if there is one: disabled pairs, groups, states.
        name: the name of the robot; None makes it of the file's name.
        tip: the last link of the arm to plan for; None for the longest arm.
        group: the group of the SRDF whose joints are planned.
        epsilon: the accuracy [m] with which links are checked.
        folder: the folder in which the scene will stand, from which paths are written; None writes whole paths.

    Raises:
        ArgumentError: an argument is of a wrong kind, or no such number.
        InputError: a file does not exist or has errors: all of them; or what was chosen does not exist.
    """
    OPTIONS["epsilon"].require(epsilon)
    for argument, given in (("name", name), ("tip", tip), ("group", group)):
        require_given(argument, given, str, NoneType)
    folder = None if folder is None else require_path("folder", folder)
    file = existing_file(_text("urdf", urdf), "URDF")
    meaning = None if srdf is None else existing_file(_text("srdf", srdf), "SRDF")
    called = robot_name(name, file, "name")
    model = make_robot_model(file, meaning, name=called, epsilon=epsilon, wishes=Wishes(tip, group))
    return robot_scene_text(model, folder)


def _text(name: str, given: Path | str) -> str:
    """The text of a path: as `Path`, `package://` would lose one of its strokes."""
    require_path(name, given)
    return str(given)


def existing_file(text: str, what: str) -> Path:
    """The path of a file; `package://NAME/…` is in the folder of an installed package.

    Raises:
        InputError: there is no such file; `what` is the name of the argument.
    """
    path = Path(text)
    if text.startswith("package://"):
        package, _, rest = text.removeprefix("package://").partition("/")
        folder = installed_folder(package) or package_folder(package, {}, Path.cwd() / "here")
        if folder is None:
            hint = f"looked for in {searched_places()}, and among installed packages"
            raise InputError([Diagnostic(what, 1, 1, f'unknown package "{package}"', hint)])
        path = folder / rest
    if not os.path.isfile(path):  # False for too long a name, too
        raise InputError([Diagnostic(what, 1, 1, f'"{text}": there is no such file', f"looked for {path}")])
    return path


def robot_name(given: str | None, urdf: Path, what: str) -> str:
    """The robot's name: as given, else made of the file's name.

    Raises:
        InputError: what was given is no name; `what` is the name of the argument.
    """
    made = proper_name(given or urdf.name.split(".")[0])
    if given is not None and made != given:
        hint = f"names are [a-z][a-z0-9_]*, such as {made}"
        raise InputError([Diagnostic(what, 1, 1, f'"{given}" is no name', hint)])
    return made
