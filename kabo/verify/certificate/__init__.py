"""Checks the certificate of a plan: every claim of its proofs, without searching."""
