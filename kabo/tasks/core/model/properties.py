"""Properties of stages: declared, typed, with defaults; inherited only where a value refers to a parent [T 3.2.5, 3.3.2].

A value may be a reference, also inside lists and mappings: to the nearest ancestor with that property, or to the
interface state of a job (resolved again for each job). A reference without a name refers to the property of the same
name.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from kabo.tasks.core.model.errors import UndeclaredProperty, UndefinedProperty, meant


class _Missing:
    def __repr__(self) -> str:
        return "MISSING"

    def __reduce__(self) -> str:
        return "MISSING"


MISSING = _Missing()
_PLAIN = frozenset((str, int, float, bool, type(None), _Missing))  # types of values that hold no reference


@dataclass(frozen=True)
class Property:
    """A declared property of a stage; a property without a default must be given a value.

    `wrong` returns why a value of the right type is invalid, or None; invalid values are refused as soon as they are
    known, in task files with their place. `doc` says what an empty value means where it is allowed. `opens` makes the value
    of a path and of the folder that it is relative to: task files give the path, always as text.
    """

    type: Any = Any
    default: Any = MISSING
    doc: str = ""
    wrong: "Callable[[Any], str | None] | None" = None
    opens: "Callable[[str, str], Any] | None" = None

    def accepts(self, value: Any) -> bool:
        """Whether a value has the declared type; integers are accepted as numbers."""
        if self.type is Any or value is None:
            return True
        kinds = self.type if isinstance(self.type, tuple) else (self.type,)
        if Any in kinds:
            return True
        if isinstance(value, bool) and bool not in kinds:
            return False
        return isinstance(value, kinds) or (float in kinds and isinstance(value, int))

    def fault(self, value: Any) -> str | None:
        """The reason why a value of the declared type is invalid, or None; references are not resolved here."""
        if self.wrong is None or value is None or any(references(value, "")):
            return None
        return self.wrong(value)

    @property
    def type_name(self) -> str:
        """The declared type as messages name it."""
        kinds = self.type if isinstance(self.type, tuple) else (self.type,)
        return " or ".join(getattr(kind, "__name__", str(kind)) for kind in kinds)


@dataclass(frozen=True)
class Reference:
    """A reference to a property of the nearest ancestor that has it, or of the interface state."""

    source: Literal["parent", "interface"]
    name: str | None = None
    through: Callable[[Any], Any] | None = field(default=None, compare=False)

    def __str__(self) -> str:
        return f"<{self.source.upper()}{'' if self.name is None else ':' + self.name}>"


def Parent(name: str | None = None, through: Callable[[Any], Any] | None = None) -> Reference:  # noqa: N802
    """A reference to the property `name` (default: the same name) of the nearest ancestor, through a function if given."""
    return Reference("parent", name, through)


def Interface(name: str | None = None, through: Callable[[Any], Any] | None = None) -> Reference:  # noqa: N802
    """A reference to the property `name` (default: the same name) of the interface state, through a function if given."""
    return Reference("interface", name, through)


PARENT, INTERFACE = Parent(), Interface()


def references(value: Any, name: str) -> Iterator[Reference]:
    """Every reference inside a property's value; one without a name refers to `name`, the property itself."""
    if isinstance(value, Reference):
        yield Reference(value.source, value.name or name, value.through)
    elif isinstance(value, Mapping):
        for key, inner in value.items():
            yield from references(inner, str(key))
    elif isinstance(value, (list, tuple)):
        for inner in value:
            yield from references(inner, name)


class PropertyOwner(Protocol):
    """The attributes of a stage that are needed to resolve the values of its properties."""

    @property
    def name(self) -> str:
        """The name of the stage."""
        ...

    @property
    def path(self) -> str:
        """The names of the stages from the task's child down to this stage, joined by `/`."""
        ...

    @property
    def parent(self) -> "PropertyOwner | None":
        """The container of the stage, from which references to parents are resolved."""
        ...

    @property
    def properties(self) -> "Properties":
        """The properties of the stage."""
        ...


Trail = tuple[tuple[str, PropertyOwner], ...]  # the references followed so far: (property, stage)


