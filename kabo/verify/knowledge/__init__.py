"""The knowledge half of the verifier: possible worlds judge a plan; a replay of kabo's own inference where they cannot.

`worlds/` is trusted, with the modules beside this file, which read formulas and effects. `replay/` is used only for plans
that worlds cannot judge, and the report says so, with the reason.
"""

from kabo.verify.knowledge.judging import KnowledgeReport, check_knowledge, validate_worlds

__all__ = ["KnowledgeReport", "check_knowledge", "validate_worlds"]
