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
grep -q '^apt-get install -y .*--no-remove .*libboost1.81-dev' "$work/called" || fail "not as asked"
