from kabo.service.client import Client as Client
from kabo.service.inline import pack_problem as pack_problem
from kabo.service.inline import problem_for as problem_for
from kabo.service.server import Server as Server
from kabo.service.server import Settings as Settings
from kabo.service.session import DEFAULT_ENDPOINT as DEFAULT_ENDPOINT
from kabo.service.session import client_config as client_config
from kabo.service.session import server_config as server_config
