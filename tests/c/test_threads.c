/* Two threads call at the same time: right results, and each its own last message. */

#include <catamaran.h>

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

enum { ROUNDS = 50, M = 150, N = 90 };

struct job {
    int number;
    int wrong;
    const double *expected;
    const double *a;
};

static void *run(void *argument)
{
    struct job *job = argument;
    double *c = malloc(sizeof(double) * N * N);
    char message[64];
    size_t too_short = (size_t)job->number;
    job->wrong += cata_last_error_message()[0] != '\0';
    snprintf(message, sizeof message, "lda: must be at least %d (columns of a), is %d", N,
             job->number);
    for (int round = 0; round < ROUNDS; round++) {
        cata_status status = cata_ata_f64(CATA_ROW_MAJOR, CATA_BOTH, M, N, 1.0, job->a, too_short,
                                          0.0, c, N, NULL);
        job->wrong += status != CATA_ERR_SHAPE;
        status = cata_ata_f64(CATA_ROW_MAJOR, CATA_BOTH, M, N, 1.0, job->a, N, 0.0, c, N, NULL);
        job->wrong += status != CATA_OK;
        job->wrong += memcmp(c, job->expected, sizeof(double) * N * N) != 0;
        job->wrong += strcmp(cata_last_error_message(), message) != 0;
    }
    free(c);
    return NULL;
}

int main(void)
{
    static double a[M * N], expected[N * N];
    unsigned state = 1;
    for (int i = 0; i < M * N; i++) {
        state = state * 1664525u + 1013904223u;
        a[i] = (double)(state >> 8) / 16777216.0;
    }
    CHECK_STATUS(cata_ata_f64(CATA_ROW_MAJOR, CATA_BOTH, M, N, 1.0, a, N, 0.0, expected, N, NULL),
                 CATA_OK);
    struct job jobs[2] = {{1, 0, expected, a}, {2, 0, expected, a}};
    pthread_t threads[2];
    for (int i = 0; i < 2; i++) {
        CHECK(pthread_create(&threads[i], NULL, run, &jobs[i]) == 0);
    }
    for (int i = 0; i < 2; i++) {
        CHECK(pthread_join(threads[i], NULL) == 0);
        CHECK(jobs[i].wrong == 0);
    }
    CHECK(cata_last_error_message()[0] == '\0');
    return report("threads");
}
