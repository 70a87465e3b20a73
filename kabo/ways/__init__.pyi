from kabo.ways.searching import FreeConfigurations as FreeConfigurations
from kabo.ways.searching import FreeSegment as FreeSegment
from kabo.ways.searching import FreeSpace as FreeSpace
from kabo.ways.searching import NoPath as NoPath
from kabo.ways.searching import find_way as find_way
from kabo.ways.searching import shortened as shortened
