"""Whatever is done to valid files, reading them ends in a problem or in an InputError with places that exist."""

import tempfile
from pathlib import Path

from hypothesis import event, given
from hypothesis import strategies as st

from kabo.errors import InputError
from kabo.language import check_files, load_problem
from tests.language.conftest import DOMAIN, PROBLEM, SCENE, Kitchen

TEXTS = {"domain": DOMAIN, "scene": SCENE, "problem": PROBLEM}
WORDS = sorted({word for text in TEXTS.values() for word in text.replace(",", " ").split()})
PIECES = st.one_of(
    st.sampled_from(
        [
            "(",
            ")",
            "[",
            "]",
            "{",
            "}",
            ":",
            ",",
            "- ",
            "\n",
            "\t",
            "  ",
            "#",
            "'",
            '"',
            "&a ",
            "*a",
            "!x ",
            "=>",
            "=",
        ]
        + [
            "not ",
            "K(",
            "forall(bottle b) ",
            "1e999",
            "-1",
            "nan",
            "deg",
            "\0",
            "\ud7ff",
            "é",
            "\x85",
            "\u2028",
            "|",
            ">",
        ]
        + ["<<: ", "---\n", "%TAG", "? ", "model: bottle", "frame: tray", "{}", "[]", "''", "."]
    ),
    st.sampled_from(WORDS),
    st.text(max_size=3),
)


@st.composite
def spoiled_texts(draw: st.DrawFn) -> dict[str, str]:
    """The three files; one of them is cut, or has pieces removed, doubled, moved or put in."""
    name = draw(st.sampled_from(sorted(TEXTS)))
    text = TEXTS[name]
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(text)))
        end = min(len(text), start + draw(st.integers(0, 30)))
        how = draw(st.sampled_from(["cut", "remove", "double", "insert", "replace", "line"]))
        if how == "cut":
            text = text[:start]
        elif how == "remove":
            text = text[:start] + text[end:]
        elif how == "double":
            text = text[:end] + text[start:end] + text[end:]
        elif how == "insert":
            text = text[:start] + draw(PIECES) + text[start:]
        elif how == "replace":
            text = text[:start] + draw(PIECES) + text[end:]
        else:
            lines = text.splitlines(keepends=True) or [""]
            line = lines.pop(draw(st.integers(0, len(lines) - 1)))
            lines.insert(draw(st.integers(0, len(lines))), line)
            text = "".join(lines)
    return {name: text.encode("utf-8", "replace").decode()}


@given(changed=spoiled_texts())
def test_spoiled_files_give_a_problem_or_findings_at_places_that_exist(changed: dict[str, str]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        kitchen = Kitchen(Path(folder))
        path = kitchen.write(**changed)
        try:
            load_problem(path)
            event("still a problem")
            found = check_files([path])
            assert all(each.severity == "warning" for each in found)
        except InputError as error:
            event(f"refused with {min(3, len(error.diagnostics))} or more findings")
            if "a problem is needed" not in error.diagnostics[0].message:
                assert list(error.diagnostics) == check_files([path])
            for each in error.diagnostics:
                lines = (Path(each.file).read_bytes().decode().removeprefix("\ufeff") + " ").replace("\r\n", "\n")
                text = lines.replace("\r", "\n").split("\n")
                assert 1 <= each.line <= len(text)
                assert 1 <= each.column <= len(text[each.line - 1]) + 1
                assert each.message and str(each)


@given(data=st.binary(max_size=200))
def test_any_bytes_at_all_give_findings(data: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "file.yaml"
        path.write_bytes(data)
        assert check_files([path])
