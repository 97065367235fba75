#pragma once
#include <vector>

#include "analysis/estimate_warnings.h"
#include "analysis/readings_analysis.h"
#include "analysis/readings_tests.h"
#include "store/table.h"

namespace surveymc::studies::estimate {

/// Table `warnings`.
store::Table warnings_table(const std::vector<analysis::Warning>& warnings);

/// The tables of an estimate result, in the order of docs/results-format.md.
std::vector<store::Table> result_tables(const survey::SixAxisReadings& readings, const survey::ReferenceField& field,
                                        const analysis::ReadingsAnalysis& analysis, const analysis::TestLevels& levels,
                                        const std::vector<analysis::ReadingsTest>& tests,
                                        const std::optional<analysis::Suspect>& examined,
                                        const std::vector<analysis::Warning>& warnings);

}  // namespace surveymc::studies::estimate
