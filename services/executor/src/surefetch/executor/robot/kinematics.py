"""Inverse kinematics of the nominal arm in closed form: every branch, each checked by FK.

The formulas follow the decoupling of Hawkins, Analytic Inverse Kinematics for the Universal
Robots UR-5/UR-10 Arms (2013), in the standard DH parameters of `ur10e`. A calibrated arm takes the
answer as a seed.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from surefetch.common.geometry import Array
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.robot import ur10e

LIMIT_MARGIN_RAD = float(np.radians(5.0))
RESIDUAL_M = 1e-4
RESIDUAL_RAD = 1e-3

_D4, _D6 = ur10e.DH_D_M[3], ur10e.DH_D_M[5]
_A2, _A3 = ur10e.DH_A_M[1], ur10e.DH_A_M[2]
_SIGNS = np.array(list(product((1.0, -1.0), repeat=3))).T  # (3, 8): shoulder, wrist, elbow


@dataclass(frozen=True)
class Singularity:
    """How far a configuration is from the three singularities; 0 is at one."""

    wrist: float
    """|sin q5|"""
    elbow: float
    """|sin q3|"""
    shoulder_m: float
    """Distance of the wrist centre from the cylinder that it cannot enter."""

    @property
    def near(self) -> bool:
        """Too near for a Cartesian move."""
        return self.wrist < 0.05 or self.elbow < 0.05 or self.shoulder_m < 0.02


def branches(T_world_flange: Array) -> Array:
    """The eight closed-form configurations (8, 6) of a flange pose (4, 4), in (-pi, pi].

    Order: shoulder left/right, wrist, elbow. Where a pose cannot be reached the nearest
    value of the branch stands in, so a caller must check the residual.
    """
    T = ur10e.T_BASE_LINK_BASE @ np.asarray(T_world_flange, dtype=np.float64)
    s_shoulder, s_wrist, s_elbow = _SIGNS
    q1 = _shoulder_pan(T, s_shoulder)
    s1, c1 = np.sin(q1), np.cos(q1)
    q5 = s_wrist * np.arccos(np.clip((T[0, 3] * s1 - T[1, 3] * c1 - _D4) / _D6, -1.0, 1.0))
    q6 = _wrist_3(T, s1, c1, np.sin(q5))
    q = np.zeros((8, 6))
    q[:, 0], q[:, 4], q[:, 5] = q1, q5, q6
    T_14 = _from_shoulder_to_wrist_1(T, q)
    x, y = T_14[:, 0, 3] - _D4 * T_14[:, 0, 1], T_14[:, 1, 3] - _D4 * T_14[:, 1, 1]
    cos_q3 = np.clip((x * x + y * y - _A2**2 - _A3**2) / (2.0 * _A2 * _A3), -1.0, 1.0)
    q3 = s_elbow * np.arccos(cos_q3)
    q2 = np.arctan2(-y, -x) - np.arctan2(-_A3 * np.sin(q3), -_A2 - _A3 * np.cos(q3))
    q[:, 1], q[:, 2] = q2, q3
    q[:, 3] = np.arctan2(T_14[:, 1, 0], T_14[:, 0, 0]) - q2 - q3
    wrapped: Array = np.pi - np.mod(np.pi - q, 2.0 * np.pi)
    return wrapped


def _shoulder_pan(T: Array, sign: Array) -> Array:
    """q1 (8,) from the wrist centre, which keeps the distance d4 from the arm's plane."""
    wrist = T[:3, 3] - _D6 * T[:3, 2]
    ratio = np.clip(_D4 / max(float(np.hypot(wrist[0], wrist[1])), 1e-12), -1.0, 1.0)
    q1: Array = np.arctan2(wrist[1], wrist[0]) + sign * np.arccos(ratio) + np.pi / 2.0
    return q1


def _wrist_3(T: Array, s1: Array, c1: Array, s5: Array) -> Array:
    """q6 (8,); 0 where wrist 1 and wrist 3 are parallel and only their sum is defined."""
    free = np.abs(s5) < 1e-9
    sign = np.where(free, 1.0, np.sign(s5))
    y = (-T[0, 1] * s1 + T[1, 1] * c1) * sign
    x = (T[0, 0] * s1 - T[1, 0] * c1) * sign
    return np.where(free, 0.0, np.arctan2(y, x))


def _from_shoulder_to_wrist_1(T: Array, q: Array) -> Array:
    """T_14 (8, 4, 4): what joints 2 to 4 must make, given q1, q5, q6."""
    A_1, A_5, A_6 = (_joint_transform(i, q[:, i]) for i in (0, 4, 5))
    made: Array = np.linalg.inv(A_1) @ T @ np.linalg.inv(A_5 @ A_6)
    return made


def _joint_transform(i: int, q: Array) -> Array:
    """A_i (n, 4, 4), standard DH."""
    A = np.zeros((len(q), 4, 4))
    c, s = np.cos(q), np.sin(q)
    A[:, 0, 0], A[:, 0, 1], A[:, 1, 0], A[:, 1, 1] = c, -s, s, c
    A[:, 2, 2] = A[:, 3, 3] = 1.0
    turned: Array = A @ ur10e.dh_constant(i)
    return turned


