#!/usr/bin/python3
"""The recipes of packaging/ and the Containerfile are of this version, and depend on what CMake asks for: test_recipes.py SOURCE"""
import ast
import pathlib
import re
import sys
import tomllib

import jinja2
import yaml

source = pathlib.Path(sys.argv[1])
cmake = (source / "CMakeLists.txt").read_text()
version = re.search(r"^project\(surveymc VERSION ([\d.]+)", cmake, re.M)[1]
found = set(re.findall(r"find_package\((\w+)", cmake)) - {"Threads", "OpenMP", "MPI"} | {"xxhash"}  # xxhash.h is looked for by the compiler
assert {"Eigen3", "HDF5", "NLopt", "fmt", "CLI11", "tomlplusplus", "Boost", "GeographicLib"} <= found, found
CONDA = {"Eigen3": "eigen", "HDF5": "hdf5", "NLopt": "nlopt", "fmt": "fmt", "CLI11": "cli11", "tomlplusplus": "tomlplusplus",
         "Boost": "libboost-headers", "GeographicLib": "geographiclib-cpp", "xxhash": "xxhash"}
SPACK = {**{k: k.lower() for k in CONDA}, "Eigen3": "eigen"}

project = tomllib.loads((source / "pyproject.toml").read_text())["project"]
python_only = tomllib.loads((source / "scripts/pyproject.toml").read_text())["project"]
assert project["version"] == python_only["version"] == version and project["dependencies"] == python_only["dependencies"]
asked = {re.match(r"[a-z0-9]+", d)[0]: re.search(r">=[\d.]+|$", d)[0] for d in project["dependencies"]}

text = (source / "packaging/conda-forge/meta.yaml").read_text()
recipe = yaml.safe_load(jinja2.Environment().from_string(text).render(compiler=lambda x: f"compiler_{x}", stdlib=lambda x: f"stdlib_{x}"))
assert recipe["package"] == {"name": "surveymc", "version": version}
assert set(recipe["requirements"]["host"]) == {CONDA[name] for name in found} | {"python"}, recipe["requirements"]["host"]
names = {"matplotlib": "matplotlib-base", "xxhash": "python-xxhash"}
runs = {d.split()[0]: "".join(d.split()[1:]) for d in recipe["requirements"]["run"]}
assert runs == {"python": project["requires-python"], **{names.get(n, n): least for n, least in asked.items()}}, runs
for path in recipe["about"]["license_file"]:
    assert (source / path).exists(), path

tree = ast.parse((source / "packaging/spack/package.py").read_text())
(package,) = [node for node in tree.body if isinstance(node, ast.ClassDef)]
calls = [(node.func.id, node.args[0].value, {k.arg: ast.unparse(k.value) for k in node.keywords}) for node in ast.walk(package)
         if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.args and isinstance(node.args[0], ast.Constant)]
assert [name for function, name, _ in calls if function == "version"] == [version]
depends = {re.match(r"[\w-]+", name)[0]: more for function, name, more in calls if function == "depends_on"}
assert {name for name, more in depends.items() if "type" not in more} == {SPACK[name] for name in found} | {"mpi"}, depends
assert {name.removeprefix("py-") for name in depends if name.startswith("py-")} == set(asked)
options = set(re.findall(r"option\((\w+)", cmake)) | set(re.findall(r"set\((\w+) ", cmake))
for recipe_text in (text, (source / "packaging/spack/package.py").read_text(), (source / "cmake/wheel_backend.py").read_text()):
    for option in re.findall(r"SURVEYMC_[A-Z_]+", recipe_text):
        assert option in options | {"SURVEYMC_PYTHON_DIR", "SURVEYMC_PYTHON"}, option

image = (source / "Containerfile").read_text()
assert f'org.opencontainers.image.version="{version}"' in image
assert re.findall(r"(?m)^USER (?!root|0)\w+$", image) == re.findall(r"(?m)^USER .*$", image) != []
print(f"recipes and image of {version}")
