/* Floating-point environments of the caller: every function computes as under the default one,
 * whichever call of a process is the first, and gives the caller's environment back. Products of
 * finite matrices raise no exception but FE_INEXACT and FE_UNDERFLOW. */

#include <catamaran.h>

#include <fenv.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include "check.h"

enum { M = 150, N = 130, POINTS = 60, UNKNOWNS = 5, SCHEMES = 7, NODES = 150, PAIRS = 4 };

/* The environments that are set, and the default one at the end. */
static const char *const names[] = {"upward",  "downward", "toward zero", "without subnormals",
                                    "trapped", "nearest"};
enum { ENVIRONMENTS = sizeof names / sizeof *names, NEAREST = ENVIRONMENTS - 1 };

static void set_environment(int number)
{
    const int modes[] = {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO};
#if defined(__SSE__)
    _mm_setcsr(0x1f80);
#endif
    fesetround(number < 3 ? modes[number] : FE_TONEAREST);
#if defined(__SSE__)
    if (number == 3) {
        _mm_setcsr(0x9fc0); /* flush to zero, denormals are zero */
    } else if (number == 4) {
        _mm_setcsr(0x0f80); /* an inexact result ends the process */
    }
#endif
}

static int environment_is(int number)
{
    const int modes[] = {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO};
#if defined(__SSE__)
    const unsigned control = _mm_getcsr() & ~0x3fu;
    if (number >= 3) {
        return control == (number == 3 ? 0x9fc0u : number == 4 ? 0x0f80u : 0x1f80u);
    }
#endif
    return fegetround() == (number < 3 ? modes[number] : FE_TONEAREST);
}

static double a[M * N], b[M * N], weights[M], points[POINTS * UNKNOWNS], targets[POINTS];
static float single[M * N];
static size_t row_starts[NODES + 1], columns[3 * NODES];
static double entries[3 * NODES];

struct results {
    double by_scheme[SCHEMES][N * N], reproducible[N * N], general[N * N], rows[N * N];
    double complex_product[(N / 2) * (N / 2) * 2];
    float single[N * N];
    double solution[UNKNOWNS], singular_values[UNKNOWNS], components[2 * UNKNOWNS];
    double orthogonal[POINTS * UNKNOWNS];
    double eigenvalues[PAIRS], eigenvectors[PAIRS * NODES];
    double mesh_values[3], mesh_vectors[3 * 5], mesh_masses[5];
    cata_status status; /* the first that is not CATA_OK */
};

static void fill(void)
{
    unsigned state = 1;
    for (int i = 0; i < M * N; i++) {
        state = state * 1664525u + 1013904223u;
        a[i] = (double)(state >> 8) / 16777216.0 - 0.5;
        b[i] = a[i] * 3.0 - 0.1;
        single[i] = (float)a[i];
    }
    for (int i = 0; i < M; i++) {
        a[i * N + N - 1] *= 1e-160; /* products with itself are subnormal */
        weights[i] = 1.0 / (1 + i);
    }
    for (int i = 0; i < POINTS; i++) {
        for (int j = 0; j < UNKNOWNS; j++) {
            points[i * UNKNOWNS + j] = j == 0 ? 1.0 : points[i * UNKNOWNS + j - 1] * i / POINTS;
        }
        targets[i] = b[i];
    }
    /* A path whose edges have weights of their own. */
    for (size_t i = 0; i < NODES; i++) {
        size_t at = row_starts[i];
        double before = i > 0 ? 1.0 + (double)((i * 37) % 11) / 7 : 0.0;
        double after = i + 1 < NODES ? 1.0 + (double)(((i + 1) * 37) % 11) / 7 : 0.0;
        if (i > 0) {
            columns[at] = i - 1;
            entries[at++] = -before;
        }
        columns[at] = i;
        entries[at++] = before + after;
        if (i + 1 < NODES) {
            columns[at] = i + 1;
            entries[at++] = -after;
        }
        row_starts[i + 1] = at;
    }
}

static void note(struct results *found, cata_status status)
{
    if (status != CATA_OK && found->status == CATA_OK) {
        found->status = status;
        fprintf(stderr, "%s: %s\n", cata_status_name(status), cata_last_error_message());
    }
}

