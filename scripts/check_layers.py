#!/usr/bin/python3
"""Fail if the tree is not as docs/architecture.md draws it. Run by ctest and .ci/run.

  * A module of lib/ includes only what it lists in lib/CMakeLists.txt, and lists only modules below it.
  * A study includes lib/ and its own folder; no module includes a study.
  * Heavy headers (TOML, HDF5, MPI, ...) are read by the module that owns them.
  * The namespace of a file is its folder: lib/stats is surveymc::stats, experiments/estimate surveymc::studies::estimate.
    lib/base is surveymc itself.
  * No type, alias, constant or concept is defined twice in one namespace.

`check_layers.py --kernels OBJECT...` looks at objects compiled for AVX-512 instead: none may hold a function that the
linker could take for others, too, or a machine without AVX-512 would run it."""
import collections
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from surveymc import streams  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent
LAYERS = ["base simd", "earth survey random disturbance stats error_model orders", "sensor estimate multistation single_station chained propagate reliability monitoring rare",
          "analysis proximity montecarlo config store render checkpoint mpi", "compare scenario", "study", "events sweep", "cli"]
OWNER = {"toml++/": "config", "hdf5": "store", "H5": "store", "omp.h": "montecarlo", "mpi.h": "mpi",
         "nlopt": "estimate chained", "Random123/": "random", "GeographicLib/": "earth", "CLI/": "cli"}
WITHIN_LAYER = {("simd", "base"), ("disturbance", "survey"), ("disturbance", "random"), ("stats", "random"), ("orders", "stats"), ("multistation", "estimate"), ("single_station", "estimate"), ("chained", "estimate"), ("checkpoint", "montecarlo"),
                ("checkpoint", "config"), ("checkpoint", "store"), ("render", "store"), ("mpi", "montecarlo"), ("scenario", "compare")}


def listed_dependencies(text):
    """{module: modules that its DEPENDS names} in the order of the file."""
    depends = {}
    for body in re.findall(r"^\s*surveymc_module\(([^)]*)\)", text, re.M):
        words = body.split()
        public = []
        if "DEPENDS" in words:
            for word in words[words.index("DEPENDS") + 1:]:
                if word == "PRIVATE_DEPENDS":
                    break
                public.append(word)
        depends[words[0]] = {d for d in public if "::" not in d}
    return depends


def bad_dependencies(depends, layer):
    for module, names in depends.items():
        if module not in layer:
            yield f"lib/CMakeLists.txt: module {module} is in no layer of scripts/check_layers.py"
            continue
        for d in sorted(names):
            if d not in depends:
                yield f"lib/CMakeLists.txt: {module} depends on unknown module {d}"
            elif layer[d] > layer[module] or (layer[d] == layer[module] and (module, d) not in WITHIN_LAYER):
                yield f"lib/CMakeLists.txt: {module} depends on {d}, which is not below it"


def reachable(depends, module):
    seen, todo = {module}, [module]
    while todo:
        for d in depends.get(todo.pop(), ()):
            if d not in seen:
                seen.add(d)
                todo.append(d)
    return seen


def bad_includes(path, text, depends, studies):
    parts = path.parts
    of_lib = parts[0] == "lib"
    module = parts[1]
    allowed = reachable(depends, module) if of_lib else set(depends)
    for number, line in enumerate(text.split("\n"), 1):
        m = re.match(r'\s*#\s*include\s*(["<])([^">]+)[">]', line)
        if not m:
            continue
        name = m.group(2)
        for header, owner in OWNER.items():
            if name.startswith(header) and not (of_lib and module in owner.split()):
                yield f"{path}:{number}: {name} may be included by {owner} only"
        if m.group(1) == "<":
            continue
        first = name.split("/")[0]
        if of_lib:
            if first in studies and first not in depends:
                yield f"{path}:{number}: a module must not include a study"
            elif "/" in name and first not in allowed:
                yield f"{path}:{number}: {module} does not depend on {first} (lib/CMakeLists.txt)"
        elif len(parts) > 2 and not (ROOT / "lib" / name).exists() and first != module:
            yield f"{path}:{number}: a study includes lib/ and its own folder, not {name}"
        elif len(parts) > 2 and first == "cli":
            yield f"{path}:{number}: a study knows nothing of the command line"


