"""A sentence to a Target by a small grammar, and a Target to words again. Pure.

Every word must mean something: a word that the perception at hand cannot tell is an error, so that
nothing is fetched on a misunderstanding. Words after a relation ("inside the white box") belong to
the container.
"""

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Final

from surefetch.common.errors import BadInput
from surefetch.common.messages import Target, Vocabulary

MAX_CHARACTERS: Final = 500

Phrase = tuple[str, ...]

_FILLERS: Final = frozenset(
    "a an the one please can could would you me for us i want need like to and that which who "
    "is are it some this now kindly robot go just my from its of has having stands standing lying "
    "sits sitting located placed".split()
)
_COMMANDS: Final = frozenset("bring fetch get give grab grasp hand pick up take pass find".split())
_CONTAINER_COLORS: Final = frozenset({"brown", "grey", "gray"})
_NEGATIONS: Final = frozenset({"not", "no", "without", "never", "except", "neither", "nor"})

_RELATIONS: Final[dict[Phrase, str]] = {
    ("inside",): "inside",
    ("inside", "of"): "inside",
    ("in",): "inside",
    ("within",): "inside",
    ("outside",): "outside",
    ("outside", "of"): "outside",
    ("out", "of"): "outside",
}
_SYNONYMS: Final[dict[Phrase, tuple[str, str]]] = {
    ("sphere",): ("shape", "ball"),
    ("hex", "prism"): ("shape", "hexagonal prism"),
    ("hexagon", "prism"): ("shape", "hexagonal prism"),
    ("cuboid",): ("shape", "block"),
    ("brick",): ("shape", "block"),
    ("tube",): ("shape", "cylinder"),
    ("violet",): ("color", "purple"),
    ("striped",): ("marking", "stripe"),
    ("stripes",): ("marking", "stripe"),
    ("dotted",): ("marking", "dot"),
    ("spotted",): ("marking", "dot"),
    ("spot",): ("marking", "dot"),
    ("crossed",): ("marking", "cross"),
    ("unmarked",): ("marking", "plain"),
    ("plain",): ("marking", "plain"),
    ("with", "no", "marking"): ("marking", "plain"),
    ("without", "marking"): ("marking", "plain"),
    ("without", "a", "marking"): ("marking", "plain"),
    ("without", "any", "marking"): ("marking", "plain"),
}


class UnknownWord(BadInput):
    """A word that the perception at hand cannot tell."""

    def __init__(self, word: str, vocabulary: Vocabulary) -> None:
        super().__init__(
            f'"{word}" is nothing that this perception ({vocabulary.backend}) can tell.\n'
            f"  Colours:    {', '.join(vocabulary.colors)}\n"
            f"  Shapes:     {', '.join(vocabulary.shapes)}\n"
            f"  Markings:   {', '.join(vocabulary.markings)}\n"
            f"  Relations:  inside, outside\n"
            f"  Containers: {', '.join(vocabulary.containers)}\n"
            "  Nothing was moved."
        )


@dataclass(frozen=True)
class Meaning:
    """One understood phrase: which slot it fills, with what, and the words that said so."""

    slot: str
    value: str
    words: str


def parse(sentence: str, vocabulary: Vocabulary) -> Target:
    """The target that a sentence names.

    Raises:
        BadInput: the sentence is empty, too long, names nothing, contradicts itself, or denies
            something ("not red").
        UnknownWord: a word is nothing that this perception can tell.
    """
    words = _words(sentence)
    slots: dict[str, str] = {}
    for meaning in _meanings(words, vocabulary):
        previous = slots.setdefault(meaning.slot, meaning.value)
        if previous != meaning.value:
            raise BadInput(
                f'the sentence names two values for one thing: {meaning.slot} "{previous}" and '
                f'"{meaning.value}".\n  Name one of them. Nothing was moved.'
            )
    return _target(slots, sentence)


def describe(target: Target) -> str:
    """What was understood, in words: "a red cylinder with a stripe, inside the box"."""
    plain = ["plain"] if target.marking == "plain" else []
    named = [*plain, *([target.color] if target.color else []), target.noun]
    marked = f" with a {target.marking}" if target.marking not in (None, "plain") else ""
    place = "" if target.relation == "any" else f", {target.relation} the {target.container}"
    article = "an" if named[0][0] in "aeiou" else "a"
    return f"{article} {' '.join(named)}{marked}{place}"


