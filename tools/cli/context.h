// The context of a verb, and the common pattern of verbs: ask a router and show its answer.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>

#include <fmt/format.h>

#include "tools/cli/admin_client.h"
#include "tools/cli/connection.h"
#include "tools/cli/options.h"
#include "tools/cli/output.h"

namespace timsctl {

class Context {
 public:
  Context(const Verb& what, const Options& command_line, Output& output, const Signals& interrupts,
          Host router)
      : verb(what),
        options(command_line),
        out(output),
        signals(interrupts),
        host(std::move(router)) {}

  const Verb& verb;
  const Options& options;
  Output& out;
  const Signals& signals;
  const Host host;

  // The end of the run by --for, counted from now; kNever without --for.
  [[nodiscard]] tims::Time run_end() const;

  // Opens a mailbox at the router. Throws Failure.
  [[nodiscard]] std::unique_ptr<Connection> connect(const MailboxRequest& request = {}) const;
  // A client of the router of the connection, or of the router of --router.
  [[nodiscard]] AdminClient admin(Connection& connection) const;
};

// Reports messages that were lost because they arrived faster than a command could show them.
class LostMessages {
 public:
  // `what`: "messages".
  explicit LostMessages(std::string_view what) : what_(what) {}

  void note(const Connection& connection, const Output& out) {
    const std::uint64_t all = connection.missed();
    if (all == reported_) return;
    out.note(fmt::format("{} {} were lost: too fast for this output, or larger than --body-max",
                         all - reported_, what_));
    reported_ = all;
  }

 private:
  std::string_view what_;
  std::uint64_t reported_ = 0;
};

// --- Verbs that send a request and show the answer, once or repeatedly (--watch)

using AskRouter = std::function<json::object(AdminClient&)>;
// Converts the answer to text; not called for JSON.
using Draw = std::function<std::string(const json::object&, const Look&)>;

Exit show(Context& context, const AskRouter& ask, const Draw& draw);
// The items of the answer as a table, or the answer as a page.
Draw table_of(std::span<const Column> columns);
Draw page_of(std::span<const Column> lines);

// Shows the items of the answer as a table, sorted by --sort.
Exit show_items(Context& context, const json::object& question, std::span<const Column> columns,
                const Draw& draw = {});
// Shows a list that does not come from a router.
Exit show_list(Context& context, std::string_view schema, json::array items,
               std::span<const Column> columns);
// Sends a command to the router; the answer is shown only as JSON.
Exit command_router(Context& context, const json::object& question);

// Adds "match" with the first argument to the request, if there is one.
json::object with_match(json::object question, const Options& options);

}  // namespace timsctl
