"""From a path to a trajectory: when to be where, from rest to rest, inside every limit.

A straight joint move gets a jerk-limited time law (ruckig) along its line. Any other path gets the
fastest law that its joint speeds, joint accelerations and tcp speeds allow, by a forward and a
backward pass over the path (after Bobrow, Dubowsky and Gibson, Time-Optimal Control of Robotic
Manipulators Along Specified Paths, 1985).
"""

from dataclasses import dataclass

import numpy as np
from ruckig import InputParameter, Result, Ruckig
from ruckig import Trajectory as RuckigTrajectory

from surefetch.common.cell import Speeds
from surefetch.common.geometry import Array
from surefetch.executor.motion.paths import LEVER_M, densify, tcp_positions
from surefetch.executor.ports import Trajectory
from surefetch.executor.robot import ur10e

SAMPLE_S = 0.010
JERK_RAD_S3 = 10.0
PATH_STEP_M = 0.003
PIECES_MIN = 8
NO_MOVE_RAD = 1e-4
BEND_SHARE = 0.5
"""Share of the joint acceleration that bends of a path may use; the rest is for its speed."""


@dataclass(frozen=True, eq=False)
class Limits:
    """What a trajectory keeps."""

    speed_rad_s: Array
    """(6,)"""
    acceleration_rad_s2: float

    @classmethod
    def of(cls, speeds: Speeds) -> "Limits":
        """The limits of a cell file."""
        fraction = speeds.joint_fraction
        return cls(fraction * ur10e.QD_MAX_RAD_S, speeds.joint_acceleration_rad_s2)


def time_joint_move(
    q_a: Array, q_b: Array, limits: Limits, tcp_limit_m_s: float, width_m: float
) -> Trajectory:
    """The straight joint move from a to b (6,), its tcp nowhere faster than the limit."""
    if np.abs(q_b - q_a).max() < 1e-9:
        return _at_rest(q_a)
    law = _ruckig(q_b - q_a, limits)
    times = _sample_times(law.duration)
    fastest = _tcp_speeds(times, _on_line(q_a, q_b, law, times), width_m).max()
    stretch = max(float(fastest) / tcp_limit_m_s, 1.0)
    times = _sample_times(law.duration * stretch)
    return Trajectory(times, _on_line(q_a, q_b, law, times / stretch))


def _ruckig(move_rad: Array, limits: Limits) -> RuckigTrajectory:
    """Part of a joint move (6,) done over time, from 0 to 1 and from rest to rest.

    One axis for the whole line: with six, ruckig leaves the line where phases cannot be matched.
    """
    ask = InputParameter(1)
    longest = float(np.abs(move_rad).max())
    ask.current_position, ask.target_position = [0.0], [1.0]
    ask.max_velocity = [float((limits.speed_rad_s / np.maximum(np.abs(move_rad), 1e-12)).min())]
    ask.max_acceleration = [limits.acceleration_rad_s2 / longest]
    ask.max_jerk = [JERK_RAD_S3 / longest]
    law = RuckigTrajectory(1)
    outcome = Ruckig(1).calculate(ask, law)
    if outcome not in (Result.Working, Result.Finished):
        raise ValueError(f"ruckig refuses a joint move by {move_rad} rad: {outcome}")
    return law


def _on_line(q_a: Array, q_b: Array, law: RuckigTrajectory, times: Array) -> Array:
    parts = np.array([law.at_time(float(t))[0][0] for t in times])
    line: Array = q_a + np.clip(parts, 0.0, 1.0)[:, None] * (q_b - q_a)
    return line


def _at_rest(q: Array) -> Trajectory:
    return Trajectory(np.array([0.0, SAMPLE_S]), np.stack([q, q]))


