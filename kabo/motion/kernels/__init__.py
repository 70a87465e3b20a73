"""Kernels of the time law: arrays in, numbers out."""
