"""kabo: combined task and motion planning on the knowledge level, with bounded geometric predicates.

The façade: `load_problem`, `solve`, `explain`, `verify`, `load_scene`, `GeometryServer`, `load_mesh`, `bounding_mesh`,
`bounding_decomposition` and the data they speak of. It imports nothing itself; each name loads its room when it is
first used, so that `import kabo` takes milliseconds.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kabo.errors import Diagnostic, InputError, KaboError, ServiceError
    from kabo.explain.explain import Explanation, explain
    from kabo.geometry.bounding.bounding_decomposition import bounding_decomposition
    from kabo.geometry.bounding.bounding_mesh import bounding_mesh
    from kabo.geometry_server import GeometryServer
    from kabo.language import load_problem
    from kabo.language.problem import Problem
    from kabo.meshes import load_mesh
    from kabo.plan import Plan, plan_from_json, plan_to_json, policy, unfold
    from kabo.planner.result import Progress, Reason, Result
    from kabo.planner.solve import solve
    from kabo.scene import Scene, load_scene
    from kabo.verify import verify_plan
    from kabo.verify import verify_plan as verify

__version__ = "0.1.0"

_HOMES = {
    "Diagnostic": "kabo.errors",
    "Explanation": "kabo.explain.explain",
    "GeometryServer": "kabo.geometry_server",
    "InputError": "kabo.errors",
    "KaboError": "kabo.errors",
    "Plan": "kabo.plan",
    "Problem": "kabo.language.problem",
    "Progress": "kabo.planner.result",
    "Reason": "kabo.planner.result",
    "Result": "kabo.planner.result",
    "Scene": "kabo.scene",
    "ServiceError": "kabo.errors",
    "bounding_decomposition": "kabo.geometry",
    "bounding_mesh": "kabo.geometry",
    "explain": "kabo.explain.explain",
    "load_mesh": "kabo.meshes",
    "load_problem": "kabo.language",
    "load_scene": "kabo.scene",
    "plan_from_json": "kabo.plan",
    "plan_to_json": "kabo.plan",
    "policy": "kabo.plan",
    "solve": "kabo.planner.solve",
    "unfold": "kabo.plan",
    "verify_plan": "kabo.verify",
}

__all__ = [
    "Diagnostic",
    "Explanation",
    "GeometryServer",
    "InputError",
    "KaboError",
    "Plan",
    "Problem",
    "Progress",
    "Reason",
    "Result",
    "Scene",
    "ServiceError",
    "bounding_decomposition",
    "bounding_mesh",
    "explain",
    "load_mesh",
    "load_problem",
    "load_scene",
    "plan_from_json",
    "plan_to_json",
    "policy",
    "solve",
    "unfold",
    "verify",
    "verify_plan",
]


def __getattr__(name: str) -> Any:
    """Loads the room that offers `name` [PEP 562]; `kabo.verify` is the room, which can be called."""
    if name == "verify":
        return import_module("kabo.verify")
    if name not in _HOMES:
        raise AttributeError(f"module 'kabo' has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
