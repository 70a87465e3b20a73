from kabo.tasks.files.building import TaskFile as TaskFile
from kabo.tasks.files.building import find_task_file as find_task_file
from kabo.tasks.files.building import load_task as load_task
from kabo.tasks.files.building import load_task_file as load_task_file
from kabo.tasks.files.costs import register_cost as register_cost
from kabo.tasks.files.registry import register as register
from kabo.tasks.files.writing import dump_task as dump_task
from kabo.tasks.files.writing import task_to_yaml as task_to_yaml
