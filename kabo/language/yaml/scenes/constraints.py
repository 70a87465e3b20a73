"""Reads and checks constraints between features, whose owners are named by roles.

Source: K Table 5.1, docs/explanation/sampling.md.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

import lark

from kabo.language.constraint_kinds import CONSTRAINT_KINDS, DIMENSION, Quantity
from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.scene_description import Constraint, Feature, FeatureName
from kabo.language.yaml.documents import Scalar
from kabo.language.yaml.syntax import Parsed, Tree, parse


@dataclass(frozen=True)
class Owner:
    """A thing (body, region, tool) with features, to which a role in a constraint may refer."""

    name: str
    features: Mapping[str, Feature | None]  # None: something is wrong with it, which was reported


Roles = Mapping[str, Sequence[Owner]]


@dataclass
class ConstraintReader:
    """Reads constraints; each text is parsed once, however many bodies copy it from their model."""

    findings: Findings
    _known: dict[int, tuple[Scalar, "_Written | None"]] = field(default_factory=dict)
    _shapes: dict[tuple[int, str], tuple[Sequence[Owner], bool, tuple[str, ...]]] = field(default_factory=dict)

    def read(self, scalar: Scalar, roles: Roles) -> Constraint | None:
        """The constraint of a scalar whose features belong to one of `roles`, in the order point, line, plane."""
        if id(scalar) not in self._known:
            self._known[id(scalar)] = (scalar, self._parse(scalar))
        written = self._known[id(scalar)][1]
        if written is None:
            return None
        constraint = written.constraint
        kinds = [self._kinds(name, place, roles, constraint) for name, place in written.features]
        if None in kinds:
            return None
        first, second = (kind or () for kind in kinds)
        return self._in_order(written, set(product(first, second)))

    def check_stroke_feature(self, name: FeatureName, place: Place, roles: Roles) -> bool:
        """Whether a stroke may be along this feature, which must exist and be a line; others are reported."""
        kinds = self._kinds(name, place, roles, None)
        if kinds is None or all(kind == "line" for kind in kinds):
            return kinds is not None
        self.findings.add(place, f'"{name}" is a {kinds[0]}; a motion follows a line')
        return False

    # ------------------------------------------------------------------------------------------- whose feature
    def _kinds(
        self, name: FeatureName, place: Place, roles: Roles, constraint: Constraint | None
    ) -> tuple[str, ...] | None:
        """What shapes the feature may have; empty if nothing can be known, None after a report."""
        if name.owner not in roles:
            hint = self.findings.near(name.owner, roles.keys()) or f"the roles here are {', '.join(roles)}"
            self.findings.add(place, f'unknown role "{name.owner}" in "{name}"', hint)
            return None
        whole = constraint is not None and not CONSTRAINT_KINDS[constraint.kind].shapes
        if name.feature is None:
            if whole:
                return ()
            self.findings.add(place, f'name a feature of "{name.owner}": {name.owner}.NAME')
            return None
        if whole:
            self.findings.add(place, "inside takes whole bodies: inside(this, region)")
            return None
        owners = roles[name.owner]
        exists, kinds = self._shapes_of(owners, name.feature)
        if not exists and owners:
            self._report_missing(name, place, owners)
            return None
        return kinds

    def _shapes_of(self, owners: Sequence[Owner], feature: str) -> tuple[bool, tuple[str, ...]]:
        """Whether any of the owners has the feature, and what shapes it then has."""
        key = (id(owners), feature)
        if key not in self._shapes:  # the owners are kept, so that their id stays theirs
            found = [owner.features[feature] for owner in owners if feature in owner.features]
            kinds = sorted({each.kind for each in found if each is not None})
            self._shapes[key] = (owners, bool(found), tuple(kinds))
        return self._shapes[key][1:]

    def _report_missing(self, name: FeatureName, place: Place, owners: Sequence[Owner]) -> None:
        if not self.findings.may_suggest:
            self.findings.add(place, f'there is no feature "{name}"')
            return
        known = sorted({feature for owner in owners for feature in owner.features})
        who = f'"{owners[0].name}" has' if len(owners) == 1 else f'nothing that "{name.owner}" can be has'
        hint = self.findings.near(name.feature or "", known)
        self.findings.add(place, f'{who} no feature "{name.feature}"', hint)

    def _in_order(self, written: "_Written", pairs: set[tuple[str, str]]) -> Constraint | None:
        constraint = written.constraint
        kind = CONSTRAINT_KINDS[constraint.kind]
        for first, second in sorted(pairs):
            if (first, second) in kind.shapes:
                continue
            swapped = (second, first) in kind.shapes
            if swapped and not kind.point_first:
                continue
            hint = f"the point stands first: {constraint.kind}({constraint.second}, {constraint.first})"
            in_order = sorted(kind.shapes, key=lambda pair: [DIMENSION[shape] for shape in pair])
            shapes = ", ".join(f"{a}–{b}" for a, b in in_order)
            message = f"{constraint.kind} does not relate a {first} and a {second}"
            self.findings.add(
                constraint.place or written.features[0][1], message, hint if swapped else f"it relates {shapes}"
            )
            return None
        if pairs and all(DIMENSION[first] > DIMENSION[second] for first, second in pairs):
            first_name, second_name = constraint.second, constraint.first
            return Constraint(
                constraint.kind, first_name, second_name, constraint.lower, constraint.upper, constraint.place
            )
        return constraint

    # ------------------------------------------------------------------------------------------------- the text
    def _parse(self, scalar: Scalar) -> "_Written | None":
        parsed = parse(scalar, "constraint", self.findings)
        if parsed is None:
            return None
        name, first, second, *bound = parsed.tree.children
        if str(name) not in CONSTRAINT_KINDS:
            known = f"the constraints are {', '.join(CONSTRAINT_KINDS)}"
            hint = self.findings.near(str(name), CONSTRAINT_KINDS) or known
            self.findings.add(parsed.place(name), f'unknown constraint "{name}"', hint)
            return None
        limits = self._limits(parsed, str(name), bound)
        if limits is None:
            return None
        features = tuple((_feature_name(tree), parsed.place(tree)) for tree in (first, second))
        constraint = Constraint(
            str(name), features[0][0], features[1][0], limits[0], limits[1], parsed.place(parsed.tree)
        )
        return _Written(constraint, features)

    def _limits(
        self, parsed: Parsed, kind: str, bound: Sequence[Tree | lark.Token]
    ) -> tuple[float | None, float | None] | None:
        quantity = CONSTRAINT_KINDS[kind].quantity
        if quantity is None:
            if bound:
                self.findings.add(parsed.place(bound[0]), f"{kind} has no bound")
            return None if bound else (None, None)
        if not bound:
            hint = f"{kind}(…) {'<= 10 deg' if quantity.unit == 'rad' else '<= 0.01'}, or in [x, y]"
            self.findings.add(parsed.place(parsed.tree), f"{kind} needs a bound", hint)
            return None
        trees = [piece for piece in bound if isinstance(piece, lark.Tree)]
        values = [self._value(parsed, tree, quantity) for tree in trees]
        if None in values:
            return None
        numbers = [value for value in values if value is not None]
        if len(numbers) == 2:
            lower, upper = numbers
            if lower > upper:
                self.findings.add(parsed.place(trees[0]), "the lower bound is greater than the upper one")
                return None
            return self._sensible(parsed, trees[0], quantity, lower, upper)
        return self._compared(parsed, quantity, bound[0], trees[0], numbers[0])

    def _compared(
        self, parsed: Parsed, quantity: Quantity, compare: Tree | lark.Token, tree: Tree, value: float
    ) -> tuple[float | None, float | None] | None:
        if compare not in ("=", "<=", ">="):
            hint = f'write "{compare}="' if compare in ("<", ">") else None
            self.findings.add(parsed.place(compare), 'a bound is written with "=", "<=", ">=" or in [x, y]', hint)
            return None
        lower = value if compare != "<=" else None
        upper = value if compare != ">=" else None
        return self._sensible(parsed, tree, quantity, lower, upper)

    def _value(self, parsed: Parsed, tree: Tree, quantity: Quantity) -> float | None:
        words = [str(token) for token in tree.children]
        degrees = words[-1] == "deg"
        value = float(words[-2] if degrees else words[-1]) * (-1.0 if words[0] == "-" else 1.0)
        if not math.isfinite(value):
            self.findings.add(parsed.place(tree), "this number is too large")
            return None
        if degrees and quantity.unit != "rad":
            self.findings.add(parsed.place(tree), f"{quantity.name} is in metres: only angles have the suffix deg")
            return None
        return math.radians(value) if degrees else value + 0.0

    def _sensible(
        self, parsed: Parsed, tree: Tree, quantity: Quantity, lower: float | None, upper: float | None
    ) -> tuple[float | None, float | None] | None:
        """The bounds, if they can hold and no other constraint expresses them; else None after a report."""
        place = parsed.place(tree)
        given = [value for value in (lower, upper) if value is not None]
        if any(value < quantity.least or value > quantity.largest + quantity.tolerance for value in given):
            self.findings.add(place, quantity.outside)
            return None
        better = _better(quantity, lower, upper)
        if better is not None:
            bound, word = better
            names = ", ".join(str(_feature_name(feature)) for feature in parsed.tree.children[1:3])
            self.findings.add(place, f"{bound} has a word of its own", f"write {word}({names})")
            return None
        return lower, upper


def _better(quantity: Quantity, lower: float | None, upper: float | None) -> tuple[str, str] | None:
    """The bound at an end of the range, in words, and the constraint that says the same without one."""
    if quantity.at_least is not None and upper is not None and upper <= quantity.least + quantity.tolerance:
        return f"{quantity.name} {quantity.least:g}", quantity.at_least
    if quantity.at_largest is not None and lower is not None and lower >= quantity.largest - quantity.tolerance:
        largest = f"{math.degrees(quantity.largest):g} deg" if quantity.unit == "rad" else f"{quantity.largest:g}"
        return f"{quantity.name} {largest}", quantity.at_largest
    return None


@dataclass(frozen=True)
class _Written:
    constraint: Constraint
    features: tuple[tuple[FeatureName, Place], ...]


def _feature_name(tree: Tree) -> FeatureName:
    words = [str(token) for token in tree.children]
    return FeatureName(words[0], words[1] if len(words) > 1 else None)
