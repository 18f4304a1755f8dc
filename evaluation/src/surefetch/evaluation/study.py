"""`surefetch study WORD …`: from recordings to parameters and tables."""

import sys
from collections.abc import Callable
from typing import Final

from surefetch.common.cli import load
from surefetch.common.errors import BadInput

COMMANDS: Final[dict[str, tuple[str, str]]] = {
    "record": ("recordings.record:main", "capture and perceive every state of many scenes, once"),
    "measure": (
        "replaying.measure_command:main",
        "removals and grasps of recorded scenes, by physics",
    ),
    "fit": (
        "fitting.fit_command:main",
        "observation models and priors from development recordings",
    ),
    "calibrate": (
        "fitting.calibrate_command:main",
        "the conformal threshold from calibration ones",
    ),
    "commit": (
        "fitting.commit_command:main",
        "how sure a grasp must be, by replay on development recordings",
    ),
    "tune": ("tuning.command:main", "the numbers of policies, on development recordings"),
    "fit-introplan": (
        "tuning.introplan_command:main",
        "what the baseline IntroPlan knows beforehand",
    ),
    "gates": (
        "fitting.gates_command:main",
        "is the scene generator hard enough? five controls tell",
    ),
    "episodes": ("running.study_episodes:main", "closed-loop episodes over the real processes"),
    "evaluate": ("replaying.command:main", "policies on recorded scenes, with intervals"),
    "audit": ("replaying.audit_command:main", "do recorded scenes go live as they go in replay?"),
    "report": ("reporting.command:main", "all tables and figures, with the paper's numbers"),
    "perception": ("seeing.command:main", "the perception table"),
}

COMES_WITH: Final = {"cv2": "surefetch-evaluation[demo]"}
"""Python packages of others that a desk without the robot's and perception's packages lacks."""


def main(argv: list[str]) -> int:
    """Run one study command. Raises BadInput for an unknown one."""
    if not argv or argv[0] in ("-h", "--help"):
        sys.stdout.write(_help())
        return 0 if argv else 2
    word, *rest = argv
    if word not in COMMANDS:
        raise BadInput(f'there is no "surefetch study {word}".\n{_help()}')
    return command(word)(rest)


def command(word: str) -> Callable[[list[str]], int]:
    """The function behind a word; imported only when it is asked for.

    Raises:
        BadInput: it needs what is not installed here; names it.
    """
    return load(f"study {word}", f"surefetch.evaluation.{COMMANDS[word][0]}", COMES_WITH)


def _help() -> str:
    width = max(map(len, COMMANDS))
    lines = [f"  {word.ljust(width)}  {what}" for word, (_, what) in COMMANDS.items()]
    return (
        "usage: surefetch study WORD …\n\n" + "\n".join(lines) + "\n\n"
        "surefetch study WORD --help tells the options.\n"
        "example: surefetch study episodes --seeds 100:110 --out study/extended\n"
    )
