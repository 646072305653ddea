/* Keys for the tests of signatures through the C interface. */
#ifndef SIGNING_FILES_H
#define SIGNING_FILES_H

#ifdef __cplusplus
extern "C" {
#endif

/* Writes "key.pem", with its certificate, "signer.pem", the certificate alone, and "other.pem", of another key. */
void write_signing_files(const char* folder);

#ifdef __cplusplus
}
#endif
#endif
