#!/bin/sh
# Makes the API reference of the public headers with Doxygen; warnings are errors.
#   docs/build_reference.sh [DIR]       default: build/reference; then open DIR/html/index.html
set -eu
cd "$(dirname "$0")/.."
out=${1:-build/reference}
if ! command -v doxygen >/dev/null; then
  echo "docs/build_reference.sh: there is no doxygen; apt-get install doxygen" >&2
  exit 77
fi
mkdir -p "$out"
{
  cat docs/Doxyfile
  echo "OUTPUT_DIRECTORY = \"$out\""
  echo "PROJECT_NUMBER = $(cat VERSION)"
} | doxygen -
