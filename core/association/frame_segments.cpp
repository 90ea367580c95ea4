#include "core/association/frame_segments.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace steadymap {
namespace {

// The plane of a sample at an edge may be unknown, so a link may skip one whose depth is on the
// way.
constexpr int kMaxLinkSamples = 2;

// Of the spacing of samples on a surface that faces the camera. On surface that is seen at a flat
// angle, samples are so far apart that a gap between two objects can lie between them.
constexpr double kSpacingSlack = 2.0;

/// Disjoint sets of samples, each with its lowest index as root.
class SampleSets {
 public:
  explicit SampleSets(std::size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), std::size_t{0});
  }

  std::size_t RootOf(std::size_t index) {
    while (parents_[index] != index) {
      parents_[index] = parents_[parents_[index]];
      index = parents_[index];
    }
    return index;
  }

  void Join(std::size_t a, std::size_t b) {
    a = RootOf(a);
    b = RootOf(b);
    parents_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> parents_;
};

bool HaveOneKey(const SurfaceSample& a, const SurfaceSample& b) {
  return a.instance == b.instance && (a.instance != 0 || a.label == b.label);
}

/// Tells whether two samples are on one surface.
class Continuity {
 public:
  Continuity(const SemanticCloud& cloud, double max_sigmas)
      : cloud_(cloud),
        max_sigmas_(max_sigmas),
        spacing_per_m_(SampleGrid::SpacingPerM(cloud.camera())) {}

  /// True if each of two samples, `steps` apart in the grid, is on the plane of the other one and
  /// as close as the spacing of the rays allows.
  bool Joins(const SurfaceSample& a, const SurfaceSample& b, int steps) const {
    const Eigen::Vector3d way = (b.position_world - a.position_world).cast<double>();
    const double depth_m = static_cast<double>(std::max(a.depth_m, b.depth_m));
    const double noise_m = max_sigmas_ * M_SQRT2 * cloud_.CellSigmaM(depth_m);
    const double spacing_m = spacing_per_m_ * depth_m;
    // Within one instance there is no gap to miss, and the spacing grows with the slant.
    const double reach_m =
        kSpacingSlack * steps *
        (a.instance == 0 ? spacing_m
                         : static_cast<double>(std::max(a.area_m2, b.area_m2)) / spacing_m);
    if (way.norm() > reach_m + noise_m / max_sigmas_) return false;
    // At an edge between two faces, a neighbour is as far from the plane as from the sample.
    const double limit_m = noise_m + steps * spacing_m;
    return std::abs(way.dot(a.normal_world.cast<double>())) < limit_m &&
           std::abs(way.dot(b.normal_world.cast<double>())) < limit_m;
  }

  /// True if the cell at a sample without a plane is on the line between its two neighbours.
  bool IsBetween(int column, int row, const SurfaceSample& a, const SurfaceSample& b) const {
    const SurfaceCell& cell =
        cloud_.At(column * SampleGrid::kStrideCells, row * SampleGrid::kStrideCells);
    if (!(cell.depth_m > 0.0F)) return false;
    const float expected_m = 2.0F / (1.0F / a.depth_m + 1.0F / b.depth_m);
    // The noise of one depth and of the mean of two.
    const double sigma_m = std::sqrt(1.5) * cloud_.CellSigmaM(static_cast<double>(expected_m));
    return static_cast<double>(std::abs(cell.depth_m - expected_m)) <= max_sigmas_ * sigma_m;
  }

 private:
  const SemanticCloud& cloud_;
  double max_sigmas_;
  double spacing_per_m_;  ///< Of samples, at a depth of one metre.
};

/// Adds the surface that a frame sees at flat angles to adjacent segments of the same instance: the
/// depth does not tell what is connected there, but the instance does.
class FlatAngleSurface {
 public:
  FlatAngleSurface(const Continuity& continuity,
                   const SampleGrid& samples,
                   const std::vector<SampleUse>& uses)
      : continuity_(continuity), samples_(samples), uses_(uses), is_taken_(samples.size(), 0) {}