def _trail_texts(trail: Trail) -> list[str]:
    return [f"{name!r} of {stage.path!r}" for name, stage in trail]


class Properties:
    """The properties of one stage, as declared by its class, with the values that were set.

    Resolves references.
    """

    def __init__(self, stage: PropertyOwner, declared: Mapping[str, Property], *, open_ended: bool) -> None:
        self._stage = stage
        self._declared = dict(declared)
        # Whether any name may be set; properties that only this stage has, for its children, may lack a value.
        self._optional = open_ended
        self._required = frozenset(declared)
        self._set: dict[str, Any] = {}

    @property
    def declared(self) -> Mapping[str, Property]:
        """Every declared property by name."""
        return self._declared

    @property
    def given(self) -> Mapping[str, Any]:
        """The values that were set on this stage, with references unresolved."""
        return self._set

    def declare(self, name: str, type: Any = Any, default: Any = MISSING, doc: str = "") -> None:  # noqa: A002
        """Declares one more property, of this stage only."""
        self._declared[name] = Property(type, default, doc)

    def set(self, name: str, value: Any) -> None:
        """Sets a property to a value or to a reference.

        Raises:
            UndeclaredProperty: the stage has no such property (containers accept any name).
            TypeError: the value does not have the declared type.
            ValueError: the value has the type but is invalid.
        """
        if name not in self._declared:
            if not self._optional:
                known = meant(name, self._declared) or f"; it has {', '.join(sorted(self._declared)) or 'none'}"
                raise UndeclaredProperty(f"stage {self._stage.name!r} has no property {name!r}{known}")
            self._declared[name] = Property()
        if not any(references(value, name)) and not self._declared[name].accepts(value):
            wanted = self._declared[name].type_name
            raise TypeError(f"property {name!r} of stage {self._stage.name!r} is {wanted}, not {value!r}")
        fault = self._declared[name].fault(value)
        if fault is not None:
            raise ValueError(f"property {name!r} of stage {self._stage.name!r} {fault}")
        self._set[name] = value

    def unset(self, name: str) -> None:
        """Removes the value that was set for a property, so that the default applies again."""
        self._set.pop(name, None)

    def has(self, name: str) -> bool:
        """Whether the stage declares the property."""
        return name in self._declared

    def value(self, name: str, interface: Mapping[str, Any] | None = None) -> Any:
        """The value of one property: as it was set, with references resolved, or the default.

        Raises:
            UndeclaredProperty: no stage declares it.
            UndefinedProperty: it has no value; the message says where it was searched for.
        """
        return self._value(name, interface, ())

    def _value(self, name: str, interface: Mapping[str, Any] | None, trail: Trail) -> Any:
        if name not in self._declared:
            raise UndeclaredProperty(
                f"stage {self._stage.path!r} declares no {name!r}{meant(name, self._declared)}"
            )
        value = self._set.get(name, self._declared[name].default)
        if value is MISSING:
            way = "".join(f", inherited by {by}" for by in reversed(_trail_texts(trail)))
            raise UndefinedProperty(f"{name!r} of stage {self._stage.path!r} is declared but undefined{way}")
        if type(value) not in _PLAIN and isinstance(value, (Reference, Mapping, list, tuple)):
            return self._resolved(value, name, interface, (*trail, (name, self._stage)))
        return value

    def _resolved(self, value: Any, name: str, interface: Mapping[str, Any] | None, trail: Trail) -> Any:
        if isinstance(value, Reference):
            found = self._looked_up(value.source, value.name or name, interface, trail)
            return found if value.through is None else value.through(found)
        if isinstance(value, Mapping):
            return {key: self._resolved(inner, str(key), interface, trail) for key, inner in value.items()}
        if isinstance(value, (list, tuple)):
            found = [self._resolved(inner, name, interface, trail) for inner in value]
            return type(value)(*found) if hasattr(value, "_fields") else type(value)(found)
        return value

    def _looked_up(self, source: str, name: str, interface: Mapping[str, Any] | None, trail: Trail) -> Any:
        if source == "interface":
            if interface is None or name not in interface:
                raise UndefinedProperty(
                    f"the interface state has no {name!r}, wanted by {' for '.join(_trail_texts(trail))}"
                )
            return interface[name]
        ancestor = self._stage.parent
        searched = []
        while ancestor is not None:
            if ancestor.properties.has(name):
                return ancestor.properties._value(name, interface, trail)
            searched.append(ancestor.name)
            ancestor = ancestor.parent
        where = " > ".join(reversed(searched)) or "no ancestor at all"
        raise UndeclaredProperty(
            f"no ancestor declares {name!r}, wanted by {' for '.join(_trail_texts(trail))} (searched: {where})"
        )

    def resolved(self, value: Any, name: str, interface: Mapping[str, Any]) -> Any:
        """A value that is not set on the stage, such as an argument of its cost term, with references resolved.

        Raises:
            UndeclaredProperty, UndefinedProperty: a reference leads nowhere.
        """
        return self._resolved(value, name, interface, ((name, self._stage),))

    def reads_interface(self, name: str) -> bool:
        """Whether the value of a property depends on the interface state, directly or through its ancestors."""
        value = self._set.get(name, self._declared[name].default)
        if type(value) in _PLAIN:
            return False
        for reference in references(value, name):
            if reference.source == "interface":
                return True
            owner = self._stage.parent
            while owner is not None and not owner.properties.has(reference.name or name):
                owner = owner.parent
            if owner is not None and owner.properties.reads_interface(reference.name or name):
                return True
        return False

    def interface_name(self, name: str) -> str | None:
        """The property of the interface state whose value a property has; None if it has any other value."""
        value = self._set.get(name, self._declared[name].default)
        if not isinstance(value, Reference) or value.through is not None:
            return None
        wanted, owner = value.name or name, self._stage.parent
        if value.source == "interface":
            return wanted
        while owner is not None and not owner.properties.has(wanted):
            owner = owner.parent
        return None if owner is None else owner.properties.interface_name(wanted)

    def problems(self) -> list[str]:
        """A sentence for every property that is invalid or has no value, as far as that is known before planning."""
        found = []
        for name in self._declared:
            if self._optional and name not in self._set and name not in self._required:
                continue
            if self.reads_interface(name):
                continue
            try:
                fault = self._invalid(name, self.value(name))
            except (UndeclaredProperty, UndefinedProperty) as error:
                found.append(str(error))
            else:
                found += [] if fault is None else [f"{name!r} of stage {self._stage.path!r} {fault}"]
        return found

    def invalid(self) -> list[str]:
        """What is wrong with values that are known by now: of the wrong type, or invalid, once references are followed."""
        found = []
        for name in self._set:
            try:
                fault = self._invalid(name, self.value(name))
            except (UndeclaredProperty, UndefinedProperty):
                continue  # not known by now
            found += [] if fault is None else [f"{name!r} {fault}"]
        return found

    def _invalid(self, name: str, value: Any) -> str | None:
        declared = self._declared[name]
        return declared.fault(value) if declared.accepts(value) else f"is {declared.type_name}, not {value!r}"


class PropertyResolver:
    """Resolves a stage's properties for each job; values that depend on no interface state are resolved only once."""

    def __init__(self, properties: Properties) -> None:
        self._properties = properties
        names = [n for n in properties.declared if n in properties.given or _has_default(properties, n)]
        self._changing = [name for name in names if properties.reads_interface(name)]
        self._fixed = {name: properties.value(name) for name in names if name not in self._changing}

    def values(self, *interfaces: Mapping[str, Any]) -> Mapping[str, Any]:
        """The values of all properties for a job, with references to interface states resolved.

        Args:
            interfaces: the properties of the interface states; of several with the same name the first is taken.

        Raises:
            UndefinedProperty: an interface state lacks a property that is referred to.
        """
        if not self._changing:
            return self._fixed
        interface: dict[str, Any] = {}
        for state in reversed(interfaces):
            interface.update(state)
        return self._fixed | {name: self._properties.value(name, interface) for name in self._changing}


def _has_default(properties: Properties, name: str) -> bool:
    return properties.declared[name].default is not MISSING
