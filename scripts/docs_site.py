#!/usr/bin/python3
"""Makes the pages of docs/ ready for Sphinx: docs_site.py SOURCE FOLDER [--notebooks FOLDER] [--results FOLDER]

The front page is README.md. Pages get the list of what is below them, pages of studies their configs.
--notebooks has the notebooks with what they printed (tests/docs/test_notebook.py); without it they are shown as they are.
--results has result files: the tables of every study get their columns, as the program names them, and the gallery gets a
picture of every config of which FOLDER/report/figures has one (`surveymc studies --quick` makes both).
"""
import argparse
import json
import pathlib
import re
import shutil
import sys
import tomllib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from surveymc import storage  # noqa: E402

#: Sections of the site, and their pages in order. What no section names stands in the place of the star.
SECTIONS = {
    "Install": ["installing"],
    "Tutorials": ["tutorials/index", "notebooks/index"],
    "How-to": ["howto", "using", "report", "cluster"],
    "Studies": ["studies", "gallery"],
    "Reference": ["keys", "sweeps", "inputs", "error-model-files", "results-format", "tables/index", "comparison-tables", "show", "diff",
                  "exit-codes", "python", "conventions", "statistics", "orders", "*", "glossary"],
    "Developers": ["contributing", "architecture", "equations", "guarantees", "numerics", "performance", "developers/*"],
    "About": ["release-notes"],
}
#: Pages with a folder of pages below them.
PARENTS = {"studies": "studies", "tutorials/index": "tutorials", "notebooks/index": "notebooks", "tables/index": "tables"}


def toctree(pages, caption=None, hidden=True):
    options = ([f":caption: {caption}"] if caption else []) + ([":hidden:"] if hidden else [])
    return "\n".join(["", "```{toctree}", *options, *pages, "```", ""])


def of_the_tree(source, folder):
    """README.md as index.md, CONTRIBUTING.md as contributing.md, LICENSE and CITATION.cff as texts; and the links to them."""
    (folder / "files").mkdir()
    places = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "LICENSE": "files/LICENSE.txt", "CITATION.cff": "files/CITATION.cff.txt"}
    for name, place in places.items():
        if (source / name).exists():
            shutil.copy(source / name, folder / place)

    def moved(match):  # of a link that leads out of docs/, or is one of the tree's own pages
        up, name, rest = match.groups()
        return f"]({up}{places[name]}{rest})"
    names = "|".join(map(re.escape, places))
    for page in folder.rglob("*.md"):
        text, depth = page.read_text(), len(page.relative_to(folder).parts) - 1
        if page.name in ("index.md", "contributing.md") and depth == 0:
            text = re.sub(r"\]\(docs/", "](", text)
            text = re.sub(rf"\]\(()({names})(#[^)]*|)\)", moved, text)
        else:
            text = re.sub(rf"\]\(\.\./((?:\.\./){{{depth}}})({names})(#[^)]*|)\)", moved, text)
        page.write_text(text)


def front_page(folder):
    """The sections, below index.md."""
    text = (folder / "index.md").read_text()
    present = {p.relative_to(folder).with_suffix("").as_posix() for p in folder.rglob("*.md")} - {"index"}
    below = {page for parent, children in PARENTS.items() for page in present if page.startswith(children + "/") and page != parent}
    listed = {page for pages in SECTIONS.values() for page in pages}
    rest = sorted(p for p in present - below - listed if not p.startswith("developers/"))
    for caption, pages in SECTIONS.items():
        found = []
        for page in pages:
            if page == "*":
                found += rest
            elif page.endswith("/*"):
                found += sorted(p for p in present if p.startswith(page[:-1]))
            elif page in present:
                found.append(page)
        text += toctree(found, caption)
    (folder / "index.md").write_text(text)


