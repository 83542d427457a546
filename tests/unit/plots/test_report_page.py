"""All pictures of a result on one page."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path

from command_line import invoke

from fretsolve import plots


class _Pictures(HTMLParser):
    """What a page shows."""

    def __init__(self) -> None:
        super().__init__()
        self.sources: list[str] = []
        self.tags: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.sources += [value or "" for name, value in attrs if name in ("src", "href")]


def test_all_kinds_and_a_report(result_folder: Path, tmp_path: Path) -> None:
    done = invoke("plot", result_folder / "torsion.h5", "--all", "-o", tmp_path / "out")
    assert done.exit_code == 0, done.stderr
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {*(f"{kind}.png" for kind in plots.KINDS if kind != "animate"), "animate.gif", "index.html"}
    text = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    page = _Pictures()
    page.feed(text)
    assert len(page.sources) == len(plots.KINDS)
    assert all(source.startswith("data:image/") for source in page.sources)
    assert "mode" not in page.tags
    assert "Fretting &lt;mode&gt; $I$ &amp;" in text
    assert "dissipated energy" in text and "<h2>Left out</h2>" not in text


def test_report_says_what_is_left_out(result_folder: Path, tmp_path: Path) -> None:
    done = invoke("plot", result_folder / "hertz.h5", "--all", "-o", tmp_path)
    assert done.exit_code == 0
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "<li>stick-history: nothing sticks or slips without friction and shear traction</li>" in text
    assert "left out: streamlines: no field 'shear' is stored, only pressure, zone" in done.stdout
    assert not (tmp_path / "streamlines.png").exists()
