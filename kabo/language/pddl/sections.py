"""The sections of PDDL definitions: parses `(define …)` forms, and reports sections that kabo does not support."""

from dataclasses import dataclass, field

from kabo.language.formulas import Place
from kabo.language.pddl.forms import Document, Form, Token
from kabo.language.source import SourceFile

DOMAIN_SECTIONS = (":requirements", ":types", ":constants", ":predicates", ":functions", ":action")
PROBLEM_SECTIONS = (":domain", ":requirements", ":objects", ":init", ":goal", ":metric")
_REFUSED = {
    ":durative-action": "durative actions are",
    ":derived": "derived predicates are",
    ":axiom": "axioms (derived predicates) are",
    ":constraints": "constraints on the whole plan are",
    ":process": "processes are",
    ":event": "events are",
    ":safety": "safety constraints are",
    ":length": "limits of the plan's length are",
    ":hidden": "a hidden true state is",
    ":situation": "named situations are",
    ":goal-reward": "rewards are",
    ":htn": "task networks are",
    ":task": "task networks are",
    ":method": "task networks are",
}
_HINTS = {":hidden": "leave it out: a plan is made for every state that :init permits"}
_REQUIREMENTS = (
    ":strips", ":typing", ":negative-preconditions", ":disjunctive-preconditions", ":equality",
    ":existential-preconditions", ":universal-preconditions", ":quantified-preconditions", ":conditional-effects",
    ":adl", ":action-costs", ":numeric-fluents", ":fluents", ":object-fluents", ":contingent",
)  # fmt: skip
_OTHER_MEANING = {
    ":open-world": "what is not mentioned would be unknown",
    ":true-negation": "what is not mentioned would be unknown",
}


@dataclass
class PddlDefinition:
    """A domain or a problem of a file: its name and its sections by their keywords."""

    kind: str  # "domain" or "problem"
    name: str
    named_at: Token | Form
    document: Document
    sections: dict[str, Form] = field(default_factory=dict)
    actions: list[Form] = field(default_factory=list)

    @property
    def source(self) -> SourceFile:
        """The file that contains the definition."""
        return self.document.source

    @property
    def place(self) -> Place:
        """The place of the definition's name in the file."""
        return self.document.place(self.named_at)

    @property
    def wanted(self) -> tuple[str, Place] | None:
        """The domain that a problem names, and the place of that name; None if none is named, as in a domain."""
        section = self.first(":domain")
        word = None if section is None or len(section.items) != 2 else section.items[1]
        return (word.text, self.document.place(word)) if isinstance(word, Token) else None

    def first(self, keyword: str) -> Form | None:
        """The section with the keyword, if there is one."""
        return self.sections.get(keyword)


def definitions_of(document: Document) -> list[PddlDefinition]:
    """The domains and problems that a file defines; anything else in the file is reported."""
    found = []
    for form in document.forms:
        definition = _definition(document, form)
        if definition is not None:
            found.append(definition)
    return found


def _definition(document: Document, form: Form) -> PddlDefinition | None:
    if form.head != "define":
        written = document.text(form.items[0]) if form.items else ")"
        document.report(form, f'unexpected "({written}", expected "(define …"')
        return None
    title = form.items[1] if len(form.items) > 1 else None
    if not isinstance(title, Form) or title.head not in ("domain", "problem") or len(title.items) != 2:
        hint = "after (define stands (domain name) or (problem name)"
        document.report(title or form, 'expected "(domain name)" or "(problem name)" here', hint)
        return None
    name = title.items[1]
    if isinstance(name, Form):
        document.report(name, f"expected the name of a {title.head}")
        return None
    definition = PddlDefinition(title.head, name.text, name, document)
    for section in form.items[2:]:
        _sort_in(definition, section)
    return definition


def _sort_in(definition: PddlDefinition, section: Token | Form) -> None:
    document = definition.document
    allowed = DOMAIN_SECTIONS if definition.kind == "domain" else PROBLEM_SECTIONS
    if not isinstance(section, Form) or not section.head:
        document.report(section, f'unexpected "{document.text(section)}" in a {definition.kind}')
    elif section.head == ":action" and definition.kind == "domain":
        if len(section.items) < 2 or not isinstance(section.items[1], Token):
            document.report(section, "an action needs a name")
        else:
            definition.actions.append(section)
    elif section.head in allowed:
        if section.head in definition.sections:
            document.report(section, f'the section "{section.head}" stands twice in this {definition.kind}')
        definition.sections.setdefault(section.head, section)
        if section.head == ":requirements":
            _check_requirements(document, section)
    elif section.head in _REFUSED:
        message = f"{_REFUSED[section.head]} not supported ({section.head})"
        document.report(section, message, _HINTS.get(section.head))
    else:
        hint = document.findings.near(section.head, allowed)
        document.report(section.items[0], f'unknown section "{section.head}" of a {definition.kind}', hint)


def _check_requirements(document: Document, section: Form) -> None:
    """Requirements demand nothing: only those that would give the rest another meaning are refused."""
    for word in section.rest:
        text = word.text if isinstance(word, Token) else ""
        if text in _OTHER_MEANING:
            document.report(word, f'the requirement "{text}" is not supported: {_OTHER_MEANING[text]}')
        elif text not in _REQUIREMENTS:
            hint = document.findings.near(text, _REQUIREMENTS, all_if_few=False) if text else None
            document.report(word, f'unknown requirement "{document.text(word)}": ignored', hint, warning=True)
