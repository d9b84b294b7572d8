// An Error on its way through code that cannot return one: a read in the middle of a solver's row
// whose bytes lie in a file. Caught where a step as a whole can be given up.
#pragma once

#include <exception>
#include <utility>

#include "core/result.h"

namespace maille {

class Failure : public std::exception {
 public:
  explicit Failure(Error error) : error_(std::move(error)) {}
  const Error& error() const { return error_; }
  const char* what() const noexcept override { return error_.message.c_str(); }

 private:
  Error error_;
};

}  // namespace maille
