"""The same requests as on the command line, over zenoh: a queue, worker processes, one reply for every request.

`Server` and `Client` load zenoh when they are first used. What a request means, free of any transport, is in
`kabo.requests`; the command line calls it too, so that every door gives the same answer.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
