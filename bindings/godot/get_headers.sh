#!/bin/sh
# Puts the headers of GDNative (Godot 3) into a folder, from Debian's source package of godot3-server, without changing what apt
# knows of the system.
#   bindings/godot/get_headers.sh DIR
set -eu
[ $# -eq 1 ] || { echo "usage: bindings/godot/get_headers.sh DIR" >&2; exit 2; }
out=$(realpath -m "$1")
[ ! -e "$out" ] || { echo "get_headers.sh: $out exists already" >&2; exit 1; }
command -v xz > /dev/null || apt-get -o DPkg::Lock::Timeout=600 -q install -y --no-install-recommends xz-utils > /dev/null
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p lists/partial parts
# The system's own sources, as sources of source packages.
for file in /etc/apt/sources.list /etc/apt/sources.list.d/debian.*; do
  case $file in
    *.sources) [ ! -e "$file" ] || sed 's/^Types:.*/Types: deb-src/' "$file" > parts/debian.sources ;;
    *.list) [ ! -s "$file" ] || sed -n 's/^deb /deb-src /p' "$file" > parts/debian.list ;;
  esac
done
apt="apt-get -q -o APT::Sandbox::User=root -o Dir::Etc::SourceList=/dev/null -o Dir::Etc::SourceParts=$work/parts
  -o Dir::State::Lists=$work/lists"
# The source is found by what is built of it: its own name depends on the release, and so does its compression.
$apt update > log 2>&1 && $apt source --download-only godot3-server >> log 2>&1 || { cat log >&2; exit 1; }
tar xf "$(find . -maxdepth 1 -name 'godot*.orig.tar.*' ! -name '*.asc')" --wildcards '*/modules/gdnative/include/*' '*/modules/gdnative/gdnative_api.json' \
  '*/modules/gdnative/gdnative_builders.py' '*/platform_methods.py'
gdnative=$(echo "$work"/*/modules/gdnative)
# Godot's own script writes the header that its build would.
PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=$gdnative:$(dirname "$(dirname "$gdnative")") python3 -c '
import sys
import gdnative_builders
gdnative_builders.build_gdnative_api_struct([sys.argv[2], sys.argv[2] + ".unused"], [sys.argv[1]], None)
' "$gdnative/gdnative_api.json" "$gdnative/include/gdnative_api_struct.gen.h"
rm "$gdnative/include/gdnative_api_struct.gen.h.unused"
mkdir -p "$(dirname "$out")"
mv "$gdnative/include" "$out"
