"""The command `surefetch`: word → function, imported on use. It knows words, not robots.

Each function takes its arguments as a list and returns an exit code; errors become a sentence and
an exit code here, in one place.
"""

import difflib
import importlib
import os
import sys
import traceback
from collections.abc import Callable, Iterable
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
    return _load(f"serve {name}", SERVE[name])(rest)


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
    return _load(name, COMMANDS[name].function)(rest)


def _load(command: str, target: str) -> Callable[[list[str]], int]:
    """The function behind ``package.module:function``. Raises BadInput naming what is missing."""
    module, function = target.split(":")
    try:
        found: Callable[[list[str]], int] = getattr(importlib.import_module(module), function)
    except ModuleNotFoundError as error:
        missing = error.name or ""
        package = ".".join(module.split(".")[:2])
        if missing == package:
            distribution = package.replace(".", "-")
            raise BadInput(
                f"{command} needs the package {distribution}, which is not installed here."
            ) from error
        if missing.startswith("surefetch"):
            raise
        raise BadInput(
            f"{command} needs the Python package {missing}, which is not installed here."
        ) from error
    return found


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
