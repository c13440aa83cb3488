/* What libraries compiled for tests export beside catamaran.h. */

#ifndef INTERNAL_H
#define INTERNAL_H

#include "catamaran.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Panics inside the library, on the calling thread if `worker` is 0 and else on a thread of its own.
   Returns CATA_ERR_PANIC. */
cata_status cata_internal_panic(int32_t worker);

#ifdef __cplusplus
}
#endif

#endif
