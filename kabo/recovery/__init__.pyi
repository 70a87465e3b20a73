from kabo.recovery.node_ways import way_back as way_back
from kabo.recovery.node_ways import way_on as way_on
from kabo.recovery.node_ways import way_open as way_open
from kabo.recovery.replanning import Replanner as Replanner
