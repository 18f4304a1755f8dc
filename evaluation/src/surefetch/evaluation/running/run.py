"""`surefetch run`: one episode on the four services, shown while it happens, kept in a folder."""

import json
import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

from msgspec import structs
from rich.console import Console

from surefetch.common.errors import BadInput
from surefetch.common.instruction import parse
from surefetch.common.messages import Empty, Instruct
from surefetch.common.topics import VOCABULARY
from surefetch.evaluation.running import artifacts, scoring, summary
from surefetch.evaluation.running.cell import CellWanted, LiveCell, open_cell
from surefetch.evaluation.running.live import Finished, Live
from surefetch.evaluation.running.request import RunRequest, read_request
from surefetch.evaluation.showing.progress import Progress

if TYPE_CHECKING:
    from surefetch.evaluation.scenes.generate import GeneratedScene

VOCABULARY_S: Final = 10.0


def main(argv: list[str]) -> int:
    """Run one episode; the exit code comes from its outcome.

    Raises:
        BadInput: something asked for cannot be used; nothing moved and nothing was written.
        InfrastructureError: the episode could not begin.
    """
    request = read_request(argv)
    progress = Progress(Console(stderr=request.json, highlight=False))
    try:
        told = _run(request, progress)
    finally:
        progress.close()
    if told["outcome"] == "aborted":
        print(f"surefetch: {told['because']}", file=sys.stderr)
    if request.json:
        print(json.dumps(told, allow_nan=False, ensure_ascii=False), flush=True)
    return summary.exit_code(told["outcome"])


def _run(request: RunRequest, progress: Progress) -> dict[str, Any]:
    wanted = CellWanted(request.config, request.connect, request.real_time)
    with open_cell(wanted, progress.wait) as cell:
        progress.say(f"cell        {cell.name} at {cell.endpoints[0]}", style="dim")
        _check_words(request, cell)
        scene = _scene(request, progress)
        finished = _episode(request, scene, cell, progress)
        progress.ended(finished.ended)
        for service, words in cell.last_words().items():
            print(f"surefetch: the last words of {service}:\n{words}", file=sys.stderr)
        progress.wait("ending the services …")
    told = _told(request, scene, cell, finished)
    progress.wait("writing the run …")
    artifacts.write(request.out, told, finished.observed, finished.journals)
    if told["verdict"] is not None:
        progress.say(f"scored      {told['verdict'].replace('_', ' ')}", style="dim")
    progress.say(f"kept in     {request.out}", style="dim")
    return told


def _check_words(request: RunRequest, cell: LiveCell) -> None:
    """Refuse a sentence of the user's own before a scene is made for it."""
    if request.instruction is None:
        return
    vocabulary = cell.bus.ask(VOCABULARY, Empty(), timeout_s=VOCABULARY_S)
    if not vocabulary.open:
        parse(request.instruction, vocabulary)


def _scene(request: RunRequest, progress: Progress) -> "GeneratedScene | None":
    if request.scene is None:
        return None
    progress.wait(f"setting the table {request.scene} …")
    try:  # a desk that only follows a cell has no simulated table
        generate = import_module("surefetch.evaluation.scenes.generate").generate
    except ModuleNotFoundError as error:
        if error.name != "surefetch.executor":
            raise
        raise BadInput(
            "--scene needs the package surefetch-executor, which is not installed here.\n"
            "  Install it: pip install --constraint constraints.txt ./services/executor"
        ) from None
    scene: GeneratedScene = generate(request.scene.family, request.scene.seed)
    return scene


def _episode(
    request: RunRequest, scene: "GeneratedScene | None", cell: LiveCell, progress: Progress
) -> Finished:
    sentence = request.instruction or (scene.sentence if scene is not None else "")
    progress.say(f"asked       {sentence}")
    progress.wait("understanding …")
    instruct = Instruct(
        sentence=sentence,
        profile=request.profile,
        policy=request.policy,
        after_grasp=request.after_grasp,
    )
    table = None if scene is None else structs.replace(scene.scene, injected=request.injected)
    return Live(cell).run(instruct, table, progress.show)


def _told(
    request: RunRequest, scene: "GeneratedScene | None", cell: LiveCell, finished: Finished
) -> dict[str, Any]:
    told = summary.summarize(
        scene="" if request.scene is None else str(request.scene),
        instruction=request.instruction or (scene.sentence if scene is not None else ""),
        profile=request.profile,
        policy=request.policy,
        accepted=finished.accepted,
        ended=finished.ended,
        score=_score(request, scene, finished),
        wall_s=finished.wall_s,
        services=cell.statuses,
        missing=finished.missing,
    )
    return told | {"injected": [str(one) for one in request.injected]}


def _score(
    request: RunRequest, scene: "GeneratedScene | None", finished: Finished
) -> scoring.Score:
    """By the scene's own target; an instruction of the user's own by what it says."""
    if scene is None:
        return scoring.UNKNOWN
    if request.instruction is None:
        asked = scoring.Asked(scene.truth.target)
    else:
        asked = scoring.meant(finished.accepted.target, scene.scene)
    return scoring.score(finished.ended, asked, finished.truth)
