import pytest
from hypothesis import given
from hypothesis import strategies as st

from surefetch.common.errors import BadInput
from surefetch.common.instruction import UnknownWord, describe, parse
from surefetch.common.messages import Target, Vocabulary

VOCABULARY = Vocabulary(
    backend="classical",
    open=False,
    nouns=("object", "thing", "item"),
    colors=("red", "orange", "blue", "white"),
    shapes=("cube", "block", "cylinder", "ball", "hexagonal prism"),
    markings=("plain", "stripe", "dot", "cross"),
    containers=("box", "tray", "open box"),
)


def maybe(values: tuple[str, ...]) -> st.SearchStrategy[str | None]:
    return st.none() | st.sampled_from(values)


@st.composite
def targets(draw: st.DrawFn) -> Target:
    shape = draw(maybe(VOCABULARY.shapes))
    return Target(
        noun=shape or draw(st.sampled_from(VOCABULARY.nouns)),
        color=draw(maybe(VOCABULARY.colors)),
        shape=shape,
        marking=draw(maybe(VOCABULARY.markings)),
        relation=draw(st.sampled_from(("inside", "outside"))),
        container=draw(st.sampled_from(VOCABULARY.containers)),
    )


@given(targets())
def test_what_is_described_is_understood_again(target: Target) -> None:
    assert parse(f"bring me {describe(target)}", VOCABULARY) == target


@given(st.text(max_size=600))
def test_any_text_is_a_target_or_bad_input(text: str) -> None:
    try:
        target = parse(text, VOCABULARY)
    except BadInput:
        return
    assert target.color in (None, *VOCABULARY.colors)


def test_words_of_the_container_do_not_describe_the_object() -> None:
    target = parse("the red cube inside the white open box", VOCABULARY)
    assert (target.color, target.relation, target.container) == ("red", "inside", "open box")


def test_an_adjective_may_name_the_marking() -> None:
    assert parse("a striped red ball", VOCABULARY).marking == "stripe"
    assert parse("a ball without any marking", VOCABULARY).marking == "plain"


@pytest.mark.parametrize(
    ("sentence", "says"),
    [
        ("", "is empty"),
        ("  ...  ", "is empty"),
        ("red cube blue", "two values"),
        ("the cube inside the box outside the box", "two values"),
        ("the cube inside", "not to what"),
        ("the cube that is not red", "denials"),
        ("fetch the tray", "the container"),
        ("please bring me", "names no object"),
        ("red cube " * 200, "at most 500"),
        ("red\x00cube", "control characters"),
    ],
)
def test_an_unusable_sentence_is_refused_with_its_reason(sentence: str, says: str) -> None:
    with pytest.raises(BadInput, match=says):
        parse(sentence, VOCABULARY)


@pytest.mark.parametrize("word", ["cup", "move", "ignore"])
def test_an_unknown_word_is_refused_with_the_words_there_are(word: str) -> None:
    with pytest.raises(UnknownWord, match="hexagonal prism"):
        parse(f"the red {word}", VOCABULARY)
