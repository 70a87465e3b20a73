"""The pictures room: still pictures, film strips and animations of scenes, plans and meshes, without a display.

It draws what the rooms below hold, with VTK (the extra `pictures`); graphs of plans are SVG and need no library. A
picture chooses its camera, names what it shows, and is the same, byte for byte, for the same input on one machine.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
