# For Doxygen: describes in every struct what facebaker.h explains once for all of them.
s|^\( *uint32_t struct_size;\)$|\1 /**< Size of this struct as the caller compiled it; set by its _init. */|
s|^\( *uint[0-9]*_t reserved[a-z_]*;\)$|\1 /**< 0 */|
s|^\( *fb_callbacks callbacks;\)$|\1 /**< Progress, notes and cancelling. */|
s|^\(FB_API void fb_[a-z_]*_fill(\)|/** Fills the first struct_size bytes of *to with defaults; its _init calls it. */\n\1|
s|^\(#define FB_API\)$|/** Marks what a library exports. */\n\1|
s|^\(static inline void fb_[a-z_]*_init(\)|/** Sets struct_size and fills in defaults. */\n\1|
