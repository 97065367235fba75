#pragma once
#include <vector>

#include "estimate_warnings.h"
#include "readings_analysis.h"
#include "readings_tests.h"
#include "store/table.h"

namespace surveymc {

/// Table `warnings`.
Table warnings_table(const std::vector<EstimateWarning>& warnings);

/// The tables of an estimate result, in the order of docs/results-format.md.
std::vector<Table> estimate_tables(const SixAxisReadings& readings, const ReferenceField& field,
                                   const ReadingsAnalysis& analysis, const TestLevels& levels,
                                   const std::vector<ReadingsTest>& tests, const std::optional<Suspect>& examined,
                                   const std::vector<EstimateWarning>& warnings);

}  // namespace surveymc
