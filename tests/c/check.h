/* CHECK for the C and C++ tests: reports, counts, goes on. Not for use by two threads at once.
 * To be included after the header of the library. */

#ifndef CHECK_H
#define CHECK_H

#include <stdio.h>

static int checks = 0;
static int failures = 0;

#define CHECK(condition)                                                        \
    do {                                                                        \
        checks++;                                                               \
        if (!(condition)) {                                                     \
            failures++;                                                         \
            fprintf(stderr, "%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
        }                                                                       \
    } while (0)

/* CHECK that also shows the status and the message. */
#define CHECK_STATUS(call, expected)                                                      \
    do {                                                                                  \
        cata_status status_ = (call);                                                     \
        checks++;                                                                         \
        if (status_ != (expected)) {                                                      \
            failures++;                                                                   \
            fprintf(stderr, "%s:%d: %s instead of %s: %s\n  in %s\n", __FILE__, __LINE__, \
                    cata_status_name(status_), #expected, cata_last_error_message(), #call); \
        }                                                                                 \
    } while (0)

static int report(const char *name)
{
    /* What a thread that still runs has allocated would be a leak. */
    CHECK(cata_threads_release() == CATA_OK);
    printf("%s: %d checks, %d failed\n", name, checks, failures);
    return failures == 0 ? 0 : 1;
}

#endif
