"""Whatever is done to a task file, it becomes a task or findings with places; a task that was written loads as itself."""

import os
import runpy
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from kabo.errors import Diagnostic, InputError
from kabo.language.findings import Findings
from kabo.language.source import SourceFile
from kabo.language.yaml.procedures import TASK_LIBRARY
from kabo.language.yaml.task_file import read_task_text
from kabo.tasks.files import TaskFile, task_to_yaml
from kabo.tasks.files.checking import check_task
from kabo.tasks.files.report_form import read_report

SCALE = float(os.environ.get("KABO_PROPERTY_SCALE", "1"))
REPOSITORY = Path(__file__).parents[2]
FILES = sorted(
    [*TASK_LIBRARY.glob("*.yaml"), *REPOSITORY.glob("examples/*/task.yaml"), *REPOSITORY.glob("domains/*/tasks/*")]
)
for own in REPOSITORY.glob("examples/*/stages.py"):  # they register what these task files name
    runpy.run_path(str(own))
TEXTS = [path.read_text() for path in FILES] + [
    (REPOSITORY / "tests" / "language" / "yaml" / "appendix_b.yaml").read_text()
]
PIECES = [
    "", "\n", "  ", "- ", ": ", ":", "#", "&a ", "*a", "<<: *a", "!x ", "|\n", ">", "'", '"', "[", "]", "{", "}", ",",
    "<PARENT>", "<PARENT:robot>", "<PARENT:x", "<INTERFACE:lift>", "<INTERFACE>", "name: a\n", "stage: Connect\n",
    "stages:\n", "wrapped: ", "monitors: ../..", "monitors: /", "only: up\n", "cost: {sum: {a: b}}\n", "default: ",
    "type: any", "properties: [a, a]\n", "1e999", "90 deg", "-", "\t", "\0", "é", "\ud7ff", "\u2028", "true", "null",
]  # fmt: skip


@pytest.fixture(scope="module", autouse=True)
def beside_the_model() -> Iterator[None]:
    """The tests run in the folder of the only model that these task files name."""
    before = Path.cwd()
    os.chdir(REPOSITORY / "examples" / "lifting_a_bar")
    yield
    os.chdir(before)


def read(text: str) -> tuple[TaskFile | None, list[Diagnostic]]:
    """The task file of a text, or what is wrong with it."""
    findings = Findings()
    description = read_task_text(SourceFile(Path("t.yaml"), "t.yaml", text), findings)
    recipe = None if description is None else check_task(description, findings)
    return (None if recipe is None or description is None else TaskFile(description, recipe)), findings.diagnostics


@st.composite
def mutated(draw: st.DrawFn) -> str:
    """A task file with some of its text gone, moved or replaced."""
    text = draw(st.sampled_from(TEXTS))
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(text)))
        end = min(len(text), start + draw(st.sampled_from([0, 0, 1, 2, 5, 20, 100])))
        kind = draw(st.sampled_from(["piece", "piece", "copy", "cut", "line"]))
        if kind == "piece":
            text = text[:start] + draw(st.sampled_from(PIECES)) + text[end:]
        elif kind == "copy":
            other = draw(st.sampled_from(TEXTS))
            at = draw(st.integers(0, len(other)))
            text = text[:start] + other[at : at + draw(st.integers(0, 200))] + text[end:]
        elif kind == "cut":
            text = text[: draw(st.integers(0, len(text)))]
        else:
            lines = text.splitlines(keepends=True)
            if lines:
                del lines[draw(st.integers(0, len(lines) - 1))]
            text = "".join(lines)
    return text


def check(text: str) -> bool:
    """The law for one text; whether it is a task."""
    file, found = read(text)
    assert all(each.line >= 1 and each.column >= 1 and each.message and each.file == "t.yaml" for each in found)
    if file is None:
        assert any(each.severity == "error" for each in found)
        return False
    try:
        task = file.task(partly=True)
        task.tree()
        written = task_to_yaml(task, max_solutions=file.max_solutions, timeout=file.timeout)
    except InputError:
        return True
    again, said = read(written)
    assert again is not None, f"{written}\n{said}"
    loaded = again.task(partly=True)
    assert loaded.tree() == task.tree()
    assert task_to_yaml(loaded, max_solutions=again.max_solutions, timeout=again.timeout) == written
    return True


@pytest.mark.parametrize("text", TEXTS[:-1], ids=[path.relative_to(REPOSITORY).as_posix() for path in FILES])
def test_every_task_file_of_ours_loads_and_is_itself_when_written(text: str) -> None:
    assert read(text)[1] == [] and check(text)


@given(text=mutated())
@settings(max_examples=int(250 * SCALE))
def test_a_mutated_file_is_a_task_or_findings(text: str) -> None:
    event("loaded" if check(text) else "refused")


@given(text=st.sampled_from(TEXTS), share=st.floats(0, 1))
@settings(max_examples=int(60 * SCALE))
def test_a_truncated_file_is_a_task_or_findings(text: str, share: float) -> None:
    check(text[: int(share * len(text))])


@given(content=st.binary(max_size=200) | st.text(max_size=200).map(str.encode))
@settings(max_examples=int(100 * SCALE))
def test_what_is_no_report_is_told(content: bytes) -> None:
    with pytest.raises(InputError):
        read_report(content, "r.json")
