"""All pictures of a result on one page."""

from __future__ import annotations

import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import pytest
from command_line import invoke, refused

from fretsolve.post import plots
from fretsolve.result import open_result


class _Pictures(HTMLParser):
    """The contents of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.sources: list[str] = []
        self.widths: list[str] = []
        self.tags: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.sources += [value or "" for name, value in attrs if name in ("src", "href")]
        self.widths += [value or "" for name, value in attrs if name == "style"]


@pytest.fixture(scope="module")
def drawn(result_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with all pictures of a result and their page."""
    folder = tmp_path_factory.mktemp("all") / "out"
    done = invoke("plot", result_folder / "torsion.h5", "--all", "-o", folder)
    assert done.exit_code == 0, done.stderr
    return folder


@pytest.mark.slow
def test_all_kinds_and_a_report(result_folder: Path, drawn: Path) -> None:
    names = {path.name for path in drawn.iterdir()}
    # of no other file than the result, and of columns that all results have
    kinds = [kind for kind in plots.KINDS.values() if not (kind.beside or kind.column or kind.surfaces)]
    assert names == {*(f"{kind.name}.{kind.formats[0]}" for kind in kinds), "index.html"}
    text = (drawn / "index.html").read_text(encoding="utf-8")
    page = _Pictures()
    page.feed(text)
    with open_result(result_folder / "torsion.h5") as result:
        increments = len(result.steps)
    assert len(page.sources) == len(kinds) + increments
    assert all(source.startswith("data:image/") for source in page.sources)
    assert "mode" not in page.tags
    assert "Fretting &lt;mode&gt; $I$ &amp;" in text
    assert "dissipated energy" in text and "<h2>Left out</h2>" not in text


@pytest.mark.slow
def test_report_says_what_is_left_out(result_folder: Path, tmp_path: Path) -> None:
    done = invoke("plot", result_folder / "hertz.h5", "--all", "-o", tmp_path)
    assert done.exit_code == 0
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "<li>stick-history: nothing sticks or slips without friction and shear traction</li>" in text
    assert "left out: streamlines: no field 'shear' is stored, only pressure, zone" in done.stdout
    assert not (tmp_path / "streamlines.png").exists()
    (tmp_path / "index.html").write_text("<title>my site</title>", encoding="utf-8")
    line = refused(4, "plot", result_folder / "hertz.h5", "--all", "-o", tmp_path)
    assert line.startswith(f"{tmp_path / 'index.html'}: is not a page of fretsolve, so it is not replaced")
    assert (tmp_path / "index.html").read_text(encoding="utf-8") == "<title>my site</title>"


CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")
def test_slider_steps_through_the_increments_in_a_browser(drawn: Path, tmp_path: Path) -> None:
    assert CHROMIUM is not None
    text = (drawn / "index.html").read_text(encoding="utf-8")
    assert not re.search(r"https?://", text)
    moved = """<script>
    slider.value = 1; slider.dispatchEvent(new Event("input"));
    const shown = [...frames].filter(frame => frame.checkVisibility());
    document.body.innerHTML = shown.map(frame => frame.naturalWidth > 500 ? frame.alt : "not loaded").join("|");
    </script>"""
    page = tmp_path / "moved.html"
    page.write_text(text.replace("</body>", f"{moved}</body>"), encoding="utf-8")
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]
    options += ["--disable-component-update", "--disable-sync", f"--user-data-dir={tmp_path / 'profile'}", "--dump-dom"]
    done = subprocess.run([CHROMIUM, *options, page.as_uri()], capture_output=True, text=True, timeout=120, check=True)
    body = done.stdout[done.stdout.index("<body>") :]
    assert body.startswith("<body>increment 1 (stage 2): P = 400 N, Mz = 1.667 N mm\n"), body[:300]
