/* Threads that call at the same time: right results, each its own last message, and together no
 * more threads than cores and callers; the end of the library's threads; processes that fork. */

#include <catamaran.h>

#include <dirent.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "check.h"

enum { M = 150, N = 90, CALLERS = 8 };

static int rounds = 50;

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
    for (int round = 0; round < rounds; round++) {
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

/* Returns the number of threads of this process. */
static int count_threads(void)
{
    DIR *tasks = opendir("/proc/self/task");
    if (tasks == NULL) {
        return 0;
    }
    int count = 0;
    for (struct dirent *task; (task = readdir(tasks)) != NULL;) {
        count += task->d_name[0] != '.';
    }
    closedir(tasks);
    return count;
}

/* Waits until threads that have ended are gone from the list of the system; returns the count. */
static int settled_threads(int expected)
{
    for (int i = 0; i < 1000 && count_threads() > expected; i++) {
        usleep(1000);
    }
    return count_threads();
}

static const double *matrix, *product;
static pthread_barrier_t start;
static int most, wrong;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static int computes(size_t threads)
{
    double *c = malloc(sizeof(double) * N * N);
    cata_ata_params params = {.struct_size = sizeof params, .threads = threads};
    cata_status status =
        cata_ata_f64(CATA_ROW_MAJOR, CATA_BOTH, M, N, 1.0, matrix, N, 0.0, c, N, &params);
    params.reproducible = 1;
    double *d = malloc(sizeof(double) * N * N);
    cata_status exact =
        cata_ata_f64(CATA_ROW_MAJOR, CATA_BOTH, M, N, 1.0, matrix, N, 0.0, d, N, &params);
    int right = status == CATA_OK && exact == CATA_OK &&
                memcmp(c, product, sizeof(double) * N * N) == 0;
    free(c);
    free(d);
    return right;
}

static void *caller(void *unused)
{
    (void)unused;
    pthread_barrier_wait(&start);
    for (int round = 0; round < rounds; round++) {
        int right = computes(0) && computes_more();
        int threads = count_threads();
        pthread_mutex_lock(&lock);
        wrong += !right;
        most = threads > most ? threads : most;
        pthread_mutex_unlock(&lock);
    }
    return NULL;
}

/* The smallest eigenpairs of a path, and least squares: what stands on other packages, too. */
static int computes_more(void)
{
    size_t starts[N + 1] = {0}, columns[3 * N];
    double entries[3 * N], values[3], vectors[3 * N], x[8];
    for (size_t i = 0; i < N; i++) {
        size_t at = starts[i];
        for (size_t j = i > 0 ? i - 1 : 0; j <= i + 1 && j < N; j++) {
            columns[at] = j;
            entries[at++] = i == j ? 2.0 : -1.0;
        }
        starts[i + 1] = at;
    }
    return cata_eigs(N, starts, columns, entries, NULL, 3, values, vectors, N, NULL, NULL) ==
               CATA_OK &&
           cata_lstsq(CATA_ROW_MAJOR, M, 8, 1, matrix, N, matrix + 9, N, NULL, x, 1, NULL, NULL) ==
               CATA_OK;
}

static void test_many_callers(void)
{
    pthread_t threads[CALLERS];
    int cores = (int)sysconf(_SC_NPROCESSORS_ONLN);
    CHECK(pthread_barrier_init(&start, NULL, CALLERS) == 0);
    /* This thread is one of the callers. */
    for (int i = 1; i < CALLERS; i++) {
        CHECK(pthread_create(&threads[i], NULL, caller, NULL) == 0);
    }
    caller(NULL);
    for (int i = 1; i < CALLERS; i++) {
        CHECK(pthread_join(threads[i], NULL) == 0);
    }
    CHECK(wrong == 0);
    CHECK(most <= cores + CALLERS);
    pthread_barrier_destroy(&start);
}

static void test_release(void)
{
    for (int round = 0; round < 3; round++) {
        CHECK(computes(3));
        CHECK_STATUS(cata_threads_release(), CATA_OK);
        CHECK(settled_threads(1) <= 1);
    }
    CHECK(computes(2));
    int before = count_threads();
    for (int round = 0; round < rounds; round++) {
        CHECK(computes(2));
    }
    CHECK(count_threads() == before);
}

/* A child has no threads of its parent, and neither waits for them nor ends them. */
static void test_fork(int releases_first)
{
    pid_t child = fork();
    if (child == 0) {
        alarm(60);
        if (releases_first && cata_threads_release() != CATA_OK) {
            _exit(2);
        }
        int right = computes(2) && computes(4);
        if (cata_threads_release() != CATA_OK || settled_threads(1) > 1) {
            _exit(3);
        }
        _exit(right && computes(2) ? 0 : 1);
    }
    int status = -1;
    CHECK(waitpid(child, &status, 0) == child);
    CHECK(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    CHECK(computes(2));
}

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "quick") == 0) {
        rounds = 3;
    }
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
    matrix = a;
    product = expected;
    test_many_callers();
    test_release();
    if (argc == 1) {
        /* Not under Valgrind: a child never frees what belongs to the threads of its parent. */
        test_fork(0);
        test_fork(1);
    }
    return report("threads");
}
