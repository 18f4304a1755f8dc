"""Episodes on disk come back as they were, and a damaged line is named."""

import math
from pathlib import Path

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from surefetch.common.errors import BadInput
from surefetch.common.hypotheses import ABS, ASKED, RELATIONS
from surefetch.evaluation.replaying import results
from surefetch.evaluation.replaying.results import EpisodeResult, GraspResult, StepResult
from surefetch.evaluation.running.metrics import VERDICTS

p = st.floats(0.0, 1.0)
words = st.text(max_size=12)
steps = st.builds(
    StepResult,
    cover=st.sampled_from(["none", "closed", "open"]),
    belief=st.dictionaries(words, p, max_size=3),
    unobs=p,
    abs=p,
    p_true=p,
    planning_s=p,
    gamma=st.lists(words, max_size=3).map(tuple),
    observations=st.lists(words, max_size=3).map(tuple),
)
grasps = st.builds(GraspResult, relation=st.sampled_from(RELATIONS), p=p)
episodes = st.builds(
    EpisodeResult,
    asked=st.sampled_from(ASKED),
    verdict=st.sampled_from(VERDICTS),
    cost=p,
    realized_cost=p,
    duration_s=p,
    commit_p=p,
    q_hat=st.one_of(p, st.just("inf")),
    seed=st.integers(0, 2**62),
    n_actions=st.integers(0, 12),
    actions=st.lists(words, max_size=3).map(tuple),
    grasps=st.lists(grasps, max_size=2).map(tuple),
    steps=st.lists(steps, max_size=3).map(tuple),
)


@given(st.lists(episodes, max_size=4))
@settings(
    deadline=None, max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_episodes_come_back_as_they_were_written(
    tmp_path: Path, written: list[EpisodeResult]
) -> None:
    results.write(tmp_path, "ours@paper", written)
    assert results.read(tmp_path, "ours@paper") == written
    assert results.policies(tmp_path) == ["ours@paper"]


@given(episodes)
@settings(deadline=None, max_examples=40)
def test_what_is_told_of_an_episode_follows_from_its_steps(episode: EpisodeResult) -> None:
    assert episode.z_in_gamma == tuple(s.z_true in s.gamma for s in episode.steps)
    assert len(episode.planning_s) == len(episode.steps)
    if episode.log_p_true is None:
        assert not episode.steps
    else:
        assert math.exp(episode.log_p_true) == pytest.approx(episode.steps[-1].p_true)


def test_the_true_hypothesis_is_looked_for_in_the_conformal_set() -> None:
    step = _step(z_true="2:inside", gamma=("2:inside", ABS))
    assert step.z_in_gamma
    assert not msgspec.structs.replace(step, z_true="unobs").z_in_gamma


def test_a_damaged_line_is_named(tmp_path: Path) -> None:
    results.path_of(tmp_path, "ours").write_text("{}\n")
    with pytest.raises(BadInput, match=r"ours\.jsonl, line 1"):
        results.read(tmp_path, "ours")


def test_a_policy_that_was_not_evaluated_is_named_with_the_command(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="study evaluate"):
        results.read(tmp_path, "ours")


def _step(z_true: str, gamma: tuple[str, ...]) -> StepResult:
    return StepResult(
        view="center", cover="none", q="center", counted=True, delivered="0", observations=(),
        belief={}, unobs=0.0, abs=0.0, gamma=gamma, z_true=z_true, p_true=0.5, action=None,
        because="", planning_s=0.0,
    )  # fmt: skip
