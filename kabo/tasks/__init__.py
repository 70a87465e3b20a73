"""Task Construction, in which the geometric procedures of a domain are written as tasks made of stages [T ch. 3].

`core` plans tasks of any kind and imports nothing of kabo; `robots` has the stages that ask the geometry server;
`files` reads and writes task files; `library` holds the tasks that domains may call.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
