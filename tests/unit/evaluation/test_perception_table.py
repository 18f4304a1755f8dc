"""Pictures for the perception table: reproducible, strange where wanted, scored by truth."""

from dataclasses import replace

import numpy as np
import pytest

from surefetch.common.cell import simulated_cell
from surefetch.common.errors import BadInput
from surefetch.evaluation.scenes.generate import GeneratedScene, generate
from surefetch.evaluation.seeing import command as perception_table
from surefetch.evaluation.seeing.conditions import unseen, unseen_camera
from surefetch.evaluation.seeing.images import Picture, cameras, pictures
from surefetch.evaluation.seeing.metrics import count, share
from surefetch.evaluation.seeing.scoring import scored
from surefetch.perception.backends import BACKENDS
from surefetch.perception.frame_geometry import LatestGeometry


@pytest.fixture(scope="module")
def made() -> GeneratedScene:
    return generate("covered", 7)


@pytest.fixture(scope="module")
def picture(made: GeneratedScene) -> Picture:
    first = cameras(simulated_cell(), made.scene)[:1]
    return next(pictures(made, simulated_cell(), made.scene, first))


def test_the_cover_is_off_and_the_target_is_seen(picture: Picture) -> None:
    assert picture.target_index is not None
    assert 0.1 < picture.target_share <= 1.0
    assert picture.things[picture.target_index].inside is True


def test_a_picture_is_found_and_answered_by_truth(picture: Picture) -> None:
    geometry = LatestGeometry()
    one = scored(picture, BACKENDS["classical"](geometry), geometry)
    counts = count([one])
    assert share(counts.target).value == 1.0
    assert min(counts.ious) > 0.8
    assert counts.container_uncut["hit"] == 1
    asked = {question for question, _, _ in one.answers}
    assert asked == {"color", "shape", "marking", "membership"}
    true_colors = [label for question, true, label in one.answers if question == "color" and true]
    assert true_colors == ["supported"] * len(one.objects)


def test_truth_changes_what_is_counted_and_nothing_that_is_found(picture: Picture) -> None:
    geometry = LatestGeometry()
    backend = BACKENDS["classical"](geometry)
    blind = replace(picture, segmentation=np.zeros_like(picture.segmentation))
    with_truth, without = scored(picture, backend, geometry), scored(blind, backend, geometry)
    assert [one.box for one in without.detections] == [one.box for one in with_truth.detections]
    assert len(without.objects) == 1


def test_unseen_conditions_are_outside_the_generators_and_the_same_each_time(
    made: GeneratedScene,
) -> None:
    strange = unseen(made.scene)
    assert strange == unseen(made.scene)
    x, y, z = strange.lighting.direction
    assert np.degrees(np.arctan2(z, np.hypot(x, y))) < 45.0
    assert strange.bodies == made.scene.bodies
    view = simulated_cell().views[0]
    camera, again = unseen_camera(made.scene, view), unseen_camera(made.scene, view)
    assert (camera.width, camera.height) != (made.scene.camera.width, made.scene.camera.height)
    assert np.array_equal(camera.K, again.K)
    assert camera.K[0, 2] != pytest.approx(camera.width / 2, abs=1.0)


@pytest.mark.parametrize("n", ["0", "101", "-3"])
def test_a_number_of_scenes_that_runs_into_other_seeds_is_refused(n: str) -> None:
    with pytest.raises(BadInput, match="--scenes"):
        perception_table.main(["--scenes", n])
