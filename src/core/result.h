// A value, or why there is none. Errors travel as values; exceptions are left to what cannot be
// foreseen (out of memory), which main() turns into an exit code.
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace maille {

// The numbers are the program's exit codes.
enum class ErrorKind {
  failed = 1,         // failed while running
  usage = 2,          // wrong command line
  bad_input = 3,      // a file says something that cannot be
  device = 4,         // no usable device, or it was lost
  out_of_memory = 5,  // out of memory or over budget
  file_system = 6,    // a file could not be opened, read or written
};

struct Error {
  ErrorKind kind = ErrorKind::failed;
  std::string message;  // names the file, the place in it and what was expected
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : content_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return content_.index() == 0; }
  explicit operator bool() const { return ok(); }

  T& value() & { return std::get<0>(content_); }
  const T& value() const& { return std::get<0>(content_); }
  T&& value() && { return std::get<0>(std::move(content_)); }
  const Error& error() const { return std::get<1>(content_); }

  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

 private:
  std::variant<T, Error> content_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : content_(std::move(error)) {}

  bool ok() const { return content_.index() == 0; }
  explicit operator bool() const { return ok(); }
  const Error& error() const { return std::get<1>(content_); }

 private:
  std::variant<std::monostate, Error> content_;
};

}  // namespace maille
