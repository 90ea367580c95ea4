#include "core/association/observation.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace steadymap {
namespace {

constexpr std::array<std::array<int, 2>, 4> kNeighbours = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

class SampleComponentSearch {
 public:
  SampleComponentSearch(const SampleGrid& samples, const Association& association)
      : samples_(samples), association_(association), is_done_(samples.size(), 0) {}

  std::vector<Observation> Run() {
    std::vector<Observation> observations;
    for (std::size_t index = 0; index < samples_.size(); ++index) {
      if (is_done_[index] == 0 && IsOpen(index)) observations.push_back(Grow(index));
    }
    return observations;
  }

 private:
  bool IsOpen(std::size_t index) const {
    return samples_[index].is_valid() && association_.owner[index] == Association::kNone;
  }

  static bool IsSameThing(const SurfaceSample& a, const SurfaceSample& b) {
    if (a.instance != 0 || b.instance != 0) return a.instance == b.instance;
    return a.label == b.label;
  }

  Observation Grow(std::size_t first) {
    Observation observation;
    observation.label = samples_[first].label;
    observation.instance = samples_[first].instance;
    is_done_[first] = 1;
    observation.samples.push_back(first);
    for (std::size_t next = 0; next < observation.samples.size(); ++next) {
      const std::size_t index = observation.samples[next];
      observation.area_m2 += static_cast<double>(samples_[index].area_m2);
      Visit(index, &observation);
    }
    return observation;
  }

  void Visit(std::size_t index, Observation* observation) {
    const int column = static_cast<int>(index % static_cast<std::size_t>(samples_.width()));
    const int row = static_cast<int>(index / static_cast<std::size_t>(samples_.width()));
    for (const auto& [right, down] : kNeighbours) {
      const int u = column + right;
      const int v = row + down;
      if (u < 0 || v < 0 || u >= samples_.width() || v >= samples_.height()) continue;
      const std::size_t neighbour = samples_.Index(u, v);
      if (is_done_[neighbour] != 0 || !IsOpen(neighbour) ||
          !AreConnected(samples_[index], samples_[neighbour]) ||
          !IsSameThing(samples_[index], samples_[neighbour])) {
        continue;
      }
      is_done_[neighbour] = 1;
      observation->samples.push_back(neighbour);
    }
  }

  const SampleGrid& samples_;
  const Association& association_;
  std::vector<std::uint8_t> is_done_;
};

}  // namespace

void KeepLargest(std::vector<Observation>* observations) {
  if (observations->size() <= kMaxObservations) return;
  std::vector<std::size_t> by_size(observations->size());
  std::iota(by_size.begin(), by_size.end(), std::size_t{0});
  std::stable_sort(by_size.begin(), by_size.end(), [&](std::size_t a, std::size_t b) {
    return (*observations)[a].samples.size() > (*observations)[b].samples.size();
  });
  by_size.resize(kMaxObservations);
  std::sort(by_size.begin(), by_size.end());
  std::vector<Observation> kept;
  kept.reserve(by_size.size());
  for (const std::size_t i : by_size) kept.push_back(std::move((*observations)[i]));
  *observations = std::move(kept);
}

std::vector<Observation> FindObservations(const SampleGrid& samples,
                                          const Association& association) {
  std::vector<Observation> observations = SampleComponentSearch(samples, association).Run();
  KeepLargest(&observations);
  return observations;
}

}  // namespace steadymap