static void products(struct results *found, size_t threads)
{
    static const int32_t schemes[SCHEMES] = {CATA_SCHEME_AUTO,     CATA_SCHEME_CLASSICAL,
                                             CATA_SCHEME_ATA2,     CATA_SCHEME_WINOGRAD,
                                             CATA_SCHEME_RXTX,     CATA_SCHEME_EXACT,
                                             CATA_SCHEME_FLOAT};
    cata_ata_params params = {.struct_size = sizeof params, .threads = threads, .tasks = 8};
    for (int i = 0; i < SCHEMES; i++) {
        params.scheme = schemes[i];
        note(found, cata_ata_f64(CATA_ROW_MAJOR, CATA_BOTH, M, N, 0.7, a, N, 0.0,
                                 found->by_scheme[i], N, &params));
    }
    params.scheme = CATA_SCHEME_AUTO;
    note(found, cata_ata_f32(CATA_ROW_MAJOR, CATA_BOTH, M, N, 0.7f, single, N, 0.0f,
                             found->single, N, &params));
    note(found, cata_atb_f64(CATA_ROW_MAJOR, M, N, N, 1.0, a, N, b, N, 0.0, found->general, N,
                             &params));
    note(found, cata_aha_c64(CATA_ROW_MAJOR, CATA_BOTH, M, N / 2, 1.0, a, N / 2, 0.0,
                             found->complex_product, N / 2, &params));
    note(found, cata_ata_rows_f64(CATA_ROW_MAJOR, CATA_BOTH, M, N, 1.0, a, N, weights,
                                  CATA_CENTER_MEAN, NULL, 0.0, found->rows, N, &params));
    params.reproducible = 1;
    note(found, cata_ata_f64(CATA_ROW_MAJOR, CATA_BOTH, M, N, 0.7, a, N, 0.0, found->reproducible,
                             N, &params));
}

static void applications(struct results *found, size_t threads)
{
    cata_lstsq_params least_squares = {.struct_size = sizeof least_squares, .threads = threads};
    note(found, cata_lstsq(CATA_ROW_MAJOR, POINTS, UNKNOWNS, 1, points, UNKNOWNS, targets, 1, NULL,
                           found->solution, 1, NULL, &least_squares));
    note(found, cata_svd(CATA_ROW_MAJOR, POINTS, UNKNOWNS, points, UNKNOWNS,
                         found->singular_values, NULL, 0, NULL));
    note(found, cata_pca(CATA_ROW_MAJOR, POINTS, UNKNOWNS, points, UNKNOWNS, 2, found->components,
                         UNKNOWNS, NULL, NULL, NULL, NULL, NULL, NULL));
    size_t rank = 0;
    memcpy(found->orthogonal, points, sizeof points);
    note(found, cata_ortho_gram_schmidt(CATA_ROW_MAJOR, POINTS, UNKNOWNS, found->orthogonal,
                                        UNKNOWNS, NULL, NULL, 0, NULL, &rank, NULL));
    cata_eigs_params eigs = {.struct_size = sizeof eigs, .threads = threads};
    note(found, cata_eigs(NODES, row_starts, columns, entries, NULL, PAIRS, found->eigenvalues,
                          found->eigenvectors, NODES, NULL, &eigs));
    static const double positions[5 * 3] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.4, 0.3, 0.1};
    static const uint32_t corners[4 * 3] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};
    note(found, cata_mesh_eigs(5, positions, 4, corners, 3, found->mesh_values,
                               found->mesh_vectors, 5, NULL, found->mesh_masses, &eigs));
}

static void compute(struct results *found, size_t threads)
{
    memset(found, 0, sizeof *found);
    products(found, threads);
    applications(found, threads);
}

/* In a process of its own: computes in an environment, then in the default one, then in that
 * environment again, and writes the results. */
static int child(FILE *file, int number, size_t threads)
{
    static struct results found;
    const int order[3] = {number, NEAREST, number};
    for (int i = 0; i < 3; i++) {
        set_environment(order[i]);
        compute(&found, threads);
        if (!environment_is(order[i])) {
            fprintf(stderr, "the caller's environment is gone\n");
            return 2;
        }
        set_environment(NEAREST);
        if (fwrite(&found, sizeof found, 1, file) != 1) {
            return 3;
        }
    }
    return fflush(file) == 0 ? 0 : 3;
}

