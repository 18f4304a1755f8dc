"""Wiring of the executor: `surefetch serve executor`."""

import sys
from collections.abc import Callable

from surefetch.common.bus import Bus
from surefetch.common.hosted import Service
from surefetch.common.runner import serve
from surefetch.common.settings import Settings, read_settings
from surefetch.common.topics import EXECUTOR
from surefetch.executor.grasping.antipodal import AntipodalProposer
from surefetch.executor.service import ExecutorService
from surefetch.executor.simulation.injected_failures import InjectedFailures
from surefetch.executor.simulation.pybullet_cell import PybulletCell
from surefetch.executor.simulation.pybullet_devices import pybullet_devices
from surefetch.executor.simulation.scorer_questions import Simulation
from surefetch.executor.skills.situation import Workcell


def pybullet(settings: Settings, bus: Bus) -> InjectedFailures:
    """The simulated cell."""
    simulated = PybulletCell(settings.cell, settings.grip)
    devices = pybullet_devices(simulated, real_time=settings.real_time)
    executor = ExecutorService(
        Workcell.of(settings.cell, AntipodalProposer()),
        devices,
        bus,
        backend="pybullet",
        simulated=Simulation(simulated),
    )
    return InjectedFailures(executor, devices.gripper, settings.cell)


EXECUTORS: dict[str, Callable[[Settings, Bus], Service]] = {"pybullet": pybullet}


def main(argv: list[str]) -> int:
    """Serve until told to end; the exit code."""
    settings = read_settings(argv, EXECUTOR)
    return serve(lambda bus: EXECUTORS[settings.executor](settings, bus), settings)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
