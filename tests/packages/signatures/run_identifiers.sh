#!/bin/sh
# Has programs of others identify archives by their bytes: file(1) with our magic and without, desktops' shared-mime-info, npm's
# file-type, and siegfried and fido where they are installed. Real databases and backups of Firebird, which are called .fbk, too,
# and files of other formats must not be taken for archives.
#   tests/packages/signatures/run_identifiers.sh
# As root on Debian; installs what it needs. npm's package goes into build/identifiers.
set -eu
cd "$(dirname "$0")/../../.."
missing=""
for package in file shared-mime-info libfile-mimeinfo-perl firebird3.0-server-core firebird3.0-utils; do
  dpkg-query --show --showformat='${db:Status-Status}\n' "$package" 2>/dev/null | grep -qx installed || missing="$missing $package"
done
# shellcheck disable=SC2086
[ -z "$missing" ] || apt-get install -y --no-install-recommends -o DPkg::Lock::Timeout=600 $missing
signatures=$PWD/tests/packages/signatures
desktop=$PWD/packager/desktop
mkdir -p build/identifiers
cd build/identifiers
[ -d node_modules/file-type ] || npm install --ignore-scripts --no-audit --no-fund file-type
cp "$signatures/file_types.mjs" .

rm -rf firebird mime
mkdir firebird
export ISC_USER=SYSDBA
echo "CREATE DATABASE 'firebird/people.fdb'; CREATE TABLE person (name VARCHAR(40)); COMMIT;" | isql-fb -q
gbak -b firebird/people.fdb firebird/people.fbk
nbackup -B 0 firebird/people.fdb firebird/people.nbk > /dev/null

mkdir -p mime/packages
cp /usr/share/mime/packages/freedesktop.org.xml "$desktop/facebaker.xml" mime/packages
update-mime-database mime 2> mime.log || { cat mime.log; exit 1; } # it notes that the folder is not searched
/usr/bin/python3 -B "$signatures/identify_by_others.py" "$PWD"
