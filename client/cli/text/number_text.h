#pragma once

#include <cstdint>
#include <string>

#include "google/protobuf/timestamp.pb.h"

/// Readable text for numbers, in units that keep them short, with the significant digits.
namespace steadymap {

/// Formats a length: `5 cm`, `2.5 mm`, `3 m`.
std::string LengthText(double length_m);

/// Formats a size: `812 B`, `12.3 MiB`.
std::string BytesText(std::uint64_t bytes);

/// Formats a count with separated thousands: `1 234 567`.
std::string CountText(std::uint64_t count);

/// Formats a duration: `0.42 s`, `12.3 s`, `4 min 05 s`.
std::string DurationText(double seconds);

/// Formats a time in UTC: `2024-05-01T12:00:00Z`, with a fraction if it is not zero.
std::string TimeText(const google::protobuf::Timestamp& moment);

/// Formats `value` with `decimals` digits after the decimal point, and zero without a sign.
std::string FixedText(double value, int decimals);

}  // namespace steadymap
