// timsctl log follow: what components say to people.
#include <fmt/format.h>

#include "os/clock.h"
#include "proxies/gdos.h"
#include "tools/timsctl/commands.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/humanize.h"
#include "tools/timsctl/message_text.h"

namespace timsctl {

namespace {

Tone tone_of(rack::gdos::Level level) {
  switch (level) {
    case rack::gdos::Level::kError:
      return Tone::kBad;
    case rack::gdos::Level::kWarning:
      return Tone::kWarning;
    case rack::gdos::Level::kInfo:
      return Tone::kGood;
    case rack::gdos::Level::kDetail:
      return Tone::kDim;
    case rack::gdos::Level::kPrint:
      break;
  }
  return Tone::kPlain;
}

void tell(Context& context, const Connection& connection, const Message& message,
          rack::gdos::Level level) {
  const auto widths = connection.widths();
  const auto decoded = rack::gdos::decode(message.body, message.header.body_order(), widths);
  const std::string text = decoded ? *decoded : decoded.error().detail() + " (malformed)";
  const WallTime now = wall_now();
  if (context.out.json())
    return context.out.write(json::object{{"schema", "tims/text/1"},
                                          {"time", rfc3339(now)},
                                          {"address", address_json(message.header.src, widths)},
                                          {"level", rack::gdos::name(level)},
                                          {"text", text}});
  const std::string line =
      fmt::format("{} {:<18} {:<7} {}", time_of_day(now, context.options.utc),
                  message.header.src.to_string(widths), rack::gdos::name(level), text);
  context.out.write(paint(line, tone_of(level), context.out.look().colour) + "\n");
}

}  // namespace

Exit log_follow(Context& context) {
  // The sink has an address of its own, and one owner.
  const auto connection =
      context.connect({.address = rack::gdos::kSink.to_hex(), .slots = 1024, .body_max = 1024});
  std::uint64_t left = context.options.count.value_or(UINT64_MAX);
  const tims::Time end =
      context.options.run_for ? tims::os::deadline_after(*context.options.run_for) : tims::kNever;
  std::uint64_t missed = 0;
  while (left > 0) {
    const auto message = receive(*connection, context.signals, end);
    if (!message) break;
    if (const std::uint64_t all = connection->missed(); all != missed) {
      context.out.note(fmt::format("{} texts were lost: too fast for this output", all - missed));
      missed = all;
    }
    const auto level = rack::gdos::level_of(message->header.type);
    if (!level) continue;
    --left;
    tell(context, *connection, *message, *level);
  }
  return left > 0 && context.options.count ? Exit::kTimeout : Exit::kDone;
}

}  // namespace timsctl
