#include "tools/timsctl/event_lines.h"

#include <fmt/format.h>

#include "os/clock.h"
#include "tools/timsctl/humanize.h"

namespace timsctl {

EventLines::EventLines(Context& context, std::string_view schema, int subject_width)
    : context_(context), schema_(schema), subject_width_(subject_width), began_(tims::os::now()) {}

void EventLines::begin() { began_ = tims::os::now(); }

void EventLines::say(std::string_view event, std::string_view subject,
                     std::string_view text) const {
  const double t = seconds(tims::os::now() - began_);
  if (context_.out.json())
    return context_.out.write(json::object{{"schema", schema_},
                                           {"time", rfc3339(wall_now())},
                                           {"t_s", t},
                                           {"event", event},
                                           {"subject", subject},
                                           {"text", text}});
  if (context_.options.quiet) return;
  context_.out.write(
      fmt::format("{:8.2f} s  {:<{}} {}\n", t, subject, subject_width_, printable_lines(text)));
}

}  // namespace timsctl
