#pragma once
/// The publications that studies follow, for `surveymc cite`. CITATION.cff lists the same
/// (tests/docs/check_citation.py).
#include <string>
#include <vector>

#include "store/result_file.h"

namespace surveymc::cli {

struct Source {
  std::string id;                    ///< "vis2019"
  std::string type;                  ///< of BibTeX: "article", "techreport", "phdthesis", "misc"
  std::vector<std::string> authors;  ///< "S. Vis"; an organisation as it is
  std::string title, where;          ///< `where`: journal, school, or who has published it
  std::string volume = {}, number = {}, pages = {};
  int year = 0;  ///< 0: not said
  std::string doi = {};
};

/// The sources that a result of this experiment and config stands on: those of its study, and of the error models of
/// gyros and the geomagnetic model where the config names them.
std::vector<Source> sources_of(const store::Provenance& p);

}  // namespace surveymc::cli
