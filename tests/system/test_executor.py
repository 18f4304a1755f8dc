"""Whole commands on the simulated cell, planned against an estimate made from the scene."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from queue import Queue

import numpy as np
import pytest
from msgspec import structs
from tabletop import body, box, estimate_of, scene

from surefetch.common.cell import simulated_cell
from surefetch.common.errors import BadInput, Refused
from surefetch.common.geometry import Array, rotation_angle
from surefetch.common.local_bus import LocalBus, LocalCell
from surefetch.common.messages import (
    AskFeasible,
    AskTruth,
    Body,
    Capture,
    Command,
    Deliver,
    Estimate,
    Grasp,
    Inform,
    Look,
    Motion,
    Outcome,
    PutBack,
    Scene,
    Screen,
    Stop,
    Stopped,
    Truth,
    Verb,
)
from surefetch.common.topics import EXECUTOR, MOVED
from surefetch.common.viewpoint import camera_pose
from surefetch.executor.grasping.antipodal import AntipodalProposer
from surefetch.executor.robot import ur10e, views
from surefetch.executor.service import ExecutorService
from surefetch.executor.simulation import scene_bodies
from surefetch.executor.simulation.pybullet_cell import PybulletCell
from surefetch.executor.simulation.pybullet_devices import pybullet_devices
from surefetch.executor.simulation.scorer_questions import Simulation
from surefetch.executor.skills.situation import Workcell

CELL = simulated_cell()
TRAY = np.asarray(CELL.delivery.position_m)


class Bench:
    """A served cell with one scene, and what the scorer can ask."""

    def __init__(self, table: Scene, *, real_time: bool = False) -> None:
        self.table = table
        self.simulated = PybulletCell(CELL)
        self.bus = LocalBus(LocalCell(), EXECUTOR)
        self.service = ExecutorService(
            Workcell.of(CELL, AntipodalProposer()),
            pybullet_devices(self.simulated, real_time=real_time),
            self.bus,
            backend="pybullet",
            simulated=Simulation(self.simulated),
        )
        self.service.load_scene(table)
        self._ids = count()

    def command(self, verb: Verb, estimate: Estimate | None = None) -> Command:
        estimate = estimate or estimate_of(self.table)
        name = f"command {next(self._ids)}"
        return Command(cmd_id=name, episode="e", step=0, verb=verb, estimate=estimate)

    def do(self, verb: Verb, estimate: Estimate | None = None) -> Outcome:
        return self.service.execute(self.command(verb, estimate))

    def truth(self) -> Truth:
        return self.service.truth(AskTruth())

    def place_m(self, index: int = 0) -> Array:
        return np.asarray(self.truth().bodies[index].position_world_m)


@contextmanager
def bench(table: Scene, *, real_time: bool = False) -> Iterator[Bench]:
    made = Bench(table, real_time=real_time)
    yield made
    made.simulated.close()


def test_a_frame_says_where_it_was_taken_and_is_kept() -> None:
    with bench(scene(body("cube"))) as b:
        assert b.do(Look(view="center")).status == "done"
        info = b.service.capture(Capture(episode="e", step=0))
        frame = b.service._frames.get(info.frame)
        wanted = camera_pose(CELL, CELL.view("center"))
        joints = np.asarray(frame.q_rad)
    assert (info.view, info.frame.counter, info.frame.boot) == ("center", 1, b.bus.boot)
    assert info.T_world_camera == pytest.approx(
        ur10e.flange(joints) @ ur10e.camera_mount(CELL.camera)
    )
    assert np.linalg.norm(info.T_world_camera[:3, 3] - wanted[:3, 3]) < 0.01
    assert rotation_angle(info.T_world_camera[:3, :3].T @ wanted[:3, :3]) < np.radians(1.0)
    assert frame.rgb.shape == (480, 640, 3)


def test_the_lid_is_taken_off_set_down_at_its_place_and_looked_under() -> None:
    content = structs.replace(body("cube", at_m=(1.02, 0.03)), position_world_m=(1.02, 0.03, 0.005))
    with bench(scene(content, body("other", at_m=(0.85, -0.2)), container=box(True))) as b:
        assert b.do(Look(view="center")).status == "done"
        outcome = b.do(Inform(name="remove_cover"))
        lid = b.truth().lid_position_world_m
        joints = b.simulated.robot.joints_rad()
        assert b.service._memory.holding is None
        moved = [
            np.linalg.norm(b.place_m(k)[:2] - b.table.bodies[k].position_world_m[:2])
            for k in (0, 1)
        ]
    assert outcome.status == "done", outcome.why
    assert outcome.checks == dict.fromkeys(
        ("closed_on_object", "width_kept", "still_held", "released"), True
    )
    thickness = scene_bodies.LID_THICKNESS_M
    assert lid == pytest.approx((*CELL.lid_place.position_m[:2], thickness / 2.0), abs=0.01)
    assert max(moved) < 0.003
    assert views.view_at(CELL, joints) == "center"
    assert not outcome.holding


SHAPES = {
    "cube": ("cube", (0.05, 0.05, 0.05)),
    "block": ("block", (0.10, 0.04, 0.05)),
    "cylinder": ("cylinder", (0.05, 0.05, 0.09)),
    "ball": ("ball", (0.05, 0.05, 0.048)),
    "prism": ("hexagonal prism", (0.05, 0.0577, 0.06)),
}


@pytest.mark.parametrize("shape", sorted(SHAPES))
def test_each_shape_is_lifted_delivered_and_let_go(shape: str) -> None:
    kind, size_m = SHAPES[shape]
    one = structs.replace(body(shape, kind, size_m, (0.92, 0.1)), yaw_rad=0.4)  # type: ignore[arg-type]
    with bench(scene(one)) as b:
        lifted = b.do(Grasp(track=0, relation="outside"))
        assert (lifted.status, lifted.holding) == ("done", True), lifted.why
        assert lifted.checks == {"closed_on_object": True, "width_kept": True}
        assert (b.truth().held, b.truth().touched) == (shape, (shape,))
        assert b.place_m()[2] > 0.10
        delivered = b.do(Deliver(place=CELL.delivery.name))
        at = b.place_m()
    assert (delivered.status, delivered.holding) == ("done", False), delivered.why
    assert all(delivered.checks[name] for name in ("still_held", "released", "released_empty"))
    assert at == pytest.approx(TRAY, abs=0.02)


def in_box(index: int = 0) -> Body:
    across, along = (-0.05, 0.06) if index == 0 else (0.04, -0.05)
    x, y = 1.02 + across, 0.03 + along
    return structs.replace(body(f"cube {index}", at_m=(x, y)), position_world_m=(x, y, 0.005))


def test_what_stands_in_an_open_box_is_fetched_and_its_neighbour_left_alone() -> None:
    with bench(scene(in_box(0), in_box(1), container=box(False))) as b:
        outcome = b.do(Grasp(track=0, relation="inside"))
        assert outcome.status == "done", outcome.why
        assert b.do(Look(view="center")).status == "done"
        assert b.truth().held == "cube 0"
        assert b.do(Deliver(place=CELL.delivery.name)).status == "done"
        assert b.place_m(1)[:2] == pytest.approx((1.06, -0.02), abs=0.005)


def test_what_was_lifted_can_be_put_back_where_it_was() -> None:
    with bench(scene(in_box(0), container=box(False))) as b:
        before = b.place_m()
        assert b.do(Grasp(track=0, relation="inside")).status == "done"
        outcome = b.do(PutBack())
        assert (outcome.status, outcome.holding) == ("done", False), outcome.why
        assert b.place_m() == pytest.approx(before, abs=0.006)


def test_what_is_not_there_is_not_grasped_and_the_hand_comes_out_open() -> None:
    elsewhere = estimate_of(scene(body("cube", at_m=(0.9, 0.2))))
    with bench(scene(body("cube", at_m=(0.9, -0.2)))) as b:
        outcome = b.do(Grasp(track=0, relation="outside"), elsewhere)
        tips = ur10e.flange(b.simulated.robot.joints_rad()) @ ur10e.tcp(outcome.gripper_width_m)
    assert (outcome.status, outcome.holding) == ("failed", False)
    assert outcome.checks == {"closed_on_object": False}
    assert tips[2, 3] > 0.07 and outcome.gripper_width_m > 0.05


def unseen_walls() -> tuple[Screen, ...]:
    """On both sides of the cube in the middle, where fingers come down."""
    return tuple(
        Screen(size_m=(0.30, 0.012, 0.16), position_world_m=(0.9, y, 0.0), yaw_rad=0.0)
        for y in (-0.045, 0.045)
    )


def test_an_arm_that_meets_what_was_not_seen_rests_and_the_hand_is_drawn_back() -> None:
    table = scene(body("cube"))
    with bench(structs.replace(table, screens=unseen_walls())) as b:
        outcome = b.do(Grasp(track=0, relation="outside"), estimate_of(table))
        joints = b.simulated.robot.joints_rad()
        assert (outcome.status, outcome.motions[-1].label) == ("failed", "back out")
        assert "degrees" in outcome.why
        assert outcome.motions[-1].q_rad[-1] == pytest.approx(joints, abs=1e-6)
        assert b.do(Look(view="center")).status == "done"


def test_what_cannot_be_grasped_is_refused_and_nothing_moves() -> None:
    with bench(scene(body("cube"))) as b:
        before = b.simulated.robot.joints_rad()
        outcome = b.do(Grasp(track=5, relation="outside"))
        assert (outcome.status, outcome.refusal, outcome.motions) == ("refused", "estimate", ())
        assert b.do(Deliver(place=CELL.delivery.name)).status == "refused"
        assert np.array_equal(b.simulated.robot.joints_rad(), before)
        with pytest.raises(BadInput, match="no view"):
            b.do(Look(view="left"))
        with pytest.raises(BadInput, match="no place"):
            b.do(Deliver(place="moon"))


def test_nothing_is_grasped_inside_while_the_lid_is_on() -> None:
    with bench(scene(body("cube", at_m=(0.85, -0.2)), container=box(True))) as b:
        outcome = b.do(Grasp(track=0, relation="inside"))
    assert (outcome.status, outcome.refusal, outcome.motions) == ("refused", "access", ())


def test_a_repeated_command_gets_its_outcome_and_moves_nothing() -> None:
    with bench(scene(body("cube"))) as b:
        command = b.command(Look(view="right"))
        first = b.service.execute(command)
        b.do(Look(view="center"))
        joints = b.simulated.robot.joints_rad()
        assert b.service.execute(command) is first
        assert np.array_equal(b.simulated.robot.joints_rad(), joints)
        with pytest.raises(Refused) as caught:
            b.service.execute(structs.replace(command, verb=Look(view="center")))
    assert caught.value.reason == "ID_REUSED"


def test_what_was_feasible_is_what_is_driven() -> None:
    with bench(scene(body("cube"))) as b:
        estimate = estimate_of(b.table)
        ask = AskFeasible(episode="e", step=0, estimate=estimate, grasps=(0,), informs=())
        assert b.service.feasible(ask).grasps[0].feasible
        promised, _ = b.service._plans.target(b.service._now(estimate), 0, np.random.default_rng())
        assert promised is not None
        outcome = b.do(Grasp(track=0, relation="outside"))
    driven = {motion.label: motion for motion in outcome.motions}
    for step in promised.steps:
        assert driven[step.label].q_rad[-1] == pytest.approx(step.end_rad, abs=2e-3)


def test_every_motion_is_published_and_comes_with_the_outcome() -> None:
    heard: list[Motion] = []
    with bench(scene(body("cube"))) as b:
        b.bus.listen(MOVED, heard.append)
        outcome = b.do(Grasp(track=0, relation="outside"))
    assert [m.label for m in heard] == [m.label for m in outcome.motions]
    ends = [m.q_rad[-1] for m in outcome.motions[:-1]]
    starts = [m.q_rad[0] for m in outcome.motions[1:]]
    assert np.abs(np.array(ends) - np.array(starts)).max() < 0.01
    total = sum(m.times_s[-1] for m in outcome.motions)
    assert outcome.duration_s == pytest.approx(total)
    assert outcome.motions[0].gripper_width_m[-1] > 0.055, "the hand was opened"


def after(seconds: float, do: Callable[[], Stopped]) -> Callable[[], Stopped]:
    """Call something from another thread after a while; the function returned waits for it."""
    answers: Queue[Stopped] = Queue()
    threading.Timer(seconds, lambda: answers.put(do())).start()
    return lambda: answers.get(timeout=5.0)


def test_a_stop_ends_the_motion_under_way_and_no_other_begins_until_a_scene_is_loaded() -> None:
    with bench(scene(body("cube")), real_time=True) as b:
        stopped = after(0.5, lambda: b.service.stop(Stop(who="the test")))
        outcome = b.do(Look(view="center"))
        joints = b.simulated.robot.joints_rad()
        assert outcome.status == "stopped"
        assert outcome.motions[-1].q_rad[-1] == pytest.approx(joints, abs=1e-3)
        assert views.view_at(CELL, joints) is None
        answer = stopped()
        assert answer.was_moving and answer.took_s < 0.5
        assert "the test" in b.service.doing
        again = b.do(Look(view="right"))
        assert (again.status, again.motions) == ("stopped", ())
        assert np.array_equal(b.simulated.robot.joints_rad(), joints)
        b.service.load_scene(b.table)
    with bench(scene(body("cube"))) as b:
        b.service.stop(Stop(who="the test"))
        b.service.load_scene(b.table)
        assert b.do(Look(view="right")).status == "done"


def test_the_same_commands_on_the_same_scene_give_the_same_bits() -> None:
    ends = []
    for _ in range(2):
        with bench(scene(body("cube"), body("other", at_m=(1.0, 0.1)))) as b:
            b.do(Look(view="center"))
            b.do(Grasp(track=0, relation="outside"))
            ends.append((b.simulated.robot.joints_rad(), b.truth().bodies))
    assert np.array_equal(ends[0][0], ends[1][0]) and ends[0][1] == ends[1][1]
