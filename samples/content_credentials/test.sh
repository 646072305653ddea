#!/bin/sh
# Signs a face's content credentials and verifies them, and tries what must fail: other bytes, another face, another root, a wrong
# key, an expired certificate. Keys, faces and npm's package are in build/content_credentials.
#   samples/content_credentials/test.sh [FACEBAKER]
set -eu
cd "$(dirname "$0")/../.."
FACEBAKER=$(realpath "${1:-build/release/bin/facebaker}")
export FACEBAKER
source=$PWD/samples/content_credentials
faces=$PWD/tests/golden/2.0/accepted
mkdir -p build/content_credentials
cd build/content_credentials
cp "$source"/*.mjs "$source"/package.json .
[ -d node_modules/@contentauth/c2pa-node ] || npm install --ignore-scripts --no-audit --no-fund
node --test test_rights_assertions.mjs

rm -rf keys others expired ./*.fbk ./*.c2pa
"$source/make_certificates.sh" keys
"$source/make_certificates.sh" others "Another archive"
"$source/make_certificates.sh" expired "Example archive" -1
cat > about.json << EOF
{"name": "Ada", "rights": {"digital_source_type": "digitalCapture", "learning": "allowed", "ai_training": "notAllowed",
 "data_mining": "constrained", "constraint_info": "statistics of collections alone"}}
EOF
"$FACEBAKER" pack "$faces/tiny.fbk" --about about.json --out face.fbk > /dev/null
cp face.fbk before.fbk

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

# Succeeds if the command fails with a message that has the words.
refused() {
  words=$1
  shift
  if "$@" > said 2>&1; then fail "nothing was wrong: $*"; fi
  grep -q -- "$words" said || fail "'$words' is not in what was said: $(cat said)"
}

sign() { node credentials.mjs sign --key keys/signer.key --certificate keys/signer.pem "$@"; }
verify() { node credentials.mjs verify --trust keys/root.pem "$@"; }
sign face.fbk
cmp face.fbk before.fbk
verify face.fbk | tee said
for words in "Example archive signer" "c2pa.created: .*/digitalCapture" "cawg.ai_training: notAllowed" \
  "cawg.ai_generative_training: allowed" "cawg.data_mining: constrained, statistics of collections alone"; do
  grep -q "$words" said || fail "'$words' is not said"
done

printf 'x' | dd of=before.fbk bs=1 seek=5000 conv=notrunc 2> /dev/null
refused "assertion.dataHash.mismatch" verify before.fbk --manifest face.fbk.c2pa
refused "assertion.dataHash.mismatch" verify "$faces/tiny.fbk" --manifest face.fbk.c2pa
refused "signingCredential.untrusted" node credentials.mjs verify --trust others/root.pem face.fbk
cp face.fbk.c2pa changed.c2pa
printf 'y' | dd of=changed.c2pa bs=1 seek=900 conv=notrunc 2> /dev/null
refused "changed.c2pa: no credentials" verify face.fbk --manifest changed.c2pa
refused "face.fbk: no credentials" verify face.fbk --manifest face.fbk
node credentials.mjs sign face.fbk --key others/signer.key --certificate keys/signer.pem --out wrong-key.c2pa
refused "claimSignature.mismatch" verify face.fbk --manifest wrong-key.c2pa
refused "not valid at time of signing" \
  node credentials.mjs sign face.fbk --key expired/signer.key --certificate expired/signer.pem --out expired.c2pa
refused "exist" sign face.fbk # credentials are not written over
refused "digital_source_type" sign "$faces/tiny.fbk" --out tiny.c2pa
refused "checksum" sign before.fbk --out before.c2pa
for name in tiny before expired; do [ ! -e $name.c2pa ] || fail "$name.c2pa was written, though signing failed"; done
echo "content credentials hold, and fail where they must"
