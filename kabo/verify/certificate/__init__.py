"""Checks every claim in the proofs of a plan's certificate, without any search."""
