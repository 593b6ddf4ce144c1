// What an agent keeps on the disk: its record, and the files of every generation.
#pragma once

#include <optional>
#include <string>

#include "tims/result.h"
#include "tools/cli/output.h"
#include "tools/configuration/folder.h"
#include "tools/configuration/host_change.h"

namespace timsctl::configuration {

json::object to_json(const Item& item);
json::object to_json(const Record& record);
// Empty: not a record. Pure.
std::optional<Record> record_of(const json::value& value);

class Store {
 public:
  // Makes the folder.
  explicit Store(std::string path);

  // A record that does not exist is an empty one; one that cannot be understood is an error.
  [[nodiscard]] tims::Result<Record> load() const;
  [[nodiscard]] tims::Result<void> save(const Record& record) const;
  [[nodiscard]] tims::Result<Texts> files(Generation generation) const;
  [[nodiscard]] tims::Result<void> keep(Generation generation, const Texts& files) const;
  // Removes the files of generations that the record no longer has.
  void forget(const Record& record) const;

 private:
  [[nodiscard]] std::string path_of(Generation generation) const;

  std::string path_;
};

}  // namespace timsctl::configuration
