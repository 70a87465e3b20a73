"""Why a goal is out of reach, as proofs and sentences: root causes, dead ends, facts that nothing achieves."""
