"""Bodies and their markings: closed meshes, true sizes, the promised share of a face."""

from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tabletop import body, box, scene

from surefetch.common.geometry import Array
from surefetch.common.messages import Body, Face, Marking, MarkingKind, Shape
from surefetch.executor.simulation import markings, scene_bodies
from surefetch.executor.simulation.scene_meshes import Mesh

SHAPES = get_args(Shape)
KINDS = [kind for kind in get_args(MarkingKind) if kind != "plain"]
FACES = get_args(Face)
COVERAGES = st.floats(0.3, 0.6)


def made(shape: Shape, kind: MarkingKind, face: Face, coverage: float) -> Body:
    x = 0.05
    size_m = {"block": (0.09, x, 0.04), "ball": (x, x, 0.048), "hexagonal prism": (x, 0.0577, 0.06)}
    marking = Marking(kind=kind, face=face, rgb=(1.0, 1.0, 1.0), coverage=coverage)
    return body("one", shape, size_m.get(shape, (x, x, 0.06)), marking=marking)


def areas(mesh: Mesh) -> Array:
    a, b, c = (mesh.vertices_m[mesh.triangles[:, k]] for k in range(3))
    found: Array = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0
    return found


def outward(mesh: Mesh) -> Array:
    """Per triangle, how much its normal looks away from the origin."""
    a, b, c = (mesh.vertices_m[mesh.triangles[:, k]] for k in range(3))
    found: Array = np.einsum("nk,nk->n", np.cross(b - a, c - a), (a + b + c) / 3.0)
    return found


@pytest.mark.parametrize("shape", SHAPES)
def test_a_mesh_is_closed_looks_outward_and_has_the_bodys_size(shape: Shape) -> None:
    one = made(shape, "dot", "top", 0.4)
    mesh = scene_bodies.mesh_of(one)
    edges = np.concatenate([mesh.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    assert {tuple(e) for e in edges.tolist()} == {tuple(e) for e in edges[:, ::-1].tolist()}
    assert (outward(mesh) > 0.0).all()
    assert np.ptp(mesh.vertices_m, axis=0) == pytest.approx(one.size_m, rel=5e-3)
    assert mesh.vertices_m[:, 2].min() == pytest.approx(-one.size_m[2] / 2.0, abs=1e-9)


@settings(deadline=None)
@given(st.sampled_from(SHAPES), st.sampled_from(KINDS), st.sampled_from(FACES), COVERAGES)
def test_a_marking_covers_its_share_of_its_face(
    shape: Shape, kind: MarkingKind, face: Face, coverage: float
) -> None:
    one = made(shape, kind, face, coverage)
    assert one.marking is not None
    outline = markings.unroll(one, one.marking).outline
    pieces = markings.cut_out(kind, outline, coverage)
    assert sum(markings.area(piece) for piece in pieces) == pytest.approx(
        coverage * markings.area(outline), rel=1e-3
    )


@settings(deadline=None)
@given(st.sampled_from(SHAPES), st.sampled_from(KINDS), st.sampled_from(FACES), COVERAGES)
def test_a_marking_lies_on_the_surface_of_its_face(
    shape: Shape, kind: MarkingKind, face: Face, coverage: float
) -> None:
    one = made(shape, kind, face, coverage)
    assert one.marking is not None
    patch = markings.patch(one, one.marking)
    assert patch is not None
    assert (outward(patch) > -1e-18).all(), "slivers of no area aside, all look outward"
    towards = {"front": (-1.0, 0.0, 0.0), "right": (0.0, -1.0, 0.0), "top": (0.0, 0.0, 1.0)}[face]
    assert np.average(patch.vertices_m, axis=0) @ towards > 0.4 * min(one.size_m) / 2.0
    flat = areas(patch).sum()
    unrolled = coverage * markings.area(markings.unroll(one, one.marking).outline)
    assert 0.75 * unrolled < flat < 1.20 * unrolled
    radius = np.abs(patch.vertices_m) - np.array(one.size_m) / 2.0
    assert radius.max() < 2.0 * markings.PROUD_M


def test_a_plain_body_has_one_look() -> None:
    assert len(scene_bodies.body(made("cube", "plain", "top", 0.4), 0).looks) == 1
    assert len(scene_bodies.body(made("cube", "dot", "top", 0.4), 0).looks) == 2


def test_things_come_in_one_order_and_the_lid_only_when_covered() -> None:
    names = [t.name for t in scene_bodies.things(scene(body("a"), container=box(covered=True)))]
    assert names == ["floor", "table", "container", "lid", "a"]
    names = [t.name for t in scene_bodies.things(scene(body("a"), container=box(covered=False)))]
    assert names == ["floor", "table", "container", "a"]
