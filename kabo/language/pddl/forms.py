"""S-expressions with their places: the outer shape of PDDL files, read without recursion and within limits."""

import re
from dataclasses import dataclass

from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.source import SourceFile

MAX_DEPTH = 60
MAX_FORMS = 1_000_000

_TOKEN = re.compile(r";[^\n]*|[()]|[^\s();]+")
_UNPRINTABLE = re.compile(r"[\x00-\x08\x0e-\x1f\x7f]")


@dataclass(eq=False, slots=True)
class Token:
    """A word in lower case: a name, a variable, a keyword or a number."""

    text: str
    start: int

    @property
    def end(self) -> int:
        """The offset behind the word."""
        return self.start + len(self.text)


@dataclass(eq=False, slots=True)
class Form:
    """A list in parentheses: words and further forms."""

    items: list["Token | Form"]
    start: int
    end: int

    @property
    def head(self) -> str:
        """The first word; empty if there is none."""
        first = self.items[0] if self.items else None
        return first.text if isinstance(first, Token) else ""

    @property
    def rest(self) -> list["Token | Form"]:
        """The items behind the first one."""
        return self.items[1:]


Node = Token | Form


@dataclass(frozen=True, eq=False)
class Document:
    """A PDDL file parsed into forms, with the collection that receives errors and warnings about the file."""

    source: SourceFile
    findings: Findings
    forms: list[Form]

    def place(self, node: Node) -> Place:
        """The place of a node, up to the end of its first line."""
        return self.source.place(node.start, node.end)

    def report(self, node: Node, message: str, hint: str | None = None, *, warning: bool = False) -> None:
        """Records a finding at a node."""
        self.findings.add(self.place(node), message, hint, warning=warning)

    def text(self, node: Node) -> str:
        """The text of a node in the file, on one line, shortened if it is long."""
        written = " ".join(self.source.text[node.start : node.end].split())
        return written if len(written) <= 60 else f"{written[:57]}…"


def read_forms(source: SourceFile, findings: Findings) -> Document | None:
    """Parses a file into forms; None if it cannot be parsed, which is reported."""
    findings.know(source)
    outermost: list[Node] = []
    opened: list[Form] = []
    items, count = outermost, 0
    for token in _TOKEN.finditer(source.text):
        text, start = token[0], token.start()
        first = text[0]
        if first == ";":
            continue
        count += 1
        if first == "(":
            form = Form([], start, start + 1)
            if len(opened) >= MAX_DEPTH or count > MAX_FORMS:
                limit = f"nested deeper than {MAX_DEPTH} levels" if count <= MAX_FORMS else "too many words"
                findings.add(source.place(start), f"the file is refused here: {limit}")
                return None
            items.append(form)
            opened.append(form)
            items = form.items
        elif first == ")":
            if not opened:
                findings.add(source.place(start), 'unexpected ")": no parenthesis is open here')
                return None
            opened.pop().end = start + 1
            items = opened[-1].items if opened else outermost
        else:
            items.append(Token(text.lower(), start))
    if opened:
        hint = "the file ends before it is closed" if len(opened) == 1 else f"{len(opened)} are open at the end"
        findings.add(source.place(opened[-1].start), "this parenthesis is never closed", hint)
        return None
    return _document(source, findings, outermost)


def _document(source: SourceFile, findings: Findings, nodes: list[Node]) -> Document | None:
    for node in nodes:
        if isinstance(node, Token):
            word = _UNPRINTABLE.sub("�", node.text[:40])
            findings.add(source.place(node.start, node.end), f'unexpected "{word}", expected "(define …"')
            return None
    if not nodes:
        findings.add(source.place(0), 'the file is empty, expected "(define …"')
        return None
    return Document(source, findings, [node for node in nodes if isinstance(node, Form)])
