#pragma once

/** How often this program has called operator new; under ThreadSanitizer, taken memory in any way. */
long allocation_count();
