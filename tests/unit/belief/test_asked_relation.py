"""The relation that a sentence asks for reaches the belief with every look."""

import pytest
from scripted_table import Table, scripted_cell, thing, thing_inside

from surefetch.common.messages import Update
from surefetch.common.topics import UPDATE


@pytest.mark.parametrize(
    ("sentence", "asked"),
    [
        ("the red object inside the box", "inside"),
        ("the red object outside the box", "outside"),
        ("the red object", "any"),
    ],
)
def test_every_look_says_what_was_asked(sentence: str, asked: str) -> None:
    with scripted_cell(Table((thing(0.8, 0.2), thing_inside()))) as cell:
        cell.fetch(sentence)
        records = cell.journal("belief").records
    told = [
        record.message(Update)
        for record in records
        if record.topic == UPDATE.name and record.kind == "request"
    ]
    assert told
    assert {update.asked for update in told} == {asked}
