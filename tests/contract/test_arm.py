"""Every arm keeps the port's promises."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from tabletop import above, move, scene

from surefetch.common.cell import simulated_cell
from surefetch.common.errors import DeviceFault
from surefetch.executor.ports import Arm
from surefetch.executor.simulation.pybullet_cell import PybulletCell
from surefetch.executor.simulation.pybullet_devices import pybullet_devices

NEVER: Callable[[], bool] = lambda: False  # noqa: E731


@contextmanager
def pybullet_arm() -> Iterator[Arm]:
    simulated = PybulletCell(simulated_cell())
    simulated.load(scene())
    yield pybullet_devices(simulated).arm
    simulated.close()


ARMS = {"pybullet": pybullet_arm}


@pytest.fixture(params=sorted(ARMS))
def arm(request: pytest.FixtureRequest) -> Iterator[Arm]:
    with ARMS[request.param]() as one:
        yield one


def test_it_starts_at_home_and_stands_still(arm: Arm) -> None:
    home = np.radians(simulated_cell().home.q_deg)
    assert np.allclose(arm.joints_rad(), home, atol=1e-3)


def test_it_reaches_the_end_of_a_trajectory(arm: Arm) -> None:
    start = arm.joints_rad()
    end = start + np.radians([20.0, -10.0, 10.0, 5.0, -10.0, 30.0])
    assert arm.follow(move(start, end), NEVER)
    assert np.abs(arm.joints_rad() - end).max() < np.radians(0.1)


def test_it_refuses_a_trajectory_that_starts_elsewhere(arm: Arm) -> None:
    start = arm.joints_rad()
    with pytest.raises(DeviceFault, match="not where the trajectory starts"):
        arm.follow(move(start + 0.1, start + 0.2), NEVER)
    assert np.allclose(arm.joints_rad(), start, atol=1e-3)


def test_a_stop_ends_the_motion_soon_and_on_its_path(arm: Arm) -> None:
    start = arm.joints_rad()
    end = start + np.radians([40.0, 0.0, 0.0, 0.0, 20.0, 0.0])
    asked = iter(range(10_000))
    assert not arm.follow(move(start, end, 4.0), lambda: next(asked) > 240)
    share = (arm.joints_rad() - start)[[0, 4]] / (end - start)[[0, 4]]
    assert share[0] == pytest.approx(share[1], abs=0.01)
    at_stop_and_a_quarter_second_later = (0.10, 0.19)
    assert at_stop_and_a_quarter_second_later[0] < share[0] < at_stop_and_a_quarter_second_later[1]


def test_after_a_stop_it_stands_still_and_takes_the_next_trajectory(arm: Arm) -> None:
    start = arm.joints_rad()
    asked = iter(range(10_000))
    arm.follow(move(start, start + 0.3), lambda: next(asked) > 100)
    stopped = arm.joints_rad()
    assert arm.follow(move(stopped, start), NEVER)
    assert np.abs(arm.joints_rad() - start).max() < np.radians(0.1)


def test_being_held_off_its_path_is_a_fault_and_it_comes_to_rest(arm: Arm) -> None:
    start = arm.joints_rad()
    over = above((0.8, 0.0, 0.10), start, 0.0)
    assert arm.follow(move(start, over), NEVER)
    through_the_table = above((0.8, 0.0, -0.25), over, 0.0)
    with pytest.raises(DeviceFault, match="left its path"):
        arm.follow(move(arm.joints_rad(), through_the_table), NEVER)
    assert np.abs(arm.joints_rad() - through_the_table).max() > 0.1


def test_being_held_off_the_end_of_its_path_is_a_fault_too(arm: Arm) -> None:
    start = arm.joints_rad()
    over = above((0.8, 0.0, 0.05), start, 0.0)
    assert arm.follow(move(start, over), NEVER)
    a_little_into_the_table = above((0.8, 0.0, -0.05), over, 0.0)
    with pytest.raises(DeviceFault, match="off its path's end"):
        arm.follow(move(arm.joints_rad(), a_little_into_the_table), NEVER)
