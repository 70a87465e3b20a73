"""Checks of a plan's certificate: every claim in its proofs is evaluated again; nothing is searched."""
