"""One replayed episode: the planner's turns, over a recorded world in the place of the services.

State, viewing conditions, failure rules and endings are the planner's own code.
"""

import time
from dataclasses import dataclass, replace
from typing import Final, assert_never

import numpy as np

from surefetch.common.cell import Cell
from surefetch.common.errors import BadInput
from surefetch.common.messages import (
    BeliefReply,
    Choice,
    Defer,
    Feasibility,
    Grasp,
    Inform,
    Target,
)
from surefetch.common.parameters import Parameters
from surefetch.evaluation.policies.observation import Observation, Policy, words_of
from surefetch.evaluation.recordings.free_space import FreeSpace
from surefetch.evaluation.replaying.beliefs import Beliefs, Heard, History
from surefetch.evaluation.replaying.world import (
    OutOfRecording,
    Report,
    ViewFailed,
    World,
    WorldFailed,
)
from surefetch.planner import endings
from surefetch.planner.account import End
from surefetch.planner.episode_state import (
    EpisodeState,
    believe,
    given_up,
    grasped_at,
    informed,
    look,
)
from surefetch.planner.profiles import Profile

OUT_OF_RECORDING: Final = "out_of_recording"
"""Reason of the end of an episode that the recording does not cover."""


@dataclass(frozen=True, eq=False)
class Errand:
    """What a policy is asked for, and what it is told once and for all."""

    target: Target
    cell: Cell
    parameters: Parameters
    profile: Profile


@dataclass(frozen=True, eq=False)
class Moment:
    """One look, what was believed after it, and what was done on it."""

    heard: Heard
    delivered: str
    believed: BeliefReply
    free_space: FreeSpace
    perception_s: float
    now: Observation | None = None
    """What the policy was told; None: it was not asked any more."""
    choice: Choice | None = None
    because: str = ""
    planning_s: float = 0.0
    report: Report | None = None
    """What came of it; None: it was not carried out."""


@dataclass(frozen=True, eq=False)
class Turn:
    """Between two actions."""

    state: EpisodeState
    moments: tuple[Moment, ...] = ()

    @property
    def heard(self) -> History:
        """All looks."""
        return tuple(moment.heard for moment in self.moments)

    def after(self, **changes: object) -> "Turn":
        """With more known of the latest moment."""
        *before, last = self.moments
        return replace(self, moments=(*before, replace(last, **changes)))  # type: ignore[arg-type]


@dataclass(frozen=True, eq=False)
class Played:
    """How an episode went, and how it ended."""

    end: End
    turn: Turn
    """The last."""

    @property
    def moments(self) -> tuple[Moment, ...]:
        """One for each look."""
        return self.turn.moments

    @property
    def taken(self) -> tuple[Choice, ...]:
        """Every action, in order; a defer included."""
        return tuple(m.choice for m in self.moments if m.choice is not None and m.report)


def play(
    policy: Policy,
    errand: Errand,
    world: World,
    beliefs: Beliefs,
    rng: np.random.Generator,
    turn: Turn | None = None,
) -> Played:
    """Turn after turn until it is over, from the beginning or from where another world was left.

    Raises:
        BadInput: the policy took an action that was not open.
    """
    turn = turn or Turn(EpisodeState(view=errand.cell.views[0].name))
    end: End | None = None
    try:
        while end is None:
            turn, feasibility = _look(turn, errand, world, beliefs)
            lost = given_up(turn.state, errand.profile.tries)
            if lost and not errand.profile.outlives_failure:
                end = endings.look_failed(lost, errand.cell, "")
            else:
                turn = _decide(turn, errand, feasibility, lost, policy, rng)
                turn, end = _act(turn, errand, world)
    except OutOfRecording as left:
        end = End("aborted", OUT_OF_RECORDING, str(left))
    except WorldFailed as failure:
        end = endings.cut_short(failure.error)
    except ViewFailed as failed:
        end = endings.view_failed(failed.view, failed.why)
    return Played(end, turn)


