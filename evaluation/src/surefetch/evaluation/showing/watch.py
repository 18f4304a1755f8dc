"""`surefetch watch`: a running cell in Rerun, live. It listens, fetches frames, and no more."""

import argparse
import socket
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final
from urllib.parse import quote

import rerun as rr
from rich.console import Console

from surefetch.common.errors import BadInput
from surefetch.common.joining import join
from surefetch.common.running_cells import newest_cell
from surefetch.evaluation.showing.live_view import LiveView
from surefetch.evaluation.showing.progress import Progress
from surefetch.evaluation.showing.recording_view import APPLICATION, blueprint
from surefetch.evaluation.showing.view import has_display, open_viewer

GRPC_PORT: Final = 9876
WEB_PORT: Final = 9090
LOOPBACK: Final = "127.0.0.1"


def main(argv: list[str]) -> int:
    """Watch until Ctrl-C or until the cell is gone.

    Raises:
        BadInput, InfrastructureError: no cell was found, or the file cannot be written.
    """
    asked = _parser().parse_args(argv)
    if asked.save is not None:
        _check_writable(asked.save)
    bus = join(asked.connect or newest_cell().endpoints)
    progress = Progress(Console(highlight=False))
    server = _serve(progress, open_window=asked.open)
    view = LiveView(bus, _Recordings(server.address, asked.save).begin, progress.show)
    try:
        view.draw_until(lambda: not bus.alive())
        progress.say("the cell is gone.", style="dim")
    except KeyboardInterrupt:
        pass
    finally:
        view.close()
        progress.close()
        bus.close()
    return 0


@dataclass(frozen=True, eq=False)
class _Server:
    """Passes recordings on to viewers, as long as its stream lives."""

    address: str
    stream: rr.RecordingStream


class _Recordings:
    """One recording per episode, to the viewers and to a file."""

    def __init__(self, server: str, save: Path | None) -> None:
        self._server = server
        self._save = save
        self._n = 0

    def begin(self, episode: str) -> rr.RecordingStream:
        recording = rr.RecordingStream(APPLICATION, recording_id=episode)
        sinks: list[Any] = [rr.GrpcSink(self._server)]
        if self._save is not None:
            sinks.append(rr.FileSink(_numbered(self._save, self._n)))
        recording.set_sinks(*sinks, default_blueprint=blueprint())
        self._n += 1
        return recording


def _numbered(path: Path, n: int) -> Path:
    """The file of the n-th episode: the name itself, then ``NAME-2.rrd`` and so on."""
    return path if n == 0 else path.with_stem(f"{path.stem}-{n + 1}")


def _serve(progress: Progress, *, open_window: bool) -> _Server:
    """Serve viewers on this machine, and say how to look."""
    port, web_port = _free(GRPC_PORT), _free(WEB_PORT)
    address = f"rerun+http://{LOOPBACK}:{port}/proxy"
    stream = rr.RecordingStream(APPLICATION, recording_id="server")
    stream.set_sinks(rr.GrpcServerSink(LOOPBACK, port))
    rr.serve_web_viewer(web_port=web_port, open_browser=False)
    progress.say(f"in a browser: http://{LOOPBACK}:{web_port}/?url={quote(address, safe='')}")
    if open_window and has_display():
        open_viewer(address)
    else:
        progress.say(f"in a window:  rerun {address}")
    progress.say("Ctrl-C ends watching; the cell goes on.", style="dim")
    return _Server(address, stream)


def _free(port: int) -> int:
    """This port of the loopback if nobody listens there, else another."""
    for wanted in (port, 0):
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((LOOPBACK, wanted))
            except OSError:
                continue
            found: int = probe.getsockname()[1]
            return found
    raise BadInput("no port is free on this machine for the viewer.")


def _check_writable(path: Path) -> None:
    if path.suffix != ".rrd" or not path.parent.is_dir():
        raise BadInput(f"--save {path}: name a file NAME.rrd in a folder that is there.")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch watch",
        description="Watch a running cell in the Rerun viewer, from any machine that reaches it; "
        "nothing in the cell is changed. Without --connect: this user's newest cell here.",
        epilog="example: surefetch watch --connect tcp/127.0.0.1:7447 --save seen.rrd",
    )
    parser.add_argument(
        "--connect", action="append", metavar="ENDPOINT", help="a cell's endpoint: tcp/HOST:PORT"
    )
    parser.add_argument("--save", type=Path, metavar="FILE.rrd", help="keep a recording too")
    parser.add_argument(
        "--no-open", dest="open", action="store_false", help="open no window, only serve"
    )
    return parser
