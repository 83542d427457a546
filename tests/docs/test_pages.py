"""The documents tell the truth: their commands, cases, code and links are tried."""

from __future__ import annotations

import importlib
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest
import yaml
from command_line import invoke
from pages import DOCS, ROOT, Block, agree, blocks, links, pages, pictures
from PIL import Image

from fretsolve import load_case
from fretsolve.case.models import Case
from fretsolve.case.schema import area_schema, line_schema
from fretsolve.case.source import parse
from fretsolve.result.layout import BULK_HISTORY, DERIVED_FIELDS, ERRORS, FIELDS, HISTORY, SPOT_HISTORY, WEAR_HISTORY

CASE = {
    "bodies": [{"young_modulus": 2e5, "poisson_ratio": 0.3}, "rigid"],
    "surface": {"sphere": {"radius": 10.0}},
    "grid": {"points": 16},
    "load_path": [{"P": 1.0}],
}
LINE_CASE = {**CASE, "surface": {"cylinder": {"radius": 10.0}}}
"""They stand for the parts of a case that a page leaves out."""


@pytest.mark.parametrize(
    ("shown", "printed", "same"),
    [
        ("P = 400 N", "P = 400.1 N", True),
        ("P = 400 N", "P = 401 N", False),
        ("P = 400 N", "P = 400 mm", False),
        ("a\n──\nb", "a\n\nb", True),
        ("a\n...\nc", "a\nb\nb\nc", True),
        ("a\n...\nc\n...", "a\nb\nc\nd", True),
        ("a\n...\nc", "a\nb", False),
        ("...\nb", "a\nc", False),
        ("wall_time=...", "wall_time=0.3", True),
        ("worst ...", "worst residual 1e-8", True),
        ("worst", "worst residual", False),
        ("a", "a\nb", False),
        ("", "", True),
    ],
)
def test_output_agrees_up_to_numbers_and_what_is_left_out(shown: str, printed: str, same: bool) -> None:
    assert agree(shown.splitlines(), printed.splitlines()) is same


