"""The words of `surefetch run`, checked before anything is started."""

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

from surefetch.common import injections, policies
from surefetch.common.cell import read_cell
from surefetch.common.errors import BadInput
from surefetch.common.instruction import MAX_CHARACTERS
from surefetch.common.messages import Injection
from surefetch.common.settings import read_machine
from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.running import artifacts

AfterGrasp = Literal["deliver", "hold", "return"]
AFTER_GRASP: Final[tuple[AfterGrasp, ...]] = ("deliver", "hold", "return")
INJECT_HELP: Final = (
    "report the K-th grasp, view or cover removal as failed, without trying it; view@0.2: each "
    "with this chance; simulation only"
)
MAX_SEED: Final = 2**63 - 1


@dataclass(frozen=True)
class SceneName:
    """The name of a scene: ``FAMILY:SEED``."""

    family: str
    seed: int

    def __str__(self) -> str:
        return f"{self.family}:{self.seed}"


@dataclass(frozen=True)
class RunRequest:
    """One episode as the user asked for it."""

    instruction: str | None
    """None: the scene's own sentence."""
    scene: SceneName | None
    """None: whatever stands in a cell that is up already."""
    profile: str
    policy: str
    after_grasp: AfterGrasp
    config: Path | None
    connect: tuple[str, ...]
    real_time: bool
    injected: tuple[Injection, ...]
    """Attempts that the simulated executor reports as failed instead of making them."""
    out: Path
    json: bool


def read_request(argv: Sequence[str]) -> RunRequest:
    """What the command line asks for.

    Raises:
        BadInput: a word that cannot be used; nothing was started.
    """
    told = _parser().parse_args(argv)
    profile, policy = policies.choose(told.profile, told.policy)
    scene = None if told.scene is None else parse_scene(told.scene)
    _check_sentence(told.instruction)
    if scene is None and (told.instruction is None or not (told.connect or told.config)):
        raise BadInput(
            "name a scene: --scene FAMILY:SEED\n"
            "  Without one, an instruction and a cell that is up are needed: --connect ENDPOINT"
        )
    injected = tuple(injections.parse(word) for word in told.inject or ())
    if injected and scene is None:
        raise BadInput("failures are injected in simulation only: name a scene with --scene")
    if told.config is not None:
        _check_config(told.config)
    out = default_out(scene) if told.out is None else told.out
    artifacts.check_free(out)
    return RunRequest(
        instruction=told.instruction,
        scene=scene,
        profile=profile,
        policy=policy,
        after_grasp=told.after_grasp,
        config=told.config,
        connect=tuple(told.connect or ()),
        real_time=told.real_time,
        injected=injected,
        out=out,
        json=told.json,
    )


def parse_scene(text: str) -> SceneName:
    """A scene's name. Raises BadInput that says what there is."""
    family, colon, seed = text.partition(":")
    if family not in FAMILIES:
        raise BadInput(f'there is no family "{family}".\n  Families: {", ".join(FAMILIES)}')
    if not colon or not seed.isascii() or not seed.isdigit() or int(seed) > MAX_SEED:
        raise BadInput(
            f"a scene is named FAMILY:SEED with a whole number from 0 to 2^63 - 1; found "
            f'"{text[:80]}".\n  For instance: {family}:1'
        )
    return SceneName(family, int(seed))


def default_out(scene: SceneName | None) -> Path:
    """Where a run goes without --out: ``runs/<time>-<scene>``."""
    name = "cell" if scene is None else f"{scene.family}-{scene.seed}"
    return Path("runs") / f"{time.strftime('%Y%m%d-%H%M%S')}-{name}"


def _check_sentence(sentence: str | None) -> None:
    """What can be told without a vocabulary; the planner tells the rest."""
    if sentence is None:
        return
    if not sentence.strip():
        raise BadInput('the instruction is empty.\n  Say what to fetch: "the red cylinder"')
    if len(sentence) > MAX_CHARACTERS:
        raise BadInput(
            f"the instruction has {len(sentence)} characters; at most {MAX_CHARACTERS} are read."
        )


def _check_config(path: Path) -> None:
    machine = read_machine(path)
    if machine.cell is not None:
        read_cell(path.parent / machine.cell)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch run",
        description="Fetch, once: one episode of perception, belief, planner and executor, each a "
        "process of its own. Services that are missing are started, and ended with the run.",
        epilog='example: surefetch run "the red cylinder inside the box" --scene covered:1',
    )
    parser.add_argument(
        "instruction",
        nargs="?",
        metavar="INSTRUCTION",
        help="what to fetch; without it, the scene's own sentence",
    )
    parser.add_argument(
        "--scene", metavar="FAMILY:SEED", help=f"simulated table; {', '.join(FAMILIES)}"
    )
    parser.add_argument("--profile", metavar="P", help="extended (default) or paper")
    parser.add_argument("--policy", metavar="NAME", help=f"{', '.join(policies.OWN_PROFILE)}")
    parser.add_argument("--config", type=Path, metavar="F", help="TOML file of the cell")
    parser.add_argument(
        "--connect", action="append", metavar="ENDPOINT", help="use the cell that is up there"
    )
    parser.add_argument(
        "--after-grasp", choices=AFTER_GRASP, default="deliver", help="default: deliver"
    )
    parser.add_argument("--real-time", action="store_true", help="pace motion to the clock")
    parser.add_argument("--inject", action="append", metavar="KIND@K", help=INJECT_HELP)
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="default: runs/<time>-<scene>; an earlier run there is replaced",
    )
    parser.add_argument("--json", action="store_true", help="the summary as stdout's last line")
    return parser
