// A base and a robot on two hosts with a line between them, on which packets can be dropped, and
// what the routers report about their link.
#pragma once

#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <gmock/gmock.h>

#include "tests/support/eventually.h"
#include "tests/support/two_networks.h"
#include "tests/system/host.h"

namespace tims::test {

// The router's status of its link to `peer`; null: no link.
inline boost::json::value link_of(const Host& host, std::string_view peer) {
  namespace json = boost::json;
  boost::system::error_code error;
  const json::value answer = json::parse(host.timsctl({"link", "show", "--json"}), error);
  if (error || answer.as_object().if_contains("items") == nullptr) return nullptr;
  for (const json::value& item : answer.at("items").as_array()) {
    const json::value& name = item.at("peer");
    if (name.is_string() && name.as_string() == peer) return item;
  }
  return nullptr;
}

// Waits until the link to `peer` is up and this router sends over that path.
inline testing::AssertionResult goes_by(const Host& host, const std::string& peer,
                                        const std::string& path, Duration within = kPatience) {
  return eventually(
      [&]() -> std::string {
        const boost::json::value link = link_of(host, peer);
        if (link.is_null()) return "no link to " + peer;
        const bool good = link.at("state") == "up" && link.at("path").as_string() == path;
        return good ? "" : "link to " + peer + ": " + boost::json::serialize(link);
      },
      within);
}

// Waits until all paths of the link to `peer` work; a link that loses one before that is down until
// the other is prepared.
inline testing::AssertionResult all_paths_work(const Host& host, const std::string& peer) {
  return eventually(
      [&] {
        const boost::json::value link = link_of(host, peer);
        if (link.is_null()) return false;
        for (const auto& path : link.at("paths").as_array())
          if (!path.at("works").as_bool()) return false;
        return true;
      },
      "all paths work");
}

// The hosts, without anything that runs there.
class OnTwoNetworks : public testing::Test {
 protected:
  void SetUp() override {
    auto made = TwoNetworks::enter();
    if (!made) GTEST_SKIP() << made.error().message();
    networks_.emplace(std::move(*made));
  }

  std::optional<TwoNetworks> networks_;
};

class TwoHosts : public OnTwoNetworks {
 protected:
  void TearDown() override {
    if (HasFailure() && robot_)
      std::cerr << "base:\n" << base_->log() << "robot:\n" << robot_->log();
    // The programs must exit before their networks are removed.
    robot_.reset();
    base_.reset();
  }
  // Drops matching packets (of nft) on the left host, incoming or outgoing.
  static void drop(const std::vector<std::string>& what, bool in = true, bool out = true) {
    std::string commands = "nft add table inet cut\n";
    for (const char* hook : {"input", "output"})
      commands += std::string("nft add chain inet cut ") + hook + " '{ type filter hook " + hook +
                  " priority 0; }'\n";
    for (const std::string& match : what) {
      if (in) commands += "nft add rule inet cut input " + match + " drop\n";
      if (out) commands += "nft add rule inet cut output " + match + " drop\n";
    }
    const auto done = TwoNetworks::run(commands);
    ASSERT_TRUE(done.ok()) << done.error().message();
  }
  static void heal() {
    const auto done = TwoNetworks::run("nft flush ruleset");
    ASSERT_TRUE(done.ok()) << done.error().message();
  }

  std::unique_ptr<Host> base_;
  std::unique_ptr<Host> robot_;
};

}  // namespace tims::test
