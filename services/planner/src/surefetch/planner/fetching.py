"""From the decision to grasp to the end of the episode, or to another try."""

from surefetch.common.messages import Deliver, Estimate, Grasp, Look, Outcome, PutBack, Track
from surefetch.planner import endings
from surefetch.planner.account import End
from surefetch.planner.crew import Crew
from surefetch.planner.endings import Lift
from surefetch.planner.episode_state import EpisodeState, grasped_at
from surefetch.planner.looks import condition
from surefetch.planner.situation import Errand
from surefetch.planner.verify import PlaceCheck, look_at_place


def fetch(
    crew: Crew, errand: Errand, state: EpisodeState, grasp: Grasp, because: str
) -> EpisodeState | End:
    """Grasp, verify by finger width and by a look, then deliver, hold or put back.

    A grasp that cannot be verified has failed; whether it is tried again is the profile's affair.
    """
    outcome = crew.execute(grasp, state.estimate)
    check = PlaceCheck(False, outcome.why)
    if outcome.status == "done":
        check = _check_place(crew, errand, state, grasp.track)
    held = check.gone is not False
    after = grasped_at(state, grasp.track, held=held)
    if held:
        return _keep(crew, errand, state.estimate, grasp, _lift(because, check))
    tries, profile = after.grasp_failures[grasp.track], errand.policy.profile
    if not profile.outlives_failure or tries >= profile.tries:
        return endings.grasp_failed(grasp, tries, check.why)
    if outcome.holding:
        crew.execute(PutBack(), state.estimate)
    return after


def _check_place(crew: Crew, errand: Errand, state: EpisodeState, number: int) -> PlaceCheck:
    """Look again from where the track was seen last."""
    view = state.seen_from.get(number) or state.view
    looked = crew.execute(Look(view=view), state.estimate)
    if looked.status != "done":
        return PlaceCheck(None, f"its old place could not be seen again ({looked.why})")
    frame = crew.capture()
    q = condition(errand.cell.informs, frame.view, None, state.cover)
    seen = crew.observe(frame, errand.target, q)
    track, others = _apart(state.estimate.tracks, number)
    return look_at_place(track, others, frame, seen.detections, state.seen_from.get(number))


def _keep(crew: Crew, errand: Errand, estimate: Estimate, grasp: Grasp, lift: Lift) -> End:
    """What was asked for after the grasp."""
    match errand.after_grasp:
        case "deliver":
            outcome = crew.execute(Deliver(place=errand.cell.delivery.name), estimate)
            delivered = outcome.status == "done"
            return endings.grasped(grasp, lift, _put_down("delivered", outcome), delivered)
        case "return":
            outcome = crew.execute(PutBack(), estimate)
            return endings.grasped(grasp, lift, _put_down("put back", outcome), None)
        case "hold":
            return endings.grasped(grasp, lift, "It is held.", None)


def _put_down(what: str, outcome: Outcome) -> str:
    if outcome.status == "done":
        return f"It was {what}."
    return endings.sentence(f"It was not {what}", outcome.why)


def _lift(because: str, check: PlaceCheck) -> Lift:
    if check.gone:
        told = "The lift was verified by finger width and by a look."
        return Lift("verified", f"{because} {told}")
    told = endings.sentence("The lift was verified by finger width alone", check.why)
    return Lift("verified_by_width", f"{because} {told}")


def _apart(tracks: tuple[Track, ...], number: int) -> tuple[Track, tuple[Track, ...]]:
    """The track of this number, and all others."""
    track = next(t for t in tracks if t.id == number)
    return track, tuple(t for t in tracks if t.id != number)
