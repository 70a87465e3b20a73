"""Kernels of execution: numbers that are wanted many times a second."""
