"""The verifier: follows a plan through all possible worlds, and proves every motion and its certificate anew.

It shares no code with the planner: it uses the problem's language, the plan, the scene, pinocchio and coal, and works
with dictionaries and sets and with the original triangle meshes. Every fault is a finding with its node.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
