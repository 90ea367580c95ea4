#pragma once

#include <cstdint>
#include <string>

#include "google/protobuf/timestamp.pb.h"

/// Numbers as a person reads them: in units that keep them short, with the digits that matter.
namespace steadymap {

/// A length: `5 cm`, `2.5 mm`, `3 m`.
std::string LengthText(double length_m);

/// A size: `812 B`, `12.3 MiB`.
std::string BytesText(std::uint64_t bytes);

/// A count, thousands separated: `1 234 567`.
std::string CountText(std::uint64_t count);

/// A duration: `0.42 s`, `12.3 s`, `4 min 05 s`.
std::string DurationText(double seconds);

/// A moment in UTC: `2024-05-01T12:00:00Z`, with fractions where there are any.
std::string MomentText(const google::protobuf::Timestamp& moment);

/// `value` with `decimals` digits behind the point.
std::string FixedText(double value, int decimals);

}  // namespace steadymap