def namespace_of(path):
    if path.parts[0] == "lib":
        return "surveymc" if path.parts[1] == "base" else f"surveymc::{path.parts[1]}"
    return "surveymc::studies" + (f"::{path.parts[1]}" if len(path.parts) > 2 else "")


def opened_namespaces(text):
    """Whole names of the namespaces that a file opens at its outermost level."""
    return re.findall(r"^namespace ([\w:]+) \{", text, re.M)


def definitions(text):
    """(name, what) at the level of the file's namespace; clang-format puts nothing else at the first column. What is in
    an anonymous namespace of a source is its own affair."""
    depth_anonymous = 0
    for line in text.split("\n"):
        if re.match(r"namespace \{", line):
            depth_anonymous += 1
        elif re.match(r"\}  // namespace$", line):
            depth_anonymous -= 1
        if depth_anonymous > 0:
            continue
        m = re.match(r"(?:struct|class|union|enum class|enum) (\w+)(?: final)?(?: :[^:;]*)? ?\{", line)
        m = m or re.match(r"(?:struct|class|enum class|enum) (\w+)(?: final)?(?: :[^:;]*)?$", line)
        m = m or re.match(r"using (\w+) =", line)
        m = m or re.match(r"(?:inline )?constexpr [^=;(]*?\b(k[A-Z]\w*)(?:\{|\s*=)", line)
        m = m or re.match(r"concept (\w+) =", line)
        if m:
            yield m.group(1)


def bad_tree():
    depends = listed_dependencies((ROOT / "lib/CMakeLists.txt").read_text())
    layer = {m: i for i, names in enumerate(LAYERS) for m in names.split()}
    yield from bad_dependencies(depends, layer)
    studies = {p.name for p in (ROOT / "experiments").iterdir() if p.is_dir()}
    where = collections.defaultdict(set)
    files = sorted(p for folder in ("lib", "experiments") for suffix in ("h", "cpp") for p in (ROOT / folder).rglob(f"*.{suffix}"))
    for file in files:
        path = file.relative_to(ROOT)
        text = file.read_text()
        if path.parts[0] == "lib" and len(path.parts) > 2 and path.parts[1] not in depends:
            yield f"{path}: module {path.parts[1]} is not in lib/CMakeLists.txt"
        if len(path.parts) > 2 or path.parts[0] == "experiments":
            yield from bad_includes(path, text, depends, studies)
        if len(path.parts) == 2 and path.name not in ("registry.h", "registry.cpp"):
            continue  # main programs, and what is precompiled
        space = namespace_of(path)
        for opened in opened_namespaces(text):
            if opened.startswith("surveymc") and opened not in (space, f"{space}::SURVEYMC_ISA"):
                yield f"{path}: opens namespace {opened}: its folder says {space}"
        if f"namespace {space} {{" not in text and f"namespace {space}::SURVEYMC_ISA {{" not in text:
            yield f"{path}: is not in namespace {space}"
        for name in set(definitions(text)):
            where[space, name].add(str(path))
    for (space, name), paths in sorted(where.items()):
        if len(paths) > 1:
            yield f"{space}::{name} is defined in {', '.join(sorted(paths))}"
    print(f"{len(depends)} modules, {len(studies)} studies, {len(files)} files", end=": ")


def shared_functions(objects):
    """Functions of the objects that the linker could take for others: weak ones that do not carry their instruction
    set's name."""
    for o in objects:
        for line in subprocess.run(["nm", "-C", "--defined-only", o], capture_output=True, text=True, check=True).stdout.splitlines():
            kind, name = line[17:18], line[19:]
            if kind in "WVu" and "isa_v4" not in name:
                yield f"{pathlib.Path(o).name}: {name} may be linked into code for lesser machines"


def main():
    if sys.argv[1:2] == ["--kernels"]:
        if not sys.argv[2:]:
            sys.exit("check_layers.py --kernels: no object was given: nothing is checked")
        bad = sorted(set(shared_functions(sys.argv[2:])))
        print(f"{len(sys.argv) - 2} objects for AVX-512", end=": ")
    else:
        bad = list(bad_tree())
    print(f"{len(bad)} faults" if bad else "layers hold")
    for b in bad:
        print(b)
    return 1 if bad else 0


streams.run(main)
