// Uses a part of every public header. Without a router it must report this, not crash.
#include <chrono>
#include <iostream>

#include <tims/address.h>
#include <tims/mailbox.h>
#include <tims/session.h>

int main() {
  const auto address = tims::Address::parse("Ladar(3/0)");
  if (!address || address->to_string() != "Ladar(3/0)") return 1;
  const auto session = tims::Session::connect({.name = "outside",
                                               .router = "/nonexistent/router.sock",
                                               .timeout = std::chrono::milliseconds(1),
                                               .on_event = [](const tims::SessionEvent&) {}});
  if (session.ok()) return 1;
  std::cout << session.error().message() << '\n';
}
