#include "volume/volume_file.h"

#include "core/atomic_file.h"
#include "core/trace.h"
#include "volume/header_lines.h"
#include "volume/metaimage.h"
#include "volume/nrrd.h"
#include "volume/raw_file.h"

namespace maille {
namespace {

enum class WrittenFormat { nrrd, metaimage };

Result<WrittenFormat> written_format(const std::filesystem::path& path) {
  const auto ending = lower_case(path.extension().string());
  if (ending == ".nrrd") return WrittenFormat::nrrd;
  if (ending == ".mha") return WrittenFormat::metaimage;
  return Error{ErrorKind::usage, path.string() + ": expected a name ending in .nrrd or .mha"};
}

Result<void> write_file(const std::filesystem::path& path, std::string_view header,
                        std::span<const std::byte> samples) {
  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  if (auto written = file->write(std::as_bytes(std::span(header))); !written) return written;
  if (auto written = file->write(samples); !written) return written;
  return file->commit();
}

// The last ending, or the last two where the last only says how the file is packed.
std::string ending_of(const std::filesystem::path& path) {
  const auto last = path.extension();
  const bool is_packing = last == ".gz" || last == ".xz" || last == ".bz2";
  return is_packing ? path.stem().extension().string() + last.string() : last.string();
}

}  // namespace

Result<Volume> read_volume(const std::filesystem::path& path) {
  const trace::Span span("read volume");
  const auto ending = lower_case(path.extension().string());
  if (ending == ".nrrd" || ending == ".nhdr") return read_nrrd(path);
  if (ending == ".mha" || ending == ".mhd") return read_metaimage(path);
  if (ending == ".raw") return read_raw_file(path);
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    return Error{ErrorKind::file_system, path.string() + ": no such file"};
  }
  return Error{ErrorKind::bad_input,
               path.string() +
                   ": expected a file ending in .nrrd, .nhdr, .mha, .mhd or .raw, got " +
                   in_quotes(ending_of(path))};
}

Result<void> write_volume(const std::filesystem::path& path, const Volume& volume) {
  const trace::Span span("write volume");
  const auto format = written_format(path);
  if (!format) return format.error();
  const auto header =
      *format == WrittenFormat::nrrd
          ? nrrd_header_text(volume.size(), volume.type(), volume.world_from_voxel(), 0)
          : metaimage_header_text(volume.size(), volume.type(), volume.world_from_voxel(), 1);
  return write_file(path, header, volume.bytes());
}

Result<void> write_vector_field(const std::filesystem::path& path, Size3 size,
                                const glm::dmat4& world_from_voxel,
                                std::span<const glm::vec3> vectors) {
  static_assert(sizeof(glm::vec3) == 3 * sizeof(float));
  const trace::Span span("write vector field");
  const auto format = written_format(path);
  if (!format) return format.error();
  const auto header = *format == WrittenFormat::nrrd
                          ? nrrd_header_text(size, VoxelType::float32, world_from_voxel, 3)
                          : metaimage_header_text(size, VoxelType::float32, world_from_voxel, 3);
  return write_file(path, header, std::as_bytes(vectors));
}

}  // namespace maille
