#!/usr/bin/env bash
# abi_test.sh BUILD [--update]: compares the functions of the C APIs (tims.h, rack.h) and the layouts of the structs that
# they take with those of the last release (*.abi here). A program of the last release must run with this library: what
# changes needs another SONAME. Libraries of C++ promise nothing of that kind.
set -euo pipefail
build=$1 update=${2:-}
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if ! command -v abidw >/dev/null; then echo "abidw is missing: apt-get install abigail-tools"; exit 77; fi

# describe LIBRARY PREFIX HEADER: of each exported function a pointer with its type, in C, where what is private is
# not known, and where nothing depends on the options and the standard library that the library is built with.
describe() {
  nm -D --defined-only "$build/lib/$1.so" | sed -nE "s/.* ($2_[a-z_]*)(@.*)?$/\1/p" | LC_ALL=C sort >"$work/functions"
  [[ -s $work/functions ]] || { echo "$1.so exports no $2_*" >&2; exit 1; }
  { echo "#include <$3>"; sed 's/.*/__typeof__(\&&) of_& = \&&;/' "$work/functions"; } >"$work/$1.c"
  gcc -g -O0 -shared -fPIC -I "$root/libtims/include" -I "$root/components/runtime/include" -Wl,-soname,"$1" \
    -o "$work/$1.so" "$work/$1.c"
  abidw --no-show-locs --no-corpus-path --no-comp-dir-path --no-elf-needed --type-id-style hash \
    --out-file "$work/$1.abi" "$work/$1.so"
  sed -i "s| path='[^']*'||" "$work/$1.abi"
}

# compare LIBRARY: its description here, and there.
compare() {
  if [[ $update == --update ]]; then cp "$work/$1.abi" "$here/$1.abi"; return; fi
  abidiff --no-architecture "$here/$1.abi" "$work/$1.abi" || {
    echo "The C API of $1.so is another one than $1.abi. What breaks programs needs another SONAME; then:" >&2
    echo "tests/install/abi_test.sh BUILD --update" >&2
    exit 1
  }
}

describe libtims tims tims.h
compare libtims
describe librack rack rack.h
compare librack
