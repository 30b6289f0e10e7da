"""A hook of mkdocs: a picture with a twin for dark pages (``NAME-dark.png``) is shown as the one that fits the page."""

import re
from pathlib import Path
from typing import Any

PICTURE = re.compile(r"!\[(?P<text>[^\]]*)\]\((?P<stem>[^)#\s]+)(?P<suffix>\.(?:png|gif|svg))\)")


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Write each picture that has a twin twice, once for each colour scheme."""
    folder = Path(page.file.abs_src_path).parent

    def both(found: re.Match[str]) -> str:
        text, stem, suffix = found["text"], found["stem"], found["suffix"]
        if not (folder / f"{stem}-dark{suffix}").exists():
            return found[0]
        return f"![{text}]({stem}{suffix}#only-light)\n![{text}]({stem}-dark{suffix}#only-dark)"

    return PICTURE.sub(both, markdown)
