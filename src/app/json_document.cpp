#include "app/json_document.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace maille {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxBytes = std::size_t{16} << 20;
constexpr std::size_t kMaxDepth = 64;
constexpr std::size_t kMaxShown = 60;  // characters of a refused value that a message repeats

std::string in_quotes(std::string_view text) {
  const bool cut = text.size() > kMaxShown;
  const json shown = std::string(text.substr(0, kMaxShown));
  auto out = shown.dump(-1, ' ', false, json::error_handler_t::replace);
  if (cut) out.insert(out.size() - 1, "...");
  return out;
}

// Never dumps what nests: that would recurse as deep as the file says.
std::string described(const json& value) {
  switch (value.type()) {
    case json::value_t::object: return value.empty() ? "an empty object" : "an object";
    case json::value_t::array: return "an array of " + std::to_string(value.size());
    case json::value_t::string: return in_quotes(value.get_ref<const std::string&>());
    default: return value.dump();
  }
}

std::string member_path(const std::string& parent, std::string_view key) {
  const bool plain = !key.empty() && key.size() <= kMaxShown &&
                     std::all_of(key.begin(), key.end(), [](unsigned char c) {
                       return std::isalnum(c) || c == '_' || c == '-';
                     });
  if (!plain) return parent + "[" + in_quotes(key) + "]";
  return parent.empty() ? std::string(key) : parent + "." + std::string(key);
}

std::string element_path(const std::string& parent, std::size_t index) {
  return parent + "[" + std::to_string(index) + "]";
}

Error bad(std::string message) { return {ErrorKind::bad_input, std::move(message)}; }

std::string place_of(std::string_view text, std::size_t byte) {
  const auto before = text.substr(0, std::min(byte, text.size()));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const auto start = before.rfind('\n');
  const auto column = start == std::string_view::npos ? before.size() : before.size() - start - 1;
  return "line " + std::to_string(line) + ", column " +
         std::to_string(std::max<std::size_t>(column, 1));
}

// Builds the tree as the parser meets it, which neither recurses nor forgets where it is.
class TreeBuilder : public nlohmann::json_sax<json> {
 public:
  explicit TreeBuilder(std::string_view text) : text_(text) {}

  std::optional<Error> error;
  json root;

