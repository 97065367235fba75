#include "cli/sources.h"

#include <algorithm>

namespace surveymc::cli {
namespace {

struct Followed {
  Source source;
  std::vector<std::string> experiments;  ///< none: any
  std::string if_config_has = {};
};

const std::vector<Followed>& all_sources() {
  static const std::string kIscwsa = "Industry Steering Committee on Wellbore Survey Accuracy";
  static const std::vector<std::string> kOfTools{"position_covariance",     "tool_code_map", "corrected_codes",
                                                 "error_model_monte_carlo", "clearance",     "collision"};
  static const std::vector<std::string> kOfTerms{
      "position_covariance", "tool_code_map", "corrected_codes", "error_model_monte_carlo",
      "clearance",           "collision",     "msa_benefit",     "sensor_monte_carlo"};
  static const std::vector<Followed> kAll{
      {{.id = "vis2019",
        .type = "misc",
        .authors = {"S. Vis"},
        .title = "Uncertainty analysis in determining the position of a drill bit with the covariance method",
        .where = "bachelor thesis, TU Delft",
        .year = 2019},
       {"msa_position", "msa_benefit", "estimate", "position_covariance", "corrected_codes"}},
      {{.id = "baarda1968",
        .type = "techreport",
        .authors = {"W. Baarda"},
        .title = "A testing procedure for use in geodetic networks",
        .where = "Netherlands Geodetic Commission, New Series",
        .volume = "2",
        .number = "5",
        .year = 1968},
       {"estimate", "gross_error_detection"}},
      {{.id = "williamson2000",
        .type = "article",
        .authors = {"H. S. Williamson"},
        .title = "Accuracy prediction for directional measurement while drilling",
        .where = "SPE Drilling & Completion",
        .volume = "15",
        .number = "4",
        .pages = "221-233",
        .year = 2000,
        .doi = "10.2118/67616-PA"},
       kOfTerms},
      {{.id = "iscwsa2022",
        .type = "misc",
        .authors = {kIscwsa},
        .title = "ISCWSA MWD error model, Revisions 4 and 5.10",
        .where = "iscwsa.net",
        .year = 2022},
       kOfTerms},
      {{.id = "owsg2020",
        .type = "misc",
        .authors = {"Operators Wellbore Survey Group"},
        .title = "OWSG tool codes, sets A and B, revision 5.1",
        .where = "iscwsa.net",
        .year = 2020},
       kOfTools},
      {{.id = "torkildsen2008",
        .type = "article",
        .authors = {"T. Torkildsen", "S. T. Håvardstein", "J. L. Weston", "R. Ekseth"},
        .title = "Prediction of wellbore position accuracy when surveyed with gyroscopic tools",
        .where = "SPE Drilling & Completion",
        .volume = "23",
        .number = "1",
        .pages = "5-12",
        .year = 2008,
        .doi = "10.2118/90408-PA"},
       kOfTools,
       "GYRO"},
      {{.id = "nyrnes2009",
        .type = "misc",
        .authors = {"E. Nyrnes", "T. Torkildsen", "H. Wilson"},
        .title = "Minimum requirements for multi-station analysis of MWD magnetic directional surveys",
        .where = "SPE 125677",
        .year = 2009,
        .doi = "10.2118/125677-MS"},
       {"corrected_codes"}},
      {{.id = "sawaryn2019",
        .type = "article",
        .authors = {"S. J. Sawaryn", "H. Wilson", "J. Bang", "E. Nyrnes", "A. Sentance", "B. Poedjono", "R. Lowdon",
                    "I. Mitchell", "J. Codling", "P. J. Clark", "W. T. Allen"},
        .title = "Well-collision-avoidance separation rule",
        .where = "SPE Drilling & Completion",
        .volume = "34",
        .number = "1",
        .pages = "1-15",
        .year = 2019,
        .doi = "10.2118/187073-PA"},
       {"clearance", "collision"}},
      {{.id = "rozsas2019",
        .type = "misc",
        .authors = {"A. Rozsas", "A. Slobbe"},
        .title = "Repository and black-box reliability challenge 2019",
        .where = "TNO",
        .year = 2019},
       {"rare_event"}},
      {{.id = "waarts2000",
        .type = "phdthesis",
        .authors = {"P. H. Waarts"},
        .title = "Structural reliability using finite element methods: an appraisal of directional adaptive response "
                 "surface sampling",
        .where = "TU Delft",
        .year = 2000},
       {"rare_event"}},
      {{.id = "owen2019",
        .type = "article",
        .authors = {"A. B. Owen", "Y. Maximov", "M. Chertkov"},
        .title = "Importance sampling the union of rare events with an application to power systems analysis",
        .where = "Electronic Journal of Statistics",
        .volume = "13",
        .number = "1",
        .pages = "231-254",
        .year = 2019,
        .doi = "10.1214/18-EJS1527"},
       {"rare_event", "collision"}},
      {{.id = "hanak2016",
        .type = "techreport",
        .authors = {"C. Hanak"},
        .title = "Correct vertical well weighting functions for cross-axis accelerometer bias terms",
        .where = "Superior QC, LLC",
        .year = 2016},
       {"vertical_well", "sensor_monte_carlo"}},
      {{.id = "torkildsen2000",
        .type = "misc",
        .authors = {"T. Torkildsen", "J. Bang"},
        .title = "Directional surveying: rotating and sliding operations give different wellbore position accuracy",
        .where = "SPE 63275",
        .year = 2000,
        .doi = "10.2118/63275-MS"},
       {"vertical_well", "sensor_monte_carlo"}},
      {{.id = "nyrnes2005",
        .type = "article",
        .authors = {"E. Nyrnes", "T. Torkildsen", "H. Nahavandchi"},
        .title = "Detection of gross errors in wellbore directional surveying for petroleum production with emphasis "
                 "on reliability analyses",
        .where = "Kart og Plan",
        .volume = "65",
        .pages = "1-19",
        .year = 2005},
       {"reliability_map", "reliability_well", "gross_error_detection"}},
      {{.id = "boechat",
        .type = "misc",
        .authors = {"A. A. Boechat", "U. F. Moreno", "D. Haramura"},
        .title = "On-line calibration monitoring system based on data-driven model for oil well sensors",
        .where = "Federal University of Santa Catarina"},
       {"drift_monitoring", "mwd_drift"}},
      {{.id = "iscwsa_chained",
        .type = "misc",
        .authors = {kIscwsa},
        .title = "Chained multistation analysis (slides)",
        .where = "iscwsa.net"},
       {"axial_correction", "chained_multistation"}},
      {{.id = "wmm2025",
        .type = "misc",
        .authors = {"NOAA National Centers for Environmental Information", "British Geological Survey"},
        .title = "World Magnetic Model 2025",
        .where = "NOAA",
        .year = 2024},
       {},
       "\"wmm2025\""},
  };
  return kAll;
}

}  // namespace

std::vector<Source> sources_of(const store::Provenance& p) {
  std::vector<Source> out;
  for (const auto& [source, experiments, word] : all_sources()) {
    const bool is_followed =
        experiments.empty() || std::find(experiments.begin(), experiments.end(), p.experiment) != experiments.end();
    if (is_followed && (word.empty() || p.config.find(word) != std::string::npos)) out.push_back(source);
  }
  return out;
}

}  // namespace surveymc::cli
