#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>
#include <absl/status/status.h>
#include <absl/status/statusor.h>

/// Readers for the small text files of data sets.
namespace steadymap {

/// Returns the size of a file in bytes. Errors: `NotFound` if the file does not exist,
/// `InvalidArgument` if it is larger than `max_bytes`; both with the file in the message.
absl::StatusOr<std::size_t> SizeOfFile(const std::filesystem::path& file, std::size_t max_bytes);

/// Reads a whole file of at most `max_bytes`. Errors: `NotFound` if it cannot be opened or read,
/// `InvalidArgument` if it is larger; both with the file in the message.
absl::StatusOr<std::string> ReadFile(const std::filesystem::path& file, std::size_t max_bytes);

/// Returns `InvalidArgument`: "FILE: expected EXPECTED, found FOUND".
absl::Status MalformedFile(const std::filesystem::path& file,
                           std::string_view expected,
                           std::string_view found);

/// A line that is not empty.
struct TextLine {
  std::size_t number = 0;  ///< The first line is 1.
  std::string text;        ///< Without comment and surrounding white space; never empty.
};

/// Returns the lines of a text file of at most 64 MiB. Text after a # is a comment. Lines without
/// other content are omitted. Errors: as `ReadFile`.
absl::StatusOr<std::vector<TextLine>> ReadTextLines(const std::filesystem::path& file);

/// Parses numbers separated by white space or commas; `nan` and `inf` are accepted. None for any
/// other content.
std::optional<std::vector<double>> ParseNumbers(std::string_view text);

/// Returns `InvalidArgument`: "FILE:LINE: expected EXPECTED, found TEXT". Long text is truncated.
absl::Status MalformedLine(const std::filesystem::path& file,
                           const TextLine& line,
                           std::string_view expected);

/// True if all numbers are finite.
bool AreFinite(std::span<const double> numbers);

/// Returns the pose in a line with the numbers "tx ty tz qx qy qz qw", which must be finite.
/// Errors: as `MalformedLine` for a position beyond 10 km or a quaternion that is not a unit
/// quaternion.
absl::StatusOr<Eigen::Isometry3d> ParsePose(const std::filesystem::path& file,
                                            const TextLine& line,
                                            std::span<const double, 7> numbers);

/// Reads a square matrix of `rows` rows, one row per line. Errors: as `ReadFile`; `InvalidArgument`
/// with the file in the message for any other content.
absl::StatusOr<Eigen::MatrixXd> ReadSquareMatrix(const std::filesystem::path& file, int rows);

/// Reads the 4x4 matrix of a rigid transform. Makes a rotation orthonormal if it deviates by less
/// than 1e-2. Returns a matrix with NaN or infinity unchanged. Errors: as `ReadSquareMatrix`;
/// `InvalidArgument` with the file in the message if the transform is not rigid.
absl::StatusOr<Eigen::Isometry3d> ReadTransform(const std::filesystem::path& file);

}  // namespace steadymap
