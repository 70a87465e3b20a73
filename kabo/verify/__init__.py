"""The verifier: leads a plan through all possible worlds, and re-proves every motion and its certificate.

It shares no code with the planner: it knows the problem's language, the plan, the scene, pinocchio and coal, and
judges with dictionaries and sets, and with the original triangle meshes. What is wrong is a finding with its node.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
