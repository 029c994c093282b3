"""What the page asks of the nodes: handed from the thread of the server to that of ROS."""

from concurrent.futures import Future
from enum import Enum
from queue import Empty, SimpleQueue
from typing import NamedTuple


class Action(Enum):
    """What a button of the page does."""

    TARE = 'tare'
    RESET = 'reset'
    RECORD = 'record'
    STOP = 'stop'


class Done(NamedTuple):
    """What came of an action, in one sentence."""

    success: bool
    message: str


class Request(NamedTuple):
    """An action, and the place of its answer."""

    action: Action
    answer: 'Future[Done]'


class Requests:
    """A queue from one thread to another."""

    def __init__(self) -> None:
        """Begin with none."""
        self._waiting: SimpleQueue[Request] = SimpleQueue()

    def put(self, action: Action) -> 'Future[Done]':
        """Ask for an action, and return where its answer will be."""
        request = Request(action, Future())
        self._waiting.put(request)
        return request.answer

    def take(self) -> list[Request]:
        """Return all whose answer somebody still waits for; from now on they are answered."""
        taken: list[Request] = []
        while True:
            try:
                request = self._waiting.get_nowait()
            except Empty:
                return taken
            if request.answer.set_running_or_notify_cancel():
                taken.append(request)
