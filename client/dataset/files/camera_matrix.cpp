#include "client/dataset/files/camera_matrix.h"

#include <string>

#include <absl/strings/str_cat.h>

#include "client/dataset/files/folder_listing.h"
#include "client/dataset/files/image_file.h"
#include "client/dataset/files/text_file.h"

namespace steadymap {

absl::StatusOr<PinholeCamera> CameraOfSequence(const std::filesystem::path& folder,
                                               const std::filesystem::path& first_depth,
                                               const PinholeCamera& fallback) {
  const std::filesystem::path file = FindEntry(folder, "camera-intrinsics.txt");
  if (file.empty()) return fallback;
  const absl::StatusOr<Eigen::MatrixXd> matrix = ReadSquareMatrix(file, 3);
  if (!matrix.ok()) return matrix.status();
  const absl::StatusOr<ImageFile> depth = ReadImageFile(first_depth);
  if (!depth.ok()) return depth.status();
  const Eigen::Matrix3d intrinsics = *matrix;
  const PinholeCamera camera = {depth->size.width_px,
                                depth->size.height_px,
                                intrinsics(0, 0),
                                intrinsics(1, 1),
                                intrinsics(0, 2),
                                intrinsics(1, 2)};
  if (const absl::Status status = ValidateCamera(camera); !status.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat(file.string(), ": expected a camera matrix: ", status.message()));
  }
  return camera;
}

}  // namespace steadymap
