#include "tools/timsctl/output.h"

#include <cerrno>

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "tools/timsctl/humanize.h"

namespace timsctl {

namespace {

bool write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(file, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

}  // namespace

Output::Output(const Options& options, bool no_color)
    : look_{.format = options.format, .utc = options.utc, .sort = options.sort},
      terminal_(::isatty(STDOUT_FILENO) == 1),
      quiet_(options.quiet),
      verbose_(options.verbose) {
  look_.colour = terminal_ && !no_color && !options.no_color;
}

void Output::write(std::string_view text) {
  if (!write_all(STDOUT_FILENO, text)) throw Interrupted();
}

void Output::write(const json::object& object) { write(to_text(object) + "\n"); }

void Output::redraw(std::string_view text) {
  if (!terminal_) return write(text);
  winsize size{};
  ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size);
  std::size_t lines_left = size.ws_row == 0 ? SIZE_MAX : size.ws_row - 1U;
  // Home; each line with what is left of the old one erased; everything below erased. Lines longer
  // than the terminal is wide are cut by the terminal (wrapping off and on again).
  std::string frame = "\033[?7l\033[H";
  for (const char c : text) {
    if (c == '\n' && lines_left-- <= 1) break;
    if (c == '\n') frame += "\033[K";
    frame += c;
  }
  write(frame + "\033[K\033[J\033[?7h");
}

void Output::note(std::string_view text) const {
  if (!quiet_) write_all(STDERR_FILENO, fmt::format("{}\n", printable(text)));
}

void Output::detail(std::string_view text) const {
  if (verbose_) note(text);
}

void Output::failure(const Failure& failure) {
  if (json()) {
    json::object error{{"code", failure.code}, {"message", failure.message}};
    if (!failure.hint.empty()) error["hint"] = failure.hint;
    write_all(STDOUT_FILENO,
              to_text(json::object{{"schema", "tims/error/1"}, {"error", error}}) + "\n");
    return;
  }
  std::string text = "timsctl: " + printable_lines(failure.message) + "\n";
  if (!failure.hint.empty()) text += "  -> " + failure.hint + "\n";
  write_all(STDERR_FILENO, text);
}

}  // namespace timsctl
