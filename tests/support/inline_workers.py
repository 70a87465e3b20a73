"""Workers without processes: the very same scheduling, and every answer there at once."""

import pickle

from kabo.tasks.core.run.workers import StageWorkers, _answer, _StageWorker


class Inline:
    """Both ends of a connection to a worker that is this process: what it is sent it answers at once."""

    def __init__(self, functions):
        self._functions, self._begun, self._said = functions, {}, []

    def send_bytes(self, sent):
        number, name, job = pickle.loads(sent)  # noqa: S301 it has just been written here
        self._said.append(_answer(self._functions[number], self._begun, name, job))

    def poll(self):
        return bool(self._said)

    def recv_bytes(self):
        return self._said.pop(0)

    def close(self):
        self._said.clear()


class InlineWorkers(StageWorkers):
    """Everything that workers do but for the processes; every job that may be sent is."""

    def _begun(self):
        functions = [node.function() for node in self._leaves]
        self._workers.append(_StageWorker(None, Inline(functions)))
        return self._workers[-1]

    def close(self):
        self._workers.clear()
