#!/bin/sh
# Runs a command in FOLDER as where nothing of FaceBaker is but a packed plugin or package in it: with PATH and HOME alone in
# the environment, and the build folder BUILD hidden (in a mount namespace, where the system allows one: it says if not).
# Libraries in FOLDER must name no folder of this machine, and need libfacebaker under the name of the file that is packed.
#   bindings/engine/tests/run_packed.sh FOLDER BUILD COMMAND...
set -eu
folder=$(realpath "$1")
build=$(realpath "$2")
shift 2
fail() { echo "run_packed.sh: $*" >&2; exit 1; }
find "$folder" -type f -name '*.so*' > "$folder/libraries.list"
while read -r file; do
  dynamic=$(readelf -d "$file" 2>&1) || fail "$file is no library"
  case $dynamic in
    *PATH*"[/"*) fail "$file has the path of a folder of this machine: $dynamic" ;;
    *NEEDED*"[/"*) fail "$file needs a library by the path of this machine: $dynamic" ;;
  esac
  needed=$(echo "$dynamic" | sed -n 's/.*NEEDED.*\[\(libfacebaker[^]]*\)\].*/\1/p')
  [ "$needed" = "" ] || [ "$needed" = libfacebaker.so ] || fail "$file needs $needed, which is not the name of a packed file"
done < "$folder/libraries.list"
rm "$folder/libraries.list"
mkdir -p "$folder/home/.local/share" "$folder/home/.config" "$folder/home/.cache"
cd "$folder"
set -- env -i PATH="$PATH" HOME="$folder/home" LANG=en_GB.UTF-8 OMP_WAIT_POLICY=PASSIVE "$@"
if unshare --mount mount -t tmpfs tmpfs "$build" 2> /dev/null; then
  exec unshare --mount sh -eu -c 'mount -t tmpfs tmpfs "$1"; shift; exec "$@"' sh "$build" "$@"
fi
echo "run_packed.sh: this system allows no mount namespaces: $build is not hidden"
exec "$@"
