"""Certificates: the proofs that the motions of a plan are free of collision, and what grants its contacts."""