  bool null() override { return put(nullptr); }
  bool boolean(bool value) override { return put(value); }
  bool number_integer(std::int64_t value) override { return put(value); }
  bool number_unsigned(std::uint64_t value) override { return put(value); }
  bool number_float(double value, const std::string&) override { return put(value); }
  bool string(std::string& value) override { return put(std::move(value)); }
  bool binary(json::binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(json::object()); }
  bool start_array(std::size_t) override { return open(json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(std::string& key) override {
    if (open_.back()->contains(key)) {
      return fail(member_path(path(open_.size() - 1), key), "the key is there twice");
    }
    keys_.back() = key;
    return true;
  }

  bool parse_error(std::size_t byte, const std::string&, const json::exception& e) override {
    if (e.id == 406) return fail(path(open_.size()), "expected a finite number");
    // "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error while ..."
    std::string_view what = e.what();
    const auto comma = what.find(", column ");
    const auto colon = comma == what.npos ? what.npos : what.find(": ", comma);
    if (colon != what.npos) what.remove_prefix(colon + 2);
    return fail(place_of(text_, byte) + ": " + std::string(what));
  }

 private:
  // The path of what is being read at a depth of the tree.
  std::string path(std::size_t depth) const {
    std::string out;
    for (std::size_t level = 0; level < depth; ++level) {
      const json& parent = *open_[level];
      const bool being_read = level + 1 == open_.size();
      if (parent.is_object()) {
        out = member_path(out, keys_[level]);
      } else {
        out = element_path(out, being_read ? parent.size() : parent.size() - 1);
      }
    }
    return out;
  }

  bool fail(std::string message) {
    if (!error) error = bad(std::move(message));
    return false;
  }
  bool fail(const std::string& at, const std::string& message) {
    return fail(at.empty() ? message : at + ": " + message);
  }

  json* place(json value) {
    if (open_.empty()) {
      root = std::move(value);
      return &root;
    }
    json& parent = *open_.back();
    if (parent.is_object()) return &(parent[keys_.back()] = std::move(value));
    parent.push_back(std::move(value));
    return &parent.back();
  }

  bool put(json value) {
    place(std::move(value));
    return true;
  }

  bool open(json value) {
    if (open_.size() == kMaxDepth) {
      return fail(path(open_.size()),
                  "nested more than " + std::to_string(kMaxDepth) + " levels deep");
    }
    open_.push_back(place(std::move(value)));
    keys_.emplace_back();
    return true;
  }

  bool close() {
    open_.pop_back();
    keys_.pop_back();
    return true;
  }

  std::string_view text_;
  std::vector<json*> open_;  // a parent does not change while a child is open, so these stay valid
  std::vector<std::string> keys_;
};

std::string shown(double value) {
  const bool whole = std::floor(value) == value && std::abs(value) < 1e15;
  return whole ? std::to_string(static_cast<std::int64_t>(value)) : json(value).dump();
}

std::string expected_number(const char* noun, Bounds bounds) {
  if (std::isfinite(bounds.high)) {
    return std::string(noun) + " from " + shown(bounds.low) + " to " + shown(bounds.high);
  }
  if (!std::isfinite(bounds.low)) return noun;
  return std::string(noun) + (bounds.low_open ? " > " : " >= ") + shown(bounds.low);
}

}  // namespace

Result<json> parse_json(std::string_view text) {
  if (text.size() > kMaxBytes) return bad("expected at most 16 MiB of JSON");
  TreeBuilder builder(text);
  const bool complete = json::sax_parse(text, &builder);
  if (builder.error) return *builder.error;
  if (!complete) return bad("not JSON");
  return std::move(builder.root);
}

bool Bounds::hold(double value) const {
  return std::isfinite(value) && (low_open ? value > low : value >= low) && value <= high;
}

void JsonReader::refuse(std::string_view sentence) const {
  if (failed()) return;
  *error_ = bad((path_.empty() ? "" : path_ + ": ") + std::string(sentence));
}

void JsonReader::refuse_value(std::string_view expected) const {
  refuse("expected " + std::string(expected) + ", got " + described(*value_));
}

void JsonReader::expect_object(std::initializer_list<std::string_view> keys) const {
  if (failed()) return;
  if (!value_->is_object()) return refuse_value("an object");
  for (const auto& [key, ignored] : value_->items()) {
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    std::string known;
    for (const auto name : keys) known += (known.empty() ? "" : ", ") + std::string(name);
    return JsonReader(*value_, member_path(path_, key), *error_)
        .refuse("unknown key (known: " + known + ")");
  }
}

bool JsonReader::has(std::string_view key) const {
  return value_->is_object() && value_->contains(key);
}

std::vector<std::string> JsonReader::keys() const {
  std::vector<std::string> out;
  if (!value_->is_object()) return out;
  for (const auto& [key, ignored] : value_->items()) out.push_back(key);
  return out;
}

JsonReader JsonReader::at(std::string_view key) const {
  static const json kNothing;
  const JsonReader member(kNothing, member_path(path_, key), *error_);
  if (failed()) return member;
  if (!value_->is_object()) {
    refuse_value("an object");
    return member;
  }
  const auto found = value_->find(key);
  if (found == value_->end()) {
    member.refuse("missing");
    return member;
  }
  return {*found, member.path_, *error_};
}

void JsonReader::each(std::string_view expected,
                      const std::function<void(const JsonReader&, std::size_t)>& f) const {
  if (failed()) return;
  if (!value_->is_array()) return refuse_value(expected);
  for (std::size_t i = 0; i < value_->size() && !failed(); ++i) {
    f(JsonReader((*value_)[i], element_path(path_, i), *error_), i);
  }
}

double JsonReader::number(Bounds bounds) const {
  if (failed()) return 0.0;
  if (value_->is_number() && bounds.hold(value_->get<double>())) return value_->get<double>();
  refuse_value(expected_number("a number", bounds));
  return 0.0;
}

std::int64_t JsonReader::integer(std::int64_t low, std::int64_t high) const {
  if (failed()) return low;
  if (value_->is_number_integer()) {
    const bool huge = value_->is_number_unsigned() &&
                      value_->get<std::uint64_t>() > std::numeric_limits<std::int64_t>::max();
    const auto number = value_->get<std::int64_t>();
    if (!huge && number >= low && number <= high) return number;
  }
  refuse_value("an integer from " + std::to_string(low) + " to " + std::to_string(high));
  return low;
}

std::uint64_t JsonReader::unsigned_integer() const {
  if (failed()) return 0;
  if (value_->is_number_unsigned()) return value_->get<std::uint64_t>();
  refuse_value("an integer >= 0");
  return 0;
}

bool JsonReader::boolean() const {
  if (failed()) return false;
  if (value_->is_boolean()) return value_->get<bool>();
  refuse_value("true or false");
  return false;
}

std::string JsonReader::string() const {
  if (failed()) return {};
  if (value_->is_string() && !value_->get_ref<const std::string&>().empty()) {
    return value_->get<std::string>();
  }
  refuse_value("a string that is not empty");
  return {};
}

glm::dvec3 JsonReader::vector(Bounds bounds) const {
  glm::dvec3 out(0.0);
  if (failed()) return out;
  if (!value_->is_array() || value_->size() != 3) {
    refuse_value("an array of 3 numbers");
    return out;
  }
  each("", [&](const JsonReader& item, std::size_t i) {
    out[static_cast<int>(i)] = item.number(bounds);
  });
  return out;
}

glm::ivec3 JsonReader::integer_vector(std::int64_t low, std::int64_t high) const {
  glm::ivec3 out(static_cast<int>(low));
  if (failed()) return out;
  if (!value_->is_array() || value_->size() != 3) {
    refuse_value("an array of 3 integers");
    return out;
  }
  each("", [&](const JsonReader& item, std::size_t i) {
    out[static_cast<int>(i)] = static_cast<int>(item.integer(low, high));
  });
  return out;
}

}  // namespace maille
