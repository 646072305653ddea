#!/bin/sh
# Inside the copy of the system that run.sh makes: installs the packages, uses them, removes them.
set -eu
cd /tmp/installed
export HOME=/tmp/installed LC_ALL=C.UTF-8
unset FACEBAKER_LIBRARY FACEBAKER_BAKE_LIBRARY PYTHONPATH LD_LIBRARY_PATH || true
face=tests/golden/2.0/accepted/tiny.fbk

fail() {
  echo "FAILED: $*" >&2
  exit 1
}
# What packages leave alone, but for what dpkg, ldconfig and man keep for themselves.
listed() {
  find /usr /etc /opt /var -xdev ! -path '/var/lib/dpkg/*' ! -path '/var/cache/*' ! -path '/var/log/*' | sort
}

listed >before
dpkg --install packages/*.deb >installed.log 2>&1 || { cat installed.log; fail "dpkg --install"; }
listed >while
cmp -s before while && fail "nothing was installed"

facebaker --version
facebaker verify $face
facebaker inspect --json $face >inspected.json
facebaker eval $face sample 2>complaint && fail "eval takes a face of other controls"
grep -q 'the source has [0-9]' complaint || fail "the installed tool does not find the sample face: $(cat complaint)"
[ "$(file --brief --mime-type -m /usr/share/facebaker/facebaker.magic $face)" = application/x-facebaker ] || fail "magic"
for page in facebaker facebaker-bake facebaker-export; do
  MANWIDTH=80 man --warnings=w $page >page.txt 2>warnings || fail "man $page"
  [ ! -s warnings ] || fail "man $page: $(cat warnings)"
  grep -q OPTIONS page.txt || fail "man $page has no options"
done
for file in bash-completion/completions/facebaker zsh/vendor-completions/_facebaker fish/vendor_completions.d/facebaker.fish \
  thumbnailers/facebaker.thumbnailer mime/packages/facebaker.xml facebaker/facebaker-signature.xml facebaker/facebaker-fido.xml; do
  [ -s /usr/share/$file ] || fail "/usr/share/$file is not installed"
done
if [ -f /usr/share/facebaker/viewer/index.html ]; then
  [ -s /usr/share/facebaker/viewer/THIRD-PARTY.txt ] || fail "the viewer's page has no notices"
  facebaker view --no-open --port 0 $face >address & # until it is asked to end
  viewer=$!
  for _ in 1 2 3 4 5 6 7 8 9 10; do [ -s address ] || sleep 0.2; done
  /usr/bin/python3 -c 'import sys, urllib.request; sys.stdout.buffer.write(urllib.request.urlopen(sys.argv[1]).read())' \
    "$(head -n 1 address)" >page.html || fail "the installed viewer serves no page"
  kill -INT $viewer
  wait $viewer || fail "facebaker view ended with $?"
  grep -q "FaceBaker viewer" page.html || fail "the installed viewer serves another page"
else
  echo "note: the packages have no viewer's page"
fi
for package in $(dpkg-query --show --showformat='${Package}\n' '*facebaker*'); do
  [ -s "/usr/share/doc/$package/copyright" ] || fail "$package has no copyright"
done
for package in $(dpkg-query --show --showformat='${Package}\n' '*facebaker*' | grep -v -e '-dev$' -e '^python3-'); do
  for file in THIRD-PARTY.txt facebaker.spdx.json; do
    [ -s "/usr/share/doc/$package/$file" ] || [ -s "/usr/share/doc/$package/$file.gz" ] || fail "$package has no $file"
  done
done

# C, by pkg-config and by CMake.
# shellcheck disable=SC2046
cc -std=c99 -Wall -Wextra -Werror samples/hello_face/hello_face.c $(pkg-config --cflags --libs facebaker) -lm -o hello
./hello $face jaw_open 1
cmake -S tests/consumers/app -B app -D HELLO="$PWD/samples/hello_face/hello_face.c" >/dev/null
cmake --build app >/dev/null
app/hello $face jaw_open 1
app/author

cd /
/usr/bin/python3 -c '
import facebaker
face = facebaker.load("/tmp/installed/tests/golden/2.0/accepted/tiny.fbk")
print(facebaker.__file__, face.name, len(face.controls))
'
cd /tmp/installed

dpkg --purge $(dpkg-query --show --showformat='${Package}\n' '*facebaker*') >removed.log 2>&1 || { cat removed.log; fail "dpkg --purge"; }
listed >after
diff before after || fail "files are left behind, or others are gone"
