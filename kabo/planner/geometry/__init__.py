"""Geometry for the search: refused procedure calls, evaluation of skeletons, and workers that make calls in advance."""
