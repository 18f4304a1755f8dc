"""Start `tiny_service.py` and talk to it."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from surefetch.common.launch import own_cell_name
from surefetch.common.messages import Accepted, Instruct
from surefetch.common.settings import BusSettings, free_endpoint
from surefetch.common.topics import INSTRUCT
from surefetch.common.zenoh_bus import ZenohBus

PROGRAM = Path(__file__).with_name("tiny_service.py")


class Tiny(NamedTuple):
    """A tiny service that is up, and an operator's bus to it."""

    process: "subprocess.Popen[str]"
    bus: ZenohBus
    cell: str
    endpoint: str

    def instruct(self, sentence: str, timeout_s: float = 10.0) -> Accepted:
        request = Instruct(sentence=sentence, profile="p", policy="q")
        return self.bus.ask(INSTRUCT, request, timeout_s=timeout_s)

    def exit_status(self, timeout_s: float = 5.0) -> int:
        return self.process.wait(timeout_s)


@contextmanager
def tiny_service(*words: str) -> Iterator[Tiny]:
    """A tiny service, ended at the end of the block however it is by then."""
    cell, endpoint = own_cell_name(), free_endpoint()
    process = subprocess.Popen(
        [sys.executable, str(PROGRAM), "--listen", endpoint, "--name", cell, *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == f"surefetch planner ready at {endpoint} in cell {cell}\n"
    bus = ZenohBus(BusSettings(cell, connect=(endpoint,)))
    try:
        yield Tiny(process, bus, cell, endpoint)
    finally:
        bus.close()
        process.kill()
        process.communicate()
