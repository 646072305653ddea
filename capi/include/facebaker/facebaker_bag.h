/** @file
 * Bags for archives and libraries: FaceBaker archives with all that is needed to read them later, as BagIt 1.0 (RFC
 * 8493). C99; in libfacebaker_bake. facebaker_bake.h, which includes this, has the rules that hold for all of it;
 * docs/archivists.md says what is in a bag.
 */
#ifndef FACEBAKER_FACEBAKER_BAG_H
#define FACEBAKER_FACEBAKER_BAG_H

#include <facebaker/facebaker_source.h>

#ifdef __cplusplus
extern "C" {
#endif

struct fb_report;

/** What to put into a bag. Paths are those of files and folders here; none is kept. */
typedef struct fb_bag_desc {
  uint32_t struct_size;
  uint32_t threads;            /**< at most 4,096; 0 (default): all */
  const char* directory;       /**< the bag: a folder that is not there yet, or is empty */
  const char* const* archives; /**< .fbk files, each with another name; they become data/archives/NAME */
  const char* const* beside;   /**< files that are kept beside the archives, such as signatures. Null (default): none */
  const char* const* sources;  /**< files and folders that the archives were made of; they become data/source/NAME. Null
                                    (default): none */
  const char* const*
      file_names;           /**< of more files: their paths in data/, such as "access/face.fbk.glb". Null (default) */
  const char* const* files; /**< the files that these are */
  const char* const* info;  /**< more lines of bag-info.txt, "Label: value", such as "Source-Organization: ...". Null
                                 (default): none */
  uint32_t archive_count;   /**< of archives; at least 1 */
  uint32_t beside_count;    /**< of beside */
  uint32_t source_count;    /**< of sources */
  uint32_t file_count;      /**< of file_names and files */
  uint32_t info_count;      /**< of info */
  uint32_t reserved;
  const char* date; /**< of the bag, "2026-11-29": the same date gives the same bytes. Null (default): today, UTC */
  /** Writes access copies of an archive, by its index: files whose paths begin with `base`, such as base with ".png"
   * after it, in a folder that is there. Called on the calling thread, between reports of progress. Returns FB_OK, or
   * an error after writing a sentence into message (message_size bytes, zero-terminated): fb_bag then fails with them.
   * Null (default): the copy is the archive's own thumbnail, if it has one; others can be given as files */
  fb_status (*make_copies)(void* user, uint32_t archive, const char* base, char* message, uint32_t message_size);
  void* copies_user; /**< passed to make_copies */
  fb_callbacks callbacks;
} fb_bag_desc;

FB_API void fb_bag_desc_fill(fb_bag_desc* to, uint32_t struct_size);
static inline void fb_bag_desc_init(fb_bag_desc* to) {
  fb_bag_desc_fill(to, (uint32_t)sizeof *to);
}
/** Verifies the archives and writes them as a bag: besides what is given, texts, the reader in Python, rights and
 * provenance as text and as PREMIS 3, and checksums by SHA-512. The bag is checked as it lies on the disk before it
 * gets its name, and so is whole or not there; what a killed process left behind is removed by the next call for that
 * folder. The document of `report`, which may be null, is that of fb_bag_check. Fails with NOT_FOUND, CORRUPT and as
 * fb_archive_open on archives, BAD_DATA on names that no bag may have or that some system takes for the same, and on
 * links in sources, IO where the folder is not empty, INTERRUPTED. */
FB_API fb_status fb_bag(const fb_bag_desc* desc, struct fb_report** report);

/** What to check. */
typedef struct fb_bag_check_desc {
  uint32_t struct_size;
  uint32_t threads;      /**< at most 4,096; 0 (default): all */
  const char* directory; /**< the bag, of anyone */
  fb_callbacks callbacks;
} fb_bag_check_desc;

FB_API void fb_bag_check_desc_fill(fb_bag_check_desc* to, uint32_t struct_size);
static inline void fb_bag_check_desc_init(fb_bag_check_desc* to) {
  fb_bag_check_desc_fill(to, (uint32_t)sizeof *to);
}
/** Checks a bag: its structure, every file against every checksum, and whether its archives evaluate as archived.
 * Follows no link in it and reads nothing outside. Faults are no error: they are in the report. Its document: {"bag",
 * "valid", "version" of BagIt, "algorithms"[], "files" and "bytes" of the payload, "archives"[]: {"file", "bytes",
 * "poses", "vertices"}, "info"[]: {"label", "value"}, "faults"[] and "warnings"[]: {"file" ("": the bag), "reason"},
 * "more_faults": their number beyond the first 10,000}. Fails with NOT_FOUND and IO where there is no folder that can
 * be read, LIMIT on more than a million files, INTERRUPTED. */
FB_API fb_status fb_bag_check(const fb_bag_check_desc* desc, struct fb_report** report);

/** What fb_bag and fb_bag_check found. */
typedef struct fb_bag_result {
  uint32_t struct_size;
  uint32_t valid;    /**< 1: there is no fault */
  uint64_t files;    /**< of the payload */
  uint64_t bytes;    /**< of them */
  uint64_t archives; /**< that evaluate as archived */
  uint64_t faults;   /**< all of them */
  uint64_t warnings; /**< in the document */
} fb_bag_result;

FB_API void fb_bag_result_fill(fb_bag_result* to, uint32_t struct_size);
static inline void fb_bag_result_init(fb_bag_result* to) {
  fb_bag_result_fill(to, (uint32_t)sizeof *to);
}
/** Refused with INVALID_ARGUMENT for the report of another call. */
FB_API fb_status fb_report_bag(const struct fb_report* report, fb_bag_result* result);

#ifdef __cplusplus
}
#endif
#endif
