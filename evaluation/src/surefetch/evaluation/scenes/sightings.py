"""Sightings of a scene's bodies: by rays before anything is simulated, or by segmentation."""

from collections.abc import Callable, Iterator
from functools import cache

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array
from surefetch.common.messages import Scene
from surefetch.evaluation.recordings.recording import Cover
from surefetch.evaluation.scenes.ground import Views
from surefetch.evaluation.scenes.plan import Plan
from surefetch.evaluation.scenes.rejection_sight import VIEWS, Look, first_cover, open_cover
from surefetch.evaluation.scenes.sightlines import Sightlines
from surefetch.evaluation.scenes.truth import Sighting
from surefetch.executor.simulation import scene_bodies
from surefetch.executor.simulation.pybullet_world import PybulletWorld

SHRINK = 2
"""Segmentation renders are this much smaller than the camera's image."""

Segment = Callable[[str, frozenset[str]], NDArray[np.int16]]
"""The segmentation of a view with these things moved away."""


def by_rays(scene: Scene, views: Views) -> Look:
    """Estimates from the drawn positions, good to a few hundredths."""
    closed = Sightlines.of(scene, views, lid=True)
    opened = Sightlines.of(scene, views, lid=False)

    @cache
    def look(k: int, view: str, cover: Cover) -> Sighting:
        lines = closed if cover == "closed" else opened
        name = scene.bodies[k].name
        seen, patch = lines.of_body(name, view), lines.of_patch(name, view)
        return Sighting(
            body=name,
            view=view,
            cover=cover,
            share=seen.share,
            pixels=seen.pixels,
            patch_px=patch.pixels,
            patch_share=patch.share,
            over_container=lines.over_container(name, view),
        )

    return look


def by_renders(world: PybulletWorld, views: Views, estimate: Look) -> Look:
    """Counted in the world as it stands, without errors of pose; the patch as estimated."""
    segment = _segments(world, views)
    names = [thing.name for thing in world.things]

    @cache
    def look(k: int, view: str, cover: Cover) -> Sighting:
        guess = estimate(k, view, cover)
        away = frozenset({scene_bodies.LID}) if cover == "open" else frozenset()
        shown = int((segment(view, away) == k).sum())
        alone = int((segment(view, frozenset(names) - {guess.body}) == k).sum())
        return Sighting(
            body=guess.body,
            view=view,
            cover=cover,
            share=shown / alone if alone else 0.0,
            pixels=float(shown * SHRINK**2),
            patch_px=guess.patch_px,
            patch_share=guess.patch_share,
            over_container=guess.over_container,
        )

    return look


def _segments(world: PybulletWorld, views: Views) -> Segment:
    width, height = views.width // SHRINK, views.height // SHRINK
    K = _shrunk(views.K)

    @cache
    def segment(view: str, hidden: frozenset[str]) -> NDArray[np.int16]:
        T = views.T_world_camera[view]
        return world.surfaces(T, K, width, height, hidden).segmentation

    return segment


def _shrunk(K: Array) -> Array:
    """Intrinsics of the smaller image; pixel centres are whole numbers."""
    small = K / SHRINK
    small[:2, 2] = (K[:2, 2] + 0.5) / SHRINK - 0.5
    small[2, 2] = 1.0
    return small


def all_of(plan: Plan, look: Look) -> Iterator[Sighting]:
    """Target, twins and near-misses in every view, with the lid on and off where there is one."""
    for k, part in enumerate(plan.parts):
        if part.role in ("target", "twin", "near miss"):
            for cover in dict.fromkeys((first_cover(plan), open_cover(plan))):
                for view in VIEWS:
                    yield look(k, view, cover)
