"""A self-contained HTML page: escaped text, inlined pictures, no scripts, no network."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

# The page may show the pictures and the style it carries; everything else is forbidden, whatever its text holds.
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"

# A cell of more characters is given some width, so that a narrow screen does not make a column of single words of it.
_LONG = 40

_STYLE = """
:root { color-scheme: light dark; 
  --text: #1d2126; --dim: #5c6670; --back: #ffffff; --line: #dde2e7; --soft: #f4f6f8; --mark: #b2182b; --grid: #dde2e7;
  --c0: #0072b2; --c1: #c04e00; --c2: #00805f; --c3: #b3568f; --c4: #b87f00; --c5: #2f8fc4; }
@media (prefers-color-scheme: dark) {
  :root { --text: #e4e7ea; --dim: #9aa4ad; --back: #14171a; --line: #30363c; --soft: #1d2226; --mark: #f4a582; --grid: #30363c;
  --c0: #6db3f2; --c1: #ffa257; --c2: #62cf99; --c3: #e3a3ca; --c4: #f0c04d; --c5: #8fd3f4; }
}
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.2rem 1rem 4rem; max-width: 60rem; background: var(--back); color: var(--text);
       font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; overflow-wrap: anywhere; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: .5rem 0; }
h2 { font-size: 1.2rem; margin: 2.4rem 0 .6rem; padding-top: .8rem; border-top: 1px solid var(--line); }
p { margin: .5rem 0; } .dim { color: var(--dim); }
figure { margin: .8rem 0; } figcaption { color: var(--dim); font-size: .9rem; }
.drawing { overflow-x: auto; } .drawing svg { display: block; width: 100%; height: auto; min-width: 34rem; }
.drawing svg text { fill: currentColor; }
.wide { overflow-x: auto; margin: .8rem 0; }
table { border-collapse: collapse; font-size: .92rem; min-width: 60%; }
th, td { padding: .3rem .9rem .3rem 0; text-align: left; vertical-align: top; border-bottom: 1px solid var(--line);
         overflow-wrap: normal; }
.long { min-width: 16rem; }
.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
pre { background: var(--soft); padding: .8rem; border-radius: 6px; overflow-x: auto; font-size: .88rem; }
ul.cautions li { color: var(--mark); } nav a { display: inline-block; margin-right: 1rem; color: inherit; }
"""


def printable(value: object) -> str:
    """Any value as text that every file can hold: bytes of a file's name that are no text become question marks."""
    return str(value).encode("utf-8", "replace").decode("utf-8")


def text(value: object) -> str:
    """Any value as escaped text."""
    return escape(printable(value), quote=True)


def paragraph(words: object, style: str = "") -> str:
    """A paragraph of escaped text."""
    return f'<p class="{style}">{text(words)}</p>' if style else f"<p>{text(words)}</p>"


def preformatted(words: object) -> str:
    """Lines as they are."""
    return f"<pre>{text(words)}</pre>"


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table; numbers, and the heads above them, stand to the right."""
    lines = [list(row) for row in rows]
    header = "".join(_cell("th", name, bool(lines) and _is_number(lines[0][place])) for place, name in enumerate(head))
    body = "".join("<tr>" + "".join(_cell("td", value, _is_number(value)) for value in line) + "</tr>" for line in lines)
    return f'<div class="wide"><table><thead><tr>{header}</tr></thead><tbody>{body}</tbody></table></div>'


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _cell(tag: str, value: object, number: bool) -> str:
    words = f"{value:.6g}" if isinstance(value, float) else text(value)
    style = ' class="number"' if number else ' class="long"' if tag == "td" and len(words) > _LONG else ""
    return f"<{tag}{style}>{words}</{tag}>"


def bullets(sentences: Iterable[object], style: str = "") -> str:
    """A list of sentences."""
    return f'<ul class="{style}">' + "".join(f"<li>{text(sentence)}</li>" for sentence in sentences) + "</ul>"


def picture(svg: str, description: str) -> str:
    """A drawing of `drawing.svg` inside the page, with its description under it."""
    words = text(description)
    return f'<figure><div class="drawing" role="img" aria-label="{words}">{svg}</div><figcaption>{words}</figcaption></figure>'


def page(title: str, lead: str, sections: Sequence[tuple[str, str]]) -> str:
    """The whole page.

    Args:
        title: plain text.
        lead: HTML under the title.
        sections: heading (plain text) and HTML of each.
    """
    links = "".join(f'<a href="#part-{number}">{text(heading)}</a>' for number, (heading, _) in enumerate(sections))
    body = "".join(
        f'<section><h2 id="part-{number}">{text(heading)}</h2>{content}</section>'
        for number, (heading, content) in enumerate(sections)
    )
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{text(title)}</title><style>{_STYLE}</style></head>"
        f"<body><h1>{text(title)}</h1>{lead}<nav>{links}</nav>{body}</body></html>\n"
    )
