"""The parts that a POMDPX document is put together from. Pure.

Source: PomdpX File Format (Version 1.0), National University of Singapore.
"""

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Sequence

Entry = tuple[tuple[str, ...], Sequence[float]]
"""Values of the parents and of the variable, ``-`` for all in turn and ``*`` for any; numbers.

No two entries of a table speak of the same case: readers differ in which one counts."""

WITHOUT_PARENTS = ("null",)


def empty_document(description: str, discount: float) -> ET.Element:
    """A document with nothing in it yet."""
    root = ET.Element(
        "pomdpx",
        {
            "version": "1.0",
            "id": "surefetch",
            "xmlns:xsi": "http://www.w3.org/2001/XMLSchema-instance",
            "xsi:noNamespaceSchemaLocation": "pomdpx.xsd",
        },
    )
    add_text(root, "Description", description)
    add_text(root, "Discount", repr(discount))
    return root


def written(root: ET.Element) -> bytes:
    """The document as UTF-8, indented."""
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def add_state(at: ET.Element, name: str, values: Iterable[str], *, observed: bool) -> None:
    """A state variable: ``NAME_0`` before an action, ``NAME_1`` after it."""
    names = {"vnamePrev": f"{name}_0", "vnameCurr": f"{name}_1"}
    variable = ET.SubElement(at, "StateVar", {**names, "fullyObs": str(observed).lower()})
    add_text(variable, "ValueEnum", " ".join(values))


def add_named(at: ET.Element, tag: str, name: str, values: Iterable[str]) -> None:
    """An action or observation variable."""
    add_text(ET.SubElement(at, tag, vname=name), "ValueEnum", " ".join(values))


def add_chances(
    at: ET.Element, variable: str, parents: Iterable[str], entries: Iterable[Entry]
) -> None:
    """A conditional distribution."""
    _add_table(ET.SubElement(at, "CondProb"), variable, parents, entries, "ProbTable")


def add_rewards(
    at: ET.Element, variable: str, parents: Iterable[str], entries: Iterable[Entry]
) -> None:
    """A table of rewards; entries have values of the parents alone."""
    _add_table(ET.SubElement(at, "Func"), variable, parents, entries, "ValueTable")


def add_text(at: ET.Element, tag: str, text: str) -> None:
    """An element that holds text."""
    ET.SubElement(at, tag).text = text


def _add_table(
    at: ET.Element, variable: str, parents: Iterable[str], entries: Iterable[Entry], numbers: str
) -> None:
    add_text(at, "Var", variable)
    add_text(at, "Parent", " ".join(parents))
    table = ET.SubElement(at, "Parameter", type="TBL")
    for instance, row in entries:
        entry = ET.SubElement(table, "Entry")
        add_text(entry, "Instance", " ".join(instance))
        add_text(entry, numbers, " ".join(repr(float(x)) for x in row))