def residuals(q_rad: Array, T_world_flange: Array) -> tuple[Array, Array]:
    """Position (n,) in metres and angle (n,) by which configurations (n, 6) miss a pose (4, 4)."""
    T = ur10e.flange(q_rad)
    miss_m: Array = np.linalg.norm(T[:, :3, 3] - T_world_flange[:3, 3], axis=1)
    R = np.swapaxes(T[:, :3, :3], 1, 2) @ T_world_flange[:3, :3]
    # |R - I|_F = 2 sqrt(2) sin(angle / 2), exact for small angles where arccos is not
    chord = np.linalg.norm(R - np.eye(3), axis=(1, 2)) / (2.0 * np.sqrt(2.0))
    angle: Array = 2.0 * np.arcsin(np.clip(chord, 0.0, 1.0))
    return miss_m, angle


def solve(T_world_flange: Array) -> Array:
    """Configurations (k, 6) in (-pi, pi] that reach a flange pose, verified by FK, k at least 1.

    Raises:
        Infeasible: reach; says by how much the nearest branch misses.
    """
    candidates = branches(T_world_flange)
    miss_m, angle = residuals(candidates, T_world_flange)
    good = (miss_m < RESIDUAL_M) & (angle < RESIDUAL_RAD)
    if not good.any():
        p = T_world_flange[:3, 3]
        raise Infeasible(
            "reach",
            f"the flange cannot reach ({p[0]:.3f}, {p[1]:.3f}, {p[2]:.3f}) m in this orientation: "
            f"the nearest configuration misses by {1e3 * miss_m.min():.0f} mm",
        )
    return _distinct(candidates[good])


def _distinct(q: Array) -> Array:
    """Rows (k, 6) without repetitions, which occur at singularities."""
    kept: list[Array] = []
    for row in q:
        if all(np.abs(np.sin((row - other) / 2.0)).max() > 1e-7 for other in kept):
            kept.append(row)
    return np.array(kept)


def inside_limits(q_rad: Array, margin_rad: float = LIMIT_MARGIN_RAD) -> bool:
    """Whether every row of q (..., 6) keeps the margin to the joint limits."""
    return bool((np.abs(q_rad) <= ur10e.Q_MAX_RAD - margin_rad).all())


def effort_s(q_a: Array, q_b: Array) -> Array:
    """The shortest time (...,) between joints (..., 6) at full joint speed."""
    longest: Array = np.max(np.abs(q_a - q_b) / ur10e.QD_MAX_RAD_S, axis=-1)
    return longest


def with_turns(q_rad: Array, margin_rad: float = LIMIT_MARGIN_RAD) -> Array:
    """All whole-turn variants (k, 6) of configurations (n, 6) that keep the joint limits."""
    turns = 2.0 * np.pi * np.array(list(product((-1.0, 0.0, 1.0), repeat=6)))
    limit = ur10e.Q_MAX_RAD - margin_rad
    useful = turns[(np.abs(turns) <= limit + np.pi).all(axis=1)]
    variants = (q_rad[:, None, :] + useful[None]).reshape(-1, 6)
    kept: Array = variants[(np.abs(variants) <= limit).all(axis=1)]
    return kept


def solutions(
    T_world_flange: Array, near_rad: Array, margin_rad: float = LIMIT_MARGIN_RAD
) -> Array:
    """Every configuration (k, 6) of a pose inside the limits, nearest to `near` (6,) first.

    Raises:
        Infeasible: reach, or limits when every branch violates the joint limits.
    """
    found = with_turns(solve(T_world_flange), margin_rad)
    if not len(found):
        raise Infeasible(
            "limits", "every configuration that reaches the pose is past a joint limit"
        )
    ordered: Array = found[np.argsort(effort_s(found, near_rad), kind="stable")]
    return ordered


def nearest(T_world_flange: Array, near_rad: Array, margin_rad: float = LIMIT_MARGIN_RAD) -> Array:
    """The configuration (6,) of a pose nearest to `near` (6,), of the turns nearest to it.

    The same as the first of `solutions` wherever that is less than half a turn away, and faster.

    Raises:
        Infeasible: reach, or limits.
    """
    found = solve(T_world_flange)
    turned = found + 2.0 * np.pi * np.round((near_rad - found) / (2.0 * np.pi))
    inside = turned[(np.abs(turned) <= ur10e.Q_MAX_RAD - margin_rad).all(axis=1)]
    if not len(inside):
        raise Infeasible("limits", "the configurations that reach the pose are past a joint limit")
    q: Array = inside[effort_s(inside, near_rad).argmin()]
    return q


def singularity(q_rad: Array) -> Singularity:
    """Distance of a configuration (6,) from singularities."""
    T = ur10e.flange(q_rad)
    wrist = T[:3, 3] - _D6 * T[:3, 2]
    return Singularity(
        wrist=float(abs(np.sin(q_rad[4]))),
        elbow=float(abs(np.sin(q_rad[2]))),
        shoulder_m=float(np.hypot(wrist[0], wrist[1]) - _D4),
    )
