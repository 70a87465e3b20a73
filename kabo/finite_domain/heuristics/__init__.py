"""Estimates for finite-domain tasks: delete relaxation and landmark cuts."""
