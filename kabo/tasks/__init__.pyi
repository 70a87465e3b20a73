from kabo.tasks.core import *
from kabo.tasks.files import TaskFile as TaskFile
from kabo.tasks.files import TaskReport as TaskReport
from kabo.tasks.files import dump_task as dump_task
from kabo.tasks.files import load_task as load_task
from kabo.tasks.files import load_task_file as load_task_file
from kabo.tasks.files import plan_task as plan_task
from kabo.tasks.files import register as register
from kabo.tasks.files import register_cost as register_cost
from kabo.tasks.files import task_to_yaml as task_to_yaml
