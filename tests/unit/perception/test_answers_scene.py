"""On rendered tables the answers are right where they can be, and withheld where they can't."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import msgspec
import pytest
from rendered import Shot, perceive, shoot
from tabletop import BLUE, RED, WHITE, body, scene

from surefetch.common.mask import iou
from surefetch.common.messages import Answers, Body, Marking, Scene, Screen, Shape, Target
from surefetch.perception.answers.color import COLORS
from surefetch.perception.answers.marking import MARKINGS
from surefetch.perception.answers.scorer import ClassicalScorer
from surefetch.perception.answers.shape import SOLIDS
from surefetch.perception.candidate import SceneView
from surefetch.perception.classical import VOCABULARY

BLACK, DARK, LIGHT = (0.10, 0.10, 0.12), (0.07, 0.07, 0.08), (0.93, 0.93, 0.91)
ORANGE, PURPLE = (0.92, 0.45, 0.09), (0.40, 0.22, 0.58)
SIZES: Mapping[Shape, tuple[float, float, float]] = {
    "cube": (0.05, 0.05, 0.05),
    "block": (0.04, 0.07, 0.04),
    "cylinder": (0.05, 0.05, 0.06),
    "ball": (0.055, 0.055, 0.053),
    "hexagonal prism": (0.05, 0.0577, 0.06),
}
PLACES = ((0.85, 0.16), (0.85, 0.0), (0.85, -0.16), (1.0, 0.1), (1.0, -0.1))


def marked(one: Body, kind: str, face: str, rgb: tuple[float, float, float] = LIGHT) -> Body:
    marking = msgspec.convert({"kind": kind, "face": face, "rgb": rgb, "coverage": 0.45}, Marking)
    return msgspec.structs.replace(one, marking=marking)


def painted(one: Body, rgb: tuple[float, float, float]) -> Body:
    return msgspec.structs.replace(one, rgb=rgb)


@dataclass(frozen=True, eq=False)
class Seen:
    """A table perceived once."""

    scene: SceneView
    shot: Shot

    def answers(self, index: int, target: Target) -> Answers:
        """About the body that has this index in the scene."""
        overlaps = [iou(one.bits, self.shot.pixels_of(index)) for one in self.scene.candidates]
        best = max(range(len(overlaps)), key=overlaps.__getitem__)
        assert overlaps[best] > 0.7
        return ClassicalScorer().score(self.scene, [self.scene.candidates[best]], target)[0]

    def label(self, index: int, question: str, value: str) -> str:
        """Of the answer to one question."""
        target = Target(noun="object", **{question: value})  # type: ignore[arg-type]
        label: str = getattr(self.answers(index, target), question).label
        return label

    def supported(self, index: int, question: str, values: Sequence[str]) -> list[str]:
        """The values that are supported; none may be left open."""
        labels = {value: self.label(index, question, value) for value in values}
        assert "unobservable" not in labels.values()
        return [value for value, label in labels.items() if label == "supported"]


def see(table: Scene, view: str = "center") -> Seen:
    """Take a picture of a table and perceive it."""
    shot = shoot(table, view)
    return Seen(perceive(shot.frame).scene, shot)


def test_every_word_of_the_vocabulary_has_an_answer() -> None:
    assert set(VOCABULARY.colors) == set(COLORS)
    assert set(VOCABULARY.shapes) == set(SOLIDS)
    assert set(VOCABULARY.markings) == set(MARKINGS)


def test_every_shape_is_told_from_all_others() -> None:
    bodies = [
        body(shape, shape, size, at)
        for (shape, size), at in zip(SIZES.items(), PLACES, strict=True)
    ]
    seen = see(scene(*bodies))
    for k, shape in enumerate(SIZES):
        assert seen.supported(k, "shape", VOCABULARY.shapes) == [shape]


def test_hard_colours_black_and_white_are_told_apart() -> None:
    named = {"red": RED, "orange": ORANGE, "blue": BLUE, "purple": PURPLE, "white": WHITE}
    bodies = [
        painted(body(name, at_m=at), rgb)
        for (name, rgb), at in zip(named.items(), PLACES, strict=True)
    ]
    bodies.append(painted(body("black", "ball", SIZES["ball"], (1.05, 0.22)), BLACK))
    seen = see(scene(*bodies))
    for k, name in enumerate([*named, "black"]):
        assert seen.supported(k, "color", VOCABULARY.colors) == [name]


@pytest.mark.parametrize("face", ["front", "top"])
def test_every_marking_is_told_on_every_shape_that_shows_it(face: str) -> None:
    kinds = ("stripe", "dot", "cross", "stripe", "cross")
    bodies = [
        marked(body(shape, shape, size, at), kind, face)
        for (shape, size), at, kind in zip(SIZES.items(), PLACES, kinds, strict=True)
    ]
    seen = see(scene(*bodies))
    for k, kind in enumerate(kinds):
        assert seen.supported(k, "marking", VOCABULARY.markings) == [kind]


def test_a_marking_that_is_turned_away_is_neither_seen_nor_denied() -> None:
    table = scene(marked(body("cube"), "dot", "right"), body("plain", at_m=(0.9, 0.15)))
    first, right = see(table), see(table, "right")
    for value in VOCABULARY.markings:
        assert first.label(0, "marking", value) == "unobservable"
    assert right.supported(0, "marking", VOCABULARY.markings) == ["dot"]
    assert right.supported(1, "marking", VOCABULARY.markings) == ["plain"]


def test_a_large_marking_is_not_taken_for_the_colour_of_the_body() -> None:
    white = marked(painted(body("white"), WHITE), "dot", "top", DARK)
    black = marked(painted(body("black", at_m=(0.9, 0.15)), BLACK), "stripe", "top", LIGHT)
    red = marked(body("red", at_m=(0.9, -0.15)), "cross", "top", LIGHT)
    seen = see(scene(white, black, red), "close_high")
    for k, name in enumerate(("white", "black", "red")):
        assert seen.supported(k, "color", VOCABULARY.colors) == [name]


def test_how_long_a_half_hidden_box_is_stays_open() -> None:
    wall = Screen(size_m=(0.012, 0.12, 0.16), position_world_m=(0.84, 0.062, 0.0), yaw_rad=0.0)
    table = msgspec.structs.replace(scene(body("cube", at_m=(0.92, 0.0))), screens=(wall,))
    seen = see(table)
    assert seen.label(0, "shape", "cube") == "unobservable"
    assert seen.label(0, "shape", "block") == "unobservable"
    assert seen.label(0, "shape", "ball") == "contradicted"
