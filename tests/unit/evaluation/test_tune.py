"""Tuning tries everything on development scenes, keeps the best, and writes all of it down."""

from pathlib import Path

import pytest
from recorded_table import numbers, record, save
from scripted_table import Table, thing, thing_inside

from surefetch.common.errors import BadInput
from surefetch.common.parameters import PROFILES, write_parameters
from surefetch.evaluation.policies import tuning
from surefetch.evaluation.policies.tuning import Tuned
from surefetch.evaluation.replaying import command as evaluating
from surefetch.evaluation.replaying import results
from surefetch.evaluation.tuning import command

UNREAD_FIRST = (thing(0.9, -0.1, center="unread"), thing(0.9, 0.1, "other", center="unread"))
TABLES: tuple[tuple[Table, int | None], ...] = (
    (Table((thing(0.9, -0.1), thing(0.9, 0.1, "other"))), 0),
    (Table(UNREAD_FIRST), 0),
    (Table((thing_inside(), thing(0.8, 0.2, "other")), covered=True), 0),
    (Table((thing(0.9, -0.1, "other"), thing(0.9, 0.1, "other"))), None),
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for profile in PROFILES:
        write_parameters(tmp_path / f"{profile}.json", numbers(profile))
    for n, (table, wanted) in enumerate(TABLES):
        recording, truth = record(table, wanted=wanted, seed=100_000 + n)
        save(tmp_path / "recordings", recording, truth)
    return tmp_path


def tuned(folder: Path, policy: str, *more: str) -> Tuned:
    words = ["--recordings", str(folder / "recordings"), "--parameters", str(folder)]
    words += ["--policies", policy, "--profile", "extended", "--out", str(folder / "out"), *more]
    assert command.main(words) == 0
    name = tuning.name_of(policy, "extended")
    return tuning.parse((folder / "out" / name).read_bytes(), name)


def test_the_ledger_holds_what_evaluating_each_configuration_gives(folder: Path) -> None:
    found = tuned(folder, "exhaustive-look", "--jobs", "2")
    assert found.tuned_on.scenes.n_episodes == len(TABLES)
    assert found.values == tuning.best(found.trials).values
    for trial in (found.trials[0], found.trials[10], found.trials[-1]):
        label = f"{tuning.written('exhaustive-look', trial.values)}@extended"
        words = ["--recordings", str(folder / "recordings"), "--parameters", str(folder)]
        words += ["--policies", label, "--out", str(folder / "results"), "--json"]
        assert evaluating.main(words) == 0
        episodes = results.read(folder / "results", label)
        assert trial.n_successes == sum(e.verdict == "success" for e in episodes)
        costs = [e.realized_cost for e in episodes]
        assert trial.mean_realized_cost == pytest.approx(sum(costs) / len(costs), abs=1e-6)


def test_the_best_sequence_looks_no_further_than_it_helps(folder: Path) -> None:
    """Under the cover lies the target, which nothing but opening shows."""
    found = tuned(folder, "best-fixed")
    assert found.sequences is not None and found.sequence_successes is not None
    assert set(found.sequences) == {"open, any asked", "covered, any asked"}
    assert found.sequences["covered, any asked"][0] == "remove_cover"
    for situation, chosen in found.sequences.items():
        successes = found.sequence_successes[situation]
        assert successes[" ".join(chosen)] == max(successes.values())
    assert len(found.sequence_successes["open, any asked"]) == 5
    assert len(found.sequence_successes["covered, any asked"]) == 30
    alone = tuned(folder, "exhaustive-look")
    best, other = tuning.best(found.trials), tuning.best(alone.trials)
    assert (-best.n_successes, best.mean_realized_cost) <= (
        -other.n_successes, other.mean_realized_cost
    )  # fmt: skip


def test_only_development_scenes_are_tuned_on(folder: Path) -> None:
    recording, truth = record(TABLES[0][0], wanted=0, seed=300_000)
    save(folder / "recordings", recording, truth)
    with pytest.raises(BadInput, match="seed 300000 is not one"):
        tuned(folder, "greedy-threshold")


@pytest.mark.parametrize("policy", ["greedy", "greedy-threshold@paper", "greedy-threshold[at=1]"])
def test_what_cannot_be_tuned_is_refused(folder: Path, policy: str) -> None:
    with pytest.raises(BadInput, match=r"nothing that is tuned|without belief"):
        tuned(folder, policy)
