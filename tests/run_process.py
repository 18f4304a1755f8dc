"""`surefetch run` as a process of its own, watched from outside."""

import os
import queue
import subprocess
import sys
import sysconfig
import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

SERVICES = ("executor", "perception", "belief", "planner")


class RunProcess:
    """One `surefetch …` with its output line by line; cells are announced in its own folder."""

    def __init__(self, words: Sequence[str], folder: Path) -> None:
        runtime = folder / "runtime"
        runtime.mkdir(mode=0o700, exist_ok=True)
        script = Path(sysconfig.get_path("scripts")) / "surefetch"
        self.process = subprocess.Popen(
            [sys.executable, str(script), *words],
            cwd=folder,
            env={**os.environ, "XDG_RUNTIME_DIR": str(runtime)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.lines: list[str] = []
        self._told: queue.Queue[str] = queue.Queue()
        self._errors: list[str] = []
        self._readers = [
            threading.Thread(target=self._read_output),
            threading.Thread(target=self._read_errors),
        ]
        for reader in self._readers:
            reader.start()

    def until(self, words: str, timeout_s: float = 60.0) -> None:
        """Wait for a line of stdout with these words."""
        end_s = time.monotonic() + timeout_s
        while True:
            try:
                if words in self._told.get(timeout=max(0.0, end_s - time.monotonic())):
                    return
            except queue.Empty:
                raise AssertionError(f"no line with {words!r} came:\n{self.text()}") from None

    def pids(self) -> dict[str, int]:
        """The service processes that it has started, by the process list."""
        found = {}
        for pid in _children(self.process.pid):
            words = _command(pid)
            if "serve" in words:
                found[words[words.index("serve") + 1]] = pid
        return found

    def wait(self, timeout_s: float = 60.0) -> int:
        """Its exit status."""
        status = self.process.wait(timeout_s)
        for reader in self._readers:
            reader.join(5.0)
        return status

    def text(self) -> str:
        """All it wrote to stdout."""
        return "".join(self.lines)

    def errors(self) -> str:
        """All it wrote to stderr."""
        return "".join(self._errors)

    def end(self) -> None:
        """Leave nothing behind, however the test ended."""
        if self.process.poll() is None:
            self.process.kill()
        self.wait()

    def _read_output(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as output:
            for line in output:
                self.lines.append(line)
                self._told.put(line)

    def _read_errors(self) -> None:
        assert self.process.stderr is not None
        with self.process.stderr as errors:
            self._errors.extend(errors)


def is_there(pid: int) -> bool:
    """Whether a process runs; one that has ended and waits for its parent does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def _children(parent: int) -> Iterator[int]:
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except (FileNotFoundError, ProcessLookupError):
            continue
        if int(fields[1]) == parent:
            yield int(path.parent.name)


def _command(pid: int) -> list[str]:
    try:
        return Path(f"/proc/{pid}/cmdline").read_text().split("\0")
    except (FileNotFoundError, ProcessLookupError):
        return []
