#!/bin/sh
# What a shared library exports is what its version scripts list and, if headers are given, what those declare with FB_API:
# no more and no less.
#   test_exports.sh LIBRARY MAP... [HEADER...]
set -eu
library=$1
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# nm prints "address type name@@VERSION"; type A is the version itself.
nm --dynamic --defined-only "$library" | awk '$2 != "A" { sub(/@.*/, "", $3); print $3 }' | sort >"$work/exported"
[ -s "$work/exported" ] || { echo "FAILED: $library exports nothing"; exit 1; }
for file in "$@"; do
  case $file in
    *.map) sed 's/#.*//' "$file" | grep -o 'fb_[a-z0-9_]*' >>"$work/maps" ;;
    *.h) sed -n 's/^FB_API .*[ *]\(fb_[a-z0-9_]*\)(.*/\1/p' "$file" >>"$work/headers" ;;
  esac
done
for source in "$work/maps" "$work/headers"; do
  [ -e "$source" ] || continue
  sort "$source" | diff - "$work/exported" && continue
  echo "FAILED: $library exports the names marked > that its ${source##*/} lack, or lacks those marked <"
  exit 1
done
