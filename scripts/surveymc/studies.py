"""What is known of the experiments (studies.toml), of the configs, and of which drawers make the figures of a result."""

import dataclasses
import os
import re
import tomllib

PACKAGE = os.path.dirname(os.path.realpath(__file__))
_IN_WHEEL = os.path.join(PACKAGE, "_native", "share", "surveymc")
#: Of the source tree, or share/surveymc.
ROOT = _IN_WHEEL if os.path.isdir(_IN_WHEEL) else os.path.dirname(os.path.dirname(PACKAGE))
SWEEP_CAPTION = "The sweep as a whole: a quantity against the keys that vary."
NOT_STUDIES = ("bench", "smoke", "examples", "new", "error_models")  # folders of configs/


@dataclasses.dataclass
class Study:
    """One table of studies.toml."""

    experiment: str
    order: int
    name: str
    source: str = ""
    question: str = ""
    read: str = ""
    plots: list = dataclasses.field(default_factory=list)
    plots_for: dict = dataclasses.field(default_factory=dict)
    sweep: list = dataclasses.field(default_factory=list)
    quick_trials: int = 1000
    trial_us: float = 50.0
    run_s: float = 0.0
    fold: list = dataclasses.field(default_factory=list)
    figures: dict = dataclasses.field(default_factory=dict)
    headline: list = dataclasses.field(default_factory=list)

    def headline_rank(self, path):
        """Place of the result's finding among those at the head of the report: those of studies.toml first."""
        name = os.path.splitext(os.path.basename(path))[0]
        place = self.headline[1:].index(name) if name in self.headline[1:] else 50
        return 10000 * (self.headline[0] if self.headline else 9) + 100 * self.order + place

    def drawers_for(self, path):
        """Drawers of the result in this file."""
        return self.plots_for.get(os.path.splitext(os.path.basename(path))[0], self.plots)

    def caption(self, suffix):
        """The caption of figure <result>_<suffix>; a sentence from its name if none is declared."""
        suffix = re.sub(r"^point\d+_", "", suffix)
        fitting = [k for k in self.figures if suffix == k or (k and suffix.startswith(k))]
        if fitting:
            return self.figures[max(fitting, key=len)]
        if suffix.startswith("sweep_"):
            return SWEEP_CAPTION
        return f"{suffix.replace('_', ' ').capitalize() or self.name}."


def is_source(root=ROOT):
    """Whether the package is that of a source tree, where results go to results/; otherwise they are installed."""
    return os.path.exists(os.path.join(root, "CMakeLists.txt"))


def load(path=os.path.join(PACKAGE, "studies.toml")):
    """All declared studies by experiment, in the order of the report."""
    with open(path, "rb") as file:
        return {k: Study(k, i, **v) for i, (k, v) in enumerate(tomllib.load(file).items())}


def study_of(studies, experiment):
    """The study of an experiment; one made from its name if it is not declared."""
    if experiment in studies:
        return studies[experiment]
    return Study(experiment, len(studies), experiment.replace("_", " ").capitalize(),
                 plots=[experiment] if os.path.exists(os.path.join(PACKAGE, "plots", f"{experiment}.py")) else [])


def configs(root=ROOT):
    """Configs of all studies: paths relative to the project, by folder and name."""
    folder = os.path.join(root, "configs")
    return sorted(os.path.join("configs", part, name)
                  for part in os.listdir(folder) if part not in NOT_STUDIES and os.path.isdir(os.path.join(folder, part))
                  for name in os.listdir(os.path.join(folder, part)) if name.endswith(".toml"))


def config_of(command, title, root=ROOT):
    """The config of the project that a result's command names, or that has its title; "" if there is none."""
    named = re.search(r"\brun (\S+\.toml)", command)
    name = named[1] if named else ""
    if name.startswith("configs/") and os.path.exists(os.path.join(root, name)):
        return name
    folder = os.path.join(root, "configs")
    for part in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:  # the package alone has no configs
        path = os.path.join("configs", part, os.path.basename(name))
        if name and title and os.path.isfile(os.path.join(root, path)):
            with open(os.path.join(root, path), encoding="utf-8") as file:
                if f'title = "{title}"' in file.read():
                    return path
    return ""


def description(config, root=ROOT):
    """The comment at the head of a config, its lines joined; lines that are indented stay lines of their own."""
    lines = []
    with open(os.path.join(root, config), encoding="utf-8") as file:
        for line in file:
            if not line.startswith("#"):
                break
            text = line[1:].rstrip()
            lines.append(text[1:] if text.startswith(" ") else text)
    paragraphs = [""]
    for line in lines:
        if line.startswith("  "):
            paragraphs.append(line)
        elif paragraphs[-1].startswith("  ") or not line:
            paragraphs.append(line)
        else:
            paragraphs[-1] = f"{paragraphs[-1]} {line}".strip()
    return [p for p in paragraphs if p.strip()]
