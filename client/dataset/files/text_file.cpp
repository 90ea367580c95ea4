#include "client/dataset/files/text_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <system_error>

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/strings/strip.h>

#include "core/geometry/geometry.h"
#include "core/types/absl_text.h"

namespace steadymap {
namespace {

constexpr std::size_t kMaxTextBytes = std::size_t{64} << 20;
constexpr std::size_t kMaxQuotedLength = 100;
constexpr double kRotationTolerance = 1e-2;

}  // namespace

absl::StatusOr<std::size_t> SizeOfFile(const std::filesystem::path& file, std::size_t max_bytes) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    return absl::NotFoundError(absl::StrCat(file.string(), ": expected a file, found none"));
  }
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) return absl::NotFoundError(absl::StrCat(file.string(), ": cannot be read"));
  if (size > max_bytes) {
    return absl::InvalidArgumentError(
        absl::StrCat(file.string(), ": expected at most ", max_bytes, " bytes, found ", size));
  }
  return static_cast<std::size_t>(size);
}

absl::StatusOr<std::string> ReadFile(const std::filesystem::path& file, std::size_t max_bytes) {
  const absl::StatusOr<std::size_t> size = SizeOfFile(file, max_bytes);
  if (!size.ok()) return size.status();
  std::ifstream stream(file, std::ios::binary);
  std::string content(*size, '\0');
  stream.read(content.data(), static_cast<std::streamsize>(content.size()));
  if (!stream) return absl::NotFoundError(absl::StrCat(file.string(), ": cannot be read"));
  return content;
}

absl::Status MalformedFile(const std::filesystem::path& file,
                           std::string_view expected,
                           std::string_view found) {
  return absl::InvalidArgumentError(
      absl::StrCat(file.string(), ": expected ", Absl(expected), ", found ", Absl(found)));
}

absl::StatusOr<std::vector<TextLine>> ReadTextLines(const std::filesystem::path& file) {
  const absl::StatusOr<std::string> content = ReadFile(file, kMaxTextBytes);
  if (!content.ok()) return content.status();
  std::vector<TextLine> lines;
  std::size_t number = 0;
  for (absl::string_view line : absl::StrSplit(*content, '\n')) {
    ++number;
    line = absl::StripAsciiWhitespace(line.substr(0, line.find('#')));
    if (!line.empty()) lines.push_back({number, std::string(line)});
  }
  return lines;
}

std::optional<std::vector<double>> ParseNumbers(std::string_view text) {
  std::vector<double> numbers;
  for (const absl::string_view word :
       absl::StrSplit(Absl(text), absl::ByAnyChar(" \t\r,"), absl::SkipEmpty())) {
    double number = 0.0;
    if (!absl::SimpleAtod(word, &number)) return std::nullopt;
    numbers.push_back(number);
  }
  return numbers;
}

absl::Status MalformedLine(const std::filesystem::path& file,
                           const TextLine& line,
                           std::string_view expected) {
  return absl::InvalidArgumentError(absl::StrCat(file.string(),
                                                 ":",
                                                 line.number,
                                                 ": expected ",
                                                 Absl(expected),
                                                 ", found \"",
                                                 line.text.substr(0, kMaxQuotedLength),
                                                 "\""));
}

bool AreFinite(std::span<const double> numbers) {
  return std::all_of(
      numbers.begin(), numbers.end(), [](double number) { return std::isfinite(number); });
}

absl::StatusOr<Eigen::Isometry3d> ParsePose(const std::filesystem::path& file,
                                            const TextLine& line,
                                            std::span<const double, 7> numbers) {
  absl::StatusOr<Eigen::Isometry3d> pose = MakePose(
      {numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5], numbers[6]});
  if (pose.ok()) return pose;
  return MalformedLine(file, line, "a position within 10 km and a unit quaternion");
}

absl::StatusOr<Eigen::MatrixXd> ReadSquareMatrix(const std::filesystem::path& file, int rows) {
  const absl::StatusOr<std::vector<TextLine>> lines = ReadTextLines(file);
  if (!lines.ok()) return lines.status();
  const std::string expected = absl::StrCat(rows, " numbers");
  if (lines->size() != static_cast<std::size_t>(rows)) {
    return absl::InvalidArgumentError(absl::StrCat(
        file.string(), ": expected ", rows, " lines of ", expected, ", found ", lines->size()));
  }
  Eigen::MatrixXd matrix(rows, rows);
  for (int row = 0; row < rows; ++row) {
    const TextLine& line = (*lines)[static_cast<std::size_t>(row)];
    const std::optional<std::vector<double>> numbers = ParseNumbers(line.text);
    if (!numbers || numbers->size() != static_cast<std::size_t>(rows)) {
      return MalformedLine(file, line, expected);
    }
    matrix.row(row) = Eigen::Map<const Eigen::RowVectorXd>(numbers->data(), rows);
  }
  return matrix;
}

absl::StatusOr<Eigen::Isometry3d> ReadTransform(const std::filesystem::path& file) {
  const absl::StatusOr<Eigen::MatrixXd> matrix = ReadSquareMatrix(file, 4);
  if (!matrix.ok()) return matrix.status();
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.matrix() = *matrix;
  if (!matrix->allFinite()) return transform;
  const Eigen::Matrix3d rotation = transform.linear();
  const Eigen::RowVector4d last_row = matrix->row(3);
  const bool is_rigid =
      (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm() < kRotationTolerance &&
      rotation.determinant() > 0 &&
      (last_row - Eigen::RowVector4d(0, 0, 0, 1)).norm() < kRotationTolerance;
  if (!is_rigid) {
    return absl::InvalidArgumentError(
        absl::StrCat(file.string(), ": expected the 4x4 matrix of a rotation and a translation"));
  }
  transform.linear() = Eigen::Quaterniond(rotation).normalized().toRotationMatrix();
  transform.matrix().row(3) << 0, 0, 0, 1;
  return transform;
}

}  // namespace steadymap
