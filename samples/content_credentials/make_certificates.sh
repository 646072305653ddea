#!/bin/sh
# Makes keys and certificates to try content credentials with: a root, and a signer that it certifies, as C2PA asks for (ECDSA on
# P-256, digital signatures, e-mail protection, no authority). Who vouches for real faces has a certificate of an authority.
#   make_certificates.sh FOLDER [NAME [DAYS]]     makes FOLDER/root.pem, FOLDER/signer.key, FOLDER/signer.pem (with its root)
# DAYS: how long the signer's holds, 365 by default.
set -eu
folder=$1
name=${2:-Example archive}
days=${3:-365}
umask 077
mkdir -p "$folder"
cd "$folder"
openssl ecparam -name prime256v1 -genkey -noout -out root.key
openssl req -x509 -new -key root.key -days 3650 -subj "/O=$name/CN=$name root" -out root.pem \
  -addext basicConstraints=critical,CA:TRUE -addext keyUsage=critical,keyCertSign,cRLSign
openssl ecparam -name prime256v1 -genkey -noout | openssl pkcs8 -topk8 -nocrypt -out signer.key
openssl req -new -key signer.key -subj "/O=$name/CN=$name signer" -out signer.csr
cat > signer.ext << EOF
basicConstraints=critical,CA:FALSE
keyUsage=critical,digitalSignature
extendedKeyUsage=critical,emailProtection
authorityKeyIdentifier=keyid
subjectKeyIdentifier=hash
EOF
openssl x509 -req -in signer.csr -CA root.pem -CAkey root.key -CAcreateserial -days "$days" -extfile signer.ext \
  -out signer-only.pem 2> openssl.log || {
    cat openssl.log
    exit 1
  }
cat signer-only.pem root.pem > signer.pem
rm signer.csr signer.ext signer-only.pem root.srl openssl.log
