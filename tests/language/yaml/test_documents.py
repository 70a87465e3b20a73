"""YAML as marked text: limits, what is refused, and that nothing is ever expanded."""
# ruff: noqa: E501 (messages stand on one line, as they are printed)

from pathlib import Path

import pytest

from kabo.errors import Diagnostic
from kabo.language import check_files
from kabo.language.findings import Findings
from kabo.language.source import read_source
from kabo.language.yaml.documents import MAX_DEPTH, MAX_NODES, Mapping, Scalar, Sequence, read_document
from tests.language.conftest import DOMAIN, Kitchen


def read(folder: Path, text: str | bytes) -> tuple[Mapping | None, list[Diagnostic]]:
    path = folder / "file.yaml"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    findings = Findings()
    return read_document(read_source(path, "file.yaml"), findings), findings.diagnostics


def only(diagnostics: list[Diagnostic]) -> tuple[int, int, str]:
    (one,) = diagnostics
    return one.line, one.column, one.message


def test_scalars_keep_their_text_whatever_yaml_would_make_of_it(tmp_path: Path) -> None:
    root, found = read(tmp_path, "on: yes\nn: 010\nt: 1:30\nd: 2024-01-01\ne: 1e-3\nnull: ~\nq: 'a b'\nempty:\n")
    assert root is not None and not found
    texts = {key: value.text for key, (_, value) in root.entries.items() if isinstance(value, Scalar)}
    expected = {"on": "yes", "n": "010", "t": "1:30", "d": "2024-01-01", "e": "1e-3", "null": "~", "q": "a b"}
    assert texts == expected | {"empty": ""}


def test_every_node_knows_its_place(tmp_path: Path) -> None:
    root, _ = read(tmp_path, "a: [x, {b: yy}]\n")
    assert root is not None
    inner = root.get("a")
    assert isinstance(inner, Sequence) and inner.flow
    mapping = inner.items[1]
    assert isinstance(mapping, Mapping)
    value = mapping.get("b")
    assert value is not None
    assert (value.place.line, value.place.column, value.place.length) == (1, 12, 2)


@pytest.mark.parametrize(
    ("text", "line", "column", "message"),
    [
        ("", 1, 1, "the file is empty"),
        ("# nothing\n", 1, 1, "the file is empty"),
        ("- a\n- b\n", 1, 1, "the file must be a mapping: lines of the form `key: value`"),
        ("word\n", 1, 1, "the file must be a mapping: lines of the form `key: value`"),
        ("a: 1\nb: 2\na: 3\n", 3, 1, 'duplicate key "a"'),
        ("a: {b: 1, b: 2}\n", 1, 11, 'duplicate key "b"'),
        ("a: !!python/object/apply:os.system [x]\n", 1, 4, 'the tag "tag:yaml.org,2002:python/object/apply:os.system" is not allowed'),
        ("a: !x y\n", 1, 4, 'the tag "!x" is not allowed'),
        ("a: !!str y\n", 1, 4, 'the tag "tag:yaml.org,2002:str" is not allowed'),
        ("a: &x y\n", 1, 4, 'the anchor "x" is not allowed in this file'),
        ("a: *x\n", 1, 4, 'the alias "x" is not allowed in this file'),
        ("<<: {a: 1}\n", 1, 1, 'the merge key "<<" is not allowed'),
        ("[a]: 1\n", 1, 1, "a key must be a word"),
        ("a: 1\n---\nb: 2\n", 2, 1, "a second document begins here; a file holds one"),
        ("a: [1, 2\n", 2, 1, 'the YAML is broken here: did not find expected "," or "]" (while parsing a flow sequence)'),
        ("a:\n\t- b\n", 2, 1, "the YAML is broken here: found character that cannot start any token (while scanning for the next token)"),
        ("a: b: c\n", 1, 5, "the YAML is broken here: mapping values are not allowed in this context"),
        ("a: *(b)\n", 1, 4, "the YAML is broken here: did not find expected alphabetic or numeric character (while scanning an alias)"),
        ("a: \x07\n", 1, 4, "the character U+0007 is not allowed in YAML"),
    ],
)  # fmt: skip
def test_what_is_no_plain_data_is_refused_where_it_stands(
    tmp_path: Path, text: str, line: int, column: int, message: str
) -> None:
    _, found = read(tmp_path, text)
    assert only(found) == (line, column, message)


def test_a_tab_is_called_a_tab(tmp_path: Path) -> None:
    _, found = read(tmp_path, "a:\n\t- b\n")
    assert found[0].hint == "this is a tab: indent with blanks"


def test_forty_levels_are_read_and_one_more_is_refused(tmp_path: Path) -> None:
    fits, found = read(tmp_path, "a: " + "[" * (MAX_DEPTH - 1) + "]" * (MAX_DEPTH - 1))
    assert fits is not None and not found
    _, found = read(tmp_path, "a: " + "[" * MAX_DEPTH + "]" * MAX_DEPTH)
    assert only(found) == (1, MAX_DEPTH + 3, "nested deeper than 40 levels")


@pytest.mark.parametrize("opening", ["[", "{a: ", "- "])
def test_a_hundred_thousand_levels_do_not_overflow_the_stack(tmp_path: Path, opening: str) -> None:
    root, found = read(tmp_path, ("" if opening == "- " else "a: ") + opening * 100_000)
    assert root is None and only(found)[2] == "nested deeper than 40 levels"


def test_an_alias_bomb_is_refused_without_being_expanded(tmp_path: Path) -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 30)]
    root, found = read(tmp_path, "\n".join(lines))
    assert root is not None
    assert len(found) == 30 + 29 * 10


def test_a_file_with_too_many_values_is_refused(tmp_path: Path) -> None:
    root, found = read(tmp_path, "a: [" + "x," * (MAX_NODES + 1) + "]")
    assert root is None and found[0].message == f"the file has more than {MAX_NODES} values"


def test_windows_line_ends_and_a_byte_order_mark_do_not_move_any_place(kitchen: Kitchen) -> None:
    spoiled = kitchen.spoil("domain", "K(not grasped(o))", "K(not «graspd»(o))")
    path = kitchen.folder / "domain.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n"))
    (one,) = check_files([path])
    assert (one.line, one.column, one.length) == (spoiled.line, spoiled.column, spoiled.length)
    assert one.source == "      - K(not graspd(o))"


def test_letters_beyond_ascii_do_not_move_any_place(kitchen: Kitchen) -> None:
    kitchen.write(domain="# ä → 𝔸\n" + DOMAIN.replace("K(not grasped(o))", "K(not graspd(o)) # ä"))
    (one,) = check_files([kitchen.folder / "domain.yaml"])
    assert (one.line, one.column) == (23, 15)


def test_a_line_of_many_characters_is_not_shown(tmp_path: Path) -> None:
    _, found = read(tmp_path, "a: 1\na: " + "x" * 5000)
    assert found[0].source is None
