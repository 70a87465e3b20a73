"""PDDL declarations: types, constants, predicates, functions, and the typed lists that all of them use."""

from collections.abc import Iterator

from kabo.language.foreign_vocabulary import ANY, NUMBER, OBJECT, Bound, Kinds, Scope, Signature, Vocabulary
from kabo.language.formulas import Variable
from kabo.language.pddl.forms import Document, Form, Node, Word

_MOST_ALTERNATIVES = 64


def typed_list(document: Document, nodes: list[Node]) -> Iterator[tuple[Word, Node | None]]:
    """Every name of `a b - t c` with its type; the type is None where none is written."""
    waiting: list[Word] = []
    position = 0
    while position < len(nodes):
        node = nodes[position]
        position += 1
        if isinstance(node, Form):
            document.report(node, f'unexpected "{document.text(node)}", expected a name')
        elif node.text != "-":
            waiting.append(node)
        elif position == len(nodes):
            document.report(node, "a type must follow this hyphen")
        else:
            kind = nodes[position]
            position += 1
            if not waiting:
                document.report(node, "no name stands before this hyphen")
            for word in waiting:
                yield word, kind
            waiting = []
    for word in waiting:
        yield word, None


def read_types(document: Document, vocabulary: Vocabulary, section: Form | None) -> None:
    """Declares the types of `(:types …)`; `object` is there always, and the parent of what has none."""
    types = vocabulary.types
    written = [] if section is None else list(typed_list(document, section.rest))
    types.declare(OBJECT, None)
    declared: dict[str, Word] = {}
    for word, _ in written:
        if word.text != OBJECT and word.text not in types.known:
            types.declare(word.text, document.place(word))
            declared[word.text] = word
    for _, kind in written:  # what stands only behind a hyphen is a type as well
        if isinstance(kind, Word) and kind.text not in types.known:
            types.declare(kind.text, document.place(kind))
            declared[kind.text] = kind
    parents: dict[str, str] = {}
    for word, kind in written:
        parent = _parent(document, vocabulary, kind)
        if word.text == OBJECT:
            if parent not in (None, OBJECT):
                document.report(word, '"object" is the root of all types and has no supertype')
        elif parents.setdefault(word.text, parent or OBJECT) != (parent or OBJECT):
            message = f'the type "{word.text}" has two supertypes, "{parents[word.text]}" and "{parent}"'
            document.report(word, f"{message}: not supported", "kabo's types form a tree")
    for name in declared:
        types.parents[types.known[name]] = types.known.get(parents.get(name, OBJECT), types.known[OBJECT])
    for name, word in declared.items():
        if types.known[OBJECT] not in types.ancestors(types.known[name]):
            document.report(word, f'the type "{name}" is its own supertype')
            types.parents[types.known[name]] = types.known[OBJECT]


def _parent(document: Document, vocabulary: Vocabulary, kind: Node | None) -> str | None:
    if isinstance(kind, Form):
        if kind.head == "either" and len(kind.items) == 2 and isinstance(kind.items[1], Word):
            return kind.items[1].text
        document.report(
            kind, "a type with several supertypes (either …) is not supported", "kabo's types form a tree"
        )
        return None
    return None if kind is None else kind.text


def read_kinds(document: Document, vocabulary: Vocabulary, node: Node | None) -> Kinds | None:
    """The types that a type specifier allows: one, or those of `(either a b)`; None after a report."""
    types = vocabulary.types
    if node is None:
        return (types.known[OBJECT],)
    words = [node]
    if isinstance(node, Form):
        if node.head != "either" or len(node.items) < 2:
            document.report(node, f'unexpected "{document.text(node)}", expected a type or (either …)')
            return None
        words = node.rest
    kinds: list[str] = []
    for word in words:
        if not isinstance(word, Word):
            document.report(word, "expected the name of a type")
            return None
        if word.text not in types.known:
            hint = vocabulary.findings.near(word.text, list(types.known))
            document.report(word, f'unknown type "{word.text}"', hint)
            return None
        kinds.append(types.known[word.text])
    return tuple(dict.fromkeys(kinds))


# ------------------------------------------------------------------------------------------ predicates, functions
def read_predicates(document: Document, vocabulary: Vocabulary, section: Form | None) -> None:
    """Declares the predicates of `(:predicates …)`."""
    for node in [] if section is None else section.rest:
        signature = _signature(document, vocabulary, node, "predicate")
        if signature is not None:
            vocabulary.predicates[signature.original] = signature


