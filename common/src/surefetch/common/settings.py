"""One machine's TOML file and the command line → one frozen value.

A file, the same on every machine of a cell::

    name = "lab"                # the cell's name on the bus; without it, the cell file's
    cell = "lab-cell.toml"      # everything physical; without it, the simulated cell

    [endpoints]                 # where each service listens; all others connect there
    executor = "tcp/192.0.2.10:7447"
    perception = "tcp/192.0.2.20:7447"
    belief = "tcp/192.0.2.30:7447"
    planner = "tcp/192.0.2.30:7448"
"""

import argparse
import re
import socket
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import msgspec

from surefetch.common.cell import Cell, read_cell, simulated_cell
from surefetch.common.errors import BadInput
from surefetch.common.topics import SERVICES

LogLevel = Literal["debug", "info", "warning", "error"]
GripModel = Literal["contact_then_hold", "friction", "attachment"]
"""How the simulated hand holds: what both fingers touch by a constraint of limited force or by
friction alone, or, as in the paper, whatever is near."""


@dataclass(frozen=True)
class BusSettings:
    """Where on the bus: the cell's name in keys, and links."""

    cell: str
    listen: tuple[str, ...] = ()
    connect: tuple[str, ...] = ()
    shared_memory: bool = False


@dataclass(frozen=True)
class Settings:
    """Everything that one service process is told."""

    service: str
    bus: BusSettings
    cell: Cell
    executor: str = "pybullet"
    perception: str = "classical"
    grip: GripModel = "contact_then_hold"
    """Of the simulated hand."""
    parameters: Path | None = None
    """Folder of parameter files used instead of the shipped ones."""
    real_time: bool = False
    log_level: str = "warning"
    journal_dir: Path | None = None
    """None: a temporary folder that goes with the process."""
    parent_pid: int | None = None
    """End when this process ends."""


class Endpoints(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where each service listens."""

    executor: str
    perception: str
    belief: str
    planner: str

    def of(self, service: str) -> str:
        """The endpoint of one service."""
        return str(getattr(self, service))


class Machine(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A configuration file; unknown and missing keys are errors."""

    endpoints: Endpoints | None
    """None only where there is no file; TOML has no null."""
    name: str | None = None
    cell: str | None = None
    executor: Literal["pybullet"] = "pybullet"
    perception: Literal["classical"] = "classical"
    grip: GripModel = "contact_then_hold"
    parameters: str | None = None
    shared_memory: bool = False
    real_time: bool = False
    log_level: LogLevel = "warning"
    journal_dir: str | None = None


def read_machine(path: Path) -> Machine:
    """Read and check a configuration file. Raises BadInput naming the file and the key."""
    try:
        return msgspec.convert(tomllib.loads(path.read_text("utf-8")), Machine)
    except OSError as error:
        raise BadInput(f"configuration {path} cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, msgspec.ValidationError, UnicodeDecodeError) as error:
        raise BadInput(f"configuration {path}: {error}") from None


def read_settings(argv: Sequence[str], service: str) -> Settings:
    """The settings of one service process. Raises BadInput that says what to write instead."""
    told = _parser(service).parse_args(argv)
    machine = Machine(endpoints=None) if told.config is None else read_machine(told.config)
    folder = Path() if told.config is None else told.config.parent
    cell = _cell(_path(told.cell, machine.cell, folder))
    return Settings(
        service=service,
        bus=BusSettings(
            cell=_cell_name(told.name or machine.name or cell.name),
            listen=_listen(told.listen, machine.endpoints, service),
            connect=_connect(told.connect, machine.endpoints, service),
            shared_memory=machine.shared_memory,
        ),
        cell=cell,
        executor=machine.executor,
        perception=machine.perception,
        grip=machine.grip,
        parameters=_path(told.parameters, machine.parameters, folder),
        real_time=told.real_time or machine.real_time,
        log_level=told.log_level or machine.log_level,
        journal_dir=_path(told.journal_dir, machine.journal_dir, folder),
        parent_pid=told.parent_pid,
    )


def free_endpoint() -> str:
    """A loopback endpoint that nobody listens on just now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


def _parser(service: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=f"surefetch serve {service}",
        description=f"Run the {service} in the foreground.",
        epilog=f"example: surefetch serve {service} --listen tcp/127.0.0.1:7447",
    )
    parser.add_argument("--config", type=Path, metavar="F", help="this machine's TOML file")
    parser.add_argument(
        "--listen", action="append", metavar="ENDPOINT", help="be reached here: tcp/HOST:PORT"
    )
    parser.add_argument(
        "--connect", action="append", metavar="ENDPOINT", help="reach another service here"
    )
    parser.add_argument("--cell", type=Path, metavar="FILE", help="cell file")
    parser.add_argument("--name", help="the cell's name on the bus")
    parser.add_argument("--parameters", type=Path, metavar="DIR", help="other parameter files")
    parser.add_argument("--journal-dir", type=Path, metavar="DIR", help="where the journal goes")
    parser.add_argument("--log-level", choices=["debug", "info", "warning", "error"])
    parser.add_argument("--real-time", action="store_true", help="pace motion to the clock")
    parser.add_argument("--parent-pid", type=int, metavar="PID", help="end when that process ends")
    return parser


def _cell(path: Path | None) -> Cell:
    return simulated_cell() if path is None else read_cell(path)


def _cell_name(name: str) -> str:
    """The name, which must fit into a key as one chunk."""
    if re.fullmatch(r"[A-Za-z0-9_.-]{1,64}", name) is None:
        raise BadInput(
            f'a cell cannot be called "{name[:80]}" on the bus.\n'
            f"  Use up to 64 letters, digits, dots, dashes and underscores."
        )
    return name


def _path(told: Path | None, written: str | None, folder: Path) -> Path | None:
    """The command line's path, or the file's, which is relative to the file."""
    if told is not None:
        return told
    return None if written is None else folder / written


def _listen(told: list[str] | None, endpoints: Endpoints | None, service: str) -> tuple[str, ...]:
    if told:
        return tuple(told)
    return (free_endpoint() if endpoints is None else endpoints.of(service),)


def _connect(told: list[str] | None, endpoints: Endpoints | None, service: str) -> tuple[str, ...]:
    if told or endpoints is None:
        return tuple(told or ())
    return tuple(endpoints.of(other) for other in SERVICES if other != service)
