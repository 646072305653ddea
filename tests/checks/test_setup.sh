#!/bin/sh
# samples/setup.sh against stand-ins for dpkg-query, apt-get, id and sudo: it installs what is missing and nothing else.
#   test_setup.sh SETUP
# Stubs are scripts in single quotes; "A && B || fail" means what it says.
# shellcheck disable=SC2015,SC2016
set -eu
setup=$1
stubs=$(mktemp -d)
trap 'rm -rf "$stubs"' EXIT

# stub NAME SCRIPT: a command NAME that comes before the real one.
stub() { printf '#!/bin/sh\n%s\n' "$2" >"$stubs/$1" && chmod +x "$stubs/$1"; }
# Runs setup.sh with the stubs and keeps its exit code and all it printed.
run() {
  : >"$stubs/calls"
  if output=$(PATH="$stubs:$PATH" STUBS="$stubs" "$setup" "$@" 2>&1); then code=0; else code=$?; fi
}
fail() { echo "FAILED: $1; exit code $code, output: $output, calls: $(cat "$stubs/calls")"; exit 1; }

# The last argument of dpkg-query is the package.
stub apt-get 'echo "apt-get $*" >>"$STUBS/calls"'
stub sudo 'echo "sudo $*" >>"$STUBS/calls"; "$@"'
stub id 'echo 0'

stub dpkg-query 'echo installed'
run
[ $code = 0 ] && [ ! -s "$stubs/calls" ] && [ -z "$output" ] || fail "nothing missing, yet something was done"

stub dpkg-query 'for p; do :; done; case $p in cmake|doctest-dev) echo not-installed ;; *) echo installed ;; esac'
run
[ $code = 0 ] || fail "root could not install"
grep -q '^apt-get .* update$' "$stubs/calls" || fail "the lists were not updated"
grep -q '^apt-get .*Timeout=600 .*--no-install-recommends cmake doctest-dev$' "$stubs/calls" || fail "wrong packages"
! grep -q sudo "$stubs/calls" || fail "root used sudo"

run --sanitizers
grep -q 'recommends cmake doctest-dev$' "$stubs/calls" || fail "--sanitizers installed what is there"

stub id 'echo 1000'
run
[ "$(grep -c '^sudo ' "$stubs/calls")" = 2 ] || fail "a user did not go through sudo"

stub apt-get 'exit 100'
run
[ $code = 100 ] || fail "a failure of apt-get was lost"

run --nonsense
[ $code = 2 ] || fail "an unknown option was accepted"
