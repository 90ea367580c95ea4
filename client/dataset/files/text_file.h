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

/// The small text files that data sets consist of beside their images.
namespace steadymap {

/// The size of a file, bytes.
/// Errors: `NotFound` if there is none, `InvalidArgument` if it is larger than `max_bytes`; both
/// name it.
absl::StatusOr<std::size_t> SizeOfFile(const std::filesystem::path& file, std::size_t max_bytes);

/// Reads a whole file of at most `max_bytes`.
/// Errors: `NotFound` if it cannot be opened, `InvalidArgument` if it is larger; both name it.
absl::StatusOr<std::string> ReadFile(const std::filesystem::path& file, std::size_t max_bytes);

/// `InvalidArgument`: "FILE: expected EXPECTED, found FOUND".
absl::Status MalformedFile(const std::filesystem::path& file,
                           std::string_view expected,
                           std::string_view found);

/// A line with something on it.
struct TextLine {
  std::size_t number = 0;  ///< From 1.
  std::string text;        ///< Without comment and outer blanks; never empty.
};

/// The lines of a text file of at most 64 MiB; what follows a # is a comment, and lines that hold
/// nothing else are left out.
/// Errors: as `ReadFile`.
absl::StatusOr<std::vector<TextLine>> ReadTextLines(const std::filesystem::path& file);

/// The numbers of a line, separated by blanks or commas; `nan` and `inf` count as numbers. None if
/// anything else stands there.
std::optional<std::vector<double>> ParseNumbers(std::string_view text);

/// `InvalidArgument`: "FILE:LINE: expected EXPECTED, found TEXT", long text cut.
absl::Status MalformedLine(const std::filesystem::path& file,
                           const TextLine& line,
                           std::string_view expected);

/// Whether none of the numbers is NaN or infinite.
bool AreFinite(std::span<const double> numbers);

/// The pose that a line tells as the numbers "tx ty tz qx qy qz qw", which must be finite.
/// Errors: as `MalformedLine` for a position beyond 10 km or a quaternion that is not unit.
absl::StatusOr<Eigen::Isometry3d> PoseInLine(const std::filesystem::path& file,
                                             const TextLine& line,
                                             std::span<const double, 7> numbers);

/// Reads `rows` lines of as many numbers, row by row.
/// Errors: as `ReadFile`; `InvalidArgument` naming the file for any other content.
absl::StatusOr<Eigen::MatrixXd> ReadSquareMatrix(const std::filesystem::path& file, int rows);

/// Reads the 4x4 matrix of a rigid transform. Rotations are made orthonormal if they are so within
/// 1e-2. A matrix that holds NaN or infinity comes back as it stands.
/// Errors: as `ReadSquareMatrix`; `InvalidArgument` naming the file if it is not rigid.
absl::StatusOr<Eigen::Isometry3d> ReadTransform(const std::filesystem::path& file);

}  // namespace steadymap
