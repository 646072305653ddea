#!/bin/sh
# Builds the documentation as a site, which any web server can give and a browser can open from the disk:
#   docs/build_site.sh [--viewer FOLDER] [--packages FOLDER] [OUT_DIR]    default: build/site; then open OUT_DIR/index.html
# --viewer: a built viewer (samples/viewer), which becomes the demo. --packages: what build_dist.py or build_debs.sh of packager/packages
# made, to be downloaded. Warnings are errors. Installs mkdocs, mkdocs-material,
# KaTeX and doxygen where they are missing (Debian, as root).
set -eu
cd "$(dirname "$0")/.."
viewer="" packages="" out=build/site
while [ $# -gt 0 ]; do
  case $1 in
    --viewer) [ $# -gt 1 ] || { echo "docs/build_site.sh: --viewer needs a folder" >&2; exit 2; }; viewer=$2; shift ;;
    --packages) [ $# -gt 1 ] || { echo "docs/build_site.sh: --packages needs a folder" >&2; exit 2; }; packages=$2; shift ;;
    -*) echo "usage: docs/build_site.sh [--viewer FOLDER] [--packages FOLDER] [OUT_DIR]" >&2; exit 2 ;;
    *) out=$1 ;;
  esac
  shift
done
if [ -n "$viewer" ] && [ ! -f "$viewer/index.html" ]; then
  echo "docs/build_site.sh: $viewer: there is no index.html: build the viewer first" >&2
  exit 1
fi
missing=""
for package in mkdocs mkdocs-material libjs-katex doxygen; do
  dpkg-query --show --showformat='${db:Status-Status}\n' "$package" 2>/dev/null | grep -qx installed || missing="$missing $package"
done
# shellcheck disable=SC2086
[ -z "$missing" ] || apt-get install -y --no-install-recommends -o DPkg::Lock::Timeout=600 $missing

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
/usr/bin/python3 -B docs/site/stage_site.py . "$work" ${viewer:+--viewer} ${packages:+--packages "$packages"}
katex=/usr/share/javascript/katex
mkdir -p "$work/pages/katex/fonts"
cp -L "$katex/katex.min.js" "$katex/katex.min.css" "$work/pages/katex/"
cp -L "$katex"/fonts/*.woff2 "$work/pages/katex/fonts/"
(cd "$work" && mkdocs build --quiet --strict --site-dir site)
docs/build_reference.sh "$work/site/reference"
[ -z "$viewer" ] || cp -r "$viewer" "$work/site/viewer"
mkdir -p "$(dirname "$out")"
rm -rf "$out.partial" && mv "$work/site" "$out.partial"
rm -rf "$out" && mv "$out.partial" "$out"
echo "$out/index.html"
