#!/usr/bin/python3
"""Makes the pictures of the pages of studies, docs/figures/studies/STUDY.png, from figures of `scripts/run_all.sh --quick`:

    scripts/draw_pictures.py results/quick [STUDY ...]
"""
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import docs_site  # noqa: E402
import surveymc  # noqa: E402

#: study: (config, which of its figures)
PICTURES = {
    "axial_correction": ("axial_correction/maps", "maps"),
    "chained_multistation": ("chained/slide11", "rms_constant"),
    "clearance": ("clearance/directions", "point0_separation"),
    "collision": ("collision/crossing", "crossing"),
    "corrected_codes": ("corrected_codes/world", "world"),
    "drift_monitoring": ("monitoring/table1", "decisions"),
    "error_model_monte_carlo": ("error_model_mc/well1", "ratio"),
    "estimate": ("examples/readings", ""),
    "gross_error_detection": ("gross_error/detection", ""),
    "msa_benefit": ("msa_benefit/building", "azimuth_ratio"),
    "msa_position": ("thesis/table9_10_11", "published"),
    "mwd_drift": ("monitoring/mwd_drift", "detection"),
    "position_covariance": ("iscwsa/well1_rev5.10", "sources"),
    "rare_event": ("rare_event/functions", "probability"),
    "reliability_map": ("reliability/fig3", "azimuth"),
    "robustness_map": ("robustness_map/breakdown", ""),
    "sensor_monte_carlo": ("sensor_monte_carlo/iscwsa_well1", "axes"),
    "tool_code_map": ("tool_codes/corrections_map", "ratio"),
    "vertical_well": ("vertical_well/fig1", "ellipses"),
}


def main():
    source, results = pathlib.Path(__file__).resolve().parents[1], pathlib.Path(sys.argv[1])
    for study in sys.argv[2:] or PICTURES:
        config, which = PICTURES[study]
        figures = docs_site.figures_of(results, config)
        with tempfile.TemporaryDirectory() as folder:
            if not figures:  # no config of `surveymc studies`
                result = surveymc.run(source / f"configs/{config}.toml")
                figures = list(map(pathlib.Path, surveymc.plot(result, folder)))
            figure = next(path for path in figures if path.stem.endswith(which))
            docs_site.smaller(figure, source / f"docs/figures/studies/{study}.png", 900)


if __name__ == "__main__":
    main()
