"""The pages of the documents taken apart: fenced blocks, commands with what they print, and links."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"

RTOL = 1e-3
"""Of numbers in the output of a command against those that a page shows."""

ATOL = 1e-6
"""The same of numbers near 0, such as residuals."""

ANYTHING = "..."
"""In the output that a page shows: any lines, or any end of a line, or of a word."""

_FENCE = re.compile(r"^```(\S*)[^\n]*\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_FILE = re.compile(r"# (\S+\.\w+)\n")
_LINK = re.compile(r'\]\(([^)\s]+)\)|<img src="([^"]+)"')
_PICTURE = re.compile(r'<img src="([^"]+\.png)"(?: width="(\d+)")?')
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?")
_RULE = re.compile(r"[\s─]*")


@dataclass(frozen=True)
class Block:
    """A fenced block of a page, which begins at a line."""

    page: Path
    line: int
    language: str
    text: str

    @property
    def place(self) -> str:
        """For messages."""
        return f"{self.page.relative_to(ROOT)}:{self.line}"

    @property
    def file(self) -> str | None:
        """The name of the file that the block is, where its first line tells one."""
        found = _FILE.match(self.text)
        return found[1] if found else None

    @property
    def commands(self) -> list[tuple[str, list[str]]]:
        """Commands of a `console` block, each with the lines that it prints."""
        found: list[tuple[str, list[str]]] = []
        for line in self.text.splitlines():
            if line.startswith("$ "):
                found.append((line[2:], []))
            else:
                found[-1][1].append(line)
        return found


def pages(folder: str = "**") -> list[Path]:
    """The Markdown files in a folder of the documents; in all of them by default."""
    return sorted(path for path in DOCS.glob(f"{folder}/*.md") if "build" not in path.parts)


def blocks(page: Path) -> Iterator[Block]:
    """Fenced blocks in their order."""
    text = page.read_text(encoding="utf-8")
    for found in _FENCE.finditer(text):
        yield Block(page, text.count("\n", 0, found.start()) + 1, found[1], found[2])


def links(page: Path) -> list[str]:
    """Targets within the repository, without what follows a ``#``."""
    text = _FENCE.sub("", page.read_text(encoding="utf-8"))
    targets = ((link or picture).partition("#")[0] for link, picture in _LINK.findall(text))
    return [target for target in targets if target and "://" not in target]


def pictures(page: Path) -> list[tuple[Path, int]]:
    """Pictures with the width in which they are shown (pixels), 0 where the page does not say."""
    found = _PICTURE.findall(page.read_text(encoding="utf-8"))
    return [(page.parent / name, int(width or 0)) for name, width in found]


def agree(shown: Sequence[str], printed: Sequence[str]) -> bool:
    """Return whether lines of output are those that a page shows; blank lines and rules of tables count for nothing."""
    runs: list[list[str]] = [[]]
    for line in shown:
        if line.strip() == ANYTHING:
            runs.append([])
        elif not _RULE.fullmatch(line):
            runs[-1].append(line)
    rest = [line for line in printed if not _RULE.fullmatch(line)]
    if len(runs) == 1:
        return len(rest) == len(runs[0]) and all(map(_lines_agree, runs[0], rest))
    first, *middle, last = runs
    if len(rest) < len(first) + len(last) or not all(map(_lines_agree, first, rest)):
        return False
    if not all(map(_lines_agree, last, rest[len(rest) - len(last) :])):
        return False
    rest = rest[len(first) : len(rest) - len(last)]
    for run in middle:
        begin = next((at for at in range(len(rest) - len(run) + 1) if all(map(_lines_agree, run, rest[at:]))), None)
        if begin is None:
            return False
        rest = rest[begin + len(run) :]
    return True


def _lines_agree(shown: str, printed: str) -> bool:
    wanted, found = shown.split(), printed.split()
    if wanted and wanted[-1] == ANYTHING:
        del wanted[-1]
        del found[len(wanted) :]
    return len(wanted) == len(found) and all(map(_words_agree, wanted, found))


def _words_agree(shown: str, printed: str) -> bool:
    if ANYTHING in shown:
        return printed.startswith(shown.partition(ANYTHING)[0])
    if _NUMBER.split(shown) != _NUMBER.split(printed):
        return False
    pairs = zip(_NUMBER.findall(shown), _NUMBER.findall(printed), strict=True)
    return all(math.isclose(float(one), float(other), rel_tol=RTOL, abs_tol=ATOL) for one, other in pairs)
