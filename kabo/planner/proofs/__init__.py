"""Proofs and explanations that a goal is out of reach: root causes, dead ends, facts without achievers."""
