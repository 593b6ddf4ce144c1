// Failure: the reason why a command cannot continue. Commands throw it; main() prints it and exits
// with its status. Resources of the command are released by their scopes.
#pragma once

#include <exception>
#include <span>
#include <string>
#include <string_view>

#include "base/toml.h"
#include "tims/result.h"

namespace timsctl {

namespace base = tims::base;

// The exit status, the same for all commands.

enum class Exit : int {
  kDone = 0,           // done; the answer is yes
  kNo = 1,             // the answer is no, a check failed, a component answered ERROR
  kUsage = 2,          // the command line is wrong
  kNoRouter = 3,       // there is no router, or it cannot be reached
  kNoSuch = 4,         // no such address, key, code
  kDenied = 5,         // the system or the router refused
  kTimeout = 6,        // no answer in time, or only a part of it
  kVersion = 7,        // the two sides do not speak the same protocol
  kInterrupted = 130,  // Ctrl-C before it was done
};

struct Failure : std::exception {
  Failure(Exit exit_code, std::string error_code, std::string what_and_where,
          std::string what_to_do = {})
      : exit(exit_code),
        code(std::move(error_code)),
        message(std::move(what_and_where)),
        hint(std::move(what_to_do)) {}
  [[nodiscard]] const char* what() const noexcept override { return message.c_str(); }

  Exit exit;
  std::string code;     // for scripts: "no_router"
  std::string message;  // what failed, and where
  std::string hint;     // what the user can do; may be empty
};

// Ctrl-C, or the reader of stdout has closed it.
struct Interrupted : std::exception {
  [[nodiscard]] const char* what() const noexcept override { return "interrupted"; }
};

Failure usage_error(std::string message, std::string hint = {});

// The address is not registered.
Failure no_such_mailbox(const std::string& address,
                        std::string hint = "`timsctl mbx list` shows all");

// The hint for an unknown name: the most similar known name, else `otherwise`, else all names.
std::string nearest_hint(std::string_view name, std::span<const std::string_view> known,
                         std::string otherwise = {});

// One or more lines of text: "timsctl: MESSAGE" and the hint.
std::string failure_text(const Failure& failure);

// `where`: the router or mailbox at which the error occurred.
Failure failure_of(const tims::Error& error, const std::string& where);

// Throws Failure with one line per problem, if there are any.
void fail_if_any(std::span<const base::Problem> problems, const std::string& code,
                 const std::string& hint);

// Returns the value or throws the failure.
template <typename T>
T value_or_fail(tims::Result<T> result, const std::string& where) {
  if (!result) throw failure_of(result.error(), where);
  if constexpr (!std::is_void_v<T>) return std::move(result).value();
}

// The meaning of error codes, drop reasons and findings of timsctl and the router, with hints.

struct CatalogueEntry {
  std::string_view code;  // "no_route", "mailboxes.dead", "3"
  std::string_view kind;  // "reason", "error", "doctor", "exit status"
  std::string_view meaning;
  std::string_view hint;
};

std::span<const CatalogueEntry> catalogue();
const CatalogueEntry* find_in_catalogue(std::string_view code);

}  // namespace timsctl
