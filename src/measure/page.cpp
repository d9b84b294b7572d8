#include "measure/page.h"

#include "core/atomic_file.h"

namespace maille {

Result<void> prepare_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder, error)) {
    return Error{ErrorKind::file_system,
                 folder.string() + ": making the folder failed: " +
                     (error ? error.message() : std::string("it is there and is no folder"))};
  }
  // Gone again when it is not committed.
  const auto trial = AtomicFile::create(folder / "trial");
  return trial ? Result<void>() : trial.error();
}

Result<void> write_page(const MeasurePage& page, const std::filesystem::path& folder,
                        const std::string& name) {
  const std::pair<const char*, const std::string*> files[] = {
      {".json", &page.json}, {".csv", &page.csv}, {".svg", &page.svg}};
  for (const auto& [ending, text] : files) {
    if (auto written = write_text_file(folder / (name + ending), *text); !written) return written;
  }
  return {};
}

}  // namespace maille
