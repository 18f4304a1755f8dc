"""Start services as processes of their own on this machine, and leave none behind.

Each is ``surefetch serve NAME …``, so that a process list names it. A service ends when its parent
does, however that came about: it watches the parent itself.
"""

import os
import secrets
import shutil
import socket
import subprocess
import sys
import sysconfig
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Self

from surefetch.common.errors import BadInput, InfrastructureError, SurefetchError

READY_S: Final = 60.0
"""From the start of a process to its word that it is ready."""
END_S: Final = 3.5
"""From SIGTERM to SIGKILL; the executor may need 3 s for a controlled stop."""
TRIES: Final = 3
TAIL_LINES: Final = 12
_LOOK_ROUND_S: Final = 0.02


@dataclass(frozen=True)
class Launch:
    """What to start."""

    services: tuple[str, ...]
    cell: str
    """The cell's name on the bus."""
    folder: Path
    """Where each service's log `NAME.log` and its journal go."""
    endpoints: Mapping[str, str] | None = None
    """Where each of these services listens. None: on free ports of this machine's loopback."""
    connect: tuple[str, ...] = ()
    """Services that are up already."""
    options: tuple[str, ...] = ()
    """More words for every ``surefetch serve NAME``: ``--config F``, ``--real-time`` …"""


@dataclass(frozen=True)
class Started:
    """One service process."""

    service: str
    endpoint: str
    process: subprocess.Popen[bytes]
    log_file: Path


class _PortTaken(Exception):
    """Somebody else got hold of a port between its choice and its use."""


class Services:
    """Service processes that this process has started; a context that ends them."""

    def __init__(self, started: Sequence[Started]) -> None:
        self._started = tuple(started)

    @classmethod
    def start(cls, launch: Launch, *, ready_s: float = READY_S) -> Self:
        """Start all and wait until every one is ready.

        Raises:
            BadInput: a service refused what it was told, as an endpoint that is in use.
            InfrastructureError: a service ended or was not ready in time. None is left behind.
        """
        launch.folder.mkdir(parents=True, exist_ok=True)
        for _ in range(TRIES):
            try:
                return cls._start_once(launch, ready_s)
            except _PortTaken:
                continue
        raise InfrastructureError("no free ports were found for the services on this machine.")

    @classmethod
    def _start_once(cls, launch: Launch, ready_s: float) -> Self:
        endpoints = launch.endpoints or _free_endpoints(launch.services)
        with ExitStack() as stack:
            started: list[Started] = []
            stack.callback(_end, started)
            for service in launch.services:
                started.append(_spawn(launch, service, endpoints))
            _wait_until_ready(started, ready_s, ports_are_ours=launch.endpoints is None)
            stack.pop_all()
        return cls(started)

    @property
    def endpoints(self) -> tuple[str, ...]:
        """Where they listen."""
        return tuple(one.endpoint for one in self._started)

    @property
    def pids(self) -> dict[str, int]:
        """Process of each service."""
        return {one.service: one.process.pid for one in self._started}

    def died(self) -> dict[str, int]:
        """Services that have ended, with their exit status; negative: the signal's number."""
        ended = {one.service: one.process.poll() for one in self._started}
        return {service: status for service, status in ended.items() if status is not None}

    def log_tail(self, service: str) -> str:
        """The last lines that a service wrote for people."""
        (one,) = (one for one in self._started if one.service == service)
        return _tail(one.log_file)

    def close(self) -> None:
        """End all: SIGTERM, and SIGKILL for what is still there after 3.5 s."""
        _end(self._started)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def own_cell_name() -> str:
    """A name that no other cell of this machine has."""
    return f"run-{secrets.token_hex(4)}"


def _free_endpoints(services: Sequence[str]) -> dict[str, str]:
    """Loopback endpoints that nobody listens on just now, all different."""
    with ExitStack() as stack:
        endpoints = {}
        for service in services:
            probe = stack.enter_context(socket.socket())
            probe.bind(("127.0.0.1", 0))
            endpoints[service] = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
    return endpoints


def _spawn(launch: Launch, service: str, endpoints: Mapping[str, str]) -> Started:
    others = [endpoints[other] for other in launch.services if other != service]
    words = ["serve", service, "--name", launch.cell, "--listen", endpoints[service]]
    for endpoint in (*others, *launch.connect):
        words += ["--connect", endpoint]
    words += ["--journal-dir", str(launch.folder), "--parent-pid", str(os.getpid())]
    log_file = launch.folder / f"{service}.log"
    with log_file.open("wb") as output:
        process = subprocess.Popen(
            [sys.executable, _command(), *words, *launch.options],
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,  # Ctrl-C is for the parent, which ends them in its own order
        )
    return Started(service, endpoints[service], process, log_file)


def _command() -> str:
    """The script `surefetch` of this very Python."""
    script = Path(sysconfig.get_path("scripts")) / "surefetch"
    found = str(script) if script.is_file() else shutil.which("surefetch")
    if found is None:
        raise InfrastructureError(
            f"the command surefetch is not there beside {sys.executable}.\n"
            f"  Install the package surefetch-common with that Python."
        )
    return found


def _wait_until_ready(started: Sequence[Started], ready_s: float, *, ports_are_ours: bool) -> None:
    """Return when every service has said so.

    Raises:
        _PortTaken, BadInput, InfrastructureError: one ended, or the time did.
    """
    deadline_s = time.monotonic() + ready_s
    for one in started:
        while not _says_ready(one):
            dead = [other for other in started if other.process.poll() is not None]
            if dead and ports_are_ours and _is_taken(dead[0].endpoint):
                raise _PortTaken
            if dead:
                raise _ended_at_start(dead[0])
            if time.monotonic() > deadline_s:
                raise InfrastructureError(
                    f"{one.service} was not ready within {ready_s:.0f} s. Its last words:\n"
                    f"{_tail(one.log_file)}"
                )
            time.sleep(_LOOK_ROUND_S)


def _says_ready(one: Started) -> bool:
    sign = f"surefetch {one.service} ready ".encode()
    return any(line.startswith(sign) for line in one.log_file.read_bytes().splitlines())


def _is_taken(endpoint: str) -> bool:
    host, port = endpoint.removeprefix("tcp/").rsplit(":", 1)
    with socket.socket() as probe:
        return probe.connect_ex((host, int(port))) == 0


def _ended_at_start(one: Started) -> SurefetchError:
    status, words = one.process.returncode, _tail(one.log_file)
    if status == BadInput.exit_code:  # it has said in a sentence what cannot be used
        return BadInput(f"{one.service}: {words.strip().removeprefix('surefetch: ')}")
    return InfrastructureError(f"{one.service} ended at its start with status {status}:\n{words}")


def _tail(path: Path) -> str:
    lines = path.read_text("utf-8", "replace").splitlines()[-TAIL_LINES:]
    return "\n".join(f"  {line}" for line in lines) or "  (nothing)"


def _end(started: Sequence[Started]) -> None:
    """SIGTERM to all, then SIGKILL to what is left; returns when none is."""
    for one in started:
        if one.process.poll() is None:
            one.process.terminate()
    deadline_s = time.monotonic() + END_S
    for one in started:
        try:
            one.process.wait(max(0.0, deadline_s - time.monotonic()))
        except subprocess.TimeoutExpired:
            one.process.kill()
    for one in started:
        one.process.wait()
