"""URDF text of `.xacro` files, made by the PyPI package xacro (the extra `xacro`) in a process of its own."""

import json
import subprocess  # noqa: S404  kabo's own Python, without a shell
import sys
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from kabo.errors import Diagnostic, InputError
from kabo.language.formulas import Place
from kabo.language.robot_files.packages import searched_places

MAX_SECONDS = 60.0  # of one file; a macro may call itself without an end


def processed(path: Path, packages: Mapping[str, Path], place: Place | None) -> tuple[bytes, tuple[Path, ...]]:
    """The URDF text that xacro makes of a file, and the files read: itself and what it includes.

    Raises:
        InputError: xacro is not installed, or cannot expand the file.
    """
    at = place or Place(str(path), 1, 1)
    if find_spec("xacro") is None:
        said = f'robot file "{path.name}" is written in xacro, which is not installed'
        hint = f'install it: pip install "kabo[xacro]"; or make a URDF elsewhere: xacro {path.name} > robot.urdf'
        raise InputError([Diagnostic(at.file, at.line, at.column, said, hint, at.length)])
    answer = _asked({"path": str(path), "packages": {name: str(folder) for name, folder in packages.items()}})
    if "xml" not in answer:
        raise InputError([_refusal(path, answer)])
    files = dict.fromkeys([path, *(Path(each) for each in answer["files"])])
    return str(answer["xml"]).encode(), tuple(files)


def _asked(request: Mapping[str, Any]) -> dict[str, Any]:
    command = [sys.executable, "-m", "kabo.scene.urdf_files.xacro_process"]
    try:
        done = subprocess.run(  # noqa: S603  see above
            command, input=json.dumps(request), capture_output=True, text=True, timeout=MAX_SECONDS, check=False
        )
        answer: dict[str, Any] = json.loads(done.stdout)
    except subprocess.TimeoutExpired:
        return {"error": f"it takes longer than {MAX_SECONDS:g} s"}
    except ValueError:
        last = done.stderr.strip().splitlines()[-1:] or ["no answer"]
        return {"error": last[0]}
    return answer


def _refusal(path: Path, answer: Mapping[str, Any]) -> Diagnostic:
    reason = " ".join(str(answer.get("error", "")).split())[:300]
    hint = "try it alone: xacro " + path.name
    if "unknown package" in reason:
        hint = f"add packages: {{NAME: FOLDER}} to the scene; looked for in {searched_places()}"
    elif "Undefined substitution argument" in reason:
        hint = f"give the argument a default, or make a URDF with it: xacro {path.name} NAME:=VALUE > robot.urdf"
    return Diagnostic(str(answer.get("file", path)), 1, 1, f'xacro cannot expand "{path.name}": {reason}', hint)
