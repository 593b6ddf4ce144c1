#include "tools/cli/context.h"

#include <algorithm>

#include "base/measure.h"
#include "base/text.h"
#include "os/clock.h"
#include "tools/cli/arguments.h"
#include "tools/cli/failure.h"

namespace timsctl {

namespace {

Exit exit_of(const json::object& answer) {
  return text_at(answer, "partial") == "true" ? Exit::kTimeout : Exit::kDone;
}

// The mailbox of this command itself is not listed.
void leave_out_own(json::array& items, tims::Address own) {
  const auto* const found = std::ranges::find_if(items, [&](const json::value& item) {
    return text_at(item.as_object(), "address.raw") == own.to_hex();
  });
  if (found != items.end()) items.erase(found);
}

// The router may be restarted during --watch.
class Watcher {
 public:
  Watcher(Context& context, const AskRouter& ask, const Draw& draw)
      : context_(context), ask_(ask), draw_(draw) {}

  Exit run() {
    const std::uint64_t count = context_.options.count.value_or(UINT64_MAX);
    tims::Time next = tims::os::now();
    if (context_.out.terminal() && !context_.out.json()) context_.out.write("\033[2J");
    for (std::uint64_t i = 0; i < count; ++i) {
      context_.signals.sleep_until(next);
      next = std::max(next + *context_.options.watch, tims::os::now());
      refresh();
    }
    return Exit::kDone;
  }

 private:
  void refresh() {
    try {
      if (!connection_) connection_ = context_.connect();
      AdminClient admin = context_.admin(*connection_);
      const json::object answer = ask_(admin);
      if (context_.out.json()) return context_.out.write(answer);
      context_.out.redraw(heading() + draw_(answer, context_.out.look()) +
                          (context_.out.terminal() ? "" : "\n"));
    } catch (const Failure& failure) {
      if (failure.exit != Exit::kNoRouter && failure.exit != Exit::kTimeout) throw;
      connection_.reset();
      if (context_.out.json()) return context_.out.failure(failure);
      context_.out.redraw(heading() + failure.message + "; retrying\n");
    }
  }

  std::string heading() const {
    if (!context_.out.terminal()) return {};
    return fmt::format("{}  every {}, stop with Ctrl-C\n\n",
                       time_of_day(tims::os::wall_now(), context_.options.utc),
                       base::human_duration(base::seconds(*context_.options.watch)));
  }

  Context& context_;
  const AskRouter& ask_;
  const Draw& draw_;
  std::unique_ptr<Connection> connection_;
};

}  // namespace

tims::Time Context::run_end() const {
  return options.run_for ? tims::os::deadline_after(*options.run_for) : tims::kNever;
}

std::unique_ptr<Connection> Context::connect(const MailboxRequest& request) const {
  // Called by the thread of the session; writes one line to stderr.
  const Log log = [this](const std::string& text) { out.detail(text); };
  return timsctl::connect(host, request, options.timeout, log);
}

AdminClient Context::admin(Connection& connection) const {
  const AdminClient here(connection, signals, options.timeout);
  if (options.router.empty()) return here;
  return here.at(find_router(here, options.router));
}

Exit show(Context& context, const AskRouter& ask, const Draw& draw) {
  if (context.options.watch) return Watcher(context, ask, draw).run();
  const auto connection = context.connect();
  AdminClient admin = context.admin(*connection);
  const json::object answer = ask(admin);
  context.out.write(answer, [&] { return draw(answer, context.out.look()); });
  return exit_of(answer);
}

Draw table_of(std::span<const Column> columns) {
  return [columns](const json::object& answer, const Look& look) {
    return render_items(items_of(answer), columns, look);
  };
}

Draw page_of(std::span<const Column> lines) {
  return [lines](const json::object& answer, const Look& look) {
    return render_page(answer, lines, look);
  };
}

Exit show_list(Context& context, std::string_view schema, json::array items,
               std::span<const Column> columns) {
  const json::object answer{{"schema", schema}, {"items", std::move(items)}};
  context.out.write(answer,
                    [&] { return render_items(items_of(answer), columns, context.out.look()); });
  return Exit::kDone;
}

Exit command_router(Context& context, const json::object& question) {
  const auto connection = context.connect();
  const json::object answer = context.admin(*connection).ask(question);
  if (context.out.json()) context.out.write(answer);
  return Exit::kDone;
}

Exit show_items(Context& context, const json::object& question, std::span<const Column> columns,
                const Draw& draw) {
  const std::string& by = context.options.sort;
  const auto ask = [&](AdminClient& admin) {
    json::object answer = admin.ask(question);
    leave_out_own(item_array(answer), admin.own_address());
    if (!by.empty()) sort_items(item_array(answer), columns, by);
    return answer;
  };
  return show(context, ask, draw ? draw : table_of(columns));
}

json::object with_match(json::object question, const Options& options) {
  if (options.arguments.empty()) return question;
  (void)need_pattern(options.arguments.front(), kAnyWidths);
  question["match"] = pattern_text(options.arguments.front());
  return question;
}

}  // namespace timsctl
