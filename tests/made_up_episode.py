"""A made-up episode as an observer would have seen it: two looks, a red cylinder, a grasp."""

import numpy as np

from surefetch.common.geometry import look_at
from surefetch.common.messages import (
    Accepted,
    Acted,
    Acting,
    ActionRecord,
    Answer,
    Answers,
    Believed,
    Body,
    Box3d,
    Captured,
    Container,
    ContainerReading,
    Decided,
    Detection,
    Ended,
    Event,
    Feasibility,
    Frame,
    FrameId,
    FrameInfo,
    Grasp,
    GraspVerdict,
    Happening,
    Inform,
    Lighting,
    Marking,
    Mask,
    Motion,
    Observations,
    Perceived,
    QValue,
    Scene,
    StepRecord,
    Target,
    TrackSummary,
)
from surefetch.evaluation.showing.observed import Observed, Seen

WIDTH, HEIGHT = 160, 120
K = np.array([[130.0, 0.0, 79.5], [0.0, 130.0, 59.5], [0.0, 0.0, 1.0]])
CENTERS = ((0.95, 0.1, 0.03), (0.95, -0.1, 0.03))
BELIEFS = (
    {
        "1:inside": 0.1,
        "1:outside": 0.4,
        "2:inside": 0.1,
        "2:outside": 0.1,
        "unobs": 0.2,
        "abs": 0.1,
    },
    {
        "1:inside": 0.01,
        "1:outside": 0.95,
        "2:inside": 0.01,
        "2:outside": 0.01,
        "unobs": 0.01,
        "abs": 0.01,
    },
)
GAMMAS = (("1:outside", "unobs"), ("1:outside",))


def frame(counter: int) -> Frame:
    """A grey image with two coloured blobs, at the start of an arm."""
    rgb = np.full((HEIGHT, WIDTH, 3), 170, np.uint8)
    rgb[40:70, 20:50] = (200, 30, 30)
    rgb[40:70, 100:130] = (30, 60, 200)
    depth_m = np.full((HEIGHT, WIDTH), 0.6, np.float32)
    T = look_at(np.array([0.4, 0.0, 0.4]), np.array([0.95, 0.0, 0.03]), np.array([0.0, 0.0, 1.0]))
    info = FrameInfo(
        frame=FrameId(boot="e", counter=counter),
        view="center",
        width=WIDTH,
        height=HEIGHT,
        K=K,
        T_world_camera=T,
        captured_s=float(counter),
    )
    return Frame(
        info=info,
        rgb=rgb,
        depth_m=depth_m,
        q_rad=(0.0, -2.0, 1.9, -1.4, -1.5, 0.0),
        gripper_width_m=0.1,
    )


def mask(x0: int, x1: int) -> Mask:
    """Rows 40 to 70 of columns x0 to x1."""
    counts = [x0 * HEIGHT + 40]
    for _ in range(x1 - x0 - 1):
        counts += [30, HEIGHT - 30]
    counts += [30, HEIGHT - 70 + (WIDTH - x1) * HEIGHT]
    return Mask(height=HEIGHT, width=WIDTH, counts=tuple(counts))


def detection(counter: int, index: int) -> Detection:
    """One of the two blobs."""
    x0 = 20 if index == 0 else 100
    membership = Answer(label="outside", scores=(0.0, 1.0, 0.0))
    return Detection(
        id=f"e-{counter}-{index}",
        box_px=(x0, 40.0, x0 + 30.0, 70.0),
        score=0.9,
        phrase="cylinder",
        mask=mask(x0, x0 + 30),
        group=index,
        representative=True,
        center_world_m=CENTERS[index],
        solid=Box3d(center_world_m=CENTERS[index], size_m=(0.05, 0.05, 0.06), yaw_rad=0.0),
        points_world_m=np.zeros((0, 3), np.float32),
        hist=None,
        answers=Answers(color=None, shape=None, marking=None, membership=membership),
    )


def observations(counter: int) -> Observations:
    """Two candidates and an open container."""
    container = ContainerReading(
        box_px=(60.0, 30.0, 95.0, 80.0),
        score=0.9,
        mask=mask(60, 95),
        outer=Box3d(center_world_m=(0.95, 0.0, 0.04), size_m=(0.2, 0.15, 0.08), yaw_rad=0.0),
        inner_size_m=(0.19, 0.14),
        floor_z_m=0.005,
        rim_z_m=0.08,
        complete=True,
        lid=None,
    )
    return Observations(
        frame=FrameId(boot="e", counter=counter),
        backend="made-up",
        detections=(detection(counter, 0), detection(counter, 1)),
        container=container,
        cover="open",
        obstacles=(),
        obstacle_points_world_m=np.zeros((0, 3), np.float32),
        duration_s=0.2,
    )


def motion() -> Motion:
    """A second of turning the base."""
    times_s = np.linspace(0.0, 1.0, 11)
    q_rad = np.tile(np.array(frame(0).q_rad), (11, 1))
    q_rad[:, 0] = times_s
    return Motion(label="right", times_s=times_s, q_rad=q_rad, gripper_width_m=np.full(11, 0.1))