def _words(sentence: str) -> list[str]:
    if len(sentence) > MAX_CHARACTERS:
        raise BadInput(
            f"the instruction has {len(sentence)} characters; at most {MAX_CHARACTERS} are read.\n"
            "  Nothing was moved."
        )
    if any(ord(character) < 32 and character not in "\t\n\r" for character in sentence):
        raise BadInput("the instruction holds control characters. Nothing was moved.")
    words = re.findall(r"[^\W_]+(?:'[^\W_]+)?", sentence.lower())
    if not words:
        raise BadInput(
            'the instruction is empty. Say what to fetch, for example "the red cylinder inside '
            'the box". Nothing was moved.'
        )
    return words


def _meanings(words: list[str], vocabulary: Vocabulary) -> Iterator[Meaning]:
    """Longest known phrase first, from left to right."""
    lexicon = _lexicon(vocabulary)
    longest = max(len(phrase) for phrase in lexicon)
    containers = _phrases(vocabulary.containers)
    at, in_container = 0, False
    while at < len(words):
        phrase = next(
            (
                tuple(words[at : at + n])
                for n in range(longest, 0, -1)
                if tuple(words[at : at + n]) in lexicon
            ),
            (words[at],),
        )
        said = " ".join(phrase)
        if in_container and phrase in containers:
            yield Meaning("container", said, said)
            in_container = False
        elif in_container and (said in vocabulary.colors or said in _CONTAINER_COLORS):
            pass  # there is one reference container; its colour tells nothing more
        elif phrase in _RELATIONS:
            yield Meaning("relation", _RELATIONS[phrase], said)
            in_container = True
        elif phrase in lexicon:
            slot, value = lexicon[phrase]
            if slot != "filler":
                yield Meaning(slot, value, said)
        else:
            yield _unknown(said, vocabulary, in_container)
        at += len(phrase)
    if in_container:
        raise BadInput(
            "the sentence names a relation but not to what.\n"
            f"  Containers: {', '.join(vocabulary.containers)}\n  Nothing was moved."
        )


def _unknown(word: str, vocabulary: Vocabulary, in_container: bool) -> Meaning:
    if word in _NEGATIONS:
        raise BadInput(
            f'"{word}": denials are not understood. Say what the object is, not what it is not.\n'
            "  Nothing was moved."
        )
    if not vocabulary.open or in_container:
        raise UnknownWord(word, vocabulary)
    return Meaning("noun", word, word)


def _lexicon(vocabulary: Vocabulary) -> dict[Phrase, tuple[str, str]]:
    lexicon: dict[Phrase, tuple[str, str]] = {(word,): ("filler", word) for word in _FILLERS}
    lexicon |= {(word,): ("filler", word) for word in (*_COMMANDS, "with")}
    lexicon |= {phrase: ("relation", value) for phrase, value in _RELATIONS.items()}
    known = {
        "color": vocabulary.colors,
        "shape": vocabulary.shapes,
        "marking": vocabulary.markings,
    }
    lexicon |= {p: (slot, value) for p, (slot, value) in _SYNONYMS.items() if value in known[slot]}
    for slot, values in (*known.items(), ("noun", vocabulary.nouns)):
        lexicon |= {phrase: (slot, " ".join(phrase)) for phrase in _phrases(values)}
    lexicon |= {
        phrase: ("fetched_container", " ".join(phrase))
        for phrase in _phrases(vocabulary.containers)
    }
    return lexicon


def _phrases(values: Collection[str]) -> set[Phrase]:
    return {tuple(value.split()) for value in values}


def _target(slots: dict[str, str], sentence: str) -> Target:
    if "fetched_container" in slots:
        raise BadInput(
            f'the sentence asks for the container ("{slots["fetched_container"]}") itself; only '
            "objects in or beside it can be fetched.\n  Nothing was moved."
        )
    shape, noun = slots.get("shape"), slots.get("noun")
    if not ({"color", "shape", "marking", "noun"} & slots.keys()):
        raise BadInput(
            f'"{sentence.strip()}" names no object.\n'
            '  Say for example "the red cylinder with a stripe inside the box". Nothing was moved.'
        )
    return Target(
        noun=shape or noun or "object",
        color=slots.get("color"),
        shape=shape,
        marking=slots.get("marking"),
        relation=slots.get("relation", "any"),  # type: ignore[arg-type]
        container=slots.get("container", "box"),
    )
