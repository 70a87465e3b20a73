"""What reading an exploration file, or a model, means: every command of `kabo explore` on it, and nothing is spoilt."""

import io
import json
import os
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

COMMANDS: tuple[Sequence[str], ...] = (
    ("show", "--json"),
    ("ask", "--json"),
    ("infer", "--target", "torque=0", "--json"),
    ("tell", "--case", "bar=steel", "hand=left", "--set", "along=0", "force=20", "--invalid", "--json"),
    ("show", "--html", "page.html", "--json"),
)


def model(path: Path, number: int) -> None:
    """Runs one command on a model; then reads it, so that what is wrong with it is judged."""
    from kabo.exploration import load_exploration

    command, *rest = COMMANDS[number % len(COMMANDS)]
    before = path.read_bytes()
    code = answered(["explore", command, str(path), *rest], path.parent, {0, 2, 4})
    (path.parent / "page.html").unlink(missing_ok=True)
    after = path.read_bytes()
    whole = before[: before.rfind(b"\n") + 1]
    assert after == before or (command == "tell" and code == 0 and after.startswith(whole)), f"spoilt by {command}"  # noqa: PT017
    load_exploration(path)


def file(path: Path, number: int) -> None:
    """Runs the trials of an exploration file; then reads it, so that what is wrong with it is judged.

    Tasks are not planned, which takes long; what a run would refuse is looked for, now and then.
    """
    from kabo.errors import InputError
    from kabo.trials import Invalid, load_exploration_file, register, trial_findings

    register(_anything(Invalid), "tests/Anything")
    output, plans = path.parent / "made.jsonl", b"task:" in path.read_bytes()
    words = ["explore", "run", str(path), "--trials", str(0 if plans else number % 3), "-o", str(output), "--json"]
    try:
        code = answered(words, path.parent, {0, 2, 4})
        assert code != 2 or not output.exists(), "a model of a file that is refused"  # noqa: PT017
        assert code == 2 or answered(["explore", "show", str(output), "--json"], path.parent, {0}) == 0  # noqa: PT017
    finally:
        output.unlink(missing_ok=True)
    found = trial_findings(load_exploration_file(path)) if number % 4 == 0 else ()
    if found:
        raise InputError(found)


def _anything(invalid):  # type: ignore[no-untyped-def]
    return lambda case, parameters, seed: invalid("why")


def answered(words: Sequence[str], folder: Path, expected: set[int]) -> int:
    """The exit code of a command that answers with one JSON object, and leaves nothing else in its folder."""
    from kabo.cli.main import main

    said, told, here = io.StringIO(), io.StringIO(), Path.cwd()
    before = sorted(os.listdir(folder))
    try:
        os.chdir(folder)
        with redirect_stdout(said), redirect_stderr(told):
            code = main(words)
    finally:
        os.chdir(here)
    shown = f"{' '.join(words[:2])}: {told.getvalue()[-600:]}"
    assert code in expected and "defect of kabo" not in told.getvalue(), f"exit code {code}: {shown}"  # noqa: PT017
    assert isinstance(json.loads(said.getvalue()), dict), f"no JSON object: {shown}"  # noqa: PT017
    left = set(os.listdir(folder)) - set(before)
    assert code != 2 or not left, f"{left} are left behind by {shown}"  # noqa: PT017
    return code
