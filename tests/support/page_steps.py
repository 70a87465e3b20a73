"""Pages whose commands and files run as tests: each fenced block that a comment marks is one step of a reader.

A comment stands in the line before a block, and is not seen by readers:

    <!-- step: write FILE -->       the block is the file
    <!-- step: append FILE -->      the block comes at the end of the file
    <!-- step: replace FILE -->     each line of the block replaces the line that begins with the same key
    <!-- step: run [exit N] -->     the lines of the block are commands; the last one ends with N (0)
    <!-- step: output -->           lines that the block before it printed, in this order; `…` alone stands for others
    <!-- step: background WORDS --> the block is a command that goes on until the page ends; wait until it prints WORDS
    <!-- step: check FILE -->       the block is the file, and `kabo check` finds nothing wrong with it
    <!-- step: python -->           the Python blocks of a page are one program, which runs after all other steps
    <!-- step: not run[, WHY] -->   nothing

A last word that is one of the page's variants (`panda`, `tiago`) says that the step is for readers of that variant only.
"""

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from tests.support.forked_commands import run_kabo

REPOSITORY = Path(__file__).parents[2]
_STEP = re.compile(r"^<!-- step: (.*?) -->\n```\w*\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_BLOCK = re.compile(r"^```(sh|yaml|json5?|python|pddl)\n", re.MULTILINE)
_SOLVE = re.compile(r"kabo solve (?:domains|examples)/[a-z_0-9/]+\.yaml -o ([a-z_]+\.json)$")
_KEPT: dict[str, tuple[str, bytes]] = {}  # by such a command: what it prints, and the plan
SECONDS = 300  # for one command; far more than any needs


@dataclass(frozen=True)
class Step:
    """One block of a page: what is done with it, the words behind that, and its text."""

    verb: str
    words: tuple[str, ...]
    text: str


def steps(
    page: Path, *, variants: Sequence[str] = (), variant: str = "", other: Mapping[str, str] = MappingProxyType({})
) -> list[Step]:
    """The steps of a page for the readers of one variant, in order; each text with other words than the page has."""
    found = []
    for header, text in _STEP.findall(page.read_text()):
        for word, instead in other.items():
            text = text.replace(word, instead)
        verb, *words = header.split()
        if words and words[-1] in variants and words.pop() != variant:
            continue
        found.append(Step(verb, tuple(words), text))
    return found


def unmarked(page: Path) -> int:
    """How many blocks of commands, files or code of a page are marked by no comment."""
    return len(_BLOCK.findall(_STEP.sub("", page.read_text())))


def follow(found: Iterable[Step], folder: Path) -> None:
    """Does what a page says, in a folder; an AssertionError names the command that did something else."""
    printed = ""
    found = list(found)
    with ExitStack() as background:
        for step in found:
            printed = _do(step, folder, printed, background)
        if programs := [step.text for step in found if step.verb == "python"]:
            (folder / "page.py").write_text("\n".join(programs))
            _command("python page.py", folder, 0)


def _do(step: Step, folder: Path, printed: str, background: ExitStack) -> str:
    """Does one step; gives what the last command printed."""
    if step.verb == "run":
        return _run(step, folder)
    if step.verb == "background":
        _start(step, folder, background)
    elif step.verb == "output":
        _compare(step.text, printed)
    elif step.verb == "check":
        (folder / step.words[0]).write_text(step.text)
        _command(f"kabo check {step.words[0]}", folder, 0)
    elif step.verb not in ("not", "python"):
        _change(step, folder / step.words[0])
    return printed


def _start(step: Step, folder: Path, background: ExitStack) -> None:
    """Starts a command, and returns when it has printed the words of the step; it ends with the page."""
    process = background.enter_context(
        subprocess.Popen(  # noqa: S603
            [*_PROGRAMS["kabo"], *shlex.split(step.text)[1:]],
            cwd=folder,
            env=environment(),
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
    )
    background.callback(process.terminate)
    assert process.stdout is not None
    said = []
    for line in process.stdout:
        said.append(line)
        if " ".join(step.words) in line:
            return
    raise AssertionError(f"{step.text}ended with: {''.join(said)}")


def environment() -> dict[str, str]:
    """The variables with which a command finds this kabo from any folder, and as much room as an output needs."""
    return {**os.environ, "PYTHONUNBUFFERED": "1", "COLUMNS": "200"}


def _change(step: Step, file: Path) -> None:
    """Writes a file, or changes one that the page has written before."""
    file.parent.mkdir(parents=True, exist_ok=True)
    if step.verb == "write":
        file.write_text(step.text)
    elif step.verb == "append":
        file.write_text(file.read_text() + step.text)
    elif step.verb == "replace":
        text = file.read_text()
        for line in step.text.splitlines():
            text, count = re.subn(
                rf"^{re.escape(line.split(':')[0])}:.*$", lambda _, new=line: new, text, flags=re.M
            )
            assert count == 1, f"{count} lines of {file.name} begin as: {line}"
        file.write_text(text)
    else:
        raise AssertionError(f"a page has a step of no kind: {step.verb}")


def _run(step: Step, folder: Path) -> str:
    """What the commands of a block print, after the last one ended with the code that the step says."""
    wanted = int(step.words[1]) if step.words[:1] == ("exit",) else 0
    *before, last = [line for line in step.text.replace("\\\n", " ").splitlines() if line and line[0] != "#"]
    printed = "".join(_command(line, folder, 0) for line in before)
    return printed + _command(last, folder, wanted)


def _command(line: str, folder: Path, wanted: int) -> str:
    """What a command prints; pages are written, and no browser is opened.

    A problem of the repository that another step has solved is not solved again: the plan is the same byte for byte.
    """
    if wanted != 0 or (solved := _SOLVE.match(line)) is None:
        return _done(line, folder, wanted)
    if line not in _KEPT:
        printed = _done(line, folder, wanted)
        _KEPT[line] = printed, (folder / solved[1]).read_bytes()
    (folder / solved[1]).write_bytes(_KEPT[line][1])
    return _KEPT[line][0]


def _done(line: str, folder: Path, wanted: int) -> str:
    """What a command prints, which ends with the code that is wanted."""
    line = re.sub(r"^kabo view ", "kabo view --no-open ", line)
    if line.startswith("kabo ") and not _SHELL.search(line):
        did = run_kabo(shlex.split(line)[1:], folder, environment(), SECONDS)
        return _printed(line, did.returncode, did.stdout, did.stderr, wanted)
    line = re.sub(r"^(kabo|python)\b", lambda word: shlex.join(_PROGRAMS[word[0]]), line)
    done = subprocess.run(  # noqa: S602 - the pages are ours, and pipe and redirect as a reader does
        line,
        shell=True,
        cwd=folder,
        env=environment(),
        capture_output=True,
        text=True,
        timeout=SECONDS,
        check=False,
    )
    return _printed(line, done.returncode, done.stdout, done.stderr, wanted)


def _printed(line: str, code: int, stdout: str, stderr: str, wanted: int) -> str:
    """What a command printed, if it ended with the code that is wanted."""
    assert code == wanted, f"{line}\n{stdout}{stderr}"
    assert "Traceback" not in stderr, f"{line}\n{stderr}"
    return stdout + stderr


_SHELL = re.compile(r"[|&;<>*?$`~{}()#]")  # what a shell does more with than to split words
_PROGRAMS = {"kabo": [sys.executable, "-m", "kabo.cli"], "python": [sys.executable]}


def _compare(text: str, printed: str) -> None:
    """Asserts that the lines of a page are among those printed, in this order."""
    left = iter(line.rstrip() for line in printed.splitlines())
    for line in text.splitlines():
        assert line.strip() in ("", "…") or line.rstrip() in left, f"the page says: {line}\nprinted is:\n{printed}"
