#!/usr/bin/env bash
# exports_test.sh BUILD: checks names and versions of the exported symbols of libtims.so. A change of
# libtims.exports is a change of the binary interface for other programs.
set -euo pipefail
build=$1
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
library=$build/lib/libtims.so
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() { echo "$*" >&2; exit 1; }

soname=$(readelf -d "$library" | sed -n 's/.*Library soname: \[\(.*\)\]/\1/p')
version=TIMS_${soname#libtims.so.}
[[ $soname =~ ^libtims\.so\.[0-9]+\.[0-9]+$ ]] || fail "an unexpected SONAME: $soname"

nm -D --defined-only --with-symbol-versions "$library" >"$work/symbols"
if grep -vE "@@$version\$| A $version\$" "$work/symbols"; then fail "symbols with another version than $version"; fi
sed -nE "s/^[0-9a-f]+ [TWV] (.*)@@$version\$/\1/p" "$work/symbols" | c++filt | LC_ALL=C sort -u >"$work/exports"
diff "$here/libtims.exports" "$work/exports" ||
  fail "the exports of libtims.so differ from libtims.exports (< expected, > found)"
