"""`surefetch view DIR`: show a run in Rerun, if need be rebuilt from its journal."""

import argparse
import os
import subprocess
import sys
from pathlib import Path

from surefetch.evaluation.running import artifacts


def main(argv: list[str]) -> int:
    """Show one run. Raises BadInput when the folder is none."""
    asked = _parser().parse_args(argv)
    artifacts.read_summary(asked.run)
    recording = asked.run / artifacts.RECORDING
    if asked.rebuild or not recording.exists():
        artifacts.rebuild(asked.run)
        print(f"rebuilt {recording} and {asked.run / artifacts.TRACE} from the journal")
    if asked.open and has_display():
        open_viewer(str(recording))
    else:
        print(f"the recording is {recording}")
        print(f"  in a window:  rerun {recording}")
        print(f"  in a browser: rerun --web-viewer {recording}")
    return 0


def has_display() -> bool:
    """Whether a window can be opened on this machine."""
    if sys.platform == "linux":
        return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    return True


def open_viewer(source: str) -> None:
    """Start the Rerun viewer on a file or a server's address; it lives on by itself."""
    subprocess.Popen(
        [sys.executable, "-m", "rerun", source],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    print(f"opening {source} in the Rerun viewer")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch view",
        description="Show a run in the Rerun viewer: images with masks, the points, the arm, the "
        "belief over time, the actions.",
        epilog="example: surefetch view runs/demo",
    )
    parser.add_argument("run", type=Path, metavar="DIR", help="a folder that surefetch run wrote")
    parser.add_argument(
        "--rebuild", action="store_true", help="draw episode.rrd and trace.png from the journal"
    )
    parser.add_argument(
        "--no-open", dest="open", action="store_false", help="only say where the recording is"
    )
    return parser
