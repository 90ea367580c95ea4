#pragma once

#include <compare>
#include <cstdint>

namespace steadymap {

inline constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

/// A moment, nanoseconds since the Unix epoch. Core never reads a clock: times come with frames.
class Timestamp {
 public:
  constexpr Timestamp() = default;

  static constexpr Timestamp FromNanoseconds(std::int64_t ns) { return Timestamp(ns); }

  static constexpr Timestamp FromSeconds(double seconds) {
    return Timestamp(static_cast<std::int64_t>(seconds * 1e9));
  }

  constexpr std::int64_t nanoseconds() const { return ns_; }

  constexpr double seconds() const { return static_cast<double>(ns_) / 1e9; }

  friend constexpr auto operator<=>(const Timestamp&, const Timestamp&) = default;

 private:
  explicit constexpr Timestamp(std::int64_t ns) : ns_(ns) {}

  std::int64_t ns_ = 0;
};

}  // namespace steadymap
