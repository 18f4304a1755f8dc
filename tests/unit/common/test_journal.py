"""A journal gives back what was written, also when its writer was cut off."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.common import codec
from surefetch.common.errors import BadInput, CodecError
from surefetch.common.journal import JournalWriter, parse_journal, read_journal
from surefetch.common.messages import Cancel, Empty


def encoded(episode: str) -> bytes:
    return codec.encode(Cancel(episode=episode), max_bytes=1000)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "deep" / "planner.journal"


def written(path: Path, n: int) -> bytes:
    journal = JournalWriter(path, "planner", "boot")
    for i in range(n):
        journal.write("request", "planner/cancel", journal.new_call(), encoded(f"e{i}"))
    journal.close()
    return path.read_bytes()


def test_records_come_back_in_order_and_whole(path: Path) -> None:
    written(path, 5)
    journal = read_journal(path)
    assert (journal.header.service, journal.header.boot) == ("planner", "boot")
    assert [record.message(Cancel).episode for record in journal.records] == [
        f"e{i}" for i in range(5)
    ]
    assert [record.seq for record in journal.records] == [0, 1, 2, 3, 4]
    assert [record.call for record in journal.records] == [1, 2, 3, 4, 5]
    times_s = [record.time_s for record in journal.records]
    assert times_s == sorted(times_s)


def test_every_record_is_in_the_file_before_the_next_thing_happens(path: Path) -> None:
    journal = JournalWriter(path, "planner", "boot")
    for i in range(3):
        journal.write("event", "planner/event", 0, encoded(f"e{i}"))
        assert len(read_journal(path).records) == i + 1
    journal.close()


@settings(deadline=None)
@given(st.data())
def test_a_torn_end_is_told_and_costs_the_last_record_only(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    folder = tmp_path_factory.mktemp("torn")
    content, shorter = written(folder / "a", 3), len(written(folder / "b", 2))
    cut = data.draw(st.integers(shorter, len(content) - 1))
    journal = parse_journal(content[:cut], "torn")
    assert len(journal.records) == 2
    assert journal.torn_bytes == cut - shorter


def test_pages_make_up_the_whole_file(path: Path) -> None:
    content = written(path, 20)
    journal = JournalWriter(path.with_name("other"), "planner", "boot")
    journal.path.write_bytes(content)
    pages, offset, total = [], 0, 1
    while offset < total:
        page, total = journal.page(offset, 100)
        pages.append(page)
        offset += len(page)
    assert b"".join(pages) == content
    assert journal.page(total + 7, 100) == (b"", total)
    assert journal.page(-5, 10)[0] == content[:10]
    journal.close()


def test_a_journal_is_never_written_over(path: Path) -> None:
    written(path, 1)
    with pytest.raises(FileExistsError):
        JournalWriter(path, "planner", "boot")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "journal here is empty"),
        (b"\x00\x00", "journal here is empty"),
        (b"\x03\x00\x00\x00abc", "here is no journal, or a damaged one"),
        (b"\xff\xff\xff\xffabc", "journal here is empty"),
    ],
)
def test_what_is_no_journal_is_told(content: bytes, words: str) -> None:
    with pytest.raises(BadInput, match=words):
        parse_journal(content, "here")


def test_another_format_and_a_missing_file_are_told(path: Path) -> None:
    content = written(path, 1).replace(b"\xa6format\x01", b"\xa6format\x07")
    with pytest.raises(BadInput, match="format 7; this reads 1"):
        parse_journal(content, "here")
    with pytest.raises(BadInput, match="cannot be read: No such file"):
        read_journal(path.with_name("none"))


def test_a_record_asked_for_as_another_message_is_told(path: Path) -> None:
    written(path, 1)
    (record,) = read_journal(path).records
    with pytest.raises(CodecError, match="expected a message Empty, found 'Cancel'"):
        record.message(Empty)
