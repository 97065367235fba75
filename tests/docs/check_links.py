#!/usr/bin/python3
"""Links that lead nowhere.

    check_links.py SOURCE         README and docs/**/*.md: relative links, anchors, figures, and every path of
                                  the project that a page names in backquotes
    check_links.py --html FOLDER  the built site: every local href and src
"""
import html.parser
import pathlib
import re
import sys
import urllib.parse


def without_code(text):
    return re.sub(r"`[^`\n]*`", "", re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S))


def anchor(heading):
    """As GitHub makes it: lower case, letters, digits, '-' and '_' only, blanks to '-'."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").strip().lower()
    return "".join(c for c in text.replace(" ", "-") if c.isalnum() or c in "-_")


def anchors(path):
    found = []
    for heading in re.findall(r"^#+ +(.*)$", re.sub(r"^```.*?^```$", "", path.read_text(), flags=re.M | re.S), re.M):
        name, n = anchor(heading), 0
        while (name if n == 0 else f"{name}-{n}") in found:
            n += 1
        found.append(name if n == 0 else f"{name}-{n}")
    return found


def named_paths(text):
    """Paths in backquotes that begin in a folder of the project: `lib/simd/lanes.h`, `configs/smoke/estimate.toml`."""
    for name in re.findall(r"`((?:lib|experiments|configs|scripts|tests|docs|cmake)/[\w./-]*\w/?)`", text):
        yield name


def check_pages(source):
    bad, links = [], 0
    pages = [source / "README.md", *sorted(source.glob("docs/**/*.md"))]
    for page in pages:
        text, here = page.read_text(), page.relative_to(source)
        for target in re.findall(r"\]\(([^)\s]+)\)", without_code(text)):
            if re.match(r"[a-z]+:", target):
                continue
            links += 1
            name, _, fragment = target.partition("#")
            path = page if not name else page.parent / urllib.parse.unquote(name)
            if not path.exists():
                bad.append(f"{here}: {target}: no such file")
            elif fragment and fragment not in anchors(path):
                bad.append(f"{here}: {target}: no such heading")
        created = set(re.findall(r"<!-- file: (\S+) -->", text))
        for name in named_paths(text):
            links += 1
            if name not in created and not (source / name).exists():
                bad.append(f"{here}: `{name}`: no such file")
    return bad, f"{len(pages)} pages, {links} links and paths"


class Page(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.ids, self.links = set(), []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("id", "name") and value:
                self.ids.add(value)
            if name in ("href", "src") and value and tag != "base":
                self.links.append(value)


def check_site(folder):
    pages = {p.relative_to(folder).as_posix(): Page(p.read_text(errors="replace")) for p in folder.glob("**/*.html")}
    bad, links = [], 0
    for name, page in pages.items():
        for link in page.links:
            if re.match(r"(https?|mailto|javascript|data):", link):
                continue
            links += 1
            target, _, fragment = urllib.parse.unquote(link).partition("#")
            path = name if not target else (pathlib.PurePosixPath(name).parent / target).as_posix()
            if path not in pages and not (folder / path).exists():
                bad.append(f"{name}: {link}: no such file")
            elif fragment == "nested-classes":  # doxygen 1.9.4 writes it where all nested classes are private
                pass
            elif fragment and path in pages and fragment not in pages[path].ids:
                bad.append(f"{name}: {link}: no such anchor")
    return bad, f"{len(pages)} pages, {links} links"


def main():
    if sys.argv[1] == "--html":
        bad, what = check_site(pathlib.Path(sys.argv[2]))
    else:
        bad, what = check_pages(pathlib.Path(sys.argv[1]).resolve())
    print("\n".join(bad) or f"links: {what}: all lead somewhere")
    return bool(bad)


if __name__ == "__main__":
    sys.exit(main())
