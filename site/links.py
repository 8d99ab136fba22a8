"""Checks the built site: every link and picture of a page is there, with the place that it names.

    python3 site/links.py FOLDER

The standard library alone. Links to other sites are listed by their number and not fetched.
"""

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

# Words of which the search has to find at least one page each.
SOUGHT = ["counterweight", "firing", "trajectory", "viscous"]


class Page(HTMLParser):
    """The places of a page, and what it refers to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.places: set[str] = set()
        self.links: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("id", "name") and value:
                self.places.add(value)
            if name in ("href", "src") and value and tag != "base":
                self.links.append(value)


def dead(root: Path, pages: dict[Path, Page]) -> list[str]:
    """Links that lead nowhere, as sentences."""
    wrong = []
    for path, page in pages.items():
        if path.name in ("404.html", "toc.html"):
            # Their links count from the root of the server.
            continue
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            goal = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if goal.is_dir():
                goal /= "index.html"
            if not goal.is_file() or root not in goal.parents:
                wrong.append(f"{path.relative_to(root)}: {link}: there is no such file in the site")
            elif parts.fragment and goal in pages and unquote(parts.fragment) not in pages[goal].places:
                wrong.append(f"{path.relative_to(root)}: {link}: there is no such place on that page")
    return wrong


def index(root: Path) -> str:
    """The text of the search index."""
    files = sorted(root.glob("searchindex*.js*"))
    return max((file.read_text(encoding="utf-8") for file in files), key=len, default="")


def main() -> int:
    root = Path(sys.argv[1]).resolve()
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(root.rglob("*.html"))}
    wrong = dead(root, pages)
    text = index(root)
    wrong += [f"the search does not know the word {word!r}" for word in SOUGHT if word not in text]
    links = [link for page in pages.values() for link in page.links]
    outside = {link for link in links if urlsplit(link).scheme}
    print(*wrong, sep="\n", end="\n" if wrong else "")
    print(f"site: {len(pages)} pages, {len(links)} links, {len(outside)} to other sites (not fetched), {len(wrong)} wrong")
    return 1 if wrong or len(pages) < 20 else 0


if __name__ == "__main__":
    sys.exit(main())