def _look(turn: Turn, errand: Errand, world: World, beliefs: Beliefs) -> tuple[Turn, Feasibility]:
    view = turn.state.view
    sight = world.see(view)
    state, looked = look(turn.state, errand.cell.informs, sight.frame, sight.seen)
    covered = state.cover == "covered"
    heard = Heard(sight.state, looked.q, looked.counted, covered, sight.take)
    history = (*turn.heard, heard)
    belief = beliefs.after(history, sight.seen)
    state = believe(state, sight.frame, belief.reply)
    moment = Moment(heard, belief.delivered, belief.reply, sight.free_space, sight.seen.duration_s)
    return Turn(state, (*turn.moments, moment)), world.feasible(history, state.estimate)


def _decide(
    turn: Turn,
    errand: Errand,
    feasibility: Feasibility,
    lost: frozenset[str],
    policy: Policy,
    rng: np.random.Generator,
) -> Turn:
    state = turn.state
    now = Observation(
        target=errand.target,
        cell=errand.cell,
        parameters=errand.parameters,
        profile=errand.profile,
        believed=turn.moments[-1].believed,
        cover=state.cover,
        used=state.used,
        given_up=lost,
        feasibility=feasibility,
        n_actions=state.n_actions,
        rng=rng,
        looks=tuple(moment.free_space for moment in turn.moments),
        estimate=state.estimate,
    )
    began_s = time.perf_counter()
    choice = policy.act(now)
    planning_s = time.perf_counter() - began_s
    return turn.after(now=now, choice=choice, because=words_of(policy), planning_s=planning_s)


def _act(turn: Turn, errand: Errand, world: World) -> tuple[Turn, End | None]:
    """Do what was chosen; no end: the episode goes on."""
    now, choice = turn.moments[-1].now, turn.moments[-1].choice
    assert now is not None
    if choice is None:
        return turn, endings.nothing_admissible(now.situation, errand.cell, "")
    _refuse_closed(now, choice)
    if not isinstance(choice, Defer) and turn.state.n_actions >= errand.profile.max_actions:
        return turn, endings.step_limit(turn.state.n_actions, "")
    match choice:
        case Defer():
            return turn.after(report=Report(done=True)), endings.deferred(now.situation, "")
        case Inform():
            return _inform(turn, errand, world, choice)
        case Grasp():
            return _grasp(turn, errand, world, choice)
        case _:
            assert_never(choice)


def _refuse_closed(now: Observation, choice: Choice) -> None:
    match choice:
        case Inform(name=name):
            is_open = name in {row.name for row in now.informs}
        case Grasp(track=track, relation=relation):
            is_open = (track, relation) in {(grip.track, grip.relation) for grip in now.grasps}
        case _:
            is_open = True
    if not is_open:
        raise BadInput(
            f"the policy chose {choice}, which is not open to it. Choose from the observation's "
            "`informs` and `grasps`, or defer."
        )


def _inform(turn: Turn, errand: Errand, world: World, choice: Inform) -> tuple[Turn, End | None]:
    row = errand.cell.inform(choice.name)
    report = world.inform(row)
    turn = replace(turn.after(report=report), state=informed(turn.state, row, done=report.done))
    failed = not report.done and not errand.profile.outlives_failure
    return turn, endings.look_failed({row.name}, errand.cell, report.why) if failed else None


def _grasp(turn: Turn, errand: Errand, world: World, choice: Grasp) -> tuple[Turn, End | None]:
    report = world.grasp(choice, turn.state)
    state = grasped_at(turn.state, choice.track, held=report.done)
    turn, profile = replace(turn.after(report=report), state=state), errand.profile
    if report.done:
        return turn, End("grasped", "verified", "", choice.track, choice.relation)
    tries = state.grasp_failures[choice.track]
    if not profile.outlives_failure or tries >= profile.tries:
        return turn, endings.grasp_failed(choice, tries, report.why)
    return turn, None