LONG = {
    "crack_initiation",
    "displacement_control",
    "grid_and_increments",
    "measured_surface",
    "rig",
    "sweeps",
    "wear",
    "will_it_break",
}
"""Pages whose commands take many seconds."""


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, id=page.stem, marks=[pytest.mark.slow] if page.stem in LONG else [])
        for page in pages("howto")
    ],
)
def test_commands_and_code_do_what_the_page_says(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, programs = tmp_path / "page", tmp_path / "bin"
    shutil.copytree(ROOT / "cases", folder / "cases", ignore=shutil.ignore_patterns("*.h5", "*.parts"))
    programs.mkdir()
    for name, module in (("fretsolve", " -m fretsolve"), ("python", "")):
        (programs / name).write_text(f'#!/bin/sh\nexec "{sys.executable}"{module} "$@"\n')
        (programs / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{programs}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.setenv("FRETSOLVE_NUMBA", "0")
    monkeypatch.chdir(folder)
    names: dict[str, object] = {}
    for block in blocks(page):
        if block.language == "yaml" and block.file:
            Path(block.file).write_text(block.text, encoding="utf-8")
        elif block.language == "console":
            _try_commands(block)
        elif block.language == "python":
            exec(compile("\n" * block.line + block.text, page, "exec"), names)


def _try_commands(block: Block) -> None:
    """Run the commands of a block; they end with 0, unless the next one is ``echo $?``."""
    code, asked = 0, [command for command, _ in block.commands[1:]] + [""]
    for (command, shown), following in zip(block.commands, asked, strict=True):
        code, output = _result_of(command, code)
        told = f"{block.place}: {command}\n{output}"
        assert agree(shown, output.splitlines()), told
        assert code == 0 or following == "echo $?", f"{told}exit code {code}"


def _result_of(command: str, code: int) -> tuple[int, str]:
    """Exit code and output of a command that comes after one that ended with `code`.

    What needs no shell is done in this process, which saves the imports.
    """
    words = shlex.split(command)
    if words[0] == "fretsolve" and not re.search(r"[|&;<>$]", command):
        result = invoke(*words[1:])
        return result.exit_code, result.output
    child = subprocess.run(
        ["bash", "-c", f"(exit {code}); {command}"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return child.returncode, child.stdout


@pytest.mark.parametrize("page", [ROOT / "README.md", *pages()], ids=lambda page: page.stem)
def test_cases_are_valid(page: Path, tmp_path: Path) -> None:
    """Whole cases, and parts of cases but for the keys that they leave out, for the reader and for the schema."""
    shutil.copytree(ROOT / "cases" / "materials", tmp_path / "cases" / "materials")
    for number, block in enumerate(blocks(page)):
        if block.language != "yaml":
            continue
        part = yaml.safe_load(block.text)
        if isinstance(part, dict) and part.keys() <= Case.model_fields.keys():
            path = tmp_path / f"{number}.yaml"
            line = part.get("plane") == "strain"
            path.write_text(yaml.safe_dump({**(LINE_CASE if line else CASE), **part}))
            load_case(path)
            schema = jsonschema.Draft202012Validator({**(line_schema() if line else area_schema()), "required": []})
            assert list(schema.iter_errors(parse(block.text).value)) == []


@pytest.mark.parametrize("page", [ROOT / "README.md", *pages()], ids=lambda page: page.stem)
def test_links_lead_somewhere(page: Path) -> None:
    lost = [target for target in links(page) if not (page.parent / target).exists()]
    assert not lost


def test_pictures_are_shown_at_half_of_their_pixels() -> None:
    shown = [found for page in pages() for found in pictures(page)]
    assert len(shown) > 20
    for name, width in shown:
        with Image.open(name) as picture:
            assert width == picture.width // 2, name


@pytest.mark.parametrize("page", pages("reference"), ids=lambda page: page.stem)
def test_reference_is_what_the_code_says(page: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(DOCS)
    generated = importlib.import_module("generated")
    text = page.read_text(encoding="utf-8")
    assert generated.updated(text) == text, "bring it up to date: python docs/generated.py --write"


def test_reference_has_every_key_and_dataset() -> None:
    schemas = area_schema(), line_schema()
    kinds = [kind for schema in schemas for kind in (schema, *schema["$defs"].values())]
    keys = {key for kind in kinds for key in kind.get("properties", ())}
    assert {"bodies", "young_modulus", "radius_x", "phi_z", "times", "tolerance"} <= keys
    case_page = (DOCS / "reference/case.md").read_text(encoding="utf-8")
    surfaces = {key for key in keys if f"\n## Surface: {key}\n" in case_page}
    assert not [key for key in keys - surfaces - {"cycle"} if f"\n- `{key}` (" not in case_page]
    assert "None" not in case_page
    result_page = (DOCS / "reference/result.md").read_text(encoding="utf-8")
    names = [
        quantity.name for quantity in (*HISTORY, *BULK_HISTORY, *SPOT_HISTORY, *WEAR_HISTORY, *FIELDS, *DERIVED_FIELDS)
    ]
    assert not [name for name in names if not re.search(rf"\n- `{name}`( \(.+\))?: ", result_page)]
    shared = dict(re.findall(r"\n- `NAME(\w+)`: (.*)", result_page))
    for quantity in ERRORS:
        name, ending = re.fullmatch(r"(\w+?)(_corrected_error|_corrected|_error|)", quantity.name).groups()
        assert f"`{name}`" in (shared[ending] if ending else result_page)


def test_stale_reference_is_written_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(DOCS)
    generated = importlib.import_module("generated")
    page = tmp_path / "result.md"
    page.write_text("# Result\n\n<!-- generated: fields -->\nold\n<!-- end of generated -->\n\nrest\n")
    monkeypatch.setattr(generated, "PAGES", tmp_path)
    text = generated.stale_pages()[page]
    assert text.startswith("# Result\n") and text.endswith("\nrest\n")
    assert "\n- `pressure` (MPa): " in text and "old" not in text
    page.write_text(text)
    assert not generated.stale_pages()
