"""`surefetch stop`: end all motion now, in every cell that this machine knows or that is named."""

import argparse
import getpass
import json
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import asdict, dataclass

from surefetch.common.errors import InfrastructureError, SurefetchError
from surefetch.common.joining import find_cell
from surefetch.common.messages import Stop
from surefetch.common.running_cells import NONE_RUNS, running_cells
from surefetch.common.settings import BusSettings
from surefetch.common.topics import STOP
from surefetch.common.zenoh_bus import ZenohBus

STOP_S = 5.0


@dataclass(frozen=True)
class CellStop:
    """What came of one cell's stop."""

    cell: str
    was_moving: bool | None = None
    took_s: float | None = None
    error: str | None = None

    @property
    def sentence(self) -> str:
        """For people."""
        if self.error is not None:
            return f"{self.cell}: NOT STOPPED. {self.error}"
        if self.was_moving:
            return f"{self.cell}: was moving, came to rest after {self.took_s:.2f} s"
        return f"{self.cell}: was at rest"


def main(argv: list[str]) -> int:
    """Stop; 0 if every executor of every cell found says that it is at rest, else 3.

    Raises:
        BadInput, InfrastructureError: no cell was found.
    """
    told = _parser().parse_args(argv)
    targets = _named(told.connect) if told.connect else _running()
    with ThreadPoolExecutor(max_workers=len(targets)) as pool:
        stops = list(pool.map(_stop, targets))
    if told.json:
        print(json.dumps({"cells": [asdict(stop) for stop in stops]}))
    else:
        print("\n".join(stop.sentence for stop in stops))
    return 0 if all(stop.error is None for stop in stops) else InfrastructureError.exit_code


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch stop",
        description="Stop all motion now. Without --connect: in all cells of this user here.",
        epilog="example: surefetch stop --connect tcp/192.0.2.10:7447",
    )
    parser.add_argument(
        "--connect", action="append", metavar="ENDPOINT", help="a cell's endpoint: tcp/HOST:PORT"
    )
    parser.add_argument("--json", action="store_true", help="one JSON object")
    return parser


def _named(connect: Sequence[str]) -> list[BusSettings]:
    """The cells behind these endpoints, each once."""
    cells = {}
    for endpoint in connect:
        found = find_cell([endpoint])
        if found is None:
            raise InfrastructureError(f"nothing is up at {endpoint}; nothing was stopped there.")
        cells[found.name] = BusSettings(found.name, connect=found.endpoints)
    return list(cells.values())


def _running() -> list[BusSettings]:
    cells = running_cells()
    if not cells:
        raise InfrastructureError(NONE_RUNS)
    return [BusSettings(cell.name, connect=cell.endpoints) for cell in cells]


def _stop(target: BusSettings) -> CellStop:
    try:
        with closing(ZenohBus(target)) as bus:
            stopped = bus.ask(STOP, Stop(who=f"surefetch stop, {_user()}"), timeout_s=STOP_S)
    except SurefetchError as error:
        return CellStop(target.cell, error=str(error))
    return CellStop(target.cell, stopped.was_moving, stopped.took_s)


def _user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return "unknown user"
