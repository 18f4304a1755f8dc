"""What a policy is told of tables that nobody saw: boxes as tracks, and what looks told of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from scripted_table import CELL, PLATE, parameters

from surefetch.common.conformal import conformal_set
from surefetch.common.geometry import Array, intrinsics, inverse, rigid, rotation_z, transform
from surefetch.common.hypotheses import RELATIONS, AskedRelation
from surefetch.common.messages import (
    BeliefReply,
    Box3d,
    ContainerReading,
    Feasibility,
    Frame,
    FrameId,
    FrameInfo,
    GraspVerdict,
    Lid,
    Mask,
    Target,
    Track,
)
from surefetch.common.viewpoint import camera_pose
from surefetch.evaluation.policies.observation import Observation
from surefetch.evaluation.recordings.free_space import FreeSpace, seen_in
from surefetch.planner.actions import State
from surefetch.planner.estimate import NOTHING_SEEN
from surefetch.planner.profiles import PROFILES

OPEN = ContainerReading(
    box_px=(0.0, 0.0, 1.0, 1.0),
    score=1.0,
    mask=Mask(height=1, width=1, counts=(1,)),
    outer=Box3d(center_world_m=(1.0, 0.0, 0.04), size_m=(0.25, 0.25, 0.08), yaw_rad=0.0),
    inner_size_m=(0.24, 0.24),
    floor_z_m=0.005,
    rim_z_m=0.08,
    complete=True,
    lid=None,
)
COVERED = msgspec.structs.replace(OPEN, lid=Lid(plate=PLATE, knob=None))
CAMERA = CELL.camera


@dataclass(frozen=True)
class Known:
    """A track, as it is known."""

    y: str | None
    p: Mapping[str, float] | float = 0.0
    """Belief by relation; a number: outside."""
    at_m: tuple[float, float] = (0.9, 0.2)
    n_observations: int = 1
    last_step: int | None = None
    """None: this look."""
    refused: int = 0
    """Grasps that were refused before one was found."""
    feasible: bool = True


def observation(
    known: Sequence[Known] = (),
    *,
    asked: AskedRelation = "any",
    cover: State = "open",
    used: Sequence[str] = (),
    unobs: float = 0.0,
    container: ContainerReading | None = OPEN,
    looks: Sequence[FreeSpace] = (),
    profile: str = "extended",
) -> Observation:
    """These tracks are known, numbered from 1; the rest of the belief says that there is none."""
    step = max(len(looks) - 1, len(used))
    tracks = tuple(track(n, one, step) for n, one in enumerate(known, start=1))
    belief = {f"{n}:{r}": _p(one, r) for n, one in enumerate(known, start=1) for r in RELATIONS}
    belief |= {"unobs": unobs, "abs": 1.0 - unobs - sum(belief.values())}
    told = BeliefReply(
        episode="e", step=step, tracks=tracks, assigned=(), prior={}, belief=belief,
        gamma=conformal_set(belief, 0.9), q_hat=0.9, digest="-",
    )  # fmt: skip
    verdicts = tuple(
        GraspVerdict(
            track=n, feasible=one.feasible, refusal=None, why="", tried={"access": one.refused}
        )
        for n, one in enumerate(known, start=1)
    )
    return Observation(
        target=Target(noun="object", color="red", relation=asked),
        cell=CELL,
        parameters=parameters(profile),
        profile=PROFILES[profile],
        believed=told,
        cover=cover,
        used=frozenset(used),
        given_up=frozenset(),
        feasibility=Feasibility(grasps=verdicts, informs=(), duration_s=0.0),
        n_actions=len(used),
        rng=np.random.default_rng(0),
        looks=tuple(looks),
        estimate=msgspec.structs.replace(NOTHING_SEEN, container=container, cover=cover),
    )


def track(number: int, known: Known, step: int) -> Track:
    """A box of 5 x 5 x 6 cm."""
    return Track(
        id=number,
        center_world_m=(*known.at_m, 0.03),
        solid=box(*known.at_m),
        points_world_m=np.zeros((0, 3), np.float32),
        hist=None,
        n_observations=known.n_observations,
        y0=known.y,
        last_detection=f"d{number}",
        last_step=step if known.last_step is None else known.last_step,
    )


def box(
    x_m: float, y_m: float, size_m: tuple[float, float, float] = (0.05, 0.05, 0.06), yaw: float = 0
) -> Box3d:
    """A box that stands on the table."""
    return Box3d(center_world_m=(x_m, y_m, size_m[2] / 2.0), size_m=size_m, yaw_rad=yaw)


def look(view: str, boxes: Sequence[Box3d]) -> FreeSpace:
    """What a look from a view tells of the space over a table with these boxes."""
    return FreeSpace.of(seen_in(rendered(camera_pose(CELL, CELL.view(view)), boxes)))


def rendered(T_world_camera: Array, boxes: Sequence[Box3d], stride: int = 4) -> Frame:
    """Depth of boxes on an endless table, (height, width) coarser than the cell's camera."""
    width, height = CAMERA.width // stride, CAMERA.height // stride
    K = intrinsics(width, height, CAMERA.vertical_fov_deg)
    v, u = np.mgrid[:height, :width].reshape(2, -1).astype(float)
    ahead = np.column_stack([u, v, np.ones(len(u))]) @ np.linalg.inv(K).T
    ahead = ahead @ T_world_camera[:3, :3].T
    eye_m = T_world_camera[:3, 3]
    depth_m = np.where(ahead[:, 2] < -1e-9, -eye_m[2] / np.minimum(ahead[:, 2], -1e-9), np.inf)
    for one in boxes:
        depth_m = np.minimum(depth_m, _depth_of(one, eye_m, ahead))
    depth_m = np.where(np.isfinite(depth_m), depth_m, 0.0)
    return Frame(
        info=FrameInfo(
            frame=FrameId(boot="made-up", counter=0), view=None, width=width, height=height, K=K,
            T_world_camera=T_world_camera, captured_s=0.0,
        ),
        rgb=np.zeros((height, width, 3), np.uint8),
        depth_m=depth_m.reshape(height, width).astype(np.float32),
        q_rad=(0.0,) * 6,
        gripper_width_m=0.0,
    )  # fmt: skip


def _depth_of(one: Box3d, eye_m: Array, ahead: Array) -> Array:
    """Where rays (n, 3) enter a box, in multiples of theirs; infinite where they miss it."""
    T_box_world = inverse(rigid(rotation_z(one.yaw_rad), np.array(one.center_world_m)))
    eye, half = transform(T_box_world, eye_m[None])[0], np.array(one.size_m) / 2.0
    ways = ahead @ T_box_world[:3, :3].T
    ways = np.where(np.abs(ways) < 1e-12, 1e-12, ways)
    low, high = (-half - eye) / ways, (half - eye) / ways
    enters, leaves = np.minimum(low, high).max(axis=1), np.maximum(low, high).min(axis=1)
    return np.where((enters <= leaves) & (enters > 0.0), enters, np.inf)


def _p(known: Known, relation: str) -> float:
    if isinstance(known.p, Mapping):
        return known.p.get(relation, 0.0)
    return known.p if relation == "outside" else 0.0
