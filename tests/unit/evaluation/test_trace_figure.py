"""The trace groups beliefs as in the paper, and can always be drawn."""

from pathlib import Path

import made_up_episode
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from surefetch.evaluation.showing import trace_figure
from surefetch.evaluation.showing.observed import Observed, steps


def test_the_groups_hold_all_of_the_belief() -> None:
    for belief in made_up_episode.BELIEFS:
        assert sum(trace_figure.grouped(belief, 1)) == pytest.approx(1.0)


def test_the_not_yet_seen_target_is_among_the_other_hypotheses() -> None:
    belief = {"1:inside": 0.2, "1:outside": 0.1, "unobs": 0.4, "abs": 0.3}
    assert trace_figure.grouped(belief, 1) == pytest.approx((0.2, 0.1, 0.4, 0.3))
    assert trace_figure.grouped(belief, None) == pytest.approx((0.0, 0.0, 0.7, 0.3))


def test_the_grasped_track_is_followed() -> None:
    assert trace_figure.followed_track(made_up_episode.observed()) == 1


def test_every_look_of_the_episode_is_a_column(tmp_path: Path) -> None:
    observed = made_up_episode.observed()
    trace_figure.draw(observed, tmp_path / "trace.png")
    assert len(list(steps(observed.events))) == 2
    with Image.open(tmp_path / "trace.png") as picture:
        assert picture.size[0] > 800


@pytest.mark.parametrize("n_events", [0, 1, 2, 4])
def test_an_episode_cut_short_still_has_a_trace(n_events: int, tmp_path: Path) -> None:
    whole = made_up_episode.observed()
    trace_figure.draw(Observed(whole.log[:n_events], {}), tmp_path / "trace.png")
    with Image.open(tmp_path / "trace.png") as picture:
        assert picture.size[0] > 0


@given(
    st.lists(
        st.tuples(
            st.floats(0.0, 640.0), st.floats(0.0, 480.0), st.sampled_from(["T1 MO", "T12 ≠"])
        ),
        max_size=12,
    )
)
@settings(deadline=None)
def test_no_tag_covers_another_and_none_sinks(places: list[tuple[float, float, str]]) -> None:
    tags = [trace_figure.Tag(x, y, text, (0, 0, 0)) for x, y, text in places]
    placed = trace_figure.apart(tags, 1.0)
    assert sorted(tag.x_px for tag in placed) == sorted(tag.x_px for tag in tags)
    for i, a in enumerate(placed):
        for b in placed[:i]:
            letters = (len(a.text) + len(b.text) + 1) / 2
            assert (
                abs(a.x_px - b.x_px) >= letters * trace_figure.TAG_LETTER_PX
                or abs(a.y_px - b.y_px) >= trace_figure.TAG_HEIGHT_PX
            )
