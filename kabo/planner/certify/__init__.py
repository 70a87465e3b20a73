"""Certificates: proofs that the motions of a plan are collision-free, and the permissions for its contacts."""
