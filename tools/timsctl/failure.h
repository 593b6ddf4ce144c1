// Why a command cannot go on. Commands throw it; main() prints it and exits with its code. What a
// command had opened is closed by its scope.
#pragma once

#include <exception>
#include <string>

#include "tims/result.h"
#include "tools/timsctl/exit_code.h"

namespace timsctl {

struct Failure : std::exception {
  Failure(Exit exit_code, std::string word, std::string what_and_where, std::string what_to_do = {})
      : exit(exit_code),
        code(std::move(word)),
        message(std::move(what_and_where)),
        hint(std::move(what_to_do)) {}
  [[nodiscard]] const char* what() const noexcept override { return message.c_str(); }

  Exit exit;
  std::string code;     // one word for scripts: "no_router"
  std::string message;  // what, and where
  std::string hint;     // what to do; may be empty
};

// Ctrl-C, or the reader of our output has gone.
struct Interrupted : std::exception {
  [[nodiscard]] const char* what() const noexcept override { return "interrupted"; }
};

Failure usage_error(std::string message, std::string hint = {});

// `where` is the router or mailbox it happened at.
Failure failure_of(const tims::Error& error, const std::string& where);

// The value, or the failure thrown.
template <typename T>
T value_or_fail(tims::Result<T> result, const std::string& where) {
  if (!result) throw failure_of(result.error(), where);
  if constexpr (!std::is_void_v<T>) return std::move(result).value();
}

}  // namespace timsctl
