// Runs the built program as a person would, and keeps what it said.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace maille::test {

struct Run {
  int exit_code = -1;  // -1: killed by a signal
  std::string out;
  std::string err;
};

// environment: variables that are others for the program than for the test.
Run run_maille(const std::vector<std::string>& words,
               const std::map<std::string, std::string>& environment = {});

// A folder of the running test's own, emptied at first and removed at the end.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  std::string operator()(const std::string& name) const { return (path_ / name).string(); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::string read_file(const std::filesystem::path& path);
void write_file(const std::filesystem::path& path, const std::string& text);

}  // namespace maille::test
