"""A target to the sentence that asks for it: twelve templates, and synonyms of the relation (pure).

`surefetch.common.instruction.parse` reads every one of them back to the same target.
"""

from itertools import product
from typing import Final

import numpy as np

from surefetch.common.messages import Target

OPENINGS: Final = (
    "bring me",
    "please bring me",
    "fetch",
    "get me",
    "could you hand me",
    "I need",
)
MARKING_AFTER: Final = (False, True)
TEMPLATES: Final = tuple(product(OPENINGS, MARKING_AFTER))
"""How a sentence begins, and whether the marking comes before the object or after it."""

BEFORE: Final = {"plain": "plain", "stripe": "striped", "dot": "dotted", "cross": "crossed"}
AFTER: Final = {
    "plain": "without any marking",
    "stripe": "with a stripe",
    "dot": "with a dot",
    "cross": "with a cross",
}
RELATIONS: Final = {
    "inside": ("inside", "in", "within"),
    "outside": ("outside", "out of", "outside of"),
}
NOUNS: Final = ("object", "thing")
"""For a target whose shape is not named."""
CONTAINER_WORDS: Final = {"tray": "tray", "open box": "box", "bin": "bin", "crate": "crate"}


def say(target: Target, template: int, synonym: int) -> str:
    """The sentence for a target by template 0 … 11 and synonym 0 … 2 of its relation."""
    opening, after = TEMPLATES[template]
    words = [opening, "the"]
    if target.marking is not None and not after:
        words.append(BEFORE[target.marking])
    if target.color is not None:
        words.append(target.color)
    words.append(target.noun)
    if target.marking is not None and after:
        words.append(AFTER[target.marking])
    if target.relation != "any":
        words += [RELATIONS[target.relation][synonym], "the", target.container]
    return " ".join(words)


def draw_sentence(target: Target, rng: np.random.Generator) -> str:
    """A sentence for a target. Draws the same from every split."""
    return say(target, int(rng.integers(len(TEMPLATES))), int(rng.integers(3)))