def lists_below(folder):
    for parent, children in PARENTS.items():
        page = folder / f"{parent}.md"
        if page.exists():
            names = sorted(p.relative_to(page.parent).with_suffix("").as_posix() for p in (folder / children).glob("*.md") if p != page)
            if children in ("studies", "tables"):  # their titles are sentences
                names = [f"{name.rsplit('/', 1)[-1]} <{name}>" for name in names]
            page.write_text(page.read_text() + toctree(names))


def configs_of(source):
    """{study: [(path in the tree, title)]} of all configs that `surveymc studies` runs, and of the examples."""
    found = {}
    for path in sorted((source / "configs").glob("*/*.toml")):
        if path.parent.name in ("error_models", "smoke", "bench", "new"):
            continue
        try:
            config = tomllib.loads(path.read_text())
        except tomllib.TOMLDecodeError:
            continue  # the form of another file
        if "experiment" in config:
            found.setdefault(config["experiment"], []).append((path.relative_to(source).as_posix(), config.get("title", path.stem)))
    return found


def cell(text):
    return re.sub(r"\s+", " ", text).replace("|", "\\|")


def study_pages(source, folder, pictures):
    """Below each page of a study: its configs; and a page with a picture of each config."""
    configs, gallery = configs_of(source), ["# Gallery", "Pictures of configs, of quick runs with few trials; a click opens the study.", ""]
    known = tomllib.loads((source / "scripts/surveymc/studies.toml").read_text())
    for page in sorted((folder / "studies").glob("*.md")):
        study = page.stem
        of = configs.get(study, []) + (configs.get("reliability_well", []) if study == "reliability_map" else [])
        if not of:
            continue
        lines = ["", "## All configs", "| config | what it computes |", "|---|---|"]
        lines += [f"| `{path}` | {cell(title)} |" for path, title in of]
        page.write_text(page.read_text() + "\n".join(lines) + "\n")
        shown = [(path, title, pictures[path]) for path, title in of if path in pictures]
        if not shown and (folder / f"figures/studies/{study}.png").exists():
            shutil.copy(folder / f"figures/studies/{study}.png", folder / f"extra/gallery/{study}.png")
            shown = [(of[0][0], of[0][1], f"gallery/{study}.png")]
        if shown:
            gallery += [f"## {known.get(study, {}).get('name', study)}", '<div class="gallery">', ""]
            gallery += [f'<figure><a href="studies/{study}.html"><img src="{picture}" alt="{html(title)}" loading="lazy"></a>'
                        f"<figcaption>{html(title)}<br><code>{path}</code></figcaption></figure>" for path, title, picture in shown]
            gallery += ["", "</div>", ""]
    (folder / "gallery.md").write_text("\n".join(gallery) + "\n")


def indexed_keys(folder):
    """Every key becomes an entry of the index, so that the search leads to its table."""
    sections = re.split(r"(?m)^(?=## )", (folder / "keys.md").read_text())
    for i, text in enumerate(sections):
        keys = re.findall(r"(?m)^\| `([^`]+)`", text)
        if keys:
            head, rest = text.split("\n", 1)
            sections[i] = "\n".join([head, "```{index} " + ", ".join(keys), "```", "", rest])
    (folder / "keys.md").write_text("".join(sections))


def html(text):
    return text.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")


def notebooks(source, folder, run):
    """Pages of the notebooks, and links to them."""
    import nbconvert
    for path in sorted((source / "docs").rglob("*.ipynb")):
        name = path.relative_to(source / "docs")
        ready = run / name if run and (run / name).exists() else path
        exporter = nbconvert.MarkdownExporter()
        text, resources = exporter.from_filename(str(ready), {"output_files_dir": f"{path.stem}_files", "unique_key": path.stem})
        page = folder / name.with_suffix(".md")
        for file, data in resources["outputs"].items():
            (page.parent / file).parent.mkdir(exist_ok=True)
            (page.parent / file).write_bytes(data)
        text = re.sub(r"<style scoped>.*?</style>\n?", "", text, flags=re.S)
        shutil.copy(path, page.parent / f"{path.stem}.ipynb.txt")
        page.write_text(text.rstrip() + f"\n\nThe notebook itself: [{path.name}]({path.stem}.ipynb.txt), to be saved as `{path.name}`.\n")
    for page in folder.rglob("*.md"):
        text = page.read_text()
        page.write_text(re.sub(r"\.ipynb\)", ".md)", text))


