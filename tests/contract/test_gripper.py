"""Every gripper keeps the port's promises: a touch is a grip, a miss stays a miss."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import pytest
from tabletop import above, body, move, scene

from surefetch.common.cell import simulated_cell
from surefetch.common.messages import AskTruth, Scene
from surefetch.common.settings import GripModel
from surefetch.executor.ports import Devices
from surefetch.executor.simulation.pybullet_cell import PybulletCell
from surefetch.executor.simulation.pybullet_devices import pybullet_devices
from surefetch.executor.simulation.scorer_questions import Simulation

NEVER: Callable[[], bool] = lambda: False  # noqa: E731
FORCE_N = 40.0
WIDTH_M = 0.05


@dataclass(frozen=True)
class Bench:
    """A gripper on an arm above a table, and what can be seen from outside."""

    devices: Devices
    lifted_m: Callable[[], float]
    """How high the first body is."""
    simulation: Simulation


@contextmanager
def pybullet_bench(table: Scene, grip: GripModel = "contact_then_hold") -> Iterator[Bench]:
    simulated = PybulletCell(simulated_cell(), grip)
    simulated.load(table)
    simulation = Simulation(simulated)

    def lifted_m() -> float:
        return simulation.truth(AskTruth()).bodies[0].position_world_m[2]

    yield Bench(pybullet_devices(simulated), lifted_m, simulation)
    simulated.close()


BENCHES = {"pybullet": pybullet_bench}


def go(bench: Bench, x: float, y: float, z: float, width_m: float = WIDTH_M) -> None:
    arm = bench.devices.arm
    start = arm.joints_rad()
    assert arm.follow(move(start, above((x, y, z), start, width_m), 1.2), NEVER)


def grasp(bench: Bench, y: float = 0.0, z: float = 0.02) -> float:
    """Open, come down at (0.9, y), close; the width reached."""
    bench.devices.gripper.move(0.09, FORCE_N, NEVER)
    go(bench, 0.9, y, 0.15, 0.09)
    go(bench, 0.9, y, z)
    return bench.devices.gripper.move(0.0, FORCE_N, NEVER)


@pytest.mark.parametrize("name", sorted(BENCHES))
def test_it_opens_and_closes_to_the_width_asked_for(name: str) -> None:
    with BENCHES[name](scene()) as bench:
        gripper = bench.devices.gripper
        for width_m in (0.16, 0.03, 0.08, 0.0):
            assert gripper.move(width_m, FORCE_N, NEVER) == pytest.approx(width_m, abs=1e-3)
            assert gripper.width_m() == pytest.approx(width_m, abs=1e-3)
            assert not gripper.grip_detected()


@pytest.mark.parametrize("name", sorted(BENCHES))
def test_a_stop_ends_the_closing(name: str) -> None:
    with BENCHES[name](scene()) as bench:
        gripper = bench.devices.gripper
        gripper.move(0.16, FORCE_N, NEVER)
        asked = iter(range(10_000))
        assert gripper.move(0.0, FORCE_N, lambda: next(asked) > 60) > 0.08


@pytest.mark.parametrize("name", sorted(BENCHES))
def test_what_it_closed_on_comes_along_and_stays_until_it_opens(name: str) -> None:
    with BENCHES[name](scene(body("red cube"))) as bench:
        assert grasp(bench) == pytest.approx(0.05, abs=2e-3)
        assert bench.devices.gripper.grip_detected()
        go(bench, 0.9, 0.0, 0.22)
        go(bench, 0.7, -0.3, 0.22)
        assert bench.lifted_m() == pytest.approx(0.20, abs=5e-3)
        assert bench.devices.gripper.width_m() == pytest.approx(0.05, abs=2e-3)
        go(bench, 0.7, -0.3, 0.03)
        bench.devices.gripper.move(0.09, FORCE_N, NEVER)
        assert not bench.devices.gripper.grip_detected()
        go(bench, 0.7, -0.3, 0.22, 0.09)
        assert bench.lifted_m() == pytest.approx(0.0, abs=3e-3)


@pytest.mark.parametrize("name", sorted(BENCHES))
@pytest.mark.parametrize(
    "shape_size",
    [
        ("cylinder", (0.05, 0.05, 0.08)),
        ("ball", (0.05, 0.05, 0.048)),
        ("hexagonal prism", (0.05, 0.0577, 0.06)),
        ("block", (0.09, 0.04, 0.03)),
    ],
    ids=lambda row: row[0],
)
def test_every_shape_is_held(name: str, shape_size: tuple[str, tuple[float, ...]]) -> None:
    shape, size_m = shape_size
    table = scene(body("one", shape, size_m))  # type: ignore[arg-type]
    with BENCHES[name](table) as bench:
        grasp(bench)
        go(bench, 0.9, 0.0, 0.22)
        assert bench.lifted_m() > 0.18


@pytest.mark.parametrize("name", sorted(BENCHES))
def test_a_miss_stays_a_miss(name: str) -> None:
    with BENCHES[name](scene(body("red cube"))) as bench:
        assert grasp(bench, y=-0.12) < 2e-3
        assert not bench.devices.gripper.grip_detected()
        go(bench, 0.9, -0.12, 0.22)
        assert bench.lifted_m() == pytest.approx(0.0, abs=2e-3)
        assert bench.simulation.truth(AskTruth()).touched == ()


def test_the_truth_names_what_both_fingers_closed_on_and_what_is_held() -> None:
    with pybullet_bench(scene(body("red cube"), body("far", at_m=(0.9, 0.25)))) as bench:
        grasp(bench)
        truth = bench.simulation.truth(AskTruth())
        assert (truth.touched, truth.held) == (("red cube",), "red cube")
        bench.devices.gripper.move(0.09, FORCE_N, NEVER)
        truth = bench.simulation.truth(AskTruth())
        assert (truth.touched, truth.held) == (("red cube",), None)


@pytest.mark.parametrize(("mass_kg", "comes_along"), [(0.2, True), (9.0, False)])
def test_friction_alone_lifts_what_it_can_bear(mass_kg: float, comes_along: bool) -> None:
    with pybullet_bench(scene(body("cube", mass_kg=mass_kg)), "friction") as bench:
        grasp(bench)
        go(bench, 0.9, 0.0, 0.22)
        assert (bench.lifted_m() > 0.1) == comes_along
        assert (bench.simulation.truth(AskTruth()).held == "cube") == comes_along


def test_a_held_body_that_is_too_heavy_slips_out() -> None:
    with pybullet_bench(scene(body("cube", mass_kg=30.0))) as bench:
        grasp(bench)
        start = bench.devices.arm.joints_rad()
        bench.devices.arm.follow(move(start, above((0.9, 0.0, 0.12), start, WIDTH_M)), NEVER)
        assert bench.simulation.truth(AskTruth()).held is None


def test_attachment_takes_what_is_near_without_touching_it() -> None:
    with pybullet_bench(scene(body("cube", mass_kg=9.0)), "attachment") as bench:
        bench.devices.gripper.move(0.09, FORCE_N, NEVER)
        go(bench, 0.9, 0.0, 0.055, 0.09)
        bench.devices.gripper.move(0.0, FORCE_N, NEVER)
        go(bench, 0.9, 0.0, 0.22)
        assert bench.lifted_m() > 0.1


def test_the_fingertips_draw_back_as_they_open() -> None:
    simulated = PybulletCell(simulated_cell())
    pybullet_devices(simulated).gripper.move(0.12, FORCE_N, NEVER)
    assert simulated.robot.retraction_m() == pytest.approx(0.0194, abs=5e-4)
    assert np.isfinite(simulated.robot.joints_rad()).all()
    simulated.close()
