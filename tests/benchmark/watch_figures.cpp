#include "tests/benchmark/watch_figures.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>

namespace steadymap::benchmarks {
namespace {

using Publications = std::map<std::uint64_t, Clock::time_point>;

double SecondsBetween(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

/// Returns the time of the first report of each revision, or of a newer one.
Publications FirstSightings(const FeedRecord& feed, const std::vector<WatcherRecord>& watchers) {
  Publications published;
  const auto see = [&published](std::uint64_t revision, Clock::time_point time) {
    const auto [entry, is_new] = published.emplace(revision, time);
    if (!is_new) entry->second = std::min(entry->second, time);
  };
  for (const Sighting& commit : feed.commits) see(commit.revision, commit.time);
  for (const WatcherRecord& watcher : watchers) {
    for (const WatchedStep& step : watcher.steps) see(step.revision, step.first);
  }
  Clock::time_point newer = Clock::time_point::max();
  for (auto entry = published.rbegin(); entry != published.rend(); ++entry) {
    newer = entry->second = std::min(entry->second, newer);
  }
  return published;
}

double MostBehind(const Publications& published, const std::vector<WatchedStep>& steps) {
  double most_s = 0.0;
  auto step = steps.begin();
  for (const auto& [revision, time] : published) {
    while (step != steps.end() && step->revision < revision) ++step;
    if (step == steps.end()) return std::numeric_limits<double>::infinity();
    most_s = std::max(most_s, SecondsBetween(time, step->last));
  }
  return most_s;
}

std::uint64_t MostCommitsAStep(const Publications& published,
                               const std::vector<WatchedStep>& steps) {
  std::uint64_t most = 0;
  auto before = published.begin();
  for (const WatchedStep& step : steps) {
    const auto after = published.upper_bound(step.revision);
    most = std::max(most, static_cast<std::uint64_t>(std::distance(before, after)));
    before = after;
  }
  return most;
}

void AppendLatencies(const FeedRecord& feed,
                     const std::vector<WatchedStep>& steps,
                     std::vector<double>* latencies_s) {
  auto step = steps.begin();
  for (std::size_t i = 0; i < feed.pushed.size(); ++i) {
    while (step != steps.end() && step->revision < i + 1) ++step;
    if (step == steps.end()) return;
    latencies_s->push_back(SecondsBetween(feed.pushed[i], step->first));
  }
}

}  // namespace

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto place = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[static_cast<std::size_t>(place)];
}

WatchFigures MeasureWatch(const FeedRecord& feed, const std::vector<WatcherRecord>& watchers) {
  const Publications published = FirstSightings(feed, watchers);
  WatchFigures figures;
  std::vector<double> latencies_s;
  double bytes = 0.0;
  std::size_t count = 0;
  for (const WatcherRecord& watcher : watchers) {
    if (watcher.stalled || watcher.steps.empty()) continue;
    ++count;
    figures.most_behind_s = std::max(figures.most_behind_s, MostBehind(published, watcher.steps));
    figures.most_commits_a_step =
        std::max(figures.most_commits_a_step, MostCommitsAStep(published, watcher.steps));
    AppendLatencies(feed, watcher.steps, &latencies_s);
    for (const WatchedStep& step : watcher.steps) bytes += static_cast<double>(step.bytes);
  }
  figures.median_latency_s = Quantile(latencies_s, 0.5);
  figures.p95_latency_s = Quantile(std::move(latencies_s), 0.95);
  if (count > 0) {
    figures.bytes_a_frame =
        bytes / static_cast<double>(count) / static_cast<double>(feed.pushed.size());
  }
  return figures;
}

}  // namespace steadymap::benchmarks
