"""The command `surefetch`: word → function, imported on use. It knows words, not robots.

Each function takes its arguments as a list and returns an exit code; errors become a sentence and
an exit code here, in one place.
"""

import difflib
import importlib
import os
import sys
import traceback
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from surefetch.common.errors import BadInput, SurefetchError

INTERRUPTED: Final = 130
PIPE_CLOSED: Final = 141


@dataclass(frozen=True)
class Command:
    """One word of the command line."""

    function: str
    """``package.module:function``"""
    does: str
    example: str


COMMANDS: Final = {
    "run": Command(
        "surefetch.evaluation.running.run:main",
        "fetch, once, in simulation: one episode on the four services",
        'surefetch run "the red cylinder inside the box" --scene covered:1',
    ),
    "serve": Command(
        "surefetch.common.cli:serve",
        "run one service in the foreground: executor, perception, belief or planner",
        "surefetch serve belief --listen tcp/127.0.0.1:7447 --connect tcp/127.0.0.1:7448",
    ),
    "stop": Command(
        "surefetch.common.stop:main",
        "stop all motion now",
        "surefetch stop",
    ),
    "status": Command(
        "surefetch.common.status:main",
        "who is up in a cell, and what they do",
        "surefetch status --connect tcp/127.0.0.1:7447",
    ),
    "watch": Command(
        "surefetch.evaluation.showing.watch:main",
        "live view of a running cell, read-only",
        "surefetch watch --connect tcp/127.0.0.1:7447",
    ),
    "doctor": Command(
        "surefetch.common.doctor:main",
        "what works on this machine",
        "surefetch doctor",
    ),
    "view": Command(
        "surefetch.evaluation.showing.view:main",
        "rebuild and show a run's view",
        "surefetch view runs/demo",
    ),
    "replay": Command(
        "surefetch.evaluation.running.replay:main",
        "take a run's decisions again from its journal",
        "surefetch replay runs/demo",
    ),
    "perceive": Command(
        "surefetch.perception.perceive:main",
        "perception alone, on a stored RGB-D frame",
        'surefetch perceive frames/7 "the red cylinder" --json',
    ),
    "filter": Command(
        "surefetch.belief.cases:main",
        "work out cases of the filter, the conformal rule and the association",
        "surefetch filter filter.json",
    ),
    "solve": Command(
        "surefetch.planner.cases:main",
        "work out cases of the planner",
        "surefetch solve plan.json",
    ),
    "study": Command(
        "surefetch.evaluation.study:main",
        "record scenes, fit parameters, calibrate, compare policies",
        "surefetch study record --seeds 0:20 --out recordings/first",
    ),
}

SERVE: Final = {
    service: f"surefetch.{service}.__main__:main"
    for service in ("executor", "perception", "belief", "planner")
}


def main(argv: list[str] | None = None) -> int:
    """Run one command; its exit code.

    Args:
        argv: the words after ``surefetch``; None: those of this process.
    """
    words = sys.argv[1:] if argv is None else argv
    debug = "--debug" in words
    try:
        status = _run([word for word in words if word != "--debug"])
        sys.stdout.flush()
        return status
    except BrokenPipeError:  # whoever reads our output has seen enough, as `head` does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE_CLOSED
    except SurefetchError as error:
        if debug:
            traceback.print_exc()
        print(f"surefetch: {error}", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        print("surefetch: interrupted from the keyboard.", file=sys.stderr)
        return INTERRUPTED
    except Exception:
        traceback.print_exc()
        print("surefetch: this is an error in surefetch itself; please report it.", file=sys.stderr)
        return SurefetchError.exit_code


def serve(argv: list[str]) -> int:
    """`surefetch serve NAME …`: the rest goes to the service."""
    name, *rest = argv or ["--help"]
    if name in ("-h", "--help"):
        print(_serve_help())
        return 0
    if name not in SERVE:
        raise BadInput(_unknown("service", name, SERVE))
    return load(f"serve {name}", SERVE[name])(rest)


def _run(words: list[str]) -> int:
    name, *rest = words or ["--help"]
    if name in ("-h", "--help", "help"):
        print(_help())
        return 0
    if name == "--version":
        print(f"surefetch {importlib.import_module('surefetch.common.version').VERSION}")
        return 0
    if name not in COMMANDS:
        raise BadInput(_unknown("command", name, COMMANDS))
    return load(name, COMMANDS[name].function)(rest)


def load(
    command: str, target: str, comes_with: Mapping[str, str] | None = None
) -> Callable[[list[str]], int]:
    """The function behind ``package.module:function``.

    Args:
        command: the words that lead to it, for the error.
        target: the function.
        comes_with: by Python package, the distribution to install for it.

    Raises:
        BadInput: it needs what is not installed here; names it.
    """
    module, function = target.split(":")
    try:
        found: Callable[[list[str]], int] = getattr(importlib.import_module(module), function)
    except ModuleNotFoundError as error:
        missing = error.name or ""
        if _is_ours(missing):
            raise
        raise BadInput(_not_installed(command, missing, comes_with or {})) from error
    return found


def _is_ours(missing: str) -> bool:
    """Whether the module is missing from a distribution of ours that is here: our own mistake."""
    distribution = _distribution(missing)
    if distribution is None or missing.count(".") < 2:
        return False
    metadata = importlib.import_module("importlib.metadata")  # slow to import, and seldom needed
    try:
        metadata.version(distribution)
    except ModuleNotFoundError:
        return False
    return True


def _distribution(module: str) -> str | None:
    """`surefetch-executor` for `surefetch.executor.robot`; None for a module of others."""
    ours, *parts = module.split(".")
    return f"{ours}-{parts[0]}" if ours == "surefetch" and parts else None


def _not_installed(command: str, missing: str, comes_with: Mapping[str, str]) -> str:
    distribution = _distribution(missing)
    if distribution is not None:
        return f"{command} needs the package {distribution}, which is not installed here."
    if missing in comes_with:
        return (
            f"{command} needs the Python package {missing}, which is not installed here.\n"
            f"  It comes with {comes_with[missing]}."
        )
    return f"{command} needs the Python package {missing}, which is not installed here."


def _unknown(kind: str, name: str, known: Iterable[str]) -> str:
    close = difflib.get_close_matches(name, known, n=1)
    hint = f' Did you mean "{close[0]}"?' if close else ""
    return f'there is no {kind} "{name[:80]}".{hint}\n  There are: {", ".join(known)}.'


def _help() -> str:
    lines = ["surefetch: fetches the object that a sentence names.", "", "Commands:"]
    for name, command in COMMANDS.items():
        lines += [f"  {name:<9} {command.does}", f"            $ {command.example}"]
    lines += [
        "",
        "surefetch COMMAND --help tells its options. --version: the version.",
        "--debug: with an error, where in the code it was raised.",
    ]
    return "\n".join(lines)


def _serve_help() -> str:
    return (
        f"usage: surefetch serve {{{','.join(SERVE)}}} [options]\n\n"
        f"{COMMANDS['serve'].does}\n\n"
        f"  $ {COMMANDS['serve'].example}\n\n"
        "surefetch serve NAME --help tells the options."
    )


if __name__ == "__main__":
    sys.exit(main())