def read_functions(document: Document, vocabulary: Vocabulary, section: Form | None) -> None:
    """Declares the functions of `(:functions …)`: numbers, or objects of the type behind the hyphen."""
    waiting: list[Node] = []
    nodes = [] if section is None else section.rest
    position = 0
    while position < len(nodes):
        node = nodes[position]
        position += 1
        if isinstance(node, Form):
            waiting.append(node)
            continue
        if node.text != "-" or position == len(nodes):
            document.report(node, f'unexpected "{node.text}", expected "(name …)" or "- type" in (:functions …)')
            continue
        kind = nodes[position]
        position += 1
        number = isinstance(kind, Word) and kind.text == NUMBER
        value: Kinds | None = (NUMBER,) if number else read_kinds(document, vocabulary, kind)
        _declare_functions(document, vocabulary, waiting, value or (NUMBER,))
        waiting = []
    _declare_functions(document, vocabulary, waiting, (NUMBER,))


def _declare_functions(document: Document, vocabulary: Vocabulary, nodes: list[Node], value: Kinds) -> None:
    for node in nodes:
        signature = _signature(document, vocabulary, node, "function", value)
        if signature is not None:
            vocabulary.functions[signature.original] = signature


def _signature(
    document: Document, vocabulary: Vocabulary, node: Node, role: str, value: Kinds | None = None
) -> Signature | None:
    if not isinstance(node, Form) or not node.head:
        document.report(node, f'unexpected "{document.text(node)}", expected "(name ?x - type …)" for a {role}')
        return None
    name = node.head
    kinds = [read_kinds(document, vocabulary, kind) for _, kind in typed_list(document, node.rest)]
    for taken, what in ((vocabulary.predicates, "predicate"), (vocabulary.functions, "function")):
        if name in taken:
            hint = vocabulary.declared_at(taken[name])
            document.report(node.items[0], f'"{name}" is already the name of a {what}', hint)
            return None
    arguments = tuple(ANY if each is None else each for each in kinds)
    return Signature(vocabulary.names.take(name), name, arguments, value, document.place(node.items[0]))


# -------------------------------------------------------------------------------------------- objects, variables
def read_objects(document: Document, vocabulary: Vocabulary, section: Form | None, what: str) -> None:
    """Declares the objects of `(:objects …)` or `(:constants …)`."""
    for word, kind in typed_list(document, [] if section is None else section.rest):
        kinds = read_kinds(document, vocabulary, kind) or ("",)
        if word.text.startswith("?"):
            document.report(word, f'"{word.text}" is a variable, expected the name of {what}')
        elif len(kinds) > 1:
            document.report(word, f'"{word.text}" is of several types (either …): not supported for {what}')
        elif word.text in vocabulary.objects:
            if vocabulary.objects[word.text][1] != kinds[0]:
                document.report(word, f'"{word.text}" is declared twice, with different types')
        else:
            vocabulary.objects[word.text] = (vocabulary.names.take(word.text), kinds[0])
            vocabulary.places[word.text] = document.place(word)


def read_variables(
    document: Document, vocabulary: Vocabulary, nodes: list[Node], scope: Scope, *, split: bool = True
) -> list[dict[str, Bound]]:
    """The variables of a parameter list or quantifier, by their names in the file.

    Args:
        document: where they stand.
        vocabulary: the declared names.
        nodes: the list.
        scope: the variables around it, whose names in kabo stay apart.
        split: whether (either a b) gives one alternative for a and one for b.

    Returns:
        The alternatives; several only if a variable is of several types.
    """
    alternatives: list[dict[str, Bound]] = [{}]
    for word, kind in typed_list(document, nodes):
        kinds = read_kinds(document, vocabulary, kind)
        kinds = ANY if kinds is None else kinds
        if not word.text.startswith("?") or len(word.text) < 2:
            document.report(word, f'"{word.text}" is no variable', f'write "?{word.text}"')
            continue
        if word.text in alternatives[0]:
            document.report(word, f'the variable "{word.text}" stands twice in this list')
            continue
        taken = {bound.variable.name for bound in (*scope.values(), *alternatives[0].values())}
        name = vocabulary.names.free(word.text[1:], taken)
        place = document.place(word)
        choices = [(each,) for each in kinds] if split and kinds else [kinds]
        if len(alternatives) * len(choices) > _MOST_ALTERNATIVES:
            document.report(word, "too many combinations of types (either …) in one list")
            choices = choices[:1]
        alternatives = [
            {**found, word.text: Bound(Variable(name, vocabulary.types.common(choice), place), choice)}
            for found in alternatives
            for choice in choices
        ]
    return alternatives
