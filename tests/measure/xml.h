// Whether a text is well-formed XML, as far as our SVG goes: one root, every tag closed in turn,
// attributes quoted, no stray < or &.
#pragma once

#include <cctype>
#include <string>
#include <vector>

namespace maille::test {

// Empty: it is. Otherwise what is wrong, and where.
inline std::string xml_fault(const std::string& text) {
  std::vector<std::string> open;
  bool root_done = false;
  const auto fault = [](const std::string& what, std::size_t at) {
    return what + " at " + std::to_string(at);
  };
  for (std::size_t at = 0; at < text.size();) {
    if (text[at] == '&') {
      const auto end = text.find(';', at);
      const auto name = text.substr(at + 1, end == text.npos ? 0 : end - at - 1);
      if (name != "amp" && name != "lt" && name != "gt" && name != "quot") {
        return fault("unknown entity", at);
      }
      at = end + 1;
    } else if (text[at] != '<') {
      if (open.empty() && !std::isspace(static_cast<unsigned char>(text[at]))) {
        return fault("text outside the root", at);
      }
      ++at;
    } else {
      std::size_t end = at + 1;
      for (bool quoted = false; end < text.size() && (quoted || text[end] != '>'); ++end) {
        if (text[end] == '"') quoted = !quoted;
        if (text[end] == '<') return fault("< inside a tag", end);
      }
      if (end == text.size()) return fault("unfinished tag", at);
      const std::string tag = text.substr(at + 1, end - at - 1);
      const auto name_end = tag.find_first_of(" /", tag[0] == '/' ? 1 : 0);
      if (tag[0] == '/') {
        if (open.empty() || open.back() != tag.substr(1)) return fault("wrong end tag " + tag, at);
        open.pop_back();
        root_done = open.empty();
      } else {
        if (root_done) return fault("a second root", at);
        if (tag.back() != '/') open.push_back(tag.substr(0, name_end));
      }
      at = end + 1;
    }
  }
  return open.empty() && root_done ? "" : "an open tag at the end";
}

}  // namespace maille::test
