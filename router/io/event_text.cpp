#include "router/io/event_text.h"

#include "base/text.h"

namespace tims::io {
namespace {

using base::valid_utf8;

std::string refused_text(const core::Event& event, const AddressWidths& widths) {
  if (event.client.port == core::PortKind::kLink)
    return event.address.to_string(widths) + " announced by " + router_text(event.client) +
           " is refused: the [[link]] it arrived on is for another system";
  std::string text =
      event.address.to_string(widths) + " refused to " + client_text(event.client) + ": ";
  if (event.owner.id) return text + "it belongs to " + client_text(event.owner);
  return text + "it is the router's own";
}

std::string limit_text(const core::Event& event, const std::string& address) {
  if (event.client.port != core::PortKind::kLink)
    return address + " refused to " + client_text(event.client) + ": limits.mailboxes_per_client";
  return router_text(event.client) +
         " announces more mailboxes than its [[link]] allows (link.mailboxes): " + address +
         " and following ones are refused";
}

// Without an address: a count of messages.
std::string judged_text(const core::Event& event, const std::string& address) {
  std::string text = event.kind == core::EventKind::kDenied ? "denied: " : "would be denied: ";
  if (event.address.raw() != 0) text += client_text(event.client) + " to " + address + ", ";
  return text + valid_utf8(event.text.view());
}

}  // namespace

std::string client_text(const core::Peer& client) {
  std::string text(client.name.view());
  if (text.empty())
    text = client.endpoint.empty() ? "client " + std::to_string(client.id.value)
                                   : std::string(client.endpoint.view());
  if (client.pid != 0) text += " (pid " + std::to_string(client.pid) + ")";
  return valid_utf8(text);
}

std::string router_text(const core::Peer& router) {
  std::string text = valid_utf8(router.name.view());
  if (!router.endpoint.empty()) text += " (" + valid_utf8(router.endpoint.view()) + ")";
  return text;
}

std::string event_text(const core::Event& event, const AddressWidths& widths) {
  using core::EventKind;
  const std::string address = event.address.to_string(widths);
  const std::string client = client_text(event.client);
  const std::string reason(core::sentence(event.reason));
  switch (event.kind) {
    case EventKind::kClientCame:
      return client + " connected";
    case EventKind::kRegistered:
      return address + " registered by " + client;
    case EventKind::kWithdrawn:
      return address + " withdrawn by " + client;
    case EventKind::kAddressRefused:
      return refused_text(event, widths);
    case EventKind::kMailboxLimit:
      return limit_text(event, address);
    case EventKind::kDeleteRefused:
      return client + " may not delete " + address + ": it belongs to " + client_text(event.owner);
    case EventKind::kClientRefused:
      return client + " was refused: " + reason;
    case EventKind::kClientWent:
      return client + " disconnected" + (reason.empty() ? "" : ": ") + reason;
    case EventKind::kLinkUp:
      return "link to " + router_text(event.client) + " is up";
    case EventKind::kLinkDown:
      return "link to " + router_text(event.client) + " is down: " + reason;
    case EventKind::kLinkRefused:
      return "link with " + router_text(event.client) +
             " refused: " + valid_utf8(event.text.view());
    case EventKind::kLinkPath:
      return "link to " + router_text(event.client) + " changed from " +
             valid_utf8(event.text.view());
    case EventKind::kLinkRenamed:
      return "the certificate of " + router_text(event.client) + " has changed, it named " +
             valid_utf8(event.text.view());
    case EventKind::kUplinkChanged:
      return event.client.id ? "unknown destinations are sent up to " + router_text(event.client)
                             : std::string("there is no super router now");
    case EventKind::kDuplicateAddress:
      return address + " of " + router_text(event.client) + " is not used: " +
             (event.owner.id ? router_text(event.owner) : std::string("this router")) +
             " has it already";
    case EventKind::kDuplicateRouter:
      return address + " is both " + router_text(event.client) + " and " +
             router_text(event.owner) + ": change the system or id of one of them";
    case EventKind::kLoop:
      return "messages to " + address + " are in a loop: they come from " +
             router_text(event.client) + " and would go on to " + router_text(event.owner);
    case EventKind::kLeaseTaken:
      return "driving lease taken: " + valid_utf8(event.text.view());
    case EventKind::kLeaseEnded:
      return "driving lease ended: " + valid_utf8(event.text.view());
    case EventKind::kDrivingRefused:
      return "driving commands from " + address + " (" + client +
             ") are refused: the driving lease has " + valid_utf8(event.text.view());
    case EventKind::kRouterChanged:
      return client + " changed the router: " + valid_utf8(event.text.view());
    case EventKind::kDenied:
    case EventKind::kObserved:
      return judged_text(event, address);
    case EventKind::kWatchdogClosed:
    case EventKind::kProtocolError:
    case EventKind::kMemoryClosed:
      return client + " was disconnected: " + reason;
    default:
      return std::string(core::sentence(event.kind));
  }
}

}  // namespace tims::io
