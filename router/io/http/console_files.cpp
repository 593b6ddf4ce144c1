#include "router/io/http/console_files.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "base/text.h"

namespace tims::io {
namespace {

// Nothing from other hosts, no inline script or style, in no frame of another page. Scripts of
// workers have their own policy, so it is sent with every file.
constexpr std::string_view kProtection =
    "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; "
    "img-src 'self' blob: data:; connect-src 'self'; worker-src 'self'; font-src 'self'; "
    "manifest-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n"
    "Referrer-Policy: no-referrer\r\n"
    "Cross-Origin-Opener-Policy: same-origin\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\n";

// The name of a file with a hash of its bytes in it changes with the bytes.
constexpr std::string_view kForEver = "public, max-age=31536000, immutable";
constexpr std::string_view kAskEachTime = "no-cache";

struct Type {
  std::string_view ending;
  std::string_view name;
};
constexpr std::array kTypes{
    Type{".html", "text/html; charset=utf-8"},
    Type{".js", "text/javascript; charset=utf-8"},
    Type{".css", "text/css; charset=utf-8"},
    Type{".svg", "image/svg+xml"},
    Type{".png", "image/png"},
    Type{".ico", "image/x-icon"},
    Type{".webp", "image/webp"},
    Type{".json", "application/json"},
    Type{".map", "application/json"},
    Type{".webmanifest", "application/manifest+json"},
    Type{".woff2", "font/woff2"},
    Type{".wasm", "application/wasm"},
    Type{".txt", kTextType},
};

std::string_view type_of(std::string_view path) {
  const auto* const found =
      std::ranges::find_if(kTypes, [&](const Type& type) { return path.ends_with(type.ending); });
  return found == kTypes.end() ? "application/octet-stream" : found->name;
}

bool is_letter_or_digit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

// "app/main-A1B2C3D4.js": parts of letters, digits, '-', '_' and '.', none of which is hidden or
// leads out of the folder. Such a path is the same in a URL.
bool is_plain_path(std::string_view path) {
  char before = '/';
  for (const char c : path) {
    const bool first = before == '/';
    if (!is_letter_or_digit(c) && c != '_' && (first || (c != '-' && c != '.' && c != '/')))
      return false;
    before = c;
  }
  return before != '/';
}

// True for a name with a hash as esbuild writes it: "main-A1B2C3D4.js".
bool has_hash(std::string_view path) {
  constexpr std::size_t kHashLetters = 8;
  const std::string_view name = path.substr(path.rfind('/') + 1);
  const std::string_view stem = name.substr(0, name.find('.'));
  if (stem.size() <= kHashLetters || stem[stem.size() - kHashLetters - 1] != '-') return false;
  return std::ranges::all_of(stem.substr(stem.size() - kHashLetters), [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
  });
}

// FNV-1a. Between versions of a file the tag must differ; nobody gains by equal ones.
std::uint64_t hash_of(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

// Calls `each` with the elements of a list such as "gzip, br;q=0.5", of all fields with this name.
template <typename Each>
void for_each_element(const HttpRequest& request, std::string_view name, Each each) {
  for (const HttpRequest::Field& field : request.fields) {
    if (!equal_ignoring_case(field.name, name)) continue;
    for (std::string_view rest = field.value; !rest.empty();) {
      const std::size_t end = std::min(rest.find(','), rest.size());
      each(base::trimmed(rest.substr(0, end)));
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }
}

// The weight of "br;q=0.000" is zero: it is excluded.
bool is_excluded(std::string_view parameters) {
  const std::size_t sign = parameters.find('=');
  if (sign == std::string_view::npos) return false;
  const std::string_view weight = base::trimmed(parameters.substr(sign + 1));
  return !weight.empty() && weight.find_first_not_of("0.") == std::string_view::npos;
}

bool accepts(const HttpRequest& request, std::string_view coding) {
  std::optional<bool> named;
  bool others = false;
  for_each_element(request, "Accept-Encoding", [&](std::string_view element) {
    const std::size_t end = std::min(element.find(';'), element.size());
    const std::string_view name = base::trimmed(element.substr(0, end));
    const bool accepted = !is_excluded(element.substr(end));
    if (equal_ignoring_case(name, coding)) named = accepted;
    if (name == "*") others = accepted;
  });
  return named.value_or(others);
}

bool has_tag(const HttpRequest& request, std::string_view tag) {
  bool found = false;
  for_each_element(request, "If-None-Match", [&](std::string_view element) {
    if (element.starts_with("W/")) element.remove_prefix(2);
    found = found || element == tag || element == "*";
  });
  return found;
}

std::string escaped_html(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '&')
      out += "&amp;";
    else
      out += c;
  }
  return out;
}

Error refused(std::string_view path, std::string_view why) {
  return {Errc::kInvalidArgument, fmt::format("{}: {}", path, why)};
}

}  // namespace

ConsoleFiles ConsoleFiles::without_console(std::string_view reason) {
  ConsoleFiles files;
  (void)files.add("index.html", fmt::format(R"(<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>RACK: no console</title>
<link rel="icon" href="data:,">
<h1>This router has no console</h1>
<p>{}</p>
<p>How to get it: install the package <code>tims-console</code>, or build it from the sources with
<code>tools/dev setup</code> and <code>tools/dev build</code>, which need npm; or set
<code>http.console</code> to a folder that contains it. Then restart the router.</p>
<p>Everything else works without it: <a href="/api/status">/api/status</a>,
<a href="/metrics">/metrics</a>, and <code>timsctl</code>.</p>
</html>
)",
                                            escaped_html(reason)));
  return files;
}

