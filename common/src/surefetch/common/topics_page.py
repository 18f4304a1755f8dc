"""The table of topics for people: ``python -m surefetch.common.topics_page`` prints it."""

from collections.abc import Iterable
from typing import Any

from surefetch.common.topics import STREAMS, TOPICS, Stream, Topic

HEAD = ("topic", "question", "answer", "who may ask", "how it travels")


def topics_markdown() -> str:
    """All topics and streams as two Markdown tables; topics of every service stand once."""
    asked = [_topic_row(topic) for topic in TOPICS if topic.verb not in ("status", "journal")]
    shared = {topic.verb: topic for topic in TOPICS if topic.verb in ("status", "journal")}
    asked += [(f"*each*/{verb}", *_topic_row(topic)[1:]) for verb, topic in shared.items()]
    heard = [_stream_row(stream) for stream in STREAMS]
    return "\n".join(
        (*_table(HEAD, asked), "", *_table(("stream", "message", "who listens"), heard))
    )


def _topic_row(topic: Topic[Any, Any]) -> tuple[str, ...]:
    travels = topic.traffic.value + (", simulated cell only" if topic.simulated_only else "")
    return (
        topic.name,
        f"`{topic.request.__name__}`",
        f"`{topic.reply.__name__}`",
        ", ".join(topic.senders),
        travels,
    )


def _stream_row(stream: Stream[Any]) -> tuple[str, ...]:
    return (stream.name, f"`{stream.message.__name__}`", ", ".join(stream.listeners))


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> list[str]:
    lines = [head, tuple("---" for _ in head), *rows]
    return [f"| {' | '.join(cells)} |" for cells in lines]


if __name__ == "__main__":
    print(topics_markdown())
