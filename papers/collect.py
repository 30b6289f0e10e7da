"""Collect the scripts of the papers into HTML pages.

    python papers/collect.py                                        # every paper, into build/papers
    python papers/collect.py psakhie_2003 --out site/papers

The ``README.md`` of a paper names its scripts in order. The scripts of a list share runs and are computed in one process.
"""

from __future__ import annotations

import argparse
import collections
import html
import importlib.util
import multiprocessing
import re
import sys
import time
import traceback
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from pages import FULL, OUT, Page, compute_page

HERE = Path(__file__).resolve().parent
PAPERS = ("nesterenko_1983", "psakhie_2003", "gato_shie_2010")
_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 56em; margin: 2em auto; padding: 0 1em; color: #222; background: #fff }
table { border-collapse: collapse; margin: 0.6em 0 } td, th { padding: 0.15em 0.8em 0.15em 0; text-align: left;
vertical-align: top; border-bottom: 1px solid #ddd } img { max-width: 100% } figcaption, .paper, footer { color: #666 }
figure { margin: 1em 0 } pre { background: #fee; overflow: auto } .no { color: #a30000 } h3 { margin-bottom: 0 }
"""


def load_script(path: Path) -> ModuleType:
    """Import a script with its folder on the path, as when it is run."""
    if str(path.parent) not in sys.path:
        sys.path.insert(0, str(path.parent))
    spec = importlib.util.spec_from_file_location(f"{path.parent.name}.{path.stem}", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def script_groups(paper: str) -> list[list[Path]]:
    """Return the scripts of a paper in the order of its README, as one list per list of the README."""
    text = (HERE / paper / "README.md").read_text()
    lists = re.findall(r"(?:^- `\w+\.py`.*\n)+", text, re.MULTILINE)
    return [[HERE / paper / name for name in re.findall(r"^- `(\w+\.py)`", one, re.MULTILINE)] for one in lists]


def _compute_group(task: tuple[Sequence[Path], Path]) -> list[Page]:
    """Compute scripts that share runs, in a separate process; errors are shown on the page."""
    pages = []
    for path in task[0]:
        started = time.monotonic()
        print(f"{path.parent.name}/{path.stem} ...", flush=True)
        try:
            module = load_script(path)
            page = compute_page(module.main, path, module.__doc__, task[1] / path.parent.name)
        except Exception:
            page = Page(path.stem, task[1], path.stem, [("error", traceback.format_exc())], ["error"])
        pages.append(page)
        notes = f": {len(page.failures)} failed: {page.failures}" if page.failures else ""
        print(f"{path.parent.name}/{path.stem}: {time.monotonic() - started:.0f} s, {len(page.rows)} rows{notes}", flush=True)
    return pages


def collect_papers(papers: Sequence[str], out: Path, processes: int = 2) -> list[Page]:
    """Compute the scripts of papers; write ``out/PAPER/index.html``, and ``out/index.html`` with counts of verdicts."""
    # Start with the last paper, which takes longest.
    tasks = [(paper, group) for paper in reversed(papers) for group in script_groups(paper)]
    with multiprocessing.get_context("spawn").Pool(processes, maxtasksperchild=1) as pool:
        found = list(pool.imap(_compute_group, [(group, out) for _, group in tasks], chunksize=1))
    lines = []
    for paper in papers:
        pages = [page for (name, _), group in zip(tasks, found, strict=True) if name == paper for page in group]
        counted = collections.Counter(row.verdict.partition(":")[0].partition(" %")[0] for page in pages for row in page.rows)
        percentiles = sum(counted.pop(name) for name in list(counted) if name.startswith("percentile"))
        words = ", ".join(f"{count} {name or 'without a printed number'}" for name, count in counted.most_common())
        words += f", {percentiles} draws" if percentiles else ""
        text = (HERE / paper / "README.md").read_text()
        (out / paper).mkdir(parents=True, exist_ok=True)
        (out / paper / "index.html").write_text(_render_readme(text, pages, words))
        lines.append(f'<p><a href="{paper}/index.html">{html.escape(_readme_title(text))}</a>: {words}.</p>')
        print(f"{out / paper / 'index.html'}: {words}")
    (out / "index.html").write_text(_render_document("The papers, recomputed", "\n".join(lines)))
    return [page for group in found for page in group]


def _readme_title(readme: str) -> str:
    return readme.partition("\n")[0].removeprefix("# ")


def _render_readme(readme: str, pages: Sequence[Page], words: str) -> str:
    introduction = re.split(r"^## ", readme, maxsplit=1, flags=re.MULTILINE)[0].partition("\n")[2]
    parts = [f"<h1>{html.escape(_readme_title(readme))}</h1>"]
    parts += [f"<p>{html.escape(one)}</p>" for one in re.split(r"\n\s*\n", introduction.strip())]
    parts += [f"<p>{words}.</p>", "<ul>", *(f'<li><a href="#{p.name}">{html.escape(p.title)}</a></li>' for p in pages), "</ul>"]
    for page in pages:
        parts.append(f'<h2 id="{page.name}">{html.escape(page.title)}</h2>')
        before = ""
        for kind, content in page.blocks:
            if (kind == "row") != (before == "row"):
                opened = "<table><tr><th>quantity</th><th>paper</th><th>here</th><th>verdict</th></tr>"
                parts.append(opened if kind == "row" else "</table>")
            parts.append(_render_block(kind, content))
            before = kind
        parts.append("</table>" if before == "row" else "")
    return _render_document(_readme_title(readme), "\n".join(parts))


def _render_block(kind: str, content: Any) -> str:
    if kind == "row":
        paper = html.escape(
            f"{content.paper} {content.unit}" if content.paper and content.near is None else content.paper or "–"
        )
        verdict = html.escape(content.verdict) + (
            f"<br><small>read as: {html.escape(content.reading)}</small>" * bool(content.reading)
        )
        return (
            f'<tr><td>{html.escape(content.what)}</td><td class="paper">{paper}</td>'
            f"<td>{html.escape(f'{content.display_text} {content.unit}')}</td>"
            f"<td{' class=no' * content.verdict.startswith('not')}>{verdict}</td></tr>"
        )
    if kind == "figure":
        return f'<figure><img src="{content[0]}" alt=""><figcaption>{html.escape(content[1])}</figcaption></figure>'
    if kind == "table":
        caption, head, rows = content
        lines = [f"<tr>{''.join(f'<{tag}>{html.escape(one)}</{tag}>' for one in row)}</tr>" for tag, row in
                 [("th", head), *(("td", row) for row in rows)]]  # fmt: skip
        return f"<p>{html.escape(caption)}</p><table>{''.join(lines)}</table>"
    tag = {"say": "p", "head": "h3", "error": "pre"}[kind]
    return f"<{tag}>{html.escape(content)}</{tag}>"


def _render_document(title: str, body: str) -> str:
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>{html.escape(title)}</title><style>{_STYLE}</style><body>{body}</body></html>\n"
    )


def main() -> None:
    """Collect the pages named on the command line."""
    parser = argparse.ArgumentParser(description="Recompute the figures and numbers of the papers.")
    parser.add_argument("paper", nargs="*", choices=[*PAPERS, []], help="papers to collect; default: all")
    parser.add_argument("--out", type=Path, default=OUT, help="output folder of the pages")
    parser.add_argument("--processes", type=int, default=1 if FULL else 2, help="number of scripts computed in parallel")
    options = parser.parse_args()
    pages = collect_papers(options.paper or PAPERS, options.out.resolve(), options.processes)
    sys.exit(1 if any(page.failures for page in pages) else 0)


if __name__ == "__main__":
    main()
