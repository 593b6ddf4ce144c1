#!/usr/bin/env bash
# setup_test.sh: `tools/dev setup` on a machine where a required package would remove one of the
# user's. Debian's tools are replaced by scripts, because a test must not change installed packages.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() { echo "$*" >&2; cat "$work"/{output,called} >&2; exit 1; }

# program NAME: creates a program from standard input; each call is recorded.
program() {
  { echo '#!/bin/sh'; echo "echo \"$1 \$*\" >>$work/called"; cat; } >"$work/$1"
  chmod +x "$work/$1"
}

program dpkg-query <<<''  # nothing is installed
program sudo <<<'exec "$@"'
program apt-get <<'TEXT'
case "$*" in
  *" -s "*) echo 'Remv libboost1.74-dev [1.74.0+ds1-21]'; echo 'Inst libboost1.81-dev (1.81.0-5 Debian:12)' ;;
esac
TEXT

if PATH=$work:$PATH "$here/../../tools/dev" setup >"$work/output" 2>&1; then fail "it did not stop"; fi
grep -q 'libboost1.74-dev \[1.74.0+ds1-21\]' "$work/output" || fail "the package to be removed is not named"
if grep -q '^apt-get install -y' "$work/called"; then fail "it installed packages nevertheless"; fi

program apt-get <<<''  # no package would be removed
PATH=$work:$PATH "$here/../../tools/dev" setup >"$work/output" 2>&1 || fail "it should have installed"
installed() { grep "^apt-get install -y .*--no-remove .*$1" "$work/called"; }
installed libboost1.81-dev >"$work/output" || fail "the required package was not installed"
grep -q clang-tidy-16 "$work/output" || fail "setup must install the packages of tests as well"

# A build needs fewer packages; here it stops because the installation fails.
program apt-get <<'TEXT'
case "$*" in "install -y"*) exit 1 ;; esac
TEXT
for verb in build demo fleet bench; do
  : >"$work/called"
  if PATH=$work:$PATH "$here/../../tools/dev" $verb >"$work/output" 2>&1; then fail "$verb: it did not stop"; fi
  installed libboost1.81-dev >"$work/output" || fail "$verb: build dependencies are not installed"
  if grep -qE 'clang|doxygen|help2man' "$work/output"; then fail "$verb: installs more than it needs"; fi
done
