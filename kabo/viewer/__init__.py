"""The viewer: scenes, plans, reports and explanations as one page that a browser opens from disk, without a server.

`content` turns them into the view document, plain data and arrays, in which no HTML is; `page` writes the file.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
