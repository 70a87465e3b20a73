"""Builds a Problem from the elements of PKS files: symbols, actions, update rules, initial knowledge, goal."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from kabo.language import formulas as f
from kabo.language.definitions import Definition
from kabo.language.expressions import Expression
from kabo.language.findings import Findings
from kabo.language.names import Names
from kabo.language.pks.actions import read_action
from kabo.language.pks.declarations import DECLARED, numeric_functions, read_constants, read_symbols, read_types
from kabo.language.pks.dialect import resolver_of
from kabo.language.pks.effects import read_effects
from kabo.language.pks.expressions import statements, tokens_of
from kabo.language.pks.formulas import read_formula
from kabo.language.pks.markup import Element, Markup, read_markup
from kabo.language.problem import Action, Domain, Problem
from kabo.language.source import SourceFile
from kabo.language.vocabulary import Symbol, Vocabulary

_ALLOWED = {
    "pks": ("domain", "problem"),
    "domain": ("symbols", "actions", "action", "updates", "types", "predicates", "functions", "constants"),
    "problem": ("symbols", "objects", "constants", "init", "goal", "updates"),
    "symbols": ("types", "predicates", "functions", "constants", "objects"),
    "actions": ("action",),
    "action": ("params", "preconds", "effects"),
    "updates": ("update",),
}
_TEXTS = (
    "types", "predicates", "functions", "constants", "objects", "params", "preconds", "effects", "init", "goal",
    "updates", "update",
)  # fmt: skip
_FACTS_AT_ONCE = 100
_REFUSED = {"dsu": "updates", "dsur": "updates", "preconditions": "preconds", "parameters": "params"}


@dataclass
class PksDefinition:
    """A domain or a problem of a PKS file."""

    kind: str
    name: str
    markup: Markup
    element: Element
    texts: dict[int, list[Expression]] = field(default_factory=dict)  # statements by where their text begins

    @property
    def source(self) -> SourceFile:
        """The file that contains the definition."""
        return self.markup.source

    @property
    def place(self) -> f.Place:
        """The place of the definition's element in the file."""
        return self.markup.place(self.element)

    @property
    def wanted(self) -> tuple[str, f.Place] | None:
        """The domain that a problem names, and the place of that name; an empty name accepts any domain."""
        if "domain" not in self.element.attributes:
            return "", self.place
        name, start = self.element.attributes["domain"]
        return name, self.source.place(start, start + max(1, len(name)))

    def all(self, name: str) -> list[Element]:
        """The elements with the given name, at any depth."""
        found, waiting = [], [self.element]
        while waiting:
            here = waiting.pop()
            found += [here] if here.name == name else []
            waiting.extend(reversed(here.children))
        return found

    def statements(self, element: Element) -> list[Expression]:
        """The statements in an element's text, parsed once."""
        if element.inside not in self.texts:
            self.texts[element.inside] = list(statements(self.markup, element.inside, element.end))
        return self.texts[element.inside]


class Pks:
    """The reader of PKS files."""

    def definitions(self, source: SourceFile, findings: Findings) -> list[Definition]:
        """All domains and problems of a file; anything else in it is reported."""
        markup = read_markup(source, findings)
        found: list[Definition] = []
        for root in [] if markup is None else markup.roots:
            assert markup is not None
            for element in root.children if root.name == "pks" else [root]:
                if element.name in ("domain", "problem"):
                    _check_elements(markup, element)
                    name = element.attributes.get("name", ("", 0))[0]
                    found.append(PksDefinition(element.name, name, markup, element))
                else:
                    markup.report(element, f"unexpected <{element.name}>, expected <domain> or <problem>")
        return found

    def read(
        self, domain: Definition, problem: Definition | None, findings: Findings, files: Mapping[str, str]
    ) -> Problem | None:
        """The problem of two definitions; None for a domain alone, which is only checked."""
        assert isinstance(domain, PksDefinition)
        assert problem is None or isinstance(problem, PksDefinition)
        vocabulary = Vocabulary(findings)
        constants = _declare(vocabulary, [domain] if problem is None else [domain, problem])
        actions = _actions(vocabulary, domain)
        rules = [each for part in (domain, problem) if part is not None for each in _rules(vocabulary, part)]
        built = Domain(
            Names().take(domain.name or "domain"), vocabulary.types.in_order(), constants,
            vocabulary.predicates_of_domain(), vocabulary.functions_of_domain(), tuple(rules), actions, domain.source.path,
        )  # fmt: skip
        if problem is None:
            return None
        vocabulary.report_renamed()
        name = Names().take(problem.name or "problem")
        return Problem(
            name, built, vocabulary.types_of_objects(), _initial(vocabulary, problem),
            _goal(vocabulary, problem), {}, None, problem.source.path, dict(files),
        )  # fmt: skip


def _check_elements(markup: Markup, element: Element) -> None:
    """Reports elements and texts where none may stand."""
    allowed = _ALLOWED.get(element.name, ())
    for child in element.children:
        if child.name in allowed:
            _check_elements(markup, child)
        else:
            hint = f"write <{_REFUSED[child.name]}>" if child.name in _REFUSED else None
            hint = hint or markup.findings.near(child.name, allowed, all_if_few=bool(allowed))
            markup.report(child, f"unexpected <{child.name}> in <{element.name}>", hint)
    if element.name not in _TEXTS:
        stray = markup.stray_text(element)
        if stray is not None:
            written = markup.text[slice(*stray)][:40]
            markup.findings.add(markup.source.place(*stray), f'unexpected "{written}" in <{element.name}>')


