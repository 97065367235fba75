#!/usr/bin/python3
"""Links that lead nowhere.

    check_links.py SOURCE         README, CONTRIBUTING and docs/**/*.md: relative links, anchors, figures, and every path of
                                  the project that a page names in backquotes
    check_links.py --html FOLDER  the built site: every local href and src; nothing from the network; every page within three
                                  clicks of the first one; the search knows every key
"""
import html.parser
import json
import os
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
    pages = [source / "README.md", source / "CONTRIBUTING.md", *sorted(source.glob("docs/**/*.md"))]
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
        self.ids, self.links, self.fetched = set(), [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("id", "name") and value:
                self.ids.add(value)
            if name in ("href", "src") and value and tag != "base":
                self.links.append(value)
                if name == "src" or tag == "link":
                    self.fetched.append(value)


def from_network(folder, pages):
    """What a reader's browser would fetch from elsewhere: sources and style sheets, of pages and of style sheets."""
    for name, page in pages.items():
        for link in page.fetched:
            if re.match(r"(https?:)?//", link):
                yield f"{name}: {link}: from the network"
    for style in folder.glob("**/*.css"):
        for link in re.findall(r"(?:url\(|@import )['\"]?((?:https?:)?//[^)'\"]+)", style.read_text(errors="replace")):
            yield f"{style.relative_to(folder)}: {link}: from the network"


def clicks(pages):
    """{page: how many clicks it is away from index.html}"""
    found, reached = {"index.html": 0}, ["index.html"]
    for name in reached:
        for link in pages[name].links:
            target = urllib.parse.unquote(link).partition("#")[0]
            path = os.path.normpath(os.path.join(os.path.dirname(name), target)) if target else name
            if path in pages and path not in found:
                found[path] = found[name] + 1
                reached.append(path)
    return found


def searched(folder):
    """What the search of the site knows: words, and entries of the index, by small letters."""
    index = json.loads(re.fullmatch(r"Search\.setIndex\((.*)\)\s*", (folder / "searchindex.js").read_text(), re.S)[1])
    return set(index["terms"]) | set(index["titleterms"]), {entry.lower() for entry in index["indexentries"]}


def check_site(folder, source):
    pages = {p.relative_to(folder).as_posix(): Page(p.read_text(errors="replace")) for p in folder.glob("**/*.html")}
    bad, links = list(from_network(folder, pages)), 0
    for name, page in pages.items():
        for link in page.links:
            if re.match(r"(https?|mailto|javascript|data):", link):
                continue
            links += 1
            target, _, fragment = urllib.parse.unquote(link).partition("#")
            target = target.partition("?")[0]
            path = name if not target else os.path.normpath(os.path.join(os.path.dirname(name), target))
            if path not in pages and not (folder / path).exists():
                bad.append(f"{name}: {link}: no such file")
            elif fragment and path in pages and fragment not in pages[path].ids:
                bad.append(f"{name}: {link}: no such anchor")
    away = clicks(pages)
    bad += [f"{name}: not within three clicks of index.html" for name in pages if away.get(name, 4) > 3]
    from sphinx.search.en import SearchEnglish  # only where the site can be built
    stem, (words, entries) = SearchEnglish({}).stem, searched(folder)
    keys = set(re.findall(r"^\| `([^`]+)`", (source / "docs/keys.md").read_text(), re.M))
    if not keys:
        bad.append("docs/keys.md: no key is found in its tables")
    for key in sorted(keys):
        if key.lower() not in entries:
            bad.append(f"search does not lead to the key {key}")
        for word in re.findall(r"\w\w\w+", key):  # as the search takes a key apart; it knows no shorter words
            if not {word.lower(), stem(word.lower())} & words:
                bad.append(f"search does not find {word} of the key {key}")
    return bad, f"{len(pages)} pages within {max(away.values())} clicks, {links} links, {len(keys)} keys to be searched"


def main():
    if sys.argv[1] == "--html":
        bad, what = check_site(pathlib.Path(sys.argv[2]), pathlib.Path(__file__).resolve().parents[2])
    else:
        bad, what = check_pages(pathlib.Path(sys.argv[1]).resolve())
    print("\n".join(bad) or f"links: {what}: all lead somewhere")
    return bool(bad)


if __name__ == "__main__":
    sys.exit(main())
