#!/usr/bin/env bash
# setup_test.sh: `tools/dev setup` on a machine where a package of ours drives out one of the user's.
# Debian's tools are stood in for: what is installed here is not for a test to change.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() { echo "$*" >&2; cat "$work"/{said,called} >&2; exit 1; }

# program NAME: its text comes from standard input; each call is noted.
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

if PATH=$work:$PATH "$here/../../tools/dev" setup >"$work/said" 2>&1; then fail "it did not stop"; fi
grep -q 'libboost1.74-dev \[1.74.0+ds1-21\]' "$work/said" || fail "what stands in the way is not named"
if grep -q '^apt-get install -y' "$work/called"; then fail "it installed all the same"; fi

program apt-get <<<''  # nothing stands in the way
PATH=$work:$PATH "$here/../../tools/dev" setup >"$work/said" 2>&1 || fail "it should have installed"
installed() { grep "^apt-get install -y .*--no-remove .*$1" "$work/called"; }
installed libboost1.81-dev >"$work/said" || fail "not as asked"
grep -q clang-tidy-16 "$work/said" || fail "setup must install what tests need, too"

# A build needs less; it ends here because the installation fails.
program apt-get <<'TEXT'
case "$*" in "install -y"*) exit 1 ;; esac
TEXT
for verb in build demo fleet bench; do
  : >"$work/called"
  if PATH=$work:$PATH "$here/../../tools/dev" $verb >"$work/said" 2>&1; then fail "$verb: it did not stop"; fi
  installed libboost1.81-dev >"$work/said" || fail "$verb: what it is built with is not installed"
  if grep -qE 'clang|doxygen|help2man' "$work/said"; then fail "$verb: installs more than it needs"; fi
done
