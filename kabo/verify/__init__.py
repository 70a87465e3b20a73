"""The verifier: judges a plan in all possible worlds, and checks every motion and the plan's certificate.

It shares no code with the planner: it uses the problem's language, the plan, the scene, pinocchio and coal, and
works with dictionaries and sets and with the original triangle meshes. Every fault is reported as a finding with
the node at fault.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
