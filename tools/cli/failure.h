// Why a command cannot go on. Commands throw it; main() prints it and exits with its code. What a
// command had opened is closed by its scope.
#pragma once

#include <exception>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "base/toml.h"
#include "tims/result.h"

namespace CLI {
class App;
}

namespace timsctl {

namespace base = tims::base;

// What a command's end means to a script. One table for all commands.

enum class Exit : int {
  kDone = 0,           // done; the answer is yes
  kNo = 1,             // the answer is no, a check failed, a component said ERROR
  kUsage = 2,          // the command line is wrong
  kNoRouter = 3,       // no router there, or not reachable
  kNoSuch = 4,         // no such address, key, code
  kDenied = 5,         // the system or the router refused
  kTimeout = 6,        // no answer in time, or only a part of it
  kVersion = 7,        // the two sides do not speak the same protocol
  kInterrupted = 130,  // Ctrl-C before it was done
};

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

// Nobody has registered it.
Failure no_such_mailbox(const std::string& address,
                        std::string hint = "`timsctl mbx list` shows all");

// For a name that nobody has: the one that was probably meant, `otherwise`, or all there are.
std::string nearest_hint(std::string_view name, std::span<const std::string_view> known,
                         std::string otherwise = {});

// For people, a line or more: "timsctl: what, and where", and what to do.
std::string failure_text(const Failure& failure);

// main() of a program without verbs: `run`, when `app` has read the command line. Both may throw
// what CLI11 throws of a command line. Returns the exit status.
int run_program(int argc, char** argv, CLI::App& app, const std::function<Exit()>& run);

// `where` is the router or mailbox it happened at.
Failure failure_of(const tims::Error& error, const std::string& where);

// Throws Failure with all of them, a line each; there may be none.
void fail_if_any(std::span<const base::Problem> problems, const std::string& code,
                 const std::string& hint);

// The value, or the failure thrown.
template <typename T>
T value_or_fail(tims::Result<T> result, const std::string& where) {
  if (!result) throw failure_of(result.error(), where);
  if constexpr (!std::is_void_v<T>) return std::move(result).value();
}

// What the words mean that timsctl and the router use for what went wrong, and what to do.

struct CatalogueEntry {
  std::string_view code;  // "no_route", "mailboxes.dead", "3"
  std::string_view kind;  // "reason", "error", "doctor", "exit status"
  std::string_view meaning;
  std::string_view hint;
};

std::span<const CatalogueEntry> catalogue();
const CatalogueEntry* find_in_catalogue(std::string_view code);

}  // namespace timsctl