# ---------------------------------------------------------------------------------------------------- declarations
def _declare(vocabulary: Vocabulary, parts: list[PksDefinition]) -> dict[str, str]:
    """Declares everything; returns the domain's constants with their types."""
    types = [(part, element) for part in parts for element in part.all("types")]
    read_types(parts[0].markup, vocabulary, [element for part, element in types if part is parts[0]])
    named = frozenset(
        token.text
        for part in parts
        for element in [*part.all("constants"), *part.all("objects")]
        for token in tokens_of(part.markup, element.inside, element.end)
    )
    numeric = numeric_functions((each for part in parts for each in _expressions(part)), named)
    for part in parts:
        for role in DECLARED:
            for element in part.all(f"{role}s"):
                read_symbols(part.markup, vocabulary, element, role, numeric)
    constants: dict[str, str] = {}
    for part in parts:
        for element in [*part.all("constants"), *part.all("objects")]:
            read_constants(part.markup, vocabulary, element)
        if part is parts[0]:
            constants = vocabulary.types_of_objects()
    return constants


def _expressions(part: PksDefinition) -> Iterator[Expression]:
    for name in ("preconds", "effects", "init", "goal", "update"):
        for element in part.all(name):
            yield from part.statements(element)
    for element in part.all("updates"):
        if not element.children:
            yield from part.statements(element)


# -------------------------------------------------------------------------------------------------- what they say
def _actions(vocabulary: Vocabulary, domain: PksDefinition) -> dict[str, Action]:
    names, actions, seen = Names(), dict[str, Action](), set[str]()
    for element in domain.all("action"):
        name = element.attributes.get("name", ("", 0))[0]
        if not name or name in seen:
            message = f'the action "{name}" is defined twice' if name else 'an action needs a name: name="…"'
            domain.markup.report(element, message)
            continue
        seen.add(name)
        where = resolver_of(domain.markup, vocabulary, f'in action "{name}"')
        for action in read_action(where, domain.markup, element, name, domain.statements, names):
            actions[action.name] = action
    return actions


def _rules(vocabulary: Vocabulary, part: PksDefinition) -> Iterator[f.Effect]:
    """The update rules; variables that nobody binds stand for all instances."""
    for element in [each for outer in part.all("updates") for each in outer.children or [outer]]:
        for node in part.statements(element):
            free: dict[str, Symbol] = {}
            here = resolver_of(part.markup, vocabulary, "in an update rule", free)
            rules = read_effects(here, node)
            variables = tuple(each.variable for each in free.values())
            if variables and rules:
                yield f.ForEach(variables, tuple(rules), here.place(node))
            else:
                yield from rules


def _initial(vocabulary: Vocabulary, problem: PksDefinition) -> tuple[f.Effect, ...]:
    here = resolver_of(problem.markup, vocabulary, "in <init>")
    nodes = [node for element in problem.all("init") for node in problem.statements(element)]
    effects = [each for node in nodes for each in read_effects(here, node, conditional=False)]
    return _together(effects)


def _together(effects: list[f.Effect]) -> tuple[f.Effect, ...]:
    """The updates with neighbouring additions to Kf joined, so that a long list is not many small steps.

    What speaks of the same atom or term stays apart: there the order matters.
    """
    found: list[f.Effect] = []
    facts: list[f.Fact] = []
    mentioned: set[object] = set()

    def finish() -> None:
        if facts:
            found.append(f.Change("add", "Kf", tuple(facts), getattr(facts[0], "place", None)))
        facts.clear()
        mentioned.clear()

    for effect in effects:
        simple = isinstance(effect, f.Change) and (effect.operation, effect.database) == ("add", "Kf")
        about = [_about(fact) for fact in effect.facts] if isinstance(effect, f.Change) and simple else [None]
        if None in about or len(facts) >= _FACTS_AT_ONCE or not mentioned.isdisjoint(about):
            finish()
        if isinstance(effect, f.Change) and None not in about:
            facts += effect.facts
            mentioned.update(about)
        else:
            found.append(effect)
    finish()
    return tuple(found)


def _about(fact: f.Fact) -> f.Atom | f.Term | None:
    if isinstance(fact, f.Literal):
        return fact.atom
    return fact.left if isinstance(fact, f.Comparison) else None


def _goal(vocabulary: Vocabulary, problem: PksDefinition) -> tuple[f.Formula, ...]:
    here = resolver_of(problem.markup, vocabulary, "in <goal>")
    elements = problem.all("goal")
    if not elements:
        problem.markup.report(problem.element, "a problem needs <goal>")
    found: list[f.Formula] = []
    for node in [node for element in elements for node in problem.statements(element)]:
        formula = read_formula(here, node, goal=True)
        if formula is not None:
            found += formula.parts if isinstance(formula, f.And) else [formula]
    return tuple(found)