def columns(folder, results):
    """Below the tables of a study: every table and column of the results that are there."""
    found = {}  # study -> table -> (title, {column: (unit, meaning)})
    for path in sorted(results.rglob("*.h5")):
        try:
            file = storage.open_file(path)
        except storage.ResultError:
            continue  # damaged, or being written
        with file:
            tables = found.setdefault(file.attrs["experiment"], {})
            for name, table in file.get("tables", {}).items():
                title, known = tables.setdefault(name, (table.attrs.get("long_name", ""), {}))
                for column in table:
                    attributes = table[column].attrs
                    if column != "row" and "." not in column:  # a key of a sweep
                        known.setdefault(column, (attributes.get("units", "text"), attributes.get("long_name", "")))
    common = {name for name in {n for tables in found.values() for n in tables} if sum(name in tables for tables in found.values()) > 10}
    for study, tables in found.items():
        page = folder / f"tables/{'collision' if study == 'rare_event' else study}.md"
        if not page.exists():
            continue
        lines = ["", f"## Columns of `{study}`, as the program names them"]
        for name, (title, known) in sorted(tables.items()):
            if name not in common:
                lines += ["", f"**`{name}`**: {cell(title)}", "", "| column | unit | meaning |", "|---|---|---|"]
                lines += [f"| `{column}` | {cell(str(unit))} | {cell(str(meaning))} |" for column, (unit, meaning) in known.items()]
        page.write_text(page.read_text() + "\n".join(lines) + "\n")


def smaller(picture, to, width=640):
    """A figure as PNG of at most `width` pixels and 64 colours."""
    from PIL import Image
    to.parent.mkdir(parents=True, exist_ok=True)
    with Image.open(picture) as image:
        small = image.convert("RGB")
        small.thumbnail((width, 4 * width))
        small.quantize(64).save(to, optimize=True)


def figures_of(results, name):
    """The figures of result NAME that the report of `results` has drawn, in its order, as PNG."""
    folder = (results / "report/figures" / name).parent
    record = folder / f".{pathlib.PurePath(name).name}.figures.json"
    files = json.loads(record.read_text())["files"] if record.exists() else []
    return [path for path in (folder / pathlib.Path(file).with_suffix(".png") for file in files) if path.exists()]


def pictures_of(folder, results):
    """{path of a config in the tree: picture of the site}: the first figure of each result."""
    found = {}
    for path in sorted(results.rglob("*.h5")) if results else []:
        name = path.relative_to(results).with_suffix("").as_posix()
        figures = figures_of(results, name)
        if figures:
            to = folder / f"extra/gallery/{name.replace('/', '_')}.png"
            smaller(figures[0], to, 480)
            found[f"configs/{name}.toml"] = to.relative_to(folder / "extra").as_posix()
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("source", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--notebooks", type=pathlib.Path)
    parser.add_argument("--results", type=pathlib.Path)
    options = parser.parse_args()
    source, folder = options.source.resolve(), options.folder
    shutil.copytree(source / "docs", folder, ignore=shutil.ignore_patterns("claims", "*.ipynb"))
    shutil.copy(source / "CMakeLists.txt", folder)
    (folder / "extra/gallery").mkdir(parents=True)
    if options.results:
        columns(folder, options.results)
    study_pages(source, folder, pictures_of(folder, options.results))
    indexed_keys(folder)
    of_the_tree(source, folder)
    front_page(folder)
    notebooks(source, folder, options.notebooks)
    lists_below(folder)


if __name__ == "__main__":
    main()
