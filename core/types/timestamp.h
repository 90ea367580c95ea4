#pragma once

#include <compare>
#include <cstdint>
#include <limits>

namespace steadymap {

inline constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

/// The difference of two points in time, nanoseconds.
class Duration {
 public:
  constexpr Duration() = default;

  static constexpr Duration FromNanoseconds(std::int64_t ns) { return Duration(ns); }

  static constexpr Duration FromSeconds(double seconds) {
    return Duration(static_cast<std::int64_t>(seconds * 1e9));
  }

  constexpr std::int64_t nanoseconds() const { return ns_; }

  constexpr double seconds() const { return static_cast<double>(ns_) / 1e9; }

  friend constexpr auto operator<=>(const Duration&, const Duration&) = default;

 private:
  explicit constexpr Duration(std::int64_t ns) : ns_(ns) {}

  std::int64_t ns_ = 0;
};

/// A point in time, nanoseconds since the Unix epoch. Core never reads a clock: times come with
/// frames.
class Timestamp {
 public:
  constexpr Timestamp() = default;

  static constexpr Timestamp FromNanoseconds(std::int64_t ns) { return Timestamp(ns); }

  static constexpr Timestamp FromSeconds(double seconds) {
    return Timestamp(static_cast<std::int64_t>(seconds * 1e9));
  }

  /// Returns the earliest time of all.
  static constexpr Timestamp Earliest() { return Timestamp(kMin); }

  constexpr std::int64_t nanoseconds() const { return ns_; }

  constexpr double seconds() const { return static_cast<double>(ns_) / 1e9; }

  friend constexpr auto operator<=>(const Timestamp&, const Timestamp&) = default;

  /// Returns the exact time from `b` to `a`; the largest or smallest duration on overflow.
  friend constexpr Duration operator-(Timestamp a, Timestamp b) {
    std::int64_t ns = 0;
    if (__builtin_sub_overflow(a.ns_, b.ns_, &ns)) ns = a < b ? kMin : kMax;
    return Duration::FromNanoseconds(ns);
  }

  /// Returns the sum; the latest or earliest time on overflow.
  friend constexpr Timestamp operator+(Timestamp time, Duration duration) {
    std::int64_t ns = 0;
    if (__builtin_add_overflow(time.ns_, duration.nanoseconds(), &ns)) {
      ns = duration < Duration() ? kMin : kMax;
    }
    return Timestamp(ns);
  }

  /// Returns the difference; the latest or earliest time on overflow.
  friend constexpr Timestamp operator-(Timestamp time, Duration duration) {
    std::int64_t ns = 0;
    if (__builtin_sub_overflow(time.ns_, duration.nanoseconds(), &ns)) {
      ns = duration < Duration() ? kMax : kMin;
    }
    return Timestamp(ns);
  }

 private:
  static constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();
  static constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();

  explicit constexpr Timestamp(std::int64_t ns) : ns_(ns) {}

  std::int64_t ns_ = 0;
};

}  // namespace steadymap
