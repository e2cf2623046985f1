#!/usr/bin/env python3
"""A preprocessor of mdBook: adapts pages that are written for GitHub.

Links: one from docs/graph-file.md to ../graphs/examples/mips.toml works on GitHub. In the book, whose root is docs/, it would lead nowhere.
So it leads to the repository. Its address is $RAXEL_REPOSITORY, or, in a workflow, that of GitHub, or else the folder on this machine.

GLSL: the highlighter of mdBook does not know it. It shows such blocks as C++, which has the same comments, numbers and most keywords.
"""

import json
import os
import posixpath
import re
import sys
from pathlib import Path

LINK = re.compile(r"(?<=\]\()([^)\s#]*)(#[^)\s]*)?(?=\))")
GLSL = re.compile(r"\A```glsl\b")
PICTURES = (".png", ".gif", ".webp", ".svg", ".jpg", ".mp4")


def address():
    server, name = os.environ.get("GITHUB_SERVER_URL"), os.environ.get("GITHUB_REPOSITORY")
    given = os.environ.get("RAXEL_REPOSITORY") or (f"{server}/{name}/blob/main" if server and name else "")
    return given or Path(__file__).resolve().parents[2].as_uri()


def chapters(items):
    for item in items:
        if chapter := item.get("Chapter") if isinstance(item, dict) else None:
            yield chapter
            yield from chapters(chapter["sub_items"])


def adapted(text, page, pages, repository):
    """The text of a page as the book shows it."""

    def place(match):
        target, anchor = match.group(1), match.group(2) or ""
        if not target or "://" in target:
            return match.group(0)
        inside = posixpath.normpath(posixpath.join(posixpath.dirname(page), target))
        # mdBook calls the page of a README.md index.html, and leaves links to it as they are.
        if posixpath.basename(inside) == "README.md" and pages & {inside, inside[: -len("README.md")] + "index.md"}:
            return f"{target[: -len('README.md')]}index.md{anchor}"
        if inside in pages or (not inside.startswith("..") and inside.endswith(PICTURES)):
            return match.group(0)
        return f"{repository}/{posixpath.normpath(posixpath.join('docs', inside))}{anchor}"

    # Links in code are left as they are.
    parts = re.split(r"(^```.*?^```$)", text, flags=re.S | re.M)
    return "".join(GLSL.sub("```cpp", part) if part.startswith("```") else LINK.sub(place, part) for part in parts)


def main():
    if sys.argv[1:2] == ["supports"]:
        return
    _, book = json.load(sys.stdin)
    all_chapters = list(chapters(book.get("sections", book.get("items", []))))
    pages = {chapter["path"] for chapter in all_chapters if chapter.get("path")}
    repository = address()
    for chapter in all_chapters:
        if chapter.get("path"):
            chapter["content"] = adapted(chapter["content"], chapter["path"], pages, repository)
    json.dump(book, sys.stdout)


if __name__ == "__main__":
    main()
