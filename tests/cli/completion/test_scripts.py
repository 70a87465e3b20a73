"""Completion in real shells: commands, options, choices, and files of the kind that is expected."""

import argparse
import os
import pty
import select
import shutil
import subprocess
import time
from pathlib import Path

import pytest

from kabo.cli.completion.scripts import SHELLS, script
from kabo.cli.completion.tree import tree_of
from kabo.cli.main import COMMANDS, parser

FILES = ("a.yaml", "b.pddl", "my plan.json", "mesh.stl", "notes.txt")
# What is written, and what is offered, at least and at most.
OFFERED = {
    "kabo so": {"solve"},
    "kabo solve --se": {"--search", "--seed"},
    "kabo solve --search gr": {"greedy"},
    "kabo -q solve --json --geometry ": {"bounding", "exact", "none"},
    "kabo solve ": {"a.yaml", "b.pddl", "sub/"},
    "kabo solve --seed 3 ": {"a.yaml", "b.pddl", "sub/"},
    "kabo verify a.yaml my": {"my plan.json"},
    "kabo bound ": {"mesh.stl", "sub/"},
    "kabo task ": {"plan", "export", "show", "compare", "stages"},
    "kabo task plan --sc": {"--scene"},
    "kabo --completion z": {"zsh"},
    "kabo solve n": {"notes.txt"},
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A folder with some files, and the scripts."""
    made = tmp_path_factory.mktemp("completion")
    work = made / "work"
    (work / "sub").mkdir(parents=True)
    for name in FILES:
        (work / name).touch()
    for shell in SHELLS:
        (made / f"kabo.{shell}").write_text(script(parser(), shell))
    return made


def needs(shell: str) -> str:
    """The path of a shell; the test is skipped where there is none."""
    path = shutil.which(shell)
    if path is None:
        pytest.skip(f"this machine has no {shell}")
    return path


@pytest.mark.parametrize("written", OFFERED)
def test_bash_offers(folder, written):
    program = (
        f"source ../kabo.bash; COMP_WORDS=({_bash_words(written)}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); "
        '_kabo; printf "%s\\n" "${COMPREPLY[@]}"'
    )
    done = subprocess.run(
        [needs("bash"), "--norc", "-c", program], cwd=folder / "work", capture_output=True, text=True, check=True
    )
    assert {_with_slash(folder, line) for line in done.stdout.split("\n") if line} == OFFERED[written]
    assert done.stderr == ""


def _bash_words(written: str) -> str:
    return " ".join(f"'{word}'" for word in written.split(" "))


def _with_slash(folder: Path, name: str) -> str:
    return f"{name}/" if (folder / "work" / name).is_dir() else name


@pytest.mark.parametrize("written", OFFERED)
def test_fish_offers(folder, written):
    program = f"source ../kabo.fish; complete -C '{written}'"
    done = subprocess.run(
        [needs("fish"), "--no-config", "-c", program],
        cwd=folder / "work",
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "HOME": str(folder)},
    )
    assert {line.split("\t")[0] for line in done.stdout.splitlines()} == OFFERED[written]
    assert done.stderr == ""


@pytest.mark.parametrize("written", OFFERED)
def test_zsh_offers(folder, written):
    """In a terminal: zsh completes nowhere else. What is offered is listed; the only one there is, is inserted."""
    shown = in_zsh(needs("zsh"), folder, written)
    if len(OFFERED[written]) == 1:
        assert f"got:{min(OFFERED[written])}" in shown
        return
    for word in OFFERED[written]:
        assert word in shown
    for other in {*FILES, "solve", "verify"} - OFFERED[written] - set(written.split()):
        assert f"{other} " not in shown and f"{other}\r" not in shown


def in_zsh(shell: str, folder: Path, written: str) -> str:
    """What zsh shows when a line is written, TAB is pressed twice, and the line is run by a `kabo` that says it."""
    child, screen = pty.fork()
    if child == 0:
        os.chdir(folder / "work")
        os.execve(shell, [shell, "-f", "-i"], {"TERM": "dumb", "PATH": os.environ["PATH"], "HOME": str(folder)})
    said = "kabo() { printf 'got:%s\\n' $@ }"
    setup = (
        f"{said}; PS1='ready''> '; setopt nobeep; autoload -U compinit; compinit -u -D; source {folder}/kabo.zsh\n"
    )
    try:
        os.write(screen, setup.encode())
        _read(screen, "ready> ")
        os.write(screen, written.encode() + b"\t\t")
        shown = _read(screen, None)
        os.write(screen, b"\n")
        return shown + _read(screen, None)
    finally:
        os.kill(child, 9)
        os.waitpid(child, 0)
        os.close(screen)


def _read(screen: int, until: str | None) -> str:
    """What is shown until a text, or until nothing comes for a second and a half."""
    shown, last = "", time.monotonic()
    while time.monotonic() < last + (1.5 if until is None else 20.0):
        if select.select([screen], [], [], 0.1)[0]:
            shown += os.read(screen, 65536).decode(errors="replace")
            last = time.monotonic() if until is None else last
            if until is not None and until in shown:
                break
    return shown


@pytest.mark.parametrize("shell", SHELLS)
def test_a_script_is_sound_and_names_every_command_and_option(folder, shell):
    path = folder / f"kabo.{shell}"
    subprocess.run([needs(shell), "-n", str(path)], check=True)
    text = path.read_text()
    for command in tree_of(parser()).all():
        assert not command.path or command.path[-1] in text
        for option in command.options:
            assert all(name.lstrip("-") in text for name in option.names)


def test_a_script_is_the_same_each_time_and_is_printed_by_the_command(kabo):
    for shell in SHELLS:
        said = kabo("--completion", shell)
        assert said.code == 0 and said.out == script(parser(), shell)


def test_every_argument_with_a_path_offers_files():
    for command in tree_of(parser()).all():
        for option in command.options:
            if option.value is not None and option.value.name in ("FILE", "PNG", "OUT", "FILE.py"):
                assert option.value.endings is not None, (command.path, option.names)
    assert {command.NAME for command in COMMANDS} == {inner.path[0] for inner in tree_of(parser()).inner}


def test_help_with_any_letters_makes_sound_scripts(folder):
    """Quotes, brackets and backslashes of a help message are no syntax of a shell."""
    made = argparse.ArgumentParser(prog="kabo")
    made.add_argument("--odd", metavar="X", help='it\'s [odd]: \\ `x` $y "z" (default: 1)')
    for shell in SHELLS:
        path = folder / f"odd.{shell}"
        path.write_text(script(made, shell))
        if shutil.which(shell):
            subprocess.run([shell, "-n", str(path)], check=True)
