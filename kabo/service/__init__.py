"""The service: answers requests over zenoh as the command line does, with a queue, worker processes and one reply each.

`Server` and `Client` load zenoh when they are first used. Requests are executed by the functions in
`kabo.requests`, which the command line calls, too.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
