#pragma once
/// Tables of a run of readings that an estimator of gains and biases solves; those of single stations and of chained
/// runs are made where these are solved.
#include <vector>

#include "analysis/estimate_warnings.h"
#include "analysis/readings_analysis.h"
#include "analysis/readings_profile.h"
#include "analysis/readings_tests.h"
#include "store/table.h"
#include "study/experiment.h"

namespace surveymc::studies::estimate {

/// A run of readings, solved.
class Estimate final : public study::StudyPoint {
 public:
  explicit Estimate(std::vector<store::Table> tables) : tables_(std::move(tables)) {}
  study::PointResult report(const stats::Tally&, const montecarlo::RunOptions&) const override {
    return {tables_, {}, {}};
  }

 private:
  std::vector<store::Table> tables_;
};

/// The plan of settings whose member `place` is that of the file: what its readings as a whole do not tell is said of
/// it.
template <class Settings, std::vector<store::Table> tables_of(const Settings&)>
class EstimatePlan final : public study::PlanOf<Settings> {
 public:
  using study::PlanOf<Settings>::PlanOf;
  std::unique_ptr<study::StudyPoint> prepare(const montecarlo::RunOptions&) const override {
    return this->s_.place.with_place([this] { return std::make_unique<Estimate>(tables_of(this->s_)); });
  }
};

/// Table `warnings`.
store::Table warnings_table(const std::vector<analysis::Warning>& warnings);

/// The tables of an estimate result, in the order of docs/results-format.md.
std::vector<store::Table> result_tables(const survey::SixAxisReadings& readings, const survey::ReferenceField& field,
                                        const analysis::ReadingsAnalysis& analysis, const analysis::TestLevels& levels,
                                        const std::vector<analysis::ReadingsTest>& tests,
                                        const std::optional<analysis::Suspect>& examined,
                                        const std::vector<analysis::ProfiledInterval>& profiled,
                                        const std::vector<analysis::Warning>& warnings);

}  // namespace surveymc::studies::estimate
