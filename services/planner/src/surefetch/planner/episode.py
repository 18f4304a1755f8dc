"""One episode, turn by turn: capture, observe, update, check, decide, act."""

from dataclasses import replace
from typing import assert_never

from surefetch.common.errors import SurefetchError
from surefetch.common.messages import Decided, Defer, Ended, FrameInfo, Grasp, Inform, Look
from surefetch.common.topics import PLANNER
from surefetch.planner import endings
from surefetch.planner.account import Account, End
from surefetch.planner.crew import Crew, Stopped
from surefetch.planner.decide import Decision, decide, worth_asking
from surefetch.planner.episode_state import EpisodeState, believe, given_up, informed, look
from surefetch.planner.fetching import fetch
from surefetch.planner.looks import condition
from surefetch.planner.situation import Errand, Situation


def run(crew: Crew, account: Account, errand: Errand) -> Ended:
    """Turn after turn until it is over; ends in exactly one way, whatever happens."""
    now: EpisodeState | End = EpisodeState(view=errand.cell.views[0].name)
    try:
        while isinstance(now, EpisodeState):
            account.step = now.step
            now = turn(crew, account, errand, now)
    except Stopped as stopped:
        now = endings.stopped(str(stopped))
    except SurefetchError as error:
        now = endings.cut_short(error)
    return account.ended(now)


def turn(crew: Crew, account: Account, errand: Errand, before: EpisodeState) -> EpisodeState | End:
    """Capture, observe, update, check, decide, act."""
    placed = _to_view(crew, errand, before)
    if isinstance(placed, End):
        return placed
    profile = errand.policy.profile
    frame = crew.capture()
    seen = crew.observe(frame, errand.target, _expected_q(errand, placed, frame))
    looked, heard = look(placed, errand.cell.informs, frame, seen)
    believed = crew.believe(
        seen,
        q=heard.q,
        asked=errand.target.relation,
        counted=heard.counted,
        covered=looked.cover == "covered",
        profile=profile.name,
    )
    state = believe(looked, frame, believed)
    lost = given_up(state, profile.tries)
    if lost and not profile.outlives_failure:
        return endings.look_failed(lost, errand.cell, "the look afterwards does not show it")
    asked = worth_asking(errand, believed, state.cover, state.used | lost)
    feasibility = crew.feasible(state.estimate, *asked)
    situation = Situation(believed, state.cover, state.used, lost, feasibility)
    decision = _decide(account, errand, situation)
    return _act(crew, errand, state, situation, decision)


def _decide(account: Account, errand: Errand, situation: Situation) -> Decision:
    with account.timed(PLANNER) as spent_s:
        decision = decide(errand, situation)
        duration_s = spent_s()
    account.decided(
        Decided(
            choice=decision.choice,
            q_values=decision.q_values,
            because=decision.because,
            feasibility=situation.feasibility,
            duration_s=duration_s,
        )
    )
    return decision


def _act(
    crew: Crew, errand: Errand, state: EpisodeState, now: Situation, decision: Decision
) -> EpisodeState | End:
    """Do what was decided; the episode goes on from there, or is over."""
    choice, because = decision.choice, decision.because
    if choice is None:
        return endings.nothing_admissible(now, errand.cell, because)
    if isinstance(choice, Defer):
        return endings.deferred(now, because)
    if state.n_actions >= errand.policy.profile.max_actions:
        return endings.step_limit(state.n_actions, because)
    match choice:
        case Inform():
            return _inform(crew, errand, state, choice)
        case Grasp():
            return fetch(crew, errand, state, choice, because)
        case _:
            assert_never(choice)


def _inform(crew: Crew, errand: Errand, state: EpisodeState, choice: Inform) -> EpisodeState | End:
    """Execute an information action; whether it gave anything, the next look tells."""
    outcome = crew.execute(choice, state.estimate)
    done = outcome.status == "done"
    if not done and not errand.policy.profile.outlives_failure:
        return endings.look_failed({choice.name}, errand.cell, outcome.why)
    return informed(state, errand.cell.inform(choice.name), done=done)


def _to_view(crew: Crew, errand: Errand, state: EpisodeState) -> EpisodeState | End:
    """The camera at the viewpoint of the next look."""
    why = ""
    for _ in range(errand.policy.profile.tries):
        if state.at_view:
            return state
        outcome = crew.execute(Look(view=state.view), state.estimate)
        state, why = replace(state, at_view=outcome.status == "done"), outcome.why
    return state if state.at_view else endings.view_failed(state.view, why)


def _expected_q(errand: Errand, state: EpisodeState, frame: FrameInfo) -> str:
    """The viewing condition if the last action did what it was to do."""
    cover = state.cover if state.tried is None else "open"
    return condition(errand.cell.informs, frame.view, state.tried, cover)