def time_path(path: Array, limits: Limits, tcp_limit_m_s: Array, width_m: float) -> Trajectory:
    """A dense path (n, 6), from rest to rest, the tcp's speed limited point by point (n,)."""
    if _arc(path)[-1] < NO_MOVE_RAD:
        return _at_rest(path[-1])
    fine = densify(path, min(PATH_STEP_M, _short_step_m(path)))
    s = _arc(fine)
    tcp_limit = np.interp(s, _arc(path), tcp_limit_m_s)
    speed = _speed_law(fine, s, limits, tcp_limit, width_m)
    moments, at_s = _sampled(s, speed)
    q = np.stack([np.interp(at_s, s, joint) for joint in fine.T], axis=1)
    stretch = _excess(moments, q, limits, width_m, np.interp(at_s, s, tcp_limit))
    return Trajectory(moments * stretch, q)


def _short_step_m(path: Array) -> float:
    """Steps that cut the shortest path into a few pieces: it must be fast somewhere between."""
    return float((np.abs(np.diff(path, axis=0)) * LEVER_M).sum()) / PIECES_MIN


def _speed_law(
    path: Array, s: Array, limits: Limits, tcp_limit_m_s: Array, width_m: float
) -> Array:
    """Speeds ds/dt (n,) along a path (n, 6) parametrised by s (n,)."""
    slope = np.abs(np.gradient(path, s, axis=0)) + 1e-12
    bend = np.abs(np.gradient(np.gradient(path, s, axis=0), s, axis=0))
    travel = np.linalg.norm(np.gradient(tcp_positions(path, width_m), s, axis=0), axis=1) + 1e-12
    a = limits.acceleration_rad_s2
    fastest = np.minimum((limits.speed_rad_s / slope).min(axis=1), tcp_limit_m_s / travel)
    ceiling = np.minimum(fastest**2, (BEND_SHARE * a / (bend + 1e-12)).min(axis=1))
    ceiling[[0, -1]] = 0.0
    push = ((1.0 - BEND_SHARE) * a / slope).min(axis=1)
    square = _climb(ceiling, push, np.diff(s))
    square = _climb(square[::-1], push[::-1], np.diff(s)[::-1])[::-1]
    speed: Array = np.sqrt(square)
    return speed


def _sampled(s: Array, speed: Array) -> tuple[Array, Array]:
    """Even times and the places on the path then, its speed changing evenly between its points."""
    took = 2.0 * np.diff(s) / (speed[1:] + speed[:-1])
    times = np.concatenate([[0.0], np.cumsum(took)])
    moments = _sample_times(times[-1])
    k = np.clip(np.searchsorted(times, moments, side="right") - 1, 0, len(took) - 1)
    since = moments - times[k]
    gained = 0.5 * (speed[k + 1] - speed[k]) / took[k] * since**2
    return moments, np.minimum(s[k] + speed[k] * since + gained, s[-1])


def _climb(ceiling: Array, push: Array, ds: Array) -> Array:
    """Squared speeds (n,) below the ceiling that rise no faster than the acceleration allows."""
    square = ceiling.copy()
    for k, step in enumerate(ds):
        gain = 2.0 * step * min(push[k], push[k + 1])
        square[k + 1] = min(square[k + 1], square[k] + gain)
    return square


def _excess(times: Array, q: Array, limits: Limits, width_m: float, tcp_limit_m_s: Array) -> float:
    """The factor by which a sampled trajectory must be slowed to keep its limits; at least 1."""
    speed = np.diff(q, axis=0) / times[1]
    bent = np.diff(speed, axis=0, prepend=0.0, append=0.0) / times[1]
    tcp = _tcp_speeds(times, q, width_m) / np.minimum(tcp_limit_m_s[1:], tcp_limit_m_s[:-1])
    by_speed = float((np.abs(speed) / limits.speed_rad_s).max())
    by_bend = float(np.sqrt(np.abs(bent).max() / limits.acceleration_rad_s2))
    return max(1.0, by_speed, by_bend, float(tcp.max()))


def _arc(path: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])


def _tcp_speeds(times: Array, q: Array, width_m: float) -> Array:
    p = tcp_positions(q, width_m)
    speeds: Array = np.linalg.norm(np.diff(p, axis=0), axis=1) / np.diff(times)
    return speeds


def _sample_times(duration_s: float) -> Array:
    """Even samples from 0 to the duration, at most SAMPLE_S apart."""
    n = max(int(np.ceil(duration_s / SAMPLE_S)), 2)
    return np.linspace(0.0, duration_s, n + 1)