Result<void> ConsoleFiles::add(std::string_view path, std::string bytes) {
  if (!is_plain_path(path))
    return refused(path,
                   "its name has other characters than letters, digits, '-', '_' and '.', or "
                   "begins with '.' or '-'");
  Coding coding = kPlain;
  std::string_view name = path;
  for (const auto& [ending, its_coding] : {std::pair(".br", kBrotli), std::pair(".gz", kGzip)})
    if (path.ends_with(ending)) {
      coding = its_coding;
      name.remove_suffix(3);
    }
  if (bytes.size() > kBytesMax - bytes_)
    return refused(path, fmt::format("with it, the files have more than {} bytes", kBytesMax));
  if (files_.size() == kFilesMax && !files_.contains(name))
    return refused(path, fmt::format("there are more than {} files", kFilesMax));
  File& file = files_[std::string(name)];
  if (file.forms[coding]) return refused(path, "added twice");
  file.type = type_of(name);
  file.cache = has_hash(name) ? kForEver : kAskEachTime;
  constexpr std::array<std::string_view, kCodings> kFields{"Content-Encoding: br\r\n",
                                                           "Content-Encoding: gzip\r\n", ""};
  const std::string tag = fmt::format("\"{:016x}-{}\"", hash_of(bytes), bytes.size());
  std::string fields =
      fmt::format("{}ETag: {}\r\nVary: Accept-Encoding\r\n{}", kFields[coding], tag, kProtection);
  bytes_ += bytes.size();
  file.forms[coding] = Form{std::move(bytes), tag, std::move(fields)};
  return {};
}

Result<void> ConsoleFiles::check() const {
  if (!files_.contains(std::string_view("index.html")))
    return Error(Errc::kInvalidArgument, "there is no index.html in it");
  for (const auto& [path, file] : files_)
    if (!file.forms[kPlain]) return refused(path, "only a compressed form of it is there");
  return {};
}

const ConsoleFiles::File* ConsoleFiles::find(std::string_view path) const {
  if (!path.starts_with('/')) return nullptr;
  const auto found = files_.find(path == "/" ? "index.html" : path.substr(1));
  return found == files_.end() ? nullptr : &found->second;
}

HttpResponse ConsoleFiles::answer(const HttpRequest& request) const {
  const File& file = *find(request.path());
  const Form& form = choose(file, request);
  const bool is_known = has_tag(request, form.tag);
  return {.status = is_known ? 304 : 200,
          .type = file.type,
          .body = {},
          .field = form.fields,
          .cache = file.cache,
          .stored = is_known ? std::string_view() : std::string_view(form.bytes)};
}

const ConsoleFiles::Form& ConsoleFiles::choose(const File& file, const HttpRequest& request) {
  if (file.forms[kBrotli] && accepts(request, "br")) return *file.forms[kBrotli];
  if (file.forms[kGzip] && accepts(request, "gzip")) return *file.forms[kGzip];
  return *file.forms[kPlain];
}

}  // namespace tims::io
