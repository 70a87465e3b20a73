from kabo.ways.edges import FreeConfigurations as FreeConfigurations
from kabo.ways.edges import FreeSegment as FreeSegment
from kabo.ways.rrt_connect import NoPath as NoPath
from kabo.ways.rrt_connect import connect as connect
from kabo.ways.shortcuts import shortcut as shortcut
