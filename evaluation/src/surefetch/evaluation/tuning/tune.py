"""Every configuration of a policy on all development scenes, and the best of them."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from surefetch.common.cell import simulated_cell
from surefetch.evaluation.policies import tuning
from surefetch.evaluation.policies.introplan_knowledge import FOLDS, fold_of
from surefetch.evaluation.policies.registry import HELD_OUT
from surefetch.evaluation.policies.tuning import Tuned, TunedOn, Values
from surefetch.evaluation.recordings import recording_store
from surefetch.evaluation.replaying import campaign
from surefetch.evaluation.replaying.campaign import Campaign
from surefetch.evaluation.replaying.contenders import WITH, Contender
from surefetch.evaluation.replaying.evaluate import evaluate
from surefetch.evaluation.replaying.hindsight import all_ways
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.replaying.scene import RecordedScene, ready
from surefetch.evaluation.tuning.best_sequence import Ends, choose, ends_of
from surefetch.evaluation.tuning.tally import Tally

Watch = Callable[[Iterable[list[EpisodeResult]]], Iterable[list[EpisodeResult]]]
"""Passes results on, scene by scene, and shows how far it got."""


@dataclass(frozen=True)
class Setting:
    """One configuration of one policy."""

    policy: str
    profile: str
    values: Values
    held_out: int | None
    """The fold that it plays; None: all scenes."""

    @property
    def label(self) -> str:
        """As a campaign takes it."""
        fold = {} if self.held_out is None else {HELD_OUT: self.held_out}
        return f"{tuning.written(self.policy, {**self.values, **fold})}{WITH}{self.profile}"


def settings_of(one: Contender) -> list[Setting]:
    """All configurations; of a policy that learned from these scenes, each once for every fold."""
    assert one.entry is not None
    folds = range(FOLDS) if one.entry.cross_fitted else (None,)
    return [
        Setting(one.name, one.profile.name, values, fold)
        for values in tuning.configurations(one.entry.scalars)
        for fold in folds
    ]


def tune(wanted: Campaign, one: Contender, on: TunedOn, jobs: int, watch: Watch) -> Tuned:
    """The best configuration of one policy, with all that were tried.

    Args:
        wanted: recordings, parameters and outcomes.
        one: the policy, with the belief that it is tuned for.
        on: what that is, in words.
        jobs: processes.
        watch: see `Watch`.
    """
    assert one.entry is not None
    settings = settings_of(one)
    tallies = _tallies(settings, watch(campaign.run(wanted.of([s.label for s in settings]), jobs)))
    trials = []
    for values in tuning.configurations(one.entry.scalars):
        together = Tally()
        for setting, tally in zip(settings, tallies, strict=True):
            together = together.plus(tally) if setting.values == values else together
        trials.append(together.trial(values))
    return Tuned(
        policy=one.name,
        profile=one.profile.name,
        values=tuning.best(trials).values,
        trials=tuple(trials),
        tuned_on=on,
    )


def _tallies(settings: Sequence[Setting], played: Iterable[Sequence[EpisodeResult]]) -> list[Tally]:
    """What came of each, over the scenes that it is played on."""
    tallies = [Tally() for _ in settings]
    for episodes in played:
        for n, (setting, episode) in enumerate(zip(settings, episodes, strict=True)):
            if setting.held_out in (None, fold_of(episode.seed)):
                tallies[n] = tallies[n].and_one(episode)
    return tallies


def tune_sequences(wanted: Campaign, one: Contender, on: TunedOn, watch: Watch) -> Tuned:
    """The same of a policy that looks along fitted sequences: the best of those, and threshold."""
    assert one.entry is not None
    (threshold,) = one.entry.scalars
    cell = simulated_cell()
    scenes: list[list[Ends]] = []

    def played(scene: RecordedScene) -> list[EpisodeResult]:
        covered = scene.recording.covered
        ways = all_ways(one, covered=covered, cell=cell)
        return list(evaluate(scene, ways, cell, wanted.conditions))

    for episodes in watch(map(played, _scenes(wanted))):
        covered = episodes[0].covered
        scenes.append(ends_of(one, episodes, covered=covered, cell=cell))
    chosen = list(choose(scenes, threshold.grid))
    best = tuning.best([each.trial for each in chosen])
    winner = next(each for each in chosen if each.trial == best)
    return Tuned(
        policy=one.name,
        profile=one.profile.name,
        values=best.values,
        trials=tuple(each.trial for each in chosen),
        tuned_on=on,
        sequences=dict(winner.sequences),
        sequence_successes={name: dict(of) for name, of in winner.successes.items()},
    )


def _scenes(wanted: Campaign) -> Iterator[RecordedScene]:
    folder = wanted.recordings
    for address in recording_store.scenes(folder):
        drawn = wanted.conditions.mode == "bernoulli"
        yield ready(
            recording_store.load(folder, *address),
            recording_store.load_truth(folder, *address),
            measured=None if drawn else recording_store.load_measured(folder, *address),
        )
