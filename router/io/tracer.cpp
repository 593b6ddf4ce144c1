#include "router/io/tracer.h"

#include <cstring>
#include <utility>

#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>

#include "base/text.h"
#include "router/io/reports.h"
#include "wire/header.h"

namespace tims::io {
namespace {

using base::valid_utf8;

namespace json = boost::json;

json::value peer_json(const core::Router& router, core::ClientId id) {
  const core::Client* client = router.client(id);
  return client == nullptr ? json::value() : json::value(to_json(client->peer()));
}

}  // namespace

void Tracer::on_traced(WallTime at, core::ClientId from, core::ClientId to,
                       const core::Message& message) {
  // A hop record must not cause further hop records.
  if (hops_.size() >= kPerTurnMax || message.header.type == type::kHopRecord) return;
  hops_.push_back({at, from, to, message.header, message.hops, message.waited});
}

void Tracer::on_denied(WallTime at, core::ClientId from, const core::Message& message,
                       std::string_view rule) {
  if (hops_.size() >= kPerTurnMax) return;
  hops_.push_back({at, from, {}, message.header, message.hops, message.waited, std::string(rule)});
}

void Tracer::send_records(const core::Router& router, std::string_view name, const Send& send) {
  const AddressWidths& widths = router.settings().widths;
  for (const Hop& hop : std::exchange(hops_, {})) {
    const json::object record{
        {"schema", "tims/hop/1"},
        {"router", base::valid_utf8(name)},
        {"address", to_json(router.settings().address, widths)},
        {"time", base::rfc3339(hop.at)},
        {"hop", hop.hops},
        {"dest", to_json(hop.header.dest, widths)},
        {"type", hop.header.type},
        {"seq_nr", hop.header.seq_nr},
        {"from", peer_json(router, hop.from)},
        {"to", peer_json(router, hop.to)},
        {"waited_s", std::chrono::duration<double>(hop.waited).count()},
        {"denied", hop.denied.empty() ? json::value() : json::value(valid_utf8(hop.denied))}};
    const std::string text = json::serialize(record);
    auto& bytes = sent_.emplace_back(kHeaderSize + text.size());
    std::memcpy(bytes.data() + kHeaderSize, text.data(), text.size());
    core::Message message{.header = {.type = type::kHopRecord,
                                     .priority = hop.header.priority,
                                     .seq_nr = hop.header.seq_nr,
                                     .dest = hop.header.src,
                                     .src = router.settings().address,
                                     .length = static_cast<std::uint32_t>(bytes.size())},
                          .bytes = bytes};
    wire::encode_header(message.header, std::span(bytes).first<kHeaderSize>());
    send(message);
  }
}

}  // namespace tims::io
