"""Laws of the one table of topics, and the README's copy of it."""

import re
from pathlib import Path
from typing import Any, get_args

import pytest

from surefetch.common.messages import Message
from surefetch.common.topics import (
    JOURNAL,
    SERVICES,
    STATUS,
    STOP,
    STREAMS,
    TOPICS,
    Role,
    Stream,
    Topic,
    Traffic,
)
from surefetch.common.topics_page import topics_markdown

ROOT = Path(__file__).parents[2]
ROLES = get_args(Role)
EVERY_TOPIC = pytest.mark.parametrize("topic", TOPICS, ids=[topic.name for topic in TOPICS])
EVERY_STREAM = pytest.mark.parametrize("stream", STREAMS, ids=[one.name for one in STREAMS])


def test_every_topic_and_stream_has_a_name_of_its_own() -> None:
    names = [topic.name for topic in TOPICS] + [stream.name for stream in STREAMS]
    assert len(names) == len(set(names))


@EVERY_TOPIC
def test_a_topic_is_answered_by_a_service_and_asked_by_others(topic: Topic[Any, Any]) -> None:
    assert topic.service in SERVICES
    assert topic.senders
    assert set(topic.senders) <= set(ROLES) - {topic.service}


@EVERY_STREAM
def test_a_stream_is_a_services_and_its_listeners_are_roles(stream: Stream[Any]) -> None:
    assert stream.service in SERVICES
    assert stream.listeners
    assert set(stream.listeners) <= set(ROLES) - {stream.service}


@EVERY_TOPIC
def test_a_verb_is_one_chunk_of_a_key(topic: Topic[Any, Any]) -> None:
    assert re.fullmatch("[a-z]+", topic.verb)


@EVERY_TOPIC
def test_a_topic_carries_messages_of_a_bounded_size(topic: Topic[Any, Any]) -> None:
    assert issubclass(topic.request, Message)
    assert issubclass(topic.reply, Message)
    assert 0 < topic.max_request_bytes <= 64 * 2**20
    assert 0 < topic.max_reply_bytes <= 64 * 2**20


@EVERY_TOPIC
def test_what_only_a_simulated_cell_answers_only_the_scorer_asks(topic: Topic[Any, Any]) -> None:
    assert topic.simulated_only == (topic.senders == ("scorer",))


def test_only_a_stop_travels_as_one() -> None:
    assert [topic for topic in TOPICS if topic.traffic is Traffic.STOP] == [STOP]


def test_every_service_tells_its_status_and_its_journal() -> None:
    assert set(STATUS) == set(JOURNAL) == set(SERVICES)


def test_the_readme_has_the_table_as_it_is() -> None:
    """Print it with ``python -m surefetch.common.topics_page``."""
    assert topics_markdown() in (ROOT / "README.md").read_text("utf-8")
