"""Things as PyBullet bodies: contact shapes, mass, friction."""

from scipy.spatial.transform import Rotation

from surefetch.common.geometry import Array
from surefetch.executor.simulation.quiet_pybullet import pybullet
from surefetch.executor.simulation.scene_bodies import BoxSolid, CylinderSolid, HullSolid, Thing

SPINNING_FRICTION = 0.005


def quaternion_of(T: Array) -> tuple[float, float, float, float]:
    """Quaternion xyzw of a rigid (4, 4) transform."""
    x, y, z, w = (float(v) for v in Rotation.from_matrix(T[:3, :3]).as_quat())
    return x, y, z, w


def add_thing(client: int, thing: Thing, friction: float) -> int:
    """The new body's id; mass 0 is fixed."""
    uid: int = pybullet.createMultiBody(
        baseMass=thing.mass_kg,
        baseCollisionShapeIndex=_shape(client, thing),
        basePosition=thing.T_world_thing[:3, 3].tolist(),
        baseOrientation=quaternion_of(thing.T_world_thing),
        physicsClientId=client,
    )
    pybullet.changeDynamics(
        uid,
        -1,
        lateralFriction=friction,
        spinningFriction=SPINNING_FRICTION,
        rollingFriction=thing.rolling_friction,
        physicsClientId=client,
    )
    return uid


def _shape(client: int, thing: Thing) -> int:
    if len(thing.solids) > 1:
        return _compound(client, thing)
    shape: int
    match thing.solids[0]:
        case HullSolid(vertices_m=vertices):
            shape = pybullet.createCollisionShape(
                pybullet.GEOM_MESH, vertices=vertices.tolist(), physicsClientId=client
            )
        case CylinderSolid() as solid:
            shape = pybullet.createCollisionShape(
                pybullet.GEOM_CYLINDER,
                radius=solid.radius_m,
                height=solid.height_m,
                collisionFramePosition=solid.center_m,
                physicsClientId=client,
            )
        case BoxSolid() as solid:
            shape = pybullet.createCollisionShape(
                pybullet.GEOM_BOX,
                halfExtents=[v / 2.0 for v in solid.size_m],
                collisionFramePosition=solid.center_m,
                physicsClientId=client,
            )
    return shape


def _compound(client: int, thing: Thing) -> int:
    """Boxes and cylinders as one shape."""
    parts = [s for s in thing.solids if not isinstance(s, HullSolid)]
    boxes = [isinstance(part, BoxSolid) for part in parts]
    shape: int = pybullet.createCollisionShapeArray(
        shapeTypes=[pybullet.GEOM_BOX if box else pybullet.GEOM_CYLINDER for box in boxes],
        halfExtents=[
            [v / 2.0 for v in p.size_m] if isinstance(p, BoxSolid) else [0.0, 0.0, 0.0]
            for p in parts
        ],
        radii=[p.radius_m if isinstance(p, CylinderSolid) else 0.0 for p in parts],
        lengths=[p.height_m if isinstance(p, CylinderSolid) else 0.0 for p in parts],
        collisionFramePositions=[p.center_m for p in parts],
        physicsClientId=client,
    )
    return shape
