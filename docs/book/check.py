#!/usr/bin/env python3
"""Checks a built book: every link and picture leads to a file and an anchor that exist, in the book or in the repository.

    cd docs/book && mdbook build && python3 check.py ../../target/book

Prints each dead link; the exit code is 1 if there is one. Links to other sites are not followed.
"""

import html
import re
import sys
from pathlib import Path
from urllib.parse import unquote

sys.dont_write_bytecode = True
from adapt import address

ROOT = Path(__file__).resolve().parents[2]
LEFT_OUT = {"404.html", "print.html", "toc.html"}


def main(book):
    pages = {page: page.read_text() for page in sorted(book.rglob("*.html")) if page.name not in LEFT_OUT}
    anchors = {page: set(re.findall(r'\bid="([^"]*)"', text)) for page, text in pages.items()}
    repository, dead, links = address(), [], 0
    for page, text in pages.items():
        main_part = re.search(r"<main>(.*)</main>", text, re.S)
        for link in re.findall(r'\b(?:href|src)="([^"]*)"', main_part[1] if main_part else ""):
            links += 1
            path, _, anchor = html.unescape(link).partition("#")
            if path.startswith(repository):
                exists = (ROOT / unquote(path[len(repository) + 1 :])).exists()
            elif re.match(r"[a-z]+:", path):
                continue
            else:
                target = (page.parent / unquote(path)).resolve() if path else page
                exists = target.exists() and (not anchor or target not in anchors or unquote(anchor) in anchors[target])
            if not exists:
                dead.append(f"{page.relative_to(book)}: {link}")
    print("\n".join(dead) or f"{links} links on {len(pages)} pages lead somewhere")
    return 1 if dead or not links else 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(Path(sys.argv[1]).resolve()))
