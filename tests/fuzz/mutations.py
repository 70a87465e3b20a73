"""Broken texts from sound ones: seeded changes of tokens, lines, brackets, elements, JSON values and bytes.

Everything is drawn from the `random.Random` that is given, so that a case is its seed.
"""

import json
import random
import re
from collections.abc import Callable, Sequence
from typing import Any

NUMBERS = (
    *(
        "0",
        "-0",
        "1",
        "-1",
        "2",
        "3",
        "0.5",
        "-0.5",
        "1e-9",
        "1e-12",
        "1e-320",
        "1e300",
        "-1e300",
        "1e308",
        "1e999",
    ),
    *("-1e999", "nan", "NaN", "inf", "-inf", "Infinity", ".inf", ".nan", "99999999999999999999", "4294967296"),
    *("2147483648", "-2147483649", "1_000", "0x10", "1e", ".", "-", "+1", "٣", "1,5", "1 000", "true", "null", ""),
    *("9" * 400, "1/0", "1e6", "10", "1000000", "5", "90 deg", "1e300 deg", "1 2 3", "a b c", "x"),
)
WORDS = (
    *("null", "~", "true", "yes", "no", "this", "world", "any", "not", "and", "or", "forall", "exists", "K", "Kw"),
    *("Kv", "Kf", "Kx", "LCW", "Kor", "when", "then", "add", "del", "=", "!=", "<=", "=>", "in", "deg", "object"),
    *(
        "Ω",
        "é",
        "\u202e",
        "x" * 300,
        "__class__",
        "..",
        "../..",
        "/",
        "/dev/null",
        "C:",
        "%s",
        "{0}",
        "\\",
        "'",
        '"',
    ),
    *(":", "- ", "&a", "*a", "<<", "!!python/object:os.system", "|", ">", "#", "---", "...", "@", "`", "?", "\t"),
)
BYTES = (
    b"\0",
    b"\xff",
    b"\xfe\xff",
    b"\xef\xbb\xbf",
    b"\xe9",
    b"\xc3",
    b"\r",
    b"\r\n",
    b"\x85",
    b"\x1b[31m",
    b"\x0b",
)
OPEN = {"(": ")", "[": "]", "{": "}"}
_TOKEN = re.compile(r"[A-Za-z_][\w.-]*|-?\d[\d.eE+-]*|[^\s\w]")
_NUMBER = re.compile(r"-?\d+\.?\d*(?:[eE][+-]?\d+)?")
_VALUE = re.compile(r'"[^"<>\n]*"')
_ELEMENT = re.compile(r"<([\w:]+)(?:\s[^<>]*)?(?:/>|>(?:(?!<\1[\s>]).)*?</\1>)", re.DOTALL)

Change = Callable[[str, random.Random], str]


def mutated(content: bytes, rng: random.Random, others: Sequence[bytes] = ()) -> bytes:
    """A file after one to four changes; mostly of its text, sometimes of its bytes.

    Args:
        content: the sound file. rng: what all is drawn from. others: files of the same kind, to be spliced in.
    """
    if rng.random() < 0.15:
        return _of_bytes(content, rng, others)
    text = content.decode("utf-8", "replace")
    tree = _parsed(text) if text[:1] in "{[" else None
    for _ in range(rng.choice((1, 1, 1, 2, 2, 3, 4))):
        if tree is not None and rng.random() < 0.7:
            tree = _value_changed(tree, rng)
            text = json.dumps(tree)
        else:
            text = rng.choice(CHANGES)(text, rng)
            tree = None
    return text.encode("utf-8", "surrogateescape" if "\udc80" <= max(text, default="") <= "\udcff" else "replace")


# ------------------------------------------------------------------------------------------------ changes of texts
def _replaced(text: str, span: tuple[int, int], by: str) -> str:
    return text[: span[0]] + by + text[span[1] :]


def _drawn(pattern: re.Pattern[str], text: str, rng: random.Random) -> tuple[int, int]:
    """A random match of a pattern, found from a random place on; an empty span if there is none."""
    found = pattern.search(text, rng.randrange(len(text) + 1)) or pattern.search(text)
    return found.span() if found else (len(text), len(text))


def other_number(text: str, rng: random.Random) -> str:
    """A number becomes another one, or no number."""
    return _replaced(text, _drawn(_NUMBER, text, rng), rng.choice(NUMBERS))


def other_value(text: str, rng: random.Random) -> str:
    """A quoted value, as of an attribute, becomes another one."""
    return _replaced(text, _drawn(_VALUE, text, rng), f'"{rng.choice(NUMBERS + WORDS)}"')


def other_token(text: str, rng: random.Random) -> str:
    """A token becomes another one of the text, or a word of one of the languages."""
    by = rng.choice(WORDS) if rng.random() < 0.4 else text[slice(*_drawn(_TOKEN, text, rng))]
    return _replaced(text, _drawn(_TOKEN, text, rng), by)


def without_token(text: str, rng: random.Random) -> str:
    """A token is missing."""
    return _replaced(text, _drawn(_TOKEN, text, rng), "")


def token_inserted(text: str, rng: random.Random) -> str:
    """A token stands where there was none."""
    at = rng.randrange(len(text) + 1)
    return text[:at] + rng.choice(WORDS + NUMBERS) + text[at:]


