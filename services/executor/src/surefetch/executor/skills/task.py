"""What every skill is given: the devices, what is planned with, and what was perceived."""

from dataclasses import dataclass

import numpy as np

from surefetch.common.geometry import rigid
from surefetch.common.messages import Estimate
from surefetch.executor.motion.collision import FINGERS, HELD
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.motion.planner import Tool
from surefetch.executor.robot import ur10e
from surefetch.executor.skills.execution import Execution, Failed
from surefetch.executor.skills.plans import Plans
from surefetch.executor.skills.situation import Situation, Workcell, allowing_contacts, surroundings
from surefetch.executor.skills.steps import Step, check_again, line

IN_CONTACT = (*FINGERS, HELD, "gripper body")
BACK_SHARES = (1.0, 0.6, 0.3)


@dataclass(frozen=True, eq=False)
class Task:
    """One command's means."""

    run: Execution
    workcell: Workcell
    plans: Plans
    estimate: Estimate
    rng: np.random.Generator

    def now(self) -> Situation:
        """Where arm and hand are, as measured."""
        devices = self.run.devices
        return Situation(
            devices.arm.joints_rad(), devices.gripper.width_m(), self.estimate, self.run.memory
        )

    def checked(self, *steps: Step) -> None:
        """Check planned steps once more against where the arm is. Raises Infeasible."""
        check_again(self.workcell.motion, steps, self.run.devices.arm.joints_rad())

    def look(self, view: str, *, lid: bool = True) -> None:
        """Bring the camera to a view. Raises Infeasible, Halted, DeviceFault."""
        now = self.now()
        if lid:
            step = self.plans.view(now, view, self.rng)
            if isinstance(step, Infeasible):
                raise step
            self.checked(step)
        else:
            around = surroundings(self.workcell, now, lid=False)
            row, tool = self.workcell.cell.view(view), now.tool()
            to_it = self.workcell.motion.to_view(now.q_rad, row, around, tool, self.rng)
            step = Step(f"to view {view}", to_it, tool, around)
        self.run.follow(step)

    def back_out(self, distance_m: float) -> None:
        """Draw the hand straight back along its own axis, as far as there is room.

        Raises:
            Failed: there is none; the hand stays where it is.
        """
        now = self.now()
        here = ur10e.flange(now.q_rad)
        tool = Tool(now.width_m, careful=True)
        why = ""
        for share in BACK_SHARES:
            away = here @ rigid(np.eye(3), np.array([0.0, 0.0, -share * distance_m]))
            try:
                scene = surroundings(self.workcell, now)
                scene = allowing_contacts(scene, now.q_rad, now.width_m, IN_CONTACT)
                step = line(self.workcell.motion, "back out", now.q_rad, away, scene, tool)
            except Infeasible as refusal:
                why = refusal.why
                continue
            self.run.follow(step)
            return
        raise Failed(f"the hand cannot move back: {why}")
