#!/bin/sh
# Builds the Debian packages, archives of the source and of everything that is installed, and the add-on for Blender, of the
# committed tree:
#   packager/packages/build_debs.sh [--without-viewer] [OUT_DIR]    by default build/packages
# The viewer's page is part of all of them, as it is in build/viewer; where it is not there, samples/viewer/build.sh builds it,
# which installs Emscripten and npm and takes some 20 minutes. --without-viewer leaves it out.
# Installs what building needs. In the environment: FB_MAINTAINER, "Name <address>", who the packages are by;
# FB_PARALLEL, how many compilers run at once.
set -eu
cd "$(dirname "$0")/../.."
viewer=$PWD/build/viewer
if [ "${1-}" = --without-viewer ]; then
  viewer=
  shift
fi
out=${1:-build/packages}
maintainer=${FB_MAINTAINER:-FaceBaker developers <developers@facebaker.invalid>}
samples/setup.sh
missing=""
for package in debhelper dh-python dpkg-dev fakeroot; do
  dpkg-query --show --showformat='${db:Status-Status}\n' "$package" 2>/dev/null | grep -qx installed || missing="$missing $package"
done
# shellcheck disable=SC2086
[ -z "$missing" ] || apt-get install -y --no-install-recommends -o DPkg::Lock::Timeout=600 $missing

version=$(cat VERSION)
# As in capi/CMakeLists.txt: while the major version is 0, every minor version has a name of its own.
case $version in
  0.*) soversion=${version%.*} ;;
  *) soversion=${version%%.*} ;;
esac
mkdir -p "$out"
out=$(cd "$out" && pwd)
[ -z "$viewer" ] || [ -f "$viewer/index.html" ] || samples/viewer/build.sh "$viewer"
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
export SOURCE_DATE_EPOCH

rm -rf "$out/debian" && mkdir "$out/debian"
git archive --format=tar --prefix="facebaker-$version/" HEAD | gzip -9n >"$out/facebaker-$version-source.tar.gz"
cp "$out/facebaker-$version-source.tar.gz" "$out/debian/facebaker_$version.orig.tar.gz"
tar -xzf "$out/debian/facebaker_$version.orig.tar.gz" -C "$out/debian"
cd "$out/debian/facebaker-$version"
[ -z "$viewer" ] || cp -r "$viewer" viewer # beside the build folder, where packager/server and make_addon.py look for it
cp -r packager/packages/debian debian
fill() {
  sed -e "s/@VERSION@/$version/g" -e "s/@SOVERSION@/$soversion/g" -e "s/@MAINTAINER@/$maintainer/g" \
    -e "s/@DATE@/$(date -R -u -d "@$SOURCE_DATE_EPOCH")/g" "$1" >"$2"
  rm "$1"
}
fill debian/control.in debian/control
fill debian/changelog.in debian/changelog
for library in libfacebaker libfacebaker-bake; do
  for list in install symbols; do fill debian/$library.$list.in debian/$library$soversion.$list; done
done

if command -v ccache >/dev/null; then # the packages' build has no home folder
  CCACHE_DIR=$(ccache --get-config cache_dir)
  export CCACHE_DIR CCACHE_BASEDIR="$PWD" CCACHE_NOHASHDIR=1
  export CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache
fi
# Debug information, which is in no package, takes a third of the compilers' time.
export DEB_CFLAGS_STRIP=-g DEB_CXXFLAGS_STRIP=-g
DEB_BUILD_OPTIONS="nocheck noautodbgsym parallel=${FB_PARALLEL:-$(nproc)}" dpkg-buildpackage --build=binary --no-sign >"$out/build.log" 2>&1 ||
  { tail -40 "$out/build.log" >&2; echo "building failed; all of it is in $out/build.log" >&2; exit 1; }
mv ../*.deb ../*.buildinfo ../*.changes "$out/"

# For the archive the same, but as it works in any folder: the tool finds its libraries beside itself, which have zlib and
# what decodes pictures in them.
build=$(ls -d obj-*)
{
  archives=/usr/lib/$(dpkg-architecture -q DEB_HOST_MULTIARCH)
  cmake -B "$build" -D CMAKE_SKIP_INSTALL_RPATH=OFF -D CMAKE_INSTALL_LIBDIR=lib -D FB_ZSH_DIR=share/zsh/site-functions \
    -D ZLIB_LIBRARY_RELEASE="$archives/libz.a" -D PNG_LIBRARY_RELEASE="$archives/libpng.a" \
    -D TURBOJPEG_LIBRARY="$archives/libturbojpeg.a" -D WEBP_LIBRARY="$archives/libwebp.a"
  cmake --build "$build" --parallel "${FB_PARALLEL:-$(nproc)}"
} >>"$out/build.log" 2>&1
cpack --config "$build/CPackConfig.cmake" -D CPACK_PACKAGE_DIRECTORY="$out" -D CPACK_PACKAGING_INSTALL_PREFIX=/ >>"$out/build.log"
/usr/bin/python3 -B bindings/blender/make_addon.py "$build" "$out/facebaker_blender-$version-Linux-$(uname -m).zip"
cd "$out"
rm -rf _CPack_Packages debian
ls -l "$out"/*.deb "$out"/*.tar.gz "$out"/*.zip
