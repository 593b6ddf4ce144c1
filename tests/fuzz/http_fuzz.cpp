// The requests do not depend on how the bytes of a connection are divided; the target and the
// fields of each request are parsed without errors, and only files of the console are sent.
#include <string>
#include <vector>

#include "router/io/http/http_message.h"
#include "router/io/http/http_pages.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using tims::io::HttpReader;
using tims::io::HttpRequest;

const tims::io::ConsoleFiles& console() {
  static const tims::io::ConsoleFiles files = [] {
    tims::io::ConsoleFiles made;
    for (const auto* path : {"index.html", "a.js", "a.js.br", "a.js.gz"})
      tims::fuzz::require(made.add(path, std::string("form ") + path).ok());
    return made;
  }();
  return files;
}

// All parts of a request as one text.
std::string as_text(const HttpRequest& request) {
  std::string text = request.method + ' ' + request.target + ' ' + std::to_string(request.version);
  text += request.keep_alive ? " keep" : " close";
  text += request.wants_websocket ? " websocket" : "";
  for (const HttpRequest::Field& field : request.fields) {
    text += '\n' + field.name + ": " + field.value;
    tims::fuzz::use(tims::io::is_safe_host(field.value));
    for (const bool is_tls : {false, true})
      tims::fuzz::use(tims::io::is_safe_origin(field.value, is_tls, request.target));
  }
  for (const bool is_tls : {false, true})
    tims::fuzz::use(tims::io::refusal_of(request, is_tls, {.names = {"robot7"}, .origins = {}}));
  if (console().has(request.path())) {
    const tims::io::HttpResponse response = console().answer(request);
    tims::fuzz::require(response.status == 304 ? response.stored.empty()
                                               : response.stored.starts_with("form "));
    text += '\n' + tims::io::to_bytes(response, {});
  }
  tims::fuzz::use(tims::io::api_question(request.path(), request.query()));
  return text;
}

std::vector<std::string> read(std::string_view stream, std::size_t chunk_max) {
  HttpReader reader;
  std::vector<std::string> requests;
  for (;;) {
    const HttpReader::Status status = reader.next();
    if (status == HttpReader::Status::kRequest) {
      requests.push_back(as_text(reader.request()));
      continue;
    }
    // An invalid request may be detected earlier or later, depending on the chunks.
    if (status == HttpReader::Status::kRefused || stream.empty()) return requests;
    const auto room = reader.room();
    tims::fuzz::require(!room.empty());
    const std::size_t n = std::min({stream.size(), room.size(), chunk_max});
    stream.copy(room.data(), n);
    stream.remove_prefix(n);
    reader.advance(n);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tims::fuzz::Input input(data, size);
  const std::size_t cut = input.number<std::uint8_t>() + std::size_t{1};
  const std::string_view stream = input.text();
  const auto whole = read(stream, stream.size() + 1);
  tims::fuzz::require(read(stream, cut) == whole);
  tims::fuzz::require(read(stream, 1) == whole);
  return 0;
}
