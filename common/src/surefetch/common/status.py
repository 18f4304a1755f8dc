"""`surefetch status`: who is up in a cell, and what they do."""

import argparse
import json
from collections.abc import Sequence

import msgspec

from surefetch.common.errors import InfrastructureError
from surefetch.common.joining import FoundCell, find_cell
from surefetch.common.messages import Status
from surefetch.common.running_cells import newest_cell
from surefetch.common.topics import SERVICES

HEAD = ("service", "host", "pid", "version", "backend", "doing")


def main(argv: list[str]) -> int:
    """Show the cell; 0 if something is up there.

    Raises:
        BadInput, InfrastructureError: no cell was found.
    """
    told = _parser().parse_args(argv)
    connect = told.connect or newest_cell().endpoints
    found = find_cell(connect)
    if found is None:
        raise InfrastructureError(f"nothing is up at {', '.join(connect)}.")
    print(json.dumps(_plain(found)) if told.json else table(found))
    return 0


def table(found: FoundCell) -> str:
    """The cell for people, a line per service; a missing one is named too."""
    by_name = {status.service: status for status in found.services}
    rows = [HEAD, *(_row(service, by_name.get(service)) for service in SERVICES)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [f"cell {found.name}"]
    lines += [_aligned(row, widths) for row in rows]
    return "\n".join(lines)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch status",
        description="Who is up in a cell. Without --connect: in this user's newest cell here.",
        epilog="example: surefetch status --connect tcp/127.0.0.1:7447 --json",
    )
    parser.add_argument(
        "--connect", action="append", metavar="ENDPOINT", help="a cell's endpoint: tcp/HOST:PORT"
    )
    parser.add_argument("--json", action="store_true", help="one JSON object")
    return parser


def _plain(found: FoundCell) -> dict[str, object]:
    services = {
        status.service: {
            name: value for name, value in msgspec.to_builtins(status).items() if name != "type"
        }
        for status in found.services
    }
    missing = [service for service in SERVICES if service not in services]
    return {
        "cell": found.name,
        "endpoints": list(found.endpoints),
        "services": services,
        "missing": missing,
    }


def _row(service: str, status: Status | None) -> tuple[str, ...]:
    if status is None:
        return (service, "-", "-", "-", "-", "not up")
    return (
        service,
        status.host,
        str(status.pid),
        status.version,
        status.backend,
        status.doing or "waits",
    )


def _aligned(row: Sequence[str], widths: Sequence[int]) -> str:
    return "  ".join(word.ljust(width) for word, width in zip(row, widths, strict=True)).rstrip()
