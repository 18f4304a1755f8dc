"""Many policies on all scenes of a folder, each recording read once; over local cores."""

import multiprocessing
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import Final

import msgspec

from surefetch.common.cell import simulated_cell
from surefetch.common.parameters import PROFILES, profile_parameters
from surefetch.evaluation.recordings import recording_store
from surefetch.evaluation.replaying.contenders import Contender, contender
from surefetch.evaluation.replaying.evaluate import Conditions, Finish, evaluate
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.replaying.scene import ready

ONE_THREAD: Final = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
PORTION: Final = 5
"""Scenes that a process takes at a time: one of each family, as a rule."""

Address = tuple[str, int]


@dataclass(frozen=True)
class Campaign:
    """What is to be played, in words that another process understands too."""

    recordings: Path
    policies: tuple[str, ...]
    profile: str
    """Of policies that name none and bring none."""
    parameters: Path | None
    conditions: Conditions
    finish_live: bool = False
    """Episodes that leave their recording are finished in the simulator."""

    def of(self, policies: Sequence[str]) -> "Campaign":
        """The same, of these policies."""
        return replace(self, policies=tuple(policies))

    def contenders(self) -> list[Contender]:
        """The policies, ready to play. Raises BadInput for what there is not."""
        numbers = {name: profile_parameters(name, self.parameters) for name in PROFILES}
        return [contender(label, self.profile, numbers) for label in self.policies]


def run(campaign: Campaign, jobs: int) -> Iterator[list[EpisodeResult]]:
    """Scene after scene, in the order of the folder, what came of every policy in their order."""
    scenes = recording_store.scenes(campaign.recordings)
    if jobs == 1:
        player = Player(campaign)
        yield from map(player.play, scenes)
        return
    for name in ONE_THREAD:
        os.environ.setdefault(name, "1")
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, fresh) as pool:
        try:
            for lines in pool.map(partial(_play, campaign), scenes, chunksize=PORTION):
                yield msgspec.json.decode(lines, type=list[EpisodeResult])
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


class Player:
    """Plays scenes of one campaign in this process."""

    def __init__(self, campaign: Campaign) -> None:
        self._campaign = campaign
        self._contenders: Sequence[Contender] = campaign.contenders()
        self._cell = simulated_cell()
        self._finish: Finish | None = finishing() if campaign.finish_live else None

    def play(self, address: Address) -> list[EpisodeResult]:
        """One scene."""
        folder = self._campaign.recordings
        recording = recording_store.load(folder, *address)
        truth = recording_store.load_truth(folder, *address)
        stratum = recording_store.load_scene_truth(folder, *address).stratum
        drawn = self._campaign.conditions.mode == "bernoulli"
        measured = None if drawn else recording_store.load_measured(folder, *address)
        scene = ready(recording, truth, stratum, measured)
        conditions = self._campaign.conditions
        return list(evaluate(scene, self._contenders, self._cell, conditions, self._finish))


def finishing() -> Finish:
    """What finishes episodes live; the simulator is imported only when it is asked for."""
    finish: Finish = import_module("surefetch.evaluation.replaying.finishing").finish
    return finish


@cache
def _player(campaign: Campaign) -> Player:
    """Made once in each process."""
    return Player(campaign)


def _play(campaign: Campaign, address: Address) -> bytes:
    return msgspec.json.encode(_player(campaign).play(address))
