#!/usr/bin/env python3
"""for_doxygen.py PAGE.md: the page as doxygen wants it, on the standard output stream. The Doxyfile names it as the filter of *.md.

On GitHub a link names a file and a heading; doxygen wants ids that are unique in all of the site, and images by their names alone. What
is no page of the site, such as a folder of sources, is text there.
"""

import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from check_links import EXTERNAL, LINK, ROOT, parts, slugs


def id_of(page, slug=""):
    name = page.relative_to(ROOT).with_suffix("").as_posix() + ("/" + slug if slug else "")
    return re.sub(r"[^A-Za-z0-9]", "_", name)


def rewritten_link(page, match):
    text, link = match.group(0), match.group(1)
    if EXTERNAL.match(link):
        return text
    path, _, slug = link.partition("#")
    target = (page.parent / path).resolve() if path else page
    label = re.match(r"!?\[(.*)\]\(", text, re.DOTALL).group(1).replace("\n", " ")  # doxygen ends a label with its line
    if text.startswith("!"):
        return f"![{label}]({target.name})"
    if target.suffix == ".md" and (target.parts[len(ROOT.parts)] == "doc" or target.parent == ROOT):
        if target.name == "README.md" and not slug:
            return f"[{label}](@ref mainpage)"
        return f"[{label}](@ref {id_of(target, slug)})"
    return label


def main():
    page = pathlib.Path(sys.argv[1]).resolve()
    text = page.read_text()
    ids = slugs(text)
    first = True
    for is_code, part in parts(text):
        if not is_code:
            part = LINK.sub(lambda match: rewritten_link(page, match), part)
        for line in part.splitlines():
            if not is_code and re.match(r"#{1,6}\s", line):
                slug = next(ids)
                name = "mainpage" if first and page.name == "README.md" else id_of(page, "" if first else slug)
                line = f"{line} {{#{name}}}"
                first = False
            print(line)


if __name__ == "__main__":
    main()
