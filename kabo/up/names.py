"""Which thing of a problem of unified-planning is called what in kabo, in both directions."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from typing import Any

from kabo.language.names import proper_name


@dataclass
class Names:
    """The names in kabo of what a problem of unified-planning declares, and what each name stands for.

    unified-planning has a namespace for each kind of thing; kabo spells names in lower case.
    """

    title: str = "problem"  # of the problem
    types: dict[str, str] = field(default_factory=dict)  # unified-planning's name -> kabo's
    objects: dict[str, str] = field(default_factory=dict)
    fluents: dict[str, str] = field(default_factory=dict)
    actions: dict[str, str] = field(default_factory=dict)

    @staticmethod
    def variable(original: str) -> str:
        """The name of a parameter or variable where it may be any: in PDDL variables have a namespace of their own."""
        spelled = proper_name(original)
        return spelled if spelled == original else f"{spelled}_{sha256(original.encode()).hexdigest()[:6]}"

    def object_of(self, problem: Any, name: str) -> Any:
        """The object of the problem that has this name in kabo.

        Raises:
            KeyError: there is none.
        """
        return problem.object(_original(self.objects, name))

    def fluent_of(self, problem: Any, name: str) -> Any:
        """The fluent of the problem that has this name in kabo.

        Raises:
            KeyError: there is none.
        """
        return problem.fluent(_original(self.fluents, name))

    def action_of(self, problem: Any, name: str) -> Any:
        """The action of the problem that has this name in kabo.

        Raises:
            KeyError: there is none.
        """
        return problem.action(_original(self.actions, name))


def _original(names: Mapping[str, str], name: str) -> str:
    for original, own in names.items():
        if own == name:
            return original
    raise KeyError(name)