  /// Appends the samples that are connected to those of a segment.
  void AddTo(std::vector<std::size_t>* segment) {
    const auto columns = static_cast<std::size_t>(samples_.width());
    for (std::size_t next = 0; next < segment->size(); ++next) {
      const std::size_t from = (*segment)[next];
      if (from % columns > 0) Reach(from, from - 1, segment);
      if (from % columns + 1 < columns) Reach(from, from + 1, segment);
      if (from >= columns) Reach(from, from - columns, segment);
      if (from + columns < samples_.size()) Reach(from, from + columns, segment);
    }
  }

 private:
  void Reach(std::size_t from, std::size_t index, std::vector<std::size_t>* segment) {
    const SurfaceSample& sample = samples_[index];
    if (is_taken_[index] != 0 || !sample.is_valid() || uses_[index] != SampleUse::kSurface) return;
    if (!HaveOneKey(samples_[from], sample) || !continuity_.Joins(samples_[from], sample, 1))
      return;
    is_taken_[index] = 1;
    segment->push_back(index);
  }

  const Continuity& continuity_;
  const SampleGrid& samples_;
  const std::vector<SampleUse>& uses_;
  std::vector<char> is_taken_;
};

FrameSegment MakeSegment(const SampleGrid& samples, std::vector<std::size_t> indices) {
  FrameSegment segment;
  std::map<std::uint16_t, std::size_t> labels;
  for (const std::size_t index : indices) {
    ++labels[samples[index].label];
    segment.area_m2 += static_cast<double>(samples[index].area_m2);
  }
  segment.label = std::max_element(labels.begin(), labels.end(), [](const auto& a, const auto& b) {
                    return a.second < b.second;
                  })->first;
  segment.instance = samples[indices.front()].instance;
  segment.samples = std::move(indices);
  return segment;
}

}  // namespace

bool IsLabelledBackground(const MapConfig& config, const SurfaceSample& sample) {
  return sample.instance == 0 && config.IsInBackground(ClassId(sample.label));
}

std::vector<FrameSegment> FindFrameSegments(const SemanticCloud& cloud,
                                            const SampleGrid& samples,
                                            const std::vector<SampleUse>& uses,
                                            const ContinuityParameters& parameters) {
  SampleSets sets(samples.size());
  const Continuity continuity(cloud, parameters.max_sigmas);
  const auto is_in = [&](std::size_t index) {
    return samples[index].is_valid() && uses[index] == SampleUse::kSegment;
  };
  const auto link = [&](int column, int row, int right, int down) {
    const SurfaceSample& sample = samples.At(column, row);
    for (int step = 1; step <= kMaxLinkSamples; ++step) {
      const int u = column + step * right;
      const int v = row + step * down;
      if (u >= samples.width() || v >= samples.height()) return;
      const SurfaceSample& other = samples.At(u, v);
      if (!is_in(samples.Index(u, v))) continue;
      if (HaveOneKey(sample, other) &&
          (step == 1 || continuity.IsBetween(column + right, row + down, sample, other)) &&
          continuity.Joins(sample, other, step)) {
        sets.Join(samples.Index(column, row), samples.Index(u, v));
      }
      return;
    }
  };
  for (int row = 0; row < samples.height(); ++row) {
    for (int column = 0; column < samples.width(); ++column) {
      if (!is_in(samples.Index(column, row))) continue;
      link(column, row, 1, 0);
      link(column, row, 0, 1);
    }
  }
  std::map<std::size_t, std::vector<std::size_t>> by_root;
  for (std::size_t index = 0; index < samples.size(); ++index) {
    if (is_in(index)) by_root[sets.RootOf(index)].push_back(index);
  }
  std::erase_if(by_root,
                [&](const auto& set) { return set.second.size() < parameters.min_samples; });
  FlatAngleSurface flat(continuity, samples, uses);
  for (auto& [root, indices] : by_root) {
    if (samples[indices.front()].instance == 0) continue;
    flat.AddTo(&indices);
    std::sort(indices.begin(), indices.end());
  }
  std::vector<FrameSegment> segments;
  segments.reserve(by_root.size());
  for (auto& [root, indices] : by_root)
    segments.push_back(MakeSegment(samples, std::move(indices)));
  return segments;
}

}  // namespace steadymap
