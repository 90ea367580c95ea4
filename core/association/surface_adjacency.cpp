#include "core/association/surface_adjacency.h"

#include <algorithm>
#include <map>
#include <utility>

namespace steadymap {
namespace {

/// The instance that most of an owner's samples show; of equals the lowest.
std::map<std::uint32_t, std::uint16_t> MainInstances(const SampleGrid& samples,
                                                     const Association& association) {
  std::map<std::uint32_t, std::map<std::uint16_t, std::size_t>> counts;
  for (std::size_t index = 0; index < samples.size(); ++index) {
    const std::uint32_t owner = association.owner[index];
    if (samples[index].is_valid() && Association::IsObject(owner))
      ++counts[owner][samples[index].instance];
  }
  std::map<std::uint32_t, std::uint16_t> main;
  for (const auto& [owner, instances] : counts) {
    const auto fewer = [](const auto& a, const auto& b) { return a.second < b.second; };
    main[owner] = std::max_element(instances.begin(), instances.end(), fewer)->first;
  }
  return main;
}

}  // namespace

std::vector<Contact> FindSurfaceAdjacencies(const SampleGrid& samples,
                                            const Association& association) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> counts;
  const auto count = [&](std::size_t a, std::size_t b) {
    const std::uint32_t first = association.owner[a];
    const std::uint32_t second = association.owner[b];
    if (first != second && Association::IsObject(first) && Association::IsObject(second) &&
        AreConnected(samples[a], samples[b])) {
      ++counts[std::minmax(first, second)];
    }
  };
  for (int row = 0; row + 1 < samples.height(); ++row) {
    for (int column = 0; column + 1 < samples.width(); ++column) {
      count(samples.Index(column, row), samples.Index(column + 1, row));
      count(samples.Index(column, row), samples.Index(column, row + 1));
    }
  }
  if (counts.empty()) return {};
  const std::map<std::uint32_t, std::uint16_t> instances = MainInstances(samples, association);
  std::vector<Contact> contacts;
  contacts.reserve(counts.size());
  for (const auto& [owners, found] : counts) {
    if (instances.at(owners.first) != instances.at(owners.second)) continue;
    contacts.push_back({owners.first, owners.second, found});
  }
  return contacts;
}

}  // namespace steadymap
