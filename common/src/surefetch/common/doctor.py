"""`surefetch doctor`: what works on this machine, and what does not and is needed."""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Final, Literal

from surefetch.common import codec
from surefetch.common.bus import Call
from surefetch.common.errors import InfrastructureError, SurefetchError
from surefetch.common.messages import Empty, Vocabulary
from surefetch.common.running_cells import default_folder
from surefetch.common.settings import BusSettings, free_endpoint
from surefetch.common.topics import PERCEPTION, VOCABULARY
from surefetch.common.zenoh_bus import ZenohBus

Grade = Literal["works", "absent", "fails"]
"""Absent: not installed, and this machine may not need it. Fails: needed here, and broken."""

IMPORT_S: Final = 60.0

PACKAGES: Final = {
    "surefetch-common": ("msgspec", "numpy", "zenoh", "PIL", "platformdirs"),
    "surefetch-executor": ("pybullet", "fcl", "ompl", "ruckig", "scipy"),
    "surefetch-perception": ("cv2", "scipy"),
    "surefetch-belief": ("scipy",),
    "surefetch-planner": ("numpy",),
    "surefetch-evaluation": ("rerun", "rich", "matplotlib"),
}
"""Each distribution and the packages without which it does nothing."""
EXTRAS: Final = ("torch",)


@dataclass(frozen=True)
class Finding:
    """One thing looked at."""

    what: str
    grade: Grade
    detail: str


def main(argv: list[str]) -> int:
    """Look at this machine; 0 if everything that is installed works, else 3."""
    told = _parser().parse_args(argv)
    findings = examine()
    fails = [finding for finding in findings if finding.grade == "fails"]
    if told.json:
        print(json.dumps({"ok": not fails, "findings": [asdict(one) for one in findings]}))
    else:
        print("\n".join(_line(finding) for finding in findings))
        print(_verdict(fails))
    return InfrastructureError.exit_code if fails else 0


def examine() -> tuple[Finding, ...]:
    """Everything that is worth knowing, in the order in which it is needed."""
    installed = {name for name in PACKAGES if _version(name) is not None}
    modules = sorted({module for name in installed for module in PACKAGES[name]})
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        imports = pool.map(_import, (*modules, *EXTRAS))
    return (
        _python(),
        *(_distribution(name) for name in PACKAGES),
        *imports,
        _try("loopback", _loop_back),
        _try("runtime folder", _write_runtime_folder),
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch doctor",
        description="What works on this machine. Status 3 if something needed here does not.",
        epilog="example: surefetch doctor --json",
    )
    parser.add_argument("--json", action="store_true", help="one JSON object")
    return parser


def _line(finding: Finding) -> str:
    sign = {"works": "ok", "absent": "-", "fails": "FAILS"}[finding.grade]
    return f"{sign:<6} {finding.what:<21} {finding.detail}"


def _verdict(fails: list[Finding]) -> str:
    if not fails:
        return "Everything that is installed here works."
    return f"Does not work: {', '.join(finding.what for finding in fails)}."


def _python() -> Finding:
    have = ".".join(map(str, sys.version_info[:3]))
    if sys.version_info[:2] == (3, 11):
        return Finding("Python", "works", have)
    return Finding("Python", "fails", f"{have} runs; surefetch needs 3.11")


def _version(distribution: str) -> str | None:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return None


def _distribution(name: str) -> Finding:
    have, common = _version(name), _version("surefetch-common")
    if have is None:
        return Finding(name, "absent", "not installed here")
    if have != common:
        return Finding(name, "fails", f"{have}, but surefetch-common is {common}; use one version")
    return Finding(name, "works", have)


def _import(module: str) -> Finding:
    """In a process of its own, so that a crash at import is a finding too."""
    program = f"import {module}; print(getattr({module}, '__version__', ''))"
    try:
        done = subprocess.run(
            [sys.executable, "-c", program], capture_output=True, text=True, timeout=IMPORT_S
        )
    except subprocess.TimeoutExpired:
        return Finding(module, "fails", f"its import takes more than {IMPORT_S:.0f} s")
    if done.returncode == 0:
        words = done.stdout.split()
        return Finding(module, "works", words[-1] if words else "")
    last = (done.stderr.strip().splitlines() or [f"status {done.returncode}"])[-1]
    optional = module in EXTRAS and f"No module named '{module}'" in last
    return Finding(module, "absent" if optional else "fails", last)


def _try(what: str, check: Callable[[], str]) -> Finding:
    try:
        return Finding(what, "works", check())
    except (SurefetchError, OSError) as error:
        return Finding(what, "fails", str(error))


def _loop_back() -> str:
    """Ask a question over Zenoh from one end of the loopback to the other."""
    endpoint = free_endpoint()
    words = Vocabulary(
        backend="doctor", open=True, nouns=(), colors=(), shapes=(), markings=(), containers=()
    )

    def reply(call: Call) -> None:
        call.reply(codec.encode(words, max_bytes=VOCABULARY.max_reply_bytes))

    with (
        closing(ZenohBus(BusSettings("doctor", listen=(endpoint,)), PERCEPTION)) as answering,
        closing(ZenohBus(BusSettings("doctor", connect=(endpoint,)))) as asking,
    ):
        answering.answer(VOCABULARY, reply)
        answering.announce()
        asking.ask(VOCABULARY, Empty(), timeout_s=5.0)
        start_s = time.perf_counter()
        asking.ask(VOCABULARY, Empty(), timeout_s=5.0)
        return f"a question and its answer take {1e3 * (time.perf_counter() - start_s):.1f} ms"


def _write_runtime_folder() -> str:
    folder = default_folder()
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    with tempfile.TemporaryFile(dir=folder):
        return str(folder)
