"""What the robot can do is planned to the end; what it cannot, it refuses for the right reason."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import structs
from tabletop import above, body, box, estimate_of, scene

from surefetch.common.cell import simulated_cell
from surefetch.common.errors import BadInput
from surefetch.common.geometry import Array
from surefetch.common.messages import (
    AskFeasible,
    Box3d,
    ContainerReading,
    Estimate,
    Feasibility,
    GraspVerdict,
    InformVerdict,
    Lid,
)
from surefetch.executor.feasibility import judge
from surefetch.executor.grasping.antipodal import AntipodalProposer
from surefetch.executor.skills.lid_removal import LidRemoval
from surefetch.executor.skills.plans import Plans
from surefetch.executor.skills.situation import Memory, Situation, Workcell, surroundings
from surefetch.executor.skills.steps import check_again

CELL = simulated_cell()
WORKCELL = Workcell.of(CELL, AntipodalProposer())
HOME = np.radians(CELL.home.q_deg)
VIEWS = ("right", "close_high")


def rng() -> np.random.Generator:
    return np.random.default_rng(7)


def asked(
    estimate: Estimate,
    grasps: tuple[int, ...] = (),
    informs: tuple[str, ...] = (),
    q_rad: Array = HOME,
) -> Feasibility:
    now = Situation(q_rad, 0.0, estimate)
    ask = AskFeasible(episode="e", step=0, estimate=estimate, grasps=grasps, informs=informs)
    return judge(Plans(WORKCELL), CELL, now, ask, rng())


def grasp(estimate: Estimate, q_rad: Array = HOME) -> GraspVerdict:
    return asked(estimate, grasps=(0,), q_rad=q_rad).grasps[0]


def inform(estimate: Estimate, name: str) -> InformVerdict:
    return asked(estimate, informs=(name,)).informs[0]


def wall(x: float, y: float, size_m: tuple[float, float, float]) -> Box3d:
    return Box3d(center_world_m=(x, y, size_m[2] / 2.0), size_m=size_m, yaw_rad=0.0)


def test_a_free_cube_can_be_grasped_and_all_views_reached() -> None:
    answer = asked(estimate_of(scene(body("cube"))), (0,), VIEWS)
    assert answer.grasps[0].feasible and answer.grasps[0].refusal is None
    assert [(v.name, v.feasible) for v in answer.informs] == [(name, True) for name in VIEWS]
    assert answer.duration_s > 0.0


def test_too_wide_an_object_is_refused_for_the_aperture() -> None:
    verdict = grasp(estimate_of(scene(body("plate", "block", (0.18, 0.17, 0.05)))))
    assert (verdict.feasible, verdict.refusal) == (False, "aperture")
    assert "170 mm" in verdict.why and verdict.tried["aperture"] > 0


def test_an_object_far_away_is_refused_for_its_reach() -> None:
    verdict = grasp(estimate_of(scene(body("cube", at_m=(1.45, 0.0)))))
    assert (verdict.feasible, verdict.refusal) == (False, "reach")
    assert sum(verdict.tried.values()) > 1


def test_an_object_outside_the_workspace_is_refused_for_the_limits() -> None:
    verdict = grasp(estimate_of(scene(body("cube", at_m=(0.30, -0.78)))))
    assert (verdict.feasible, verdict.refusal) == (False, "limits")
    assert "workspace" in verdict.why


def test_an_object_under_the_lid_is_refused_for_access() -> None:
    verdict = grasp(estimate_of(scene(body("cube", at_m=(1.02, 0.03)), container=box(True))))
    assert (verdict.feasible, verdict.refusal) == (False, "access")
    assert "lid" in verdict.why
    opened = estimate_of(scene(body("cube", at_m=(1.02, 0.03)), container=box(False)))
    assert grasp(opened).feasible


def test_an_object_boxed_in_by_neighbours_is_refused_for_access_or_collision() -> None:
    around = [(0.9 + dx, dy) for dx in (-0.052, 0.0, 0.052) for dy in (-0.052, 0.0, 0.052)]
    around.remove((0.9, 0.0))
    bodies = [body("cube"), *(body(f"other {i}", at_m=at) for i, at in enumerate(around))]
    verdict = grasp(estimate_of(scene(*bodies)))
    assert not verdict.feasible and verdict.refusal in ("access", "collision")


def test_an_object_behind_a_wall_without_a_way_around_is_refused_for_the_path() -> None:
    table = estimate_of(scene(body("cube", at_m=(0.7, -0.4))))
    walled = structs.replace(table, obstacles=(wall(0.9, 0.0, (1.3, 0.02, 1.6)),))
    beyond = above((0.7, 0.4, 0.1), HOME, 0.0)
    verdict = grasp(walled, beyond)
    assert (verdict.feasible, verdict.refusal) == (False, "path")
    assert grasp(table, beyond).feasible


def test_what_was_hardly_seen_or_never_is_refused_for_the_estimate() -> None:
    seen = estimate_of(scene(body("cube")))
    flat = structs.replace(seen, tracks=(structs.replace(seen.tracks[0], solid=None),))
    assert grasp(flat).refusal == "estimate"
    assert grasp(structs.replace(seen, tracks=())).refusal == "estimate"


def test_the_lid_can_be_taken_off_where_its_knob_is_seen_and_its_place_is_free() -> None:
    covered = estimate_of(scene(container=box(True)))
    assert inform(covered, "remove_cover").feasible
    assert inform(with_lid(covered, None), "remove_cover").refusal == "estimate"
    assert covered.container is not None and covered.container.lid is not None
    knobless = Lid(plate=covered.container.lid.plate, knob=None)
    assert inform(with_lid(covered, knobless), "remove_cover").refusal == "estimate"
    x, y, _ = CELL.lid_place.position_m
    occupied = structs.replace(covered, obstacles=(wall(x, y, (0.1, 0.1, 0.3)),))
    assert inform(occupied, "remove_cover").refusal == "collision"


def with_lid(estimate: Estimate, lid: Lid | None) -> Estimate:
    assert isinstance(estimate.container, ContainerReading)
    return structs.replace(estimate, container=structs.replace(estimate.container, lid=lid))


def test_a_view_that_is_walled_off_is_refused() -> None:
    table = estimate_of(scene())
    walled = structs.replace(table, obstacles=(wall(0.75, 0.0, (0.1, 1.2, 1.0)),))
    verdict = inform(walled, "close_high")
    assert not verdict.feasible and verdict.refusal in ("collision", "path")


def test_an_unknown_action_is_bad_input() -> None:
    with pytest.raises(BadInput, match="has no action"):
        inform(estimate_of(scene()), "left")


@settings(max_examples=12, deadline=None)
@given(st.floats(0.78, 1.10), st.floats(-0.28, 0.28), st.floats(-1.5, 1.5), st.booleans())
def test_every_plan_is_one_checked_way_from_the_present_joints(
    x: float, y: float, yaw_rad: float, in_hand: bool
) -> None:
    one = structs.replace(body("block", "block", (0.09, 0.04, 0.05), (x, y)), yaw_rad=yaw_rad)
    other = body("other", at_m=(0.94, 0.0))
    now = Situation(HOME, 0.0, estimate_of(scene(one, other)))
    pick, tried = Plans(WORKCELL).target(now, 0, rng())
    if pick is None:
        assert tried.refusal is not None
        return
    check_again(WORKCELL.motion, pick.steps, HOME)
    held = surroundings(WORKCELL, now.then(pick.lift_on.end_rad, 0.04, pick.holding))
    assert held.in_collision(pick.lift_on.end_rad, pick.way.object_width_m) is None


def test_the_same_question_gets_the_same_plan_until_something_changes() -> None:
    plans, estimate = Plans(WORKCELL), estimate_of(scene(body("cube")))
    now = Situation(HOME, 0.0, estimate, Memory())
    first = plans.target(now, 0, rng())
    again = Situation(HOME.copy(), 0.0, estimate_of(scene(body("cube"))), now.memory)
    assert plans.target(again, 0, rng()) is first
    moved = structs.replace(estimate, obstacles=(wall(0.8, 0.3, (0.05, 0.05, 0.05)),))
    assert plans.target(Situation(HOME, 0.0, moved, now.memory), 0, rng()) is not first


def test_what_was_set_down_stays_an_obstacle() -> None:
    covered = estimate_of(scene(container=box(True)))
    now = Situation(HOME, 0.0, covered)
    plan = Plans(WORKCELL).lid(now, rng())
    assert isinstance(plan, LidRemoval)
    after = Situation(HOME, 0.0, covered, now.memory.put(plan.put_down.box))
    names = [thing.name for thing in surroundings(WORKCELL, after, lid=False).obstacles.boxes]
    assert "lid set down" in names and "lid" not in names


PLANNING = (
    "feasibility",
    "service",
    "skills.commands",
    "skills.task",
    "skills.plans",
    "skills.pick",
    "skills.put_down",
    "skills.lid_removal",
)


def test_planning_and_skills_know_no_simulator() -> None:
    """Importing all of them brings in neither PyBullet nor a module of the simulated cell."""
    imports = "; ".join(f"import surefetch.executor.{name}" for name in PLANNING)
    names = f"{imports}; import sys; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", names], capture_output=True, text=True, check=True, cwd=Path.home()
    )
    loaded = done.stdout.split()
    assert "surefetch.executor.skills.commands" in loaded
    simulated = ("pybullet", "surefetch.executor.simulation")
    assert not [name for name in loaded if name.startswith(simulated) or "pybullet" in name]
