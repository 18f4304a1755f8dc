"""The services' journals of one episode, asked for over the bus; a dead one's from its file."""

import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from surefetch.common.bus import Bus
from surefetch.common.errors import SurefetchError
from surefetch.common.journal import LENGTH
from surefetch.common.messages import JournalBytes, JournalPage
from surefetch.common.topics import JOURNAL, SERVICES

PAGE_S: Final = 5.0


def sizes(bus: Bus) -> dict[str, int]:
    """How long each journal is now; an episode that begins now is what comes after."""
    return {service: _page(bus, service, 0).total for service in SERVICES}


def collect(
    bus: Bus, since: Mapping[str, int], folder: Path
) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """Each journal's header and its records from these sizes on; in words what could not be had.

    Args:
        bus: on which the services are asked that are alive.
        since: `sizes` before the episode.
        folder: where services that were started here write their journals.
    """
    found: dict[str, bytes] = {}
    missing = []
    for service in SERVICES:
        try:
            if service in bus.alive():
                found[service] = _from_bus(bus, service, since[service])
            else:
                found[service] = _from_file(folder, service, since[service])
        except (SurefetchError, OSError) as error:
            missing.append(f"journal of {service}: {error}")
    return found, tuple(missing)


def _page(bus: Bus, service: str, offset: int) -> JournalBytes:
    return bus.ask(JOURNAL[service], JournalPage(offset=offset), timeout_s=PAGE_S)


def _from_bus(bus: Bus, service: str, since: int) -> bytes:
    page = _page(bus, service, 0)
    header = _header(page.content)
    parts = [header]
    offset = max(since, len(header))
    while offset < page.total and page.content:
        page = _page(bus, service, offset)
        parts.append(page.content)
        offset += len(page.content)
    return b"".join(parts)


def _from_file(folder: Path, service: str, since: int) -> bytes:
    for path in folder.glob(f"{service}-*.journal"):
        whole = path.read_bytes()
        header = _header(whole)
        return header + whole[max(since, len(header)) :]
    raise FileNotFoundError(f"{service} is gone, and was not started by this run")


def _header(content: bytes) -> bytes:
    """The first record, which says what the journal is."""
    try:
        (length,) = LENGTH.unpack_from(content)
    except struct.error:
        return content
    return content[: LENGTH.size + length]
