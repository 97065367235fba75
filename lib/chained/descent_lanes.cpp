#include "chained/descent_lanes.h"

namespace surveymc::chained::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;

ToolFrame<T> load_frame(const double* row) {
  T x[6];
  for (int i = 0; i < 6; ++i) x[i] = load<T>(row + i * kGroup);
  return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
}
void store_frame(double* row, const ToolFrame<T>& frame) {
  const T x[6] = {frame.n.x, frame.n.y, frame.n.z, frame.d.x, frame.d.y, frame.d.z};
  for (int i = 0; i < 6; ++i) store(row + i * kGroup, x[i]);
}
void store_end(double* row, const DescentEnd<T>& end) {
  store(row, end.cost);
  store(row + kGroup, end.iterations);
  store(row + 2 * kGroup, end.status);
}

}  // namespace

void descend_chains(const ChainDescentBatch& b) {
  static_assert(sizeof(DescentMemory<T>) <= kDescentScratch * sizeof(double));
  auto* memory = reinterpret_cast<DescentMemory<T>*>(b.scratch);
  for (std::size_t group = 0; group < static_cast<std::size_t>(b.groups); ++group)
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(kGroup); lane += lane_count<T>) {
      double* points = b.points + group * b.points_stride + lane;
      const auto row = [&](int k) { return points + static_cast<std::size_t>(kPointRows * k) * kGroup; };
      for (int k = 0; k < b.model.stations; ++k) {
        memory[k].frame = load_frame(row(k));
        for (std::size_t i = 0; i < kChainStates; ++i) memory[k].c[i] = load<T>(row(k) + (6 + i) * kGroup);
      }
      ChainDescent<T> chain(b.model, memory);
      store_end(b.outcome.rows + group * b.outcome.stride + lane, descend(chain, b.options));
      for (int k = 0; k < b.model.stations; ++k) {
        store_frame(row(k), memory[k].frame);
        for (std::size_t i = 0; i < kChainStates; ++i) store(row(k) + (6 + i) * kGroup, memory[k].c[i]);
      }
    }
}

void descend_attitudes(const AttitudeDescentBatch& b) {
  for (std::size_t k = 0; k < static_cast<std::size_t>(b.model.stations); ++k)
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(kGroup); lane += lane_count<T>) {
      double* frames = b.frames + k * b.frames_stride + lane;
      AttitudeDescent<T> attitude(b.model, static_cast<int>(k), load_frame(frames));
      store_end(b.outcome.rows + k * b.outcome.stride + lane, descend(attitude, b.options));
      store_frame(frames, attitude.frame());
    }
}

void descend_offsets(const OffsetDescentBatch& b) {
  for (std::size_t lane = 0; lane < static_cast<std::size_t>(kGroup); lane += lane_count<T>) {
    std::array<T, 6> x;
    for (std::size_t i = 0; i < 6; ++i) x[i] = load<T>(b.offsets + i * kGroup + lane);
    OffsetDescent<T> offsets(b.model, x);
    store_end(b.outcome.rows + lane, descend(offsets, b.options));
    for (std::size_t i = 0; i < 6; ++i) store(b.offsets + i * kGroup + lane, offsets.offsets()[i]);
  }
}

}  // namespace surveymc::chained::SURVEYMC_ISA