def other_lines(text: str, rng: random.Random) -> str:
    """A line is missing, doubled, moved, indented otherwise or repeated often."""
    lines = text.split("\n")
    here, there = rng.randrange(len(lines)), rng.randrange(len(lines))
    kind = rng.randrange(6)
    if kind == 0:
        del lines[here]
    elif kind == 1:
        lines.insert(there, lines[here])
    elif kind == 2:
        lines[here], lines[there] = lines[there], lines[here]
    elif kind == 3:
        lines[here] = " " * rng.choice((1, 2, 4)) + lines[here]
    elif kind == 4:
        lines[here] = lines[here].lstrip()
    else:
        lines[here:here] = [lines[here]] * rng.choice((10, 60))
    return "\n".join(lines)


def other_group(text: str, rng: random.Random) -> str:
    """What stands in brackets is missing, doubled, emptied, nested or replaced by another group."""
    first = _group(text, rng)
    inner, other = text[slice(*first)], text[slice(*_group(text, rng))]
    nested = rng.choice((3, 45, 300))
    by = rng.choice(
        ("", inner + inner, f"{inner} {inner}", inner[:1] + inner[-1:], other, inner[:1] * nested + inner)
    )
    return _replaced(text, first, by)


def _group(text: str, rng: random.Random) -> tuple[int, int]:
    start = min((at for sign in OPEN if (at := text.find(sign, rng.randrange(len(text) + 1))) >= 0), default=-1)
    depth = 0
    for at in range(max(start, 0), min(len(text), start + 3000) if start >= 0 else 0):
        depth += (text[at] in OPEN) - (text[at] in OPEN.values())
        if depth == 0:
            return start, at + 1
    return len(text), len(text)


def other_element(text: str, rng: random.Random) -> str:
    """An XML element is missing, doubled, emptied or replaced by another one."""
    first = _drawn(_ELEMENT, text, rng)
    inner, other = text[slice(*first)], text[slice(*_drawn(_ELEMENT, text, rng))]
    return _replaced(
        text, first, rng.choice(("", inner + inner, other, inner.replace("/>", ">"), f"<a>{inner}</a>"))
    )


def cut_off(text: str, rng: random.Random) -> str:
    """The end is missing."""
    return text[: rng.randrange(len(text) + 1)]


CHANGES: tuple[Change, ...] = (
    *(other_number, other_number, other_value, other_token, other_token, without_token, token_inserted),
    *(other_lines, other_lines, other_group, other_element, cut_off),
)


# ------------------------------------------------------------------------------------------------ bytes and JSON
def _of_bytes(content: bytes, rng: random.Random, others: Sequence[bytes]) -> bytes:
    data = bytearray(content)
    for _ in range(rng.choice((1, 2, 5))):
        at = rng.randrange(len(data) + 1)
        kind = rng.randrange(6)
        if kind == 0 and at < len(data):
            data[at] = rng.randrange(256)
        elif kind == 1:
            data[at:at] = rng.choice(BYTES)
        elif kind == 2:
            del data[at:]
        elif kind == 3:
            del data[at : at + rng.choice((1, 2, 4, 50))]
        elif kind == 4 and others:
            other = rng.choice(others)
            data[at:] = other[rng.randrange(len(other) + 1) :]
        elif at + 4 <= len(data):
            data[at : at + 4] = rng.choice(
                (b"\xff\xff\xff\xff", b"\0\0\0\0", b"\0\0\xc0\x7f", b"\0\0\x80\xff", b"\xff\xff\x7f\x7f")
            )
    return bytes(data)


VALUES: tuple[Any, ...] = (
    *(
        None,
        True,
        False,
        0,
        -1,
        1.5,
        1e300,
        -1e300,
        1e-320,
        float("nan"),
        float("inf"),
        10**30,
        2**63,
        "",
        "x",
        "é",
    ),
    *([], {}, [[]], [0], {"x": 0}, "n0", "n1", "a" * 300, ["a", "b"], [1, 2, 3], "../../etc", "\0", "sha256:"),
)


def _parsed(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return None


def _value_changed(tree: Any, rng: random.Random) -> Any:
    """A JSON tree in which one value is another one, missing, doubled or somewhere else."""
    places: list[tuple[Any, Any]] = []
    waiting = [tree]
    while waiting:
        here = waiting.pop()
        keys = list(here) if isinstance(here, dict) else range(len(here)) if isinstance(here, list) else ()
        for key in keys:
            places.append((here, key))
            if isinstance(here[key], (dict, list)):
                waiting.append(here[key])
    if not places:
        return rng.choice(VALUES)
    owner, key = rng.choice(places)
    other, there = rng.choice(places)
    kind = rng.randrange(5)
    copy = json.loads(json.dumps(other[there]))
    if kind == 0:
        del owner[key]
    elif kind == 1:
        owner[key] = copy
    elif kind == 2 and isinstance(owner, dict):
        owner[rng.choice(("x", "", str(there), "format"))] = copy
    elif kind == 2:
        owner.insert(key, copy)
    else:
        owner[key] = json.loads(json.dumps(rng.choice(VALUES)))
    return tree
