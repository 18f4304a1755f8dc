"""A service that does what the sentence says, in a process of its own, to see what becomes of it.

It is hosted as a planner: ``python tiny_service.py --listen ENDPOINT --name CELL [--ends-gently]``.
"""

import os
import signal
import sys
import threading
import time
from typing import Any

from surefetch.common.bus import Bus
from surefetch.common.errors import BadInput
from surefetch.common.messages import (
    Accepted,
    Acting,
    Cancel,
    Empty,
    Ended,
    Event,
    Instruct,
    Look,
    Target,
)
from surefetch.common.runner import Handle, Later, serve
from surefetch.common.settings import read_settings
from surefetch.common.topics import CANCEL, EVENTS, INSTRUCT, PLANNER


class TinyPlanner:
    """Words: `answer`, `sleep S`, `crash`, `refuse`, `later S`, `crash later`, `episode`, `die`."""

    name, backend = PLANNER, "tiny"

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._n_episodes = 0
        self.gone: list[str] = []
        self.cancelled: list[str] = []

    @property
    def doing(self) -> str:
        return f"missed {','.join(self.gone)} cancelled {','.join(self.cancelled)}"

    @property
    def handles(self) -> tuple[Handle[Any, Any], ...]:
        return (Handle(INSTRUCT, self.instruct), Handle(CANCEL, self.cancel, concurrent=True))

    def peer_gone(self, service: str) -> None:
        self.gone.append(service)

    def cancel(self, request: Cancel) -> Empty:
        if request.episode == "crash":
            raise ValueError("crashed on purpose")
        if request.episode == "signal":
            signal.pthread_kill(threading.get_ident(), signal.SIGTERM)
        self.cancelled.append(request.episode)
        return Empty()

    def instruct(self, request: Instruct) -> Accepted | Later[Accepted]:
        word, *arguments = request.sentence.split()
        match word:
            case "sleep":
                time.sleep(float(arguments[0]))
            case "crash":
                raise ValueError("crashed on purpose")
            case "refuse":
                raise BadInput("refused on purpose")
            case "later" if arguments == ["crash"]:
                return Later(self._accepted(), self.crash)
            case "later":
                return Later(self._accepted(), lambda: time.sleep(float(arguments[0])))
            case "episode" | "die":
                self._n_episodes += 1
                return Later(self._accepted(), lambda: self._run_episode(word))
        return self._accepted()

    def crash(self) -> None:
        time.sleep(0.1)  # by then the reply has left
        raise ValueError("crashed on purpose")

    def _accepted(self) -> Accepted:
        """Says in which thread it was made."""
        return Accepted(
            episode=f"e{self._n_episodes}",
            target=Target(noun="object"),
            understood=threading.current_thread().name,
        )

    def _run_episode(self, word: str) -> None:
        episode = f"e{self._n_episodes}"
        acting = Acting(cmd_id="c", verb=Look(view="center"))
        for seq in range(3):
            self._bus.publish(EVENTS, Event(episode=episode, seq=seq, step=0, happening=acting))
            time.sleep(0.05)
        if word == "die":
            os.kill(os.getpid(), signal.SIGKILL)
        ended = Ended(
            outcome="deferred",
            reason="absent",
            because="It is not there.",
            track=None,
            relation=None,
            delivered=None,
            actions=(),
            steps=(),
            q_hat=0.5,
            durations={},
        )
        self._bus.publish(EVENTS, Event(episode=episode, seq=3, step=0, happening=ended))


class GentlePlanner(TinyPlanner):
    """One that brings what it does to an end when it is told to."""

    def __init__(self, bus: Bus) -> None:
        super().__init__(bus)
        self._end = threading.Event()

    def instruct(self, request: Instruct) -> Accepted | Later[Accepted]:
        if request.sentence == "until the end":
            self._end.wait(20.0)
            time.sleep(1.5)  # longer than others are given, shorter than 3 s
            print("brought to rest", flush=True)
        return self._accepted()

    def end(self) -> None:
        self._end.set()


def main(argv: list[str]) -> int:
    kind = GentlePlanner if "--ends-gently" in argv else TinyPlanner
    words = [word for word in argv if word != "--ends-gently"]
    return serve(kind, read_settings(words, PLANNER))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
