// What a component's program states about itself with --describe
// (components/runtime/logic/README.md), read from its JSON. Pure.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/cli/output.h"

namespace timsctl::configuration {

struct Description {
  struct Parameter {
    std::string name{};
    std::string type{};  // "int", "float", "text"
    std::string initial{};
    std::optional<double> min{};
    std::optional<double> max{};
    std::string unit{};
    std::vector<std::string> choices{};
    std::string takes_effect{};
    bool required = false;
    bool host_file = false;

    // Why this value is refused: "must be from 0 to 10, not 11"; empty: it is good.
    [[nodiscard]] std::string refusal(std::string_view value) const;
  };
  struct Input {
    std::string class_name{};
    std::string system{};  // names of parameters
    std::string instance{};
    bool optional = false;
  };
  struct Output {
    std::string class_name{};
    std::string period{};  // name of a parameter; empty: none
    double default_ms = 0;
  };
  std::string program{};
  std::string class_name{};
  std::uint32_t class_id = 0;
  std::vector<Parameter> parameters{};
  std::vector<Input> inputs{};
  std::vector<Output> outputs{};

  [[nodiscard]] const Parameter* find(std::string_view name) const;
  [[nodiscard]] std::vector<std::string> names() const;
};

std::optional<Description> description_of(const json::object& described);

// Null: the program is not known on this host.
using Describe = std::function<const Description*(const std::string& program)>;

}  // namespace timsctl::configuration
