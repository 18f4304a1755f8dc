"""`surefetch replay DIR`: a run's decisions once more from its journal, compared bit for bit."""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from surefetch.common.errors import BadInput
from surefetch.common.journal import read_journal
from surefetch.common.messages import Decided
from surefetch.common.topics import PLANNER
from surefetch.evaluation.running import artifacts
from surefetch.evaluation.showing import words
from surefetch.planner.replay import Redone, decisions


def main(argv: list[str]) -> int:
    """Take the decisions again; 0 when all are the same, 1 when one differs.

    Raises:
        BadInput: the folder is no run, or the planner's journal is not in it.
    """
    asked = _parser().parse_args(argv)
    artifacts.read_summary(asked.run)
    path = artifacts.journal_path(asked.run, PLANNER)
    if not path.exists():
        raise BadInput(f"{asked.run} has no journal of the planner; its decisions are not known.")
    redone = decisions(read_journal(path))
    differ = sum(not one.same for one in redone)
    for one in redone:
        print(line(one))
    print(_sum(len(redone), differ))
    if asked.json:
        print(json.dumps(_plain(redone), allow_nan=False))
    return 1 if differ else 0


def line(redone: Redone) -> str:
    """One decision for people."""
    taken = words.choice(redone.recorded.choice)
    if redone.same:
        return f"step {redone.step}  {taken}  equal"
    if redone.again is None:
        return f"step {redone.step}  {taken}  different: it is not taken again"
    return f"step {redone.step}  {taken}  different: {_difference(redone.recorded, redone.again)}"


def _difference(recorded: Decided, again: Decided) -> str:
    if recorded.choice != again.choice:
        return f"now {words.choice(again.choice)}"
    if recorded.q_values != again.q_values:
        return f"now at {', '.join(map(words.q_value, again.q_values))}"
    if recorded.because != again.because:
        return f"now because: {again.because}"
    return "by what the robot said it can do"


def _sum(n: int, differ: int) -> str:
    if n == 0:
        return "the episode ended before its first decision."
    if differ == 0:
        return f"all {n} decisions are the same, bit for bit."
    return f"{differ} of {n} decisions differ."


def _plain(redone: Sequence[Redone]) -> dict[str, Any]:
    return {
        "decisions": [
            {
                "step": one.step,
                "choice": words.choice(one.recorded.choice),
                "again": None if one.again is None else words.choice(one.again.choice),
                "same": one.same,
            }
            for one in redone
        ],
        "same": all(one.same for one in redone),
    }


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch replay",
        description="Take the decisions of a run again, from the planner's journal alone, and "
        "compare them bit for bit.",
        epilog="example: surefetch replay runs/demo",
    )
    parser.add_argument("run", type=Path, metavar="DIR", help="a folder that surefetch run wrote")
    parser.add_argument("--json", action="store_true", help="one JSON object as the last line")
    return parser
