"""The meshes room: triangle meshes as arrays and files, what is wrong with them, safe repairs, pictures.

It knows arrays, metres and file formats; it knows nothing of epsilon, convex parts, robots or scenes. What is read is
checked and told in one sentence; what is written is read back and compared bit by bit.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
