"""The outcome of a check as JUnit XML, which build servers read: a suite per case, a test per expectation."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from fretsolve.system.files import writing

if TYPE_CHECKING:
    from fretsolve.commands.check import Comparison, Outcome


def write_junit(path: Path, outcomes: Sequence[Outcome]) -> None:
    """Write the file `path`. Raises FileError where that is impossible."""
    suites = ElementTree.Element("testsuites", name="fretsolve check")
    for outcome in outcomes:
        suites.append(_suite(outcome))
    ElementTree.indent(suites)
    text = ElementTree.tostring(suites, encoding="unicode", xml_declaration=True)
    with writing(path):
        path.write_text(text + "\n", encoding="utf-8")


def _suite(outcome: Outcome) -> ElementTree.Element:
    name = _printable(str(outcome.case))
    tests = [_test(name, comparison, outcome) for comparison in outcome.comparisons]
    if not tests:
        tests = [ElementTree.Element("testcase", classname=name, name="case")]
        _note(tests[0], "error", str(outcome.error), type(outcome.error).__name__)
    counts = {
        "tests": len(tests),
        "failures": sum(test.find("failure") is not None for test in tests),
        "errors": sum(test.find("error") is not None for test in tests),
    }
    suite = ElementTree.Element("testsuite", name=name, time=f"{outcome.seconds:.3f}")
    suite.attrib |= {key: str(count) for key, count in counts.items()}
    suite.extend(tests)
    return suite


def _test(case: str, comparison: Comparison, outcome: Outcome) -> ElementTree.Element:
    name = f"{comparison.expected.quantity} at stage {comparison.stage}"
    test = ElementTree.Element("testcase", classname=case, name=name)
    _, _, expected, found, deviation, allowed, _ = comparison.cells()
    if comparison.found is None:
        _note(test, "error", str(outcome.error), type(outcome.error).__name__)
    elif not comparison.ok:
        _note(
            test,
            "failure",
            f"{expected} expected, {found} found: {deviation} off, {allowed} allowed",
            "deviation",
        )
    return test


def _note(test: ElementTree.Element, tag: str, message: str, kind: str) -> None:
    ElementTree.SubElement(test, tag, message=_printable(message), type=kind)


def _printable(text: str) -> str:
    """Without the control characters that XML cannot hold."""
    return "".join(character if character.isprintable() or character == "\n" else "?" for character in text)
