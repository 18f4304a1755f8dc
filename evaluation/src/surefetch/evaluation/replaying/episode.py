"""One replayed episode: the planner's turns, over a recorded world in the place of the services.

State, viewing conditions, failure rules and endings are the planner's own code. A recording does
not tell what the robot could do, so every view, removal and grasp counts as feasible.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import assert_never

import numpy as np

from surefetch.common.cell import Cell
from surefetch.common.errors import BadInput
from surefetch.common.messages import (
    BeliefReply,
    Choice,
    Defer,
    Feasibility,
    FrameInfo,
    Grasp,
    GraspVerdict,
    Inform,
    InformVerdict,
    Observations,
    Target,
)
from surefetch.common.parameters import Parameters
from surefetch.evaluation.policies.observation import Observation, Policy
from surefetch.evaluation.replaying.beliefs import Beliefs, Heard, History
from surefetch.evaluation.replaying.world import RecordedWorld
from surefetch.planner import actions, endings
from surefetch.planner.account import End
from surefetch.planner.episode_state import EpisodeState, given_up, grasped_at, informed, look
from surefetch.planner.profiles import Profile


@dataclass(frozen=True, eq=False)
class Errand:
    """What a policy is asked for, and what it is told once and for all."""

    target: Target
    cell: Cell
    parameters: Parameters
    profile: Profile


@dataclass(frozen=True, eq=False)
class Turn:
    """Between two actions."""

    state: EpisodeState
    heard: History = ()
    taken: tuple[Choice, ...] = ()


@dataclass(frozen=True)
class Played:
    """How an episode ended."""

    end: End
    taken: tuple[Choice, ...]
    """Every action, in order; a defer included."""
    n_tracks: int
    """At the end."""


def play(
    policy: Policy, errand: Errand, world: RecordedWorld, beliefs: Beliefs, rng: np.random.Generator
) -> Played:
    """Turn after turn until it is over.

    Raises:
        OutOfRecording: the policy went where nothing was recorded.
        BadInput: the policy took an action that was not open.
    """
    turn = Turn(EpisodeState(view=errand.cell.views[0].name))
    while True:
        turn = _look(turn, errand, world)
        believed = beliefs.after(turn.heard)
        lost = given_up(turn.state, errand.profile.tries)
        if lost and not errand.profile.outlives_failure:
            end: End | None = endings.look_failed(lost, errand.cell, "")
        else:
            now = _observation(turn.state, errand, believed, lost, rng)
            choice = policy.act(now)
            turn, end = _act(turn, errand, world, now, choice)
        if end is not None:
            return Played(end, turn.taken, len(believed.tracks))


def _look(turn: Turn, errand: Errand, world: RecordedWorld) -> Turn:
    view = turn.state.view
    seen = world.see(view)
    state, looked = look(turn.state, errand.cell.informs, _frame(view, seen), seen)
    heard = Heard(world.state(view), looked.q, looked.counted, state.cover == "covered")
    return replace(turn, state=replace(state, step=state.step + 1), heard=(*turn.heard, heard))


def _frame(view: str, seen: Observations) -> FrameInfo:
    """Only its view is asked for; the recording keeps no camera."""
    return FrameInfo(
        frame=seen.frame,
        view=view,
        width=0,
        height=0,
        K=np.zeros((3, 3)),
        T_world_camera=np.zeros((4, 4)),
        captured_s=0.0,
    )


def _observation(
    state: EpisodeState,
    errand: Errand,
    believed: BeliefReply,
    lost: frozenset[str],
    rng: np.random.Generator,
) -> Observation:
    open_rows = actions.expandable(errand.cell.informs, state.cover, state.used | lost)
    return Observation(
        target=errand.target,
        cell=errand.cell,
        parameters=errand.parameters,
        profile=errand.profile,
        believed=believed,
        cover=state.cover,
        used=state.used,
        given_up=lost,
        feasibility=_feasible((t.id for t in believed.tracks), (row.name for row in open_rows)),
        n_actions=state.n_actions,
        rng=rng,
    )


def _feasible(tracks: Iterable[int], informs: Iterable[str]) -> Feasibility:
    return Feasibility(
        grasps=tuple(
            GraspVerdict(track=i, feasible=True, refusal=None, why="", tried={}) for i in tracks
        ),
        informs=tuple(
            InformVerdict(name=name, feasible=True, refusal=None, why="") for name in informs
        ),
        duration_s=0.0,
    )


def _act(
    turn: Turn, errand: Errand, world: RecordedWorld, now: Observation, choice: Choice | None
) -> tuple[Turn, End | None]:
    """Do what was chosen; no end: the episode goes on."""
    if choice is None:
        return turn, endings.nothing_admissible(now.situation, errand.cell, "")
    _refuse_closed(now, choice)
    if not isinstance(choice, Defer) and turn.state.n_actions >= errand.profile.max_actions:
        return turn, endings.step_limit(turn.state.n_actions, "")
    turn = replace(turn, taken=(*turn.taken, choice))
    match choice:
        case Defer():
            return turn, endings.deferred(now.situation, "")
        case Inform():
            return _inform(turn, errand, world, choice)
        case Grasp():
            return _grasp(turn, errand, world, now, choice)
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


def _inform(
    turn: Turn, errand: Errand, world: RecordedWorld, choice: Inform
) -> tuple[Turn, End | None]:
    row = errand.cell.inform(choice.name)
    done = world.inform(row)
    state = informed(turn.state, row, done=done)
    failed = not done and not errand.profile.outlives_failure
    end = endings.look_failed({row.name}, errand.cell, "") if failed else None
    return replace(turn, state=state), end


def _grasp(
    turn: Turn, errand: Errand, world: RecordedWorld, now: Observation, choice: Grasp
) -> tuple[Turn, End | None]:
    held = world.grasp(next(t for t in now.believed.tracks if t.id == choice.track))
    state = grasped_at(turn.state, choice.track, held=held)
    turn, profile = replace(turn, state=state), errand.profile
    if held:
        return turn, End("grasped", "verified", "", choice.track, choice.relation)
    tries = state.grasp_failures[choice.track]
    if not profile.outlives_failure or tries >= profile.tries:
        return turn, endings.grasp_failed(choice, tries, "")
    return turn, None
