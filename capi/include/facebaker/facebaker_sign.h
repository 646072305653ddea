/** @file
 * FaceBaker signatures: who vouches for a file, and whether a consent was withdrawn. C99; in libfacebaker_bake.
 * facebaker_bake.h, which includes this, has the rules that hold for all of it; docs/archivists.md tells how keys are
 * made.
 *
 * A signature is a file of its own beside the one that it signs, which stays as it is: CMS SignedData (RFC 5652) in
 * DER, which `openssl cms -verify` checks too. Nothing here reads a network or a list of certificates that the system
 * has.
 */
#ifndef FACEBAKER_FACEBAKER_SIGN_H
#define FACEBAKER_FACEBAKER_SIGN_H

#include <facebaker/facebaker_archive.h>

#ifdef __cplusplus
extern "C" {
#endif

struct fb_report;

/** What to sign, and by which key. */
typedef struct fb_sign_desc {
  uint32_t struct_size;
  uint32_t reserved;
  const char* path;        /**< any file. An archive is verified first, and what says that it is a consent or a list of
                              withdrawals must be one */
  const char* key;         /**< PEM: the private key, RSA of 2048 bits or more, P-256, P-384 or P-521 */
  const char* certificate; /**< PEM: its certificate, and those of who issued it; null: they are in `key`, too */
  const char* pass_phrase; /**< of an encrypted key; null: there is none, and nobody is asked for one */
  const char* signature;   /**< the file to write; null: `path` with ".sig" */
} fb_sign_desc;

FB_API void fb_sign_desc_fill(fb_sign_desc* to, uint32_t struct_size);
static inline void fb_sign_desc_init(fb_sign_desc* to) {
  fb_sign_desc_fill(to, (uint32_t)sizeof *to);
}
/** Signs the bytes of a file, with the time of the system's clock. The signature appears complete or not at all. The
 * document of `report`, which may be null: {"file", "sha256", "signature", "signed_at", "digest", "signer"}, see
 * fb_verify_signature. Fails with INVALID_ARGUMENT on a pass phrase that is wrong or missing, UNSUPPORTED on another
 * kind of key, BAD_DATA on files that hold no key or no certificate of it, on one that is not valid today and on
 * documents, as fb_verify on archives, and with NOT_FOUND and IO. */
FB_API fb_status fb_sign(const fb_sign_desc* desc, struct fb_report** report);

/* Flags of fb_verify_signature_desc. */
#define FB_SIGNATURE_ACCEPT_EXPIRED \
  1u /**< a certificate that was valid when the signer says to have signed is enough */

/** A signature to check, and whom to trust. */
typedef struct fb_verify_signature_desc {
  uint32_t struct_size;
  uint32_t flags;               /**< FB_SIGNATURE_... */
  const fb_archive* archive;    /**< what is signed: the bytes that it was opened from; null: `path` */
  const char* path;             /**< what is signed, where `archive` is null: any file */
  const char* signature;        /**< its signature; null: `path`, or the archive's, with ".sig" */
  const char* const* trusted;   /**< PEM files: certificates of signers or of who issued theirs, and public keys */
  const char* const* withdrawn; /**< lists of withdrawn consents, each with its signature, ".sig", beside it */
  uint32_t trusted_count;       /**< of trusted; 0: the call fails, saying who would have to be trusted */
  uint32_t withdrawn_count;     /**< of withdrawn */
  const char* on;               /**< the day on which all of it must hold, as "2031-12-31" of UTC; null: today */
} fb_verify_signature_desc;

FB_API void fb_verify_signature_desc_fill(fb_verify_signature_desc* to, uint32_t struct_size);
static inline void fb_verify_signature_desc_init(fb_verify_signature_desc* to) {
  fb_verify_signature_desc_fill(to, (uint32_t)sizeof *to);
}
/** Whether a file is as somebody trusted has signed it, and its consent not withdrawn by a list that somebody trusted
 * has signed: one that names the archive by its SHA-256 or by "agreement" of its "rights" (fb_about). What an archive
 * evaluates to is not looked at: see fb_verify. The document of `report`, which may be null: {"file", "sha256",
 * "signature", "on", "signed_at" (the signer's word: nothing proves it), "digest", "signer": {"subject", "issuer",
 * "key", "key_sha256" (of the public key in DER), "valid_from", "valid_until", "expired"}, "trusted": {"by"
 * ("certificate", "public key" or "issuer"), "name", "file"}, "agreement" (null: none), "withdrawn": [{"file",
 * "issued", "next_issue", "entries", "signed_by", "signed_at"}], "notes"}. Fails with BAD_DATA or UNSUPPORTED, naming
 * what is not so: a file that is no signature, cut, of other bytes, by another key, by several signers; a signer who is
 * not trusted; a certificate that is not valid on that day; a list that is unsigned, changed, out of date or of a later
 * day; a consent that is withdrawn, since when, why, and by whose list. */
FB_API fb_status fb_verify_signature(const fb_verify_signature_desc* desc, struct fb_report** report);

#ifdef __cplusplus
}
#endif
#endif
