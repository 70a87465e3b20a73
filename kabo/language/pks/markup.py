"""Parser of the markup of PKS files, which need not be XML: raw `&` and `<` in the text, and no declaration.

XML parsers reject such text. A tag is what looks like a whole tag; everything else is text. Comments become blanks
and entities their characters padded with blanks, so that every offset stays that of the file.
"""

import re
from dataclasses import dataclass, field

from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.source import SourceFile

MAX_DEPTH = 12
MAX_ELEMENTS = 100_000

_ASIDE = re.compile(r"<!--|<\?|<!DOCTYPE|<!\[CDATA\[|\]\]>", re.IGNORECASE)
_ENDS = {"<!--": "-->", "<?": "?>", "<!doctype": ">"}
_TAG = re.compile(r"""<(/?)([A-Za-z_][\w.:-]*)((?:\s+[\w.:-]+\s*=\s*(?:"[^"<>]*"|'[^'<>]*'))*)\s*(/?)>""")
_WORD = re.compile(r"\S+")
_ATTRIBUTE = re.compile(r"""([\w.:-]+)\s*=\s*(?:"([^"]*)"|'([^']*)')""")
# What comes before a sign stays behind it, so that "&lt;=" and "=&gt;" become one sign each.
_ENTITIES = {"&lt;": "   <", "&gt;": ">   ", "&amp;": "&    ", "&quot;": '"     ', "&apos;": "'     "}
_ENTITY = re.compile("|".join(_ENTITIES))


@dataclass(eq=False)
class Element:
    """An element: its attributes with their offsets, its children, and the span of its text."""

    name: str
    start: int  # of the opening tag
    attributes: dict[str, tuple[str, int]] = field(default_factory=dict)
    children: list["Element"] = field(default_factory=list)
    inside: int = 0  # where the text begins
    end: int = 0  # where the text ends
    name_length: int = 0

    def all(self, name: str) -> list["Element"]:
        """The child elements with the given name."""
        return [child for child in self.children if child.name == name]


@dataclass(eq=False)
class Markup:
    """A file parsed into elements; `text` is as long as the file, with comments and entities replaced."""

    source: SourceFile
    findings: Findings
    text: str
    roots: list[Element] = field(default_factory=list)

    def place(self, element: Element) -> Place:
        """The place of an element's name in the file."""
        return self.source.place(element.start + 1, element.start + 1 + element.name_length)

    def report(self, element: Element, message: str, hint: str | None = None) -> None:
        """Records a finding at an element."""
        self.findings.add(self.place(element), message, hint)

    def stray_text(self, element: Element) -> tuple[int, int] | None:
        """The offsets of the first word in the element's text outside of its children; None if there is none."""
        starts = [element.inside, *(child.end for child in element.children)]  # tags are blanks in the text
        ends = [*(child.start for child in element.children), element.end]
        for start, end in zip(starts, ends, strict=True):
            word = _WORD.search(self.text, start, end)
            if word is not None:
                return word.span()
        return None


def read_markup(source: SourceFile, findings: Findings) -> Markup | None:
    """Parses a file into elements; None if it cannot be parsed, which is reported."""
    findings.know(source)
    text = _without_asides(source, findings)
    if text is None:
        return None
    markup = Markup(source, findings, "")
    blanked = _read_tags(markup, text)
    if blanked is None:
        return None
    markup.text = _ENTITY.sub(lambda found: _ENTITIES[found[0]], blanked)
    if not markup.roots:
        findings.add(source.place(0), "this is no PKS file, expected <pks>, <domain> or <problem>")
        return None
    return markup


def _blank(text: str) -> str:
    return re.sub(r"[^\n]", " ", text)


def _without_asides(source: SourceFile, findings: Findings) -> str | None:
    """The text with blanks in the place of comments, declarations and the marks of CDATA."""
    text, pieces, position = source.text, list[str](), 0
    while (opening := _ASIDE.search(text, position)) is not None:
        pieces.append(text[position : opening.start()])
        closing = _ENDS.get(opening[0].lower())
        end = opening.end()
        if closing is not None:
            end = text.find(closing, end) + len(closing)
            if end < len(closing):
                findings.add(
                    source.place(*opening.span()), "this comment is never closed", f'it ends with "{closing}"'
                )
                return None
        pieces.append(_blank(text[opening.start() : end]))
        position = end
    return "".join([*pieces, text[position:]])


def _read_tags(markup: Markup, text: str) -> str | None:
    """Builds the elements; the text with blanks in the place of tags, or None after a report."""
    source, findings = markup.source, markup.findings
    opened: list[Element] = []
    pieces: list[str] = []
    position = count = 0
    for tag in _TAG.finditer(text):
        pieces += [text[position : tag.start()], _blank(tag[0])]
        position = tag.end()
        name, count = tag[2], count + 1
        if tag[1]:
            if not opened or opened[-1].name != name:
                expected = f"</{opened[-1].name}>" if opened else "no closing tag: nothing is open"
                findings.add(source.place(*tag.span()), f"unexpected </{name}>, expected {expected}")
                return None
            opened.pop().end = tag.start()
            continue
        if len(opened) >= MAX_DEPTH or count > MAX_ELEMENTS:
            limit = f"nested deeper than {MAX_DEPTH}" if count <= MAX_ELEMENTS else f"more than {MAX_ELEMENTS}"
            findings.add(source.place(*tag.span()), f"the file is refused here: elements {limit}")
            return None
        element = Element(name, tag.start(), inside=tag.end(), end=tag.end(), name_length=len(name))
        for each in _ATTRIBUTE.finditer(text, *tag.span(3)):
            value = each[2] if each[2] is not None else each[3]
            element.attributes[each[1]] = (value, each.start(2) if each[2] is not None else each.start(3))
        (opened[-1].children if opened else markup.roots).append(element)
        if not tag[4]:
            opened.append(element)
    if opened:
        markup.report(opened[-1], f"<{opened[-1].name}> is never closed", f"expected </{opened[-1].name}>")
        return None
    return "".join([*pieces, text[position:]])
