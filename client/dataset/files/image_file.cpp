#include "client/dataset/files/image_file.h"

#include <cstddef>
#include <string_view>
#include <utility>

#include <absl/strings/str_cat.h>

#include "client/dataset/files/text_file.h"

namespace steadymap {
namespace {

constexpr std::string_view kPngSignature = "\x89PNG";

}  // namespace

absl::Status CheckImageSize(const std::filesystem::path& file,
                            const PinholeCamera& camera,
                            const ImageSize& size) {
  if (size.width_px == camera.width_px && size.height_px == camera.height_px) {
    return absl::OkStatus();
  }
  return MalformedFile(
      file,
      absl::StrCat("an image of ", camera.width_px, " x ", camera.height_px, " pixels"),
      absl::StrCat(size.width_px, " x ", size.height_px));
}

absl::StatusOr<ImageFile> ReadImageFile(const std::filesystem::path& file) {
  absl::StatusOr<std::string> data = ReadFile(file, kMaxImageFileBytes);
  if (!data.ok()) return data.status();
  const absl::StatusOr<ImageSize> size = PeekImageSize(*data);
  if (!size.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat(file.string(), ": expected a PNG or JPEG image: ", size.status().message()));
  }
  ImageFile image;
  image.is_png = std::string_view(*data).starts_with(kPngSignature);
  image.data = *std::move(data);
  image.size = *size;
  return image;
}

absl::StatusOr<ImageFile> ReadImageFile(const std::filesystem::path& file,
                                        const PinholeCamera& camera) {
  absl::StatusOr<ImageFile> image = ReadImageFile(file);
  if (!image.ok()) return image;
  if (absl::Status status = CheckImageSize(file, camera, image->size); !status.ok()) return status;
  return image;
}

absl::StatusOr<ImageFile> ReadPngFile(const std::filesystem::path& file,
                                      const PinholeCamera& camera) {
  absl::StatusOr<ImageFile> image = ReadImageFile(file, camera);
  if (image.ok() && !image->is_png) {
    return absl::InvalidArgumentError(
        absl::StrCat(file.string(), ": expected a PNG image, found a JPEG"));
  }
  return image;
}

}  // namespace steadymap
