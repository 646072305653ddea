#!/bin/sh
# Writes a bag and has the Library of Congress' validator look at it (bagit.py, from pip: BAGIT names the command), and then
# at bags with a fault each, which `facebaker bag --check` must all refuse: it prints which of them the other accepts. Where
# PREMIS_XSD names the schema of PREMIS 3 (premis.xsd of the Library of Congress), xmllint validates the XML against it.
# bagit.py 1.9 does not read %25, by which RFC 8493 writes per cent signs in names: none has one here.
#   [BAGIT=bagit.py] [PREMIS_XSD=FILE] tests/packager/validate_bag.sh [FACEBAKER [FACE.fbk...]]
set -eu
cd "$(dirname "$0")/../.."
tool=$(realpath "${1:-build/release/bin/facebaker}")
[ $# -lt 1 ] || shift
bagit=${BAGIT:-bagit.py}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
if [ $# -eq 0 ]; then
  golden=$PWD/tests/golden
  set -- "$golden/2.0/accepted/tiny.fbk" "$golden/2.0/accepted/character.fbk" "$golden/2.1/accepted/driven.fbk"
fi

echo "words" > "$folder/two words.txt"
"$tool" bag "$@" --source "$folder/two words.txt" --organisation "An archive" --out "$folder/whole" > /dev/null 2>&1
$bagit --quiet --validate "$folder/whole"
echo "agrees that it is whole: $bagit"
if [ -n "${PREMIS_XSD:-}" ]; then
  xmllint --noout --schema "$PREMIS_XSD" "$folder/whole/data/metadata/premis.xml"
fi

# The line of a manifest for an empty file of this path.
line() {
  printf '%s  %s\n' "$(printf '' | sha512sum | cut -d' ' -f1)" "$1"
}

# Puts the fault $1 into the bag, which is the current folder.
damage() {
  manifest=manifest-sha512.txt
  archive=$(find data/archives -name '*.fbk' | sort | head -n 1)
  case $1 in
    missing) rm data/README.txt ;;
    changed) echo more >> data/README.txt ;;
    extra) echo more > data/extra.txt ;;
    truncated) truncate -s 100 "$archive" ;;
    no-declaration) rm bagit.txt ;;
    other-version) sed -i 's/1.0/3.7/' bagit.txt ;;
    other-encoding) sed -i 's/UTF-8/klingon/' bagit.txt ;;
    more-in-declaration) echo "Comment: none" >> bagit.txt ;;
    byte-order-mark) printf '\357\273\277' | cat - bagit.txt > marked && mv marked bagit.txt ;;
    no-manifest) rm $manifest ;;
    unknown-algorithm) mv $manifest manifest-whirlpool.txt ;;
    latin-1) line "$(printf 'data/caf\351')" >> $manifest ;;
    parent) line ../outside >> $manifest ;;
    absolute) line /etc/passwd >> $manifest ;;
    home) line '~/outside' >> $manifest ;;
    not-in-data) line bagit.txt >> $manifest ;;
    twice) head -n 1 $manifest >> $manifest ;;
    twice-otherwise) line "$(head -n 1 $manifest | cut -d' ' -f3-)" >> $manifest ;;
    short-checksum) echo "abc  data/x" >> $manifest ;;
    not-hexadecimal) sed -i '1s/^../zz/' $manifest ;;
    malformed) echo "nothing" >> $manifest ;;
    oxum-bytes) sed -i 's/Payload-Oxum: /&9/' bag-info.txt ;;
    oxum-files) sed -i '/Payload-Oxum/s/$/9/' bag-info.txt ;;
    changed-tag) echo "Contact-Name: A" >> bag-info.txt ;;
    no-label) echo "no label" >> bag-info.txt ;;
    to-fetch) rm data/README.txt && echo "https://example.org/x - data/README.txt" > fetch.txt ;;
    link) mv data/README.txt ../kept.txt && ln -s "$PWD/../kept.txt" data/README.txt ;;
    link-to-folder) mv data/texts ../texts && ln -s "$PWD/../texts" data/texts ;;
    pipe) mkfifo data/pipe ;;
    case) : > data/readme.TXT && line data/readme.TXT >> $manifest ;;
    normalisation)
      for name in "$(printf 'data/\303\251')" "$(printf 'data/e\314\201')"; do : > "$name" && line "$name" >> $manifest; done ;;
    reserved) : > data/nul.txt && line data/nul.txt >> $manifest ;;
    nested)
      mkdir -p data/inner/data
      for name in data/inner/bagit.txt data/inner/data/x; do : > $name && line $name >> $manifest; done ;;
    empty) rm -r data && mkdir data && : > $manifest ;;
    damaged-archive) # the checksum is that of the damage
      before=$(sha512sum < "$archive" | cut -d' ' -f1)
      printf '\377\000\377\000' | dd of="$archive" bs=1 seek=300 conv=notrunc status=none
      sed -i "s/$before/$(sha512sum < "$archive" | cut -d' ' -f1)/" $manifest ;;
  esac
  # What was changed on purpose is not to be found by its own checksum.
  case $1 in
    changed-tag | to-fetch) ;;
    *)
      [ ! -f bag-info.txt ] || case $1 in oxum*) ;; *) sed -i '/Payload-Oxum/d' bag-info.txt ;; esac
      rm tagmanifest-sha512.txt ;;
  esac
}

refused=0 laxer=""
for fault in missing changed extra truncated no-declaration other-version other-encoding more-in-declaration \
  byte-order-mark no-manifest unknown-algorithm latin-1 parent absolute home not-in-data twice twice-otherwise \
  short-checksum not-hexadecimal malformed oxum-bytes oxum-files changed-tag no-label to-fetch link link-to-folder pipe \
  case normalisation reserved nested empty damaged-archive; do
  rm -rf "$folder/faulty" "$folder/kept.txt" "$folder/texts"
  cp -r "$folder/whole" "$folder/faulty"
  (cd "$folder/faulty" && damage $fault)
  if "$tool" bag --check "$folder/faulty" > /dev/null 2>&1; then
    echo "$fault: not found by facebaker bag --check" >&2
    exit 1
  fi
  if timeout 20 $bagit --quiet --validate "$folder/faulty" > /dev/null 2>&1; then laxer="$laxer $fault"; else refused=$((refused + 1)); fi
done
echo "both refuse $refused faulty bags; $bagit accepts:${laxer:- none}"