def happenings() -> list[tuple[int, Happening]]:
    """Two looks: first the view from the right, then the grasp."""
    feasible = GraspVerdict(track=1, feasible=True, refusal=None, why="", tried={})
    refused = GraspVerdict(track=2, feasible=False, refusal="access", why="no room", tried={})
    feasibility = Feasibility(grasps=(feasible, refused), informs=(), duration_s=0.1)
    look = (QValue(action="defer", value=0.7), QValue(action="right", value=0.1))
    take = (QValue(action="grasp", value=0.05, track=1, relation="outside"), *look)
    target = Target(noun="cylinder", color="red", shape="cylinder")
    told: list[tuple[int, Happening]] = [
        (0, Accepted(episode="made-up", target=target, understood="a red cylinder"))
    ]
    choices: tuple[Inform | Grasp, ...] = (Inform(name="right"), Grasp(track=1, relation="outside"))
    for step, (choice, q_values) in enumerate(zip(choices, (look, take), strict=True)):
        tracks = tuple(
            TrackSummary(id=i + 1, center_world_m=c, n_observations=step + 1, y0="MO")
            for i, c in enumerate(CENTERS)
        )
        told += [
            (step, Captured(frame=FrameId(boot="e", counter=step), view="center", q="center")),
            (
                step,
                Perceived(
                    frame=FrameId(boot="e", counter=step),
                    n_candidates=2,
                    container=True,
                    cover="open",
                    duration_s=0.2,
                ),
            ),
            (
                step,
                Believed(
                    q="center",
                    belief=BELIEFS[step],
                    gamma=GAMMAS[step],
                    tracks=tracks,
                    counted=("1 MO", "2 mismatch"),
                ),
            ),
            (
                step,
                Decided(
                    choice=choice,
                    q_values=q_values,
                    because="the red cylinder is the only one left",
                    feasibility=feasibility,
                    duration_s=0.01,
                ),
            ),
            (step, Acting(cmd_id=f"c{step}", verb=choice)),
            (
                step,
                Acted(
                    cmd_id=f"c{step}",
                    action="right" if step == 0 else "grasp",
                    status="done",
                    why="",
                    duration_s=4.0,
                ),
            ),
        ]
    told.append((1, ended()))
    return told


def ended() -> Ended:
    """Grasped and delivered."""
    return Ended(
        outcome="grasped",
        reason="verified",
        because="Track 1 is the only candidate left; the lift was verified.",
        track=1,
        relation="outside",
        delivered=True,
        actions=(
            ActionRecord(action="right", status="done", duration_s=4.0),
            ActionRecord(action="grasp", status="done", duration_s=4.0),
        ),
        steps=tuple(
            StepRecord(
                q="center", observations=("1 MO",), belief=BELIEFS[i], gamma=GAMMAS[i], q_values=()
            )
            for i in range(2)
        ),
        q_hat=0.9,
        durations={"executor": 1.0, "motion": 8.0},
    )


def events() -> tuple[Event, ...]:
    """The planner's events, numbered without gaps."""
    return tuple(
        Event(episode="made-up", seq=seq, step=step, happening=happening)
        for seq, (step, happening) in enumerate(happenings())
    )


def observed() -> Observed:
    """All of it, in order of arrival."""
    log: list[Seen] = []
    for event in events():
        if isinstance(event.happening, Perceived):
            counter = event.happening.frame.counter
            log.append(observations(counter))
        if isinstance(event.happening, Acted):
            log.append(motion())
        log.append(event)
    frames = {FrameId(boot="e", counter=n): frame(n) for n in range(2)}
    return Observed(tuple(log), frames)


def body(
    name: str, rgb: tuple[float, float, float], at: tuple[float, float], marked: bool = False
) -> Body:
    """A cylinder on the table."""
    stripe = Marking(kind="stripe", face="top", rgb=(0.9, 0.9, 0.9), coverage=0.4)
    return Body(
        name=name,
        shape="cylinder",
        size_m=(0.05, 0.05, 0.06),
        rgb=rgb,
        marking=stripe if marked else None,
        mass_kg=0.1,
        position_world_m=(*at, 0.0),
        yaw_rad=0.0,
    )


def scene() -> Scene:
    """The table of the episode: a red and a blue cylinder beside an open box."""
    return Scene(
        family="visible",
        seed=1,
        generator_version=1,
        bodies=(
            body("red cylinder", (0.76, 0.13, 0.11), (0.95, 0.1)),
            body("blue cylinder", (0.13, 0.37, 0.72), (0.95, -0.1)),
        ),
        container=Container(
            kind="open box",
            inner_size_m=(0.19, 0.14),
            wall_height_m=0.075,
            wall_thickness_m=0.005,
            floor_thickness_m=0.005,
            rgb=(0.5, 0.5, 0.5),
            position_world_m=(1.1, 0.25, 0.0),
            yaw_rad=0.3,
            covered=False,
            lid_rgb=(0.5, 0.5, 0.5),
        ),
        screens=(),
        lighting=Lighting(direction=(0.0, 0.0, 1.0), ambient=0.5, diffuse=0.5, specular=0.0),
        table_rgb=(0.7, 0.6, 0.5),
    )
