#!/usr/bin/python3
"""Fail if a lib/ module includes a module that it does not list in lib/CMakeLists.txt, lists one of its own or a higher
layer, or includes a heavy header that another module owns. Run by ctest and .ci/run."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
LAYERS = ["base simd", "survey field random stats", "error_model sensor estimate propagate reliability monitoring",
          "montecarlo config store checkpoint", "study"]
OWNER = {"toml++/": "config", "hdf5": "store", "H5": "store", "omp.h": "montecarlo", "mpi.h": "montecarlo",
         "nlopt": "estimate", "Random123/": "random", "CLI/": "experiments", "spdlog/": "experiments"}


def listed_dependencies(text):
    """{module: modules that its DEPENDS names} in the order of the file."""
    depends = {}
    for body in re.findall(r"^surveymc_module\(([^)]*)\)", text, re.M):
        words = body.split()
        public = []
        if "DEPENDS" in words:
            for word in words[words.index("DEPENDS") + 1:]:
                if word.isupper() or word == "PRIVATE_DEPENDS":
                    break
                public.append(word)
        depends[words[0]] = {d for d in public if "::" not in d}
    return depends


def main():
    depends = listed_dependencies((ROOT / "lib/CMakeLists.txt").read_text())
    layer = {m: i for i, names in enumerate(LAYERS) for m in names.split()}
    bad = []
    for module, names in depends.items():
        if module not in layer:
            bad.append(f"lib/CMakeLists.txt: module {module} is in no layer")
            continue
        for d in sorted(names):
            if d not in depends:
                bad.append(f"lib/CMakeLists.txt: {module} depends on unknown module {d}")
            elif layer[d] > layer[module] or (layer[d] == layer[module] and (module, d) != ("simd", "base")
                                              and list(depends).index(d) > list(depends).index(module)):
                bad.append(f"lib/CMakeLists.txt: {module} depends on {d}, which is not below it")

    def reachable(module):
        seen, todo = set(), [module]
        while todo:
            for d in depends.get(todo.pop(), ()):
                if d not in seen:
                    seen.add(d)
                    todo.append(d)
        return seen | {module}

    files = sorted([*ROOT.glob("lib/*/*.h"), *ROOT.glob("lib/*/*.cpp"), *ROOT.glob("experiments/*.h"),
                    *ROOT.glob("experiments/*.cpp")])
    for f in files:
        parts = f.relative_to(ROOT).parts
        module = parts[1] if parts[0] == "lib" else "experiments"
        if parts[0] == "lib" and module not in depends:
            bad.append(f"{f.relative_to(ROOT)}: module {module} is not in lib/CMakeLists.txt")
            continue
        allowed = reachable(module) if module in depends else set(depends)
        for n, line in enumerate(f.read_text().splitlines(), 1):
            hit = re.match(r'\s*#\s*include\s*["<]([^">]+)[">]', line)
            if not hit:
                continue
            included = hit[1]
            other = included.split("/")[0]
            if "/" in included and other in depends and other not in allowed:
                bad.append(f"{f.relative_to(ROOT)}:{n}: {module} may not include {included}: list {other} in DEPENDS")
            for prefix, owner in OWNER.items():
                if included.startswith(prefix) and module != owner:
                    bad.append(f"{f.relative_to(ROOT)}:{n}: <{included}> belongs to {owner}")
    print("\n".join(bad) or f"{len(depends)} modules, {len(files)} files: layers hold")
    return bool(bad)


if __name__ == "__main__":
    sys.exit(main())
