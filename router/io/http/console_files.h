// The files of the console as the HTTP port serves them: kept in memory, each with its compressed
// forms. Pure: bytes of files in, answers out; console_folder.h reads the folder.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "router/io/http/http_message.h"
#include "tims/result.h"

namespace tims::io {

class ConsoleFiles {
 public:
  static constexpr std::size_t kFilesMax = 64;        // their compressed forms are not counted
  static constexpr std::size_t kBytesMax = 4U << 20;  // of all files and forms

  // A page that states why there is no console, and how to get it.
  static ConsoleFiles without_console(std::string_view reason);

  // Adds a file. `path`: relative to the folder, such as "index.html" or "main-A1B2C3D4.js.br";
  // ".br" and ".gz" are compressed forms of the file without this ending.
  Result<void> add(std::string_view path, std::string bytes);
  // Whether the files are a console: called after the last one was added.
  [[nodiscard]] Result<void> check() const;

  [[nodiscard]] std::size_t size() const { return files_.size(); }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

  // Whether there is a file for this path of a request. Only equal paths match: nothing is decoded.
  [[nodiscard]] bool has(std::string_view path) const { return find(path) != nullptr; }
  // Precondition: there is one. The bytes of the response are those of this object.
  [[nodiscard]] HttpResponse answer(const HttpRequest& request) const;

 private:
  // In the order of preference of compressed forms.
  enum Coding : std::size_t { kBrotli, kGzip, kPlain, kCodings };
  struct Form {
    std::string bytes;
    std::string tag;     // ETag, with its quotes
    std::string fields;  // of the response
  };
  struct File {
    std::string_view type;
    std::string_view cache;
    std::array<std::optional<Form>, kCodings> forms;
  };

  [[nodiscard]] const File* find(std::string_view path) const;
  [[nodiscard]] static const Form& choose(const File& file, const HttpRequest& request);

  std::map<std::string, File, std::less<>> files_;
  std::size_t bytes_ = 0;
};

}  // namespace tims::io
