#!/usr/bin/env python3
"""Checks the links of the documentation, without the network.

check_links.py            the Markdown pages as they stand in the repository: files, and headings by GitHub's rules
check_links.py FOLDER     the site that doxygen has written into FOLDER: files and ids
check_links.py --external also prints the links that lead elsewhere, which nobody has followed
"""

import html.parser
import pathlib
import re
import sys
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
LINK = re.compile(r"!?\[(?:[^\][]|\[[^\]]*\])*\]\(<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\)")
WRITTEN_BY_DOXYGEN = ("nested-classes",)  # the summary of a class names this, where there is nothing to list
EXTERNAL = re.compile(r"[a-z][a-z0-9+.-]*:|//")


def parts(text):
    """A page in parts, each with whether it is a block of code: a link may begin on one line and end on the next."""
    lines, inside = [], False
    for line in text.splitlines(keepends=True):
        fence = line.lstrip().startswith("```")
        if fence and not inside:
            yield False, "".join(lines)
            lines = []
        lines.append(line)
        if fence and inside:
            yield True, "".join(lines)
            lines = []
        inside ^= fence
    yield inside, "".join(lines)


def prose(text):
    """A page without its blocks of code."""
    return "".join(part for is_code, part in parts(text) if not is_code)


def slugs(text):
    """The ids that GitHub gives the headings of a page."""
    seen = {}
    for line in prose(text).splitlines():
        heading = re.match(r"#{1,6}\s+(.*?)\s*#*$", line)
        if not heading:
            continue
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading.group(1))
        slug = re.sub(r"[^\w\- ]", "", words.replace("`", "").lower()).replace(" ", "-")
        seen[slug] = seen.get(slug, -1) + 1
        yield slug if seen[slug] == 0 else f"{slug}-{seen[slug]}"


def pages():
    """All pages of the repository but those of what is built, or of hidden folders other than GitHub's."""
    for page in sorted(ROOT.rglob("*.md")):
        folders = page.relative_to(ROOT).parts[:-1]
        if not any(name.startswith("build") or (name.startswith(".") and name != ".github") for name in folders):
            yield page


def markdown_links():
    for page in pages():
        for link in LINK.findall(re.sub(r"`[^`\n]*`", "", prose(page.read_text()))):
            yield page, link


class Ids(html.parser.HTMLParser):
    """The links and the ids of a page of HTML."""

    def __init__(self, page):
        super().__init__()
        self.ids, self.links = set(), []
        self.feed(page.read_text(errors="replace"))

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.ids.update(values[name] for name in ("id", "name") if values.get(name))
        if tag in ("a", "link") and values.get("href"):
            self.links.append(values["href"])
        if tag in ("img", "script", "source", "video") and values.get("src"):
            self.links.append(values["src"])


def check(links, ids_of):
    """Prints what leads nowhere. \\return (links, faults, links that lead elsewhere)"""
    count, faults, external = 0, 0, {}
    for page, link in links:
        count += 1
        if EXTERNAL.match(link):
            external.setdefault(link, page)
            continue
        path, _, fragment = urllib.parse.unquote(link).partition("#")
        path = path.partition("?")[0]
        target = (page.parent / path).resolve() if path else page
        fault = None
        if not target.exists():
            fault = "no such file"
        elif fragment in WRITTEN_BY_DOXYGEN:
            continue
        elif fragment and target.suffix in (".md", ".html") and fragment not in ids_of(target):
            fault = "no such heading"
        if fault:
            faults += 1
            print(f"{page}: {link}: {fault}", file=sys.stderr)
    return count, faults, external


def main():
    arguments = [argument for argument in sys.argv[1:] if argument != "--external"]
    known = {}
    if arguments:
        folder = pathlib.Path(arguments[0]).resolve()
        parsed = {page: Ids(page) for page in sorted(folder.rglob("*.html"))}
        links = [(page, link) for page, read in parsed.items() for link in read.links]
        result = check(links, lambda page: parsed[page].ids)
    else:
        result = check(markdown_links(), lambda page: known.setdefault(page, set(slugs(page.read_text()))))
    count, faults, external = result
    if "--external" in sys.argv:
        for link, page in sorted(external.items()):
            print(f"not followed: {link} ({page.name})")
    print(f"{count} links, {faults} lead nowhere, {len(external)} other sites")
    return 1 if faults or not count else 0


if __name__ == "__main__":
    sys.exit(main())