static void compare(const struct results *found, const struct results *expected)
{
#define SAME(field) CHECK(memcmp(&found->field, &expected->field, sizeof found->field) == 0)
    CHECK(found->status == CATA_OK);
    for (int i = 0; i < SCHEMES; i++) {
        SAME(by_scheme[i]);
    }
    SAME(reproducible);
    SAME(general);
    SAME(rows);
    SAME(complex_product);
    SAME(single);
    SAME(solution);
    SAME(singular_values);
    SAME(components);
    SAME(orthogonal);
    SAME(eigenvalues);
    SAME(eigenvectors);
    SAME(mesh_values);
    SAME(mesh_vectors);
    SAME(mesh_masses);
}

/* What the results of the default environment are. */
static void check_reference(const struct results *expected)
{
    double worst = 0.0;
    for (int j = 0; j < N - 1; j++) {
        for (int i = 0; i < N - 1; i++) {
            double sum = 0.0;
            for (int p = 0; p < M; p++) {
                sum += a[p * N + i] * a[p * N + j];
            }
            worst = fmax(worst, fabs(0.7 * sum - expected->reproducible[i * N + j]));
        }
    }
    CHECK(worst < 1e-13);
    double corner = expected->by_scheme[1][N * N - 1];
    CHECK(corner > 0.0 && fpclassify(corner) == FP_SUBNORMAL);
}

/* Products with a column of zeros by every scheme, small and large leaves, on 1 and 2 threads. */
static void check_exceptions(void)
{
    static const size_t shapes[][3] = {{13, 8, 5}, {8, 13, 7}, {1, 1, 1}, {64, 64, 64},
                                       {0, 5, 3},  {5, 0, 4},  {70, 33, 9}};
    static const size_t leaves[] = {0, 1, 2, 8};
    static double left[70 * 70], right[70 * 70], c[70 * 70];
    enum { RAISED = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW };
    for (size_t i = 0; i < 70 * 70; i++) {
        left[i] = i % 70 == 0 ? 0.0 : a[i];
        right[i] = b[i];
    }
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        const size_t m = shapes[i][0], n = shapes[i][1], k = shapes[i][2];
        for (int32_t scheme = CATA_SCHEME_AUTO; scheme <= CATA_SCHEME_FLOAT; scheme++) {
            for (size_t j = 0; j < sizeof leaves / sizeof *leaves; j++) {
                for (size_t threads = 1; threads <= 2; threads++) {
                    cata_ata_params params = {.struct_size = sizeof params, .scheme = scheme};
                    params.leaf = leaves[j];
                    params.threads = threads;
                    params.error_factor = INFINITY;
                    feclearexcept(FE_ALL_EXCEPT);
                    CHECK(cata_ata_f64(CATA_ROW_MAJOR, CATA_BOTH, m, n, 0.7, left, 70, 0.0, c, 70,
                                       &params) == CATA_OK);
                    CHECK(cata_atb_f64(CATA_ROW_MAJOR, m, n, k, 0.7, left, 70, right, 70, 0.5, c,
                                       70, &params) == CATA_OK);
                    if (fetestexcept(RAISED)) {
                        fprintf(stderr, "scheme %d, leaf %zu, %zu x %zu x %zu\n", (int)scheme,
                                leaves[j], m, n, k);
                        CHECK(!"exceptions");
                    }
                }
            }
        }
    }
}

int main(void)
{
    static struct results expected, found;
    FILE *files[ENVIRONMENTS][2];
    fill();
    /* Before the first call of this process, so that a child has no threads of its parent. */
    for (int number = 0; number < ENVIRONMENTS; number++) {
        for (int i = 0; i < 2; i++) {
            files[number][i] = tmpfile();
            pid_t process = fork();
            if (process == 0) {
                _exit(child(files[number][i], number, i == 0 ? 1 : 4));
            }
            int status = -1;
            CHECK(waitpid(process, &status, 0) == process);
            CHECK(WIFEXITED(status) && WEXITSTATUS(status) == 0);
        }
    }
    compute(&expected, 1);
    check_reference(&expected);
    check_exceptions();
    for (int number = 0; number < ENVIRONMENTS; number++) {
        for (int i = 0; i < 2; i++) {
            int before = failures;
            rewind(files[number][i]);
            for (int call = 0; call < 3; call++) {
                CHECK(fread(&found, sizeof found, 1, files[number][i]) == 1);
                compare(&found, &expected);
            }
            if (failures > before) {
                fprintf(stderr, "in the environment \"%s\", %d threads\n", names[number],
                        i == 0 ? 1 : 4);
            }
            fclose(files[number][i]);
        }
    }
    return report("rounding");
}
