// JSON text read strictly: what a person may have meant twice or by accident is refused, with the
// place, instead of being guessed at.
//
// Reading a tree is a chain of calls that never fail half way: the first error is kept, everything
// asked for after it gives a harmless default, and the caller looks once at the end.
#pragma once

#include <functional>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include "core/result.h"

namespace maille {

// Errors: bad_input: syntax ("line 3, column 14: ..."), a key given twice and a number beyond a
// double's reach (with the key's path), nesting beyond 64 levels, more than 16 MiB.
Result<nlohmann::json> parse_json(std::string_view text);

// Which numbers are welcome. Infinite ends are open; NaN never is.
struct Bounds {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;

  static Bounds any() { return {}; }
  static Bounds at_least(double low) { return {low}; }
  static Bounds above(double low) { return {low, std::numeric_limits<double>::infinity(), true}; }
  static Bounds between(double low, double high) { return {low, high}; }
  bool hold(double value) const;
};

// A value in the tree, the path that led to it ("actions[2].drag") and where the first error goes.
class JsonReader {
 public:
  JsonReader(const nlohmann::json& value, std::string path, std::optional<Error>& error)
      : value_(&value), path_(std::move(path)), error_(&error) {}

  bool failed() const { return error_->has_value(); }
  const std::string& path() const { return path_; }
  bool is_object() const { return value_->is_object(); }
  bool is_array() const { return value_->is_array(); }
  bool is_string() const { return value_->is_string(); }

  // Refuses anything but an object of these keys. Call before asking for members.
  void expect_object(std::initializer_list<std::string_view> keys) const;
  bool has(std::string_view key) const;
  std::vector<std::string> keys() const;      // empty unless an object
  JsonReader at(std::string_view key) const;  // a missing key is an error

  void each(std::string_view expected,
            const std::function<void(const JsonReader&, std::size_t)>& f) const;

  double number(Bounds bounds = Bounds::any()) const;
  std::int64_t integer(std::int64_t low, std::int64_t high) const;
  std::uint64_t unsigned_integer() const;
  bool boolean() const;
  std::string string() const;  // not empty
  glm::dvec3 vector(Bounds bounds = Bounds::any()) const;
  glm::ivec3 integer_vector(std::int64_t low, std::int64_t high) const;

  // Records "PATH: expected WHAT, got VALUE" and "PATH: SENTENCE".
  void refuse_value(std::string_view expected) const;
  void refuse(std::string_view sentence) const;

 private:
  const nlohmann::json* value_;
  std::string path_;
  std::optional<Error>* error_;
};

}  // namespace maille
