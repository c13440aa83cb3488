/* The products in one precision. Wants REAL, NAME(base) for the library's function, LOCAL(base) for
 * a name of its own, and UNIT, the unit roundoff. Included once for each. */

/* Reproducible entries in [-1, 1). */
static REAL LOCAL(entry)(unsigned *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (REAL)((double)(*state >> 8) / 8388608.0 - 1.0);
}

static REAL *LOCAL(make)(size_t len, unsigned seed)
{
    /* No room beyond the last element, so that Valgrind sees every step too far. */
    REAL *x = malloc(len * sizeof(REAL) + (len == 0));
    if (x == NULL) {
        fputs("out of memory\n", stderr);
        exit(2);
    }
    for (size_t i = 0; i < len; i++) {
        x[i] = LOCAL(entry)(&seed);
    }
    return x;
}

static size_t LOCAL(at)(int32_t layout, size_t ld, size_t i, size_t j)
{
    return layout == CATA_ROW_MAJOR ? i * ld + j : i + j * ld;
}

static size_t LOCAL(len)(int32_t layout, size_t rows, size_t cols, size_t ld)
{
    size_t lines = layout == CATA_ROW_MAJOR ? rows : cols;
    size_t line = layout == CATA_ROW_MAJOR ? cols : rows;
    return lines == 0 ? 0 : (lines - 1) * ld + line;
}

/* sum_r w_r a(r, i) b(r, j) in double. */
static double LOCAL(dot)(int32_t layout, size_t m, const REAL *a, size_t lda, size_t i,
                         const REAL *b, size_t ldb, size_t j, const REAL *w)
{
    double sum = 0.0;
    for (size_t r = 0; r < m; r++) {
        sum += (w ? (double)w[r] : 1.0) * (double)a[LOCAL(at)(layout, lda, r, i)] *
               (double)b[LOCAL(at)(layout, ldb, r, j)];
    }
    return sum;
}

/* Every entry of C against the plain loop, and every element of its memory that is not asked for
 * against what it was. */
static void LOCAL(compare)(int32_t layout, int32_t uplo, size_t m, size_t n, const REAL *a,
                           size_t lda, double alpha, double beta, const REAL *c, const REAL *before,
                           size_t ldc, const REAL *weights)
{
    double bound = 16.0 * UNIT * (double)(m + 4);
    size_t wrong = 0, touched = 0, unsymmetric = 0;
    size_t len = LOCAL(len)(layout, n, n, ldc);
    for (size_t at = 0; at < len; at++) {
        size_t major = at / ldc, minor = at % ldc;
        size_t i = layout == CATA_ROW_MAJOR ? major : minor;
        size_t j = layout == CATA_ROW_MAJOR ? minor : major;
        int inside = minor < n;
        int wanted = inside && (uplo == CATA_BOTH || (uplo == CATA_LOWER ? i >= j : i <= j));
        if (!wanted) {
            touched += memcmp(&c[at], &before[at], sizeof(REAL)) != 0;
            continue;
        }
        size_t old = at;
        if (uplo == CATA_BOTH) {
            size_t other = LOCAL(at)(layout, ldc, j, i);
            old = i >= j ? at : other;
            unsymmetric += memcmp(&c[at], &c[other], sizeof(REAL)) != 0;
        }
        double expected = alpha * LOCAL(dot)(layout, m, a, lda, i, a, lda, j, weights);
        if (beta != 0.0) {
            expected += beta * (double)before[old];
        }
        wrong += !(fabs((double)c[at] - expected) <= bound);
    }
    CHECK(wrong == 0);
    CHECK(touched == 0);
    CHECK(unsymmetric == 0);
}

static REAL *LOCAL(copy)(const REAL *x, size_t len)
{
    REAL *y = LOCAL(make)(len, 0);
    if (len > 0) {
        memcpy(y, x, len * sizeof(REAL));
    }
    return y;
}

static void LOCAL(test_ata)(int32_t layout, int32_t uplo, size_t m, size_t n, size_t gap,
                            const cata_ata_params *params)
{
    size_t line = layout == CATA_ROW_MAJOR ? n : m;
    size_t lda = (line ? line : 1) + gap, ldc = (n ? n : 1) + gap;
    size_t len = LOCAL(len)(layout, n, n, ldc);
    REAL *a = LOCAL(make)(LOCAL(len)(layout, m, n, lda), 1);
    REAL *before = LOCAL(make)(len, 2);
    REAL *weights = LOCAL(make)(m, 3);

    REAL *c = LOCAL(copy)(before, len);
    CHECK_STATUS(NAME(cata_ata)(layout, uplo, m, n, (REAL)1.5, a, lda, (REAL)0.5, c, ldc, params),
                 CATA_OK);
    LOCAL(compare)(layout, uplo, m, n, a, lda, 1.5, 0.5, c, before, ldc, NULL);

    /* In scratch full of NaN, of exactly the length asked for: the same bits. */
    size_t scratch_len = 12345;
    CHECK_STATUS(NAME(cata_ata_scratch_len)(m, n, params, &scratch_len), CATA_OK);
    REAL *scratch = LOCAL(make)(scratch_len, 4);
    for (size_t i = 0; i < scratch_len; i++) {
        scratch[i] = (REAL)NAN;
    }
    REAL *d = LOCAL(copy)(before, len);
    CHECK_STATUS(NAME(cata_ata_with_scratch)(layout, uplo, m, n, (REAL)1.5, a, lda, (REAL)0.5, d,
                                             ldc, scratch, scratch_len, params),
                 CATA_OK);
    CHECK(len == 0 || memcmp(c, d, len * sizeof(REAL)) == 0);

    /* beta == 0 does not read C: NaN in the wanted part must not survive. */
    for (size_t i = 0; i < len; i++) {
        c[i] = before[i];
    }
    for (size_t i = 0; i < n; i++) {
        c[LOCAL(at)(layout, ldc, i, i)] = (REAL)NAN;
    }
    CHECK_STATUS(NAME(cata_ata)(layout, uplo, m, n, 1, a, lda, 0, c, ldc, params), CATA_OK);
    LOCAL(compare)(layout, uplo, m, n, a, lda, 1.0, 0.0, c, before, ldc, NULL);

    /* Weighted. */
    CHECK_STATUS(NAME(cata_ata_rows)(layout, uplo, m, n, 1, a, lda, weights, CATA_CENTER_NONE, NULL,
                                     0, c, ldc, params),
                 CATA_OK);
    LOCAL(compare)(layout, uplo, m, n, a, lda, 1.0, 0.0, c, before, ldc, weights);

    /* A A^T of the other layout's view is A^T A. */
    int32_t other = layout == CATA_ROW_MAJOR ? CATA_COL_MAJOR : CATA_ROW_MAJOR;
    int32_t flipped = uplo == CATA_UPPER ? CATA_LOWER : uplo == CATA_LOWER ? CATA_UPPER : uplo;
    CHECK_STATUS(NAME(cata_aat)(other, flipped, n, m, 1, a, lda, 0, c, ldc, params), CATA_OK);
    LOCAL(compare)(layout, uplo, m, n, a, lda, 1.0, 0.0, c, before, ldc, NULL);

    /* The check accepts it, and refuses it with one entry wrong. */
    int32_t passed = -1;
    double residual = -1.0, tolerance = -1.0;
    CHECK_STATUS(NAME(cata_verify)(layout, uplo, m, n, 1.0, a, lda, c, ldc, 20, 1, &passed,
                                   &residual, &tolerance),
                 CATA_OK);
    CHECK(passed == 1 && residual >= 0.0 && residual <= tolerance);
    if (m > 0 && n > 0) {
        c[LOCAL(at)(layout, ldc, n - 1, n - 1)] += (REAL)1.0;
        CHECK_STATUS(NAME(cata_verify)(layout, uplo, m, n, 1.0, a, lda, c, ldc, 20, 1, &passed,
                                       NULL, NULL),
                     CATA_OK);
        CHECK(passed == 0);
    }
    free(a);
    free(before);
    free(weights);
    free(scratch);
    free(c);
    free(d);
}

static void LOCAL(test_atb)(int32_t layout, size_t m, size_t n, size_t k,
                            const cata_ata_params *params)
{
    int rows = layout == CATA_ROW_MAJOR;
    size_t lda = (rows ? n : m) + 2, ldb = (rows ? k : m) + 1, ldc = (rows ? k : n) + 3;
    size_t len = LOCAL(len)(layout, n, k, ldc), scratch_len = 12345, wrong = 0;
    REAL *a = LOCAL(make)(LOCAL(len)(layout, m, n, lda), 1);
    REAL *b = LOCAL(make)(LOCAL(len)(layout, m, k, ldb), 2);
    REAL *before = LOCAL(make)(len, 3);
    REAL *c = LOCAL(copy)(before, len), *d = LOCAL(copy)(before, len);
    CHECK_STATUS(
        NAME(cata_atb)(layout, m, n, k, 2, a, lda, b, ldb, -1, c, ldc, params), CATA_OK);
    for (size_t at = 0; at < len; at++) {
        size_t major = at / ldc, minor = at % ldc;
        size_t i = rows ? major : minor, j = rows ? minor : major;
        double expected = (double)before[at];
        if (minor < (rows ? k : n)) {
            expected = 2.0 * LOCAL(dot)(layout, m, a, lda, i, b, ldb, j, NULL) - expected;
        }
        wrong += !(fabs((double)c[at] - expected) <= 16.0 * UNIT * (double)(m + 4));
    }
    CHECK(wrong == 0);
    CHECK_STATUS(NAME(cata_atb_scratch_len)(m, n, k, params, &scratch_len), CATA_OK);
    REAL *scratch = LOCAL(make)(scratch_len, 4);
    CHECK_STATUS(NAME(cata_atb_with_scratch)(layout, m, n, k, 2, a, lda, b, ldb, -1, d, ldc, scratch,
                                             scratch_len, params),
                 CATA_OK);
    CHECK(len == 0 || memcmp(c, d, len * sizeof(REAL)) == 0);
    free(a);
    free(b);
    free(before);
    free(c);
    free(d);
    free(scratch);
}

/* The scatter matrix: against the plain loop over centred rows; a given centre of the mean is the
 * same. */
static void LOCAL(test_centred)(void)
{
    enum { M = 53, N = 5 };
    REAL *a = LOCAL(make)(M * N, 1), c[N * N], d[N * N], mean[N], centred[M * N];
    for (size_t j = 0; j < N; j++) {
        double sum = 0.0;
        for (size_t i = 0; i < M; i++) {
            sum += (double)a[i * N + j];
        }
        mean[j] = (REAL)(sum / M);
        for (size_t i = 0; i < M; i++) {
            centred[i * N + j] = a[i * N + j] - mean[j];
        }
    }
    CHECK_STATUS(NAME(cata_ata_rows)(CATA_ROW_MAJOR, CATA_BOTH, M, N, 1, a, N, NULL,
                                     CATA_CENTER_MEAN, NULL, 0, c, N, NULL),
                 CATA_OK);
    LOCAL(compare)(CATA_ROW_MAJOR, CATA_BOTH, M, N, centred, N, 1.0, 0.0, c, c, N, NULL);
    CHECK_STATUS(NAME(cata_ata_rows)(CATA_ROW_MAJOR, CATA_BOTH, M, N, 1, a, N, NULL,
                                     CATA_CENTER_GIVEN, mean, 0, d, N, NULL),
                 CATA_OK);
    LOCAL(compare)(CATA_ROW_MAJOR, CATA_BOTH, M, N, centred, N, 1.0, 0.0, d, d, N, NULL);
    free(a);
}

/* Whole numbers whose sums of products the classical algorithm rounds on the way: with `reproducible`
 * every entry is the true sum, rounded once, in either layout and on any number of threads. */
static void LOCAL(test_reproducible)(size_t most_threads)
{
    enum { M = 83, N = 37, K = 34 };
    static const int32_t uplos[] = {CATA_UPPER, CATA_LOWER, CATA_BOTH};
    const int bits = sizeof(REAL) == sizeof(double) ? 28 : 14;
    static int64_t whole[M][N];
    REAL rows[M * N], columns[M * N], c[N * N], d[N * K];
    size_t wrong = 0, touched = 0, wrong_atb = 0, inexact = 0;
    unsigned state = 5;
    for (size_t i = 0; i < M; i++) {
        for (size_t j = 0; j < N; j++) {
            state = state * 1664525u + 1013904223u;
            whole[i][j] = (int64_t)(state >> (32 - bits)) - ((int64_t)1 << (bits - 1));
            rows[i * N + j] = columns[i + j * M] = (REAL)whole[i][j];
        }
    }
    cata_ata_params params = {.struct_size = sizeof params, .reproducible = 1};
    for (size_t run = 0; run < 2 * 2 * 3; run++) {
        params.threads = run % 2 == 0 ? 1 : most_threads;
        params.pin = run % 4 == 1;
        params.scheme = run % 3 == 0 ? CATA_SCHEME_AUTO : CATA_SCHEME_EXACT;
        int32_t layout = run / 2 % 2 == 0 ? CATA_ROW_MAJOR : CATA_COL_MAJOR, uplo = uplos[run / 4];
        const REAL *a = layout == CATA_ROW_MAJOR ? rows : columns;
        size_t lda = layout == CATA_ROW_MAJOR ? N : M, ldd = layout == CATA_ROW_MAJOR ? K : N;
        for (size_t i = 0; i < N * N; i++) {
            c[i] = (REAL)0.5;
        }
        CHECK_STATUS(NAME(cata_ata)(layout, uplo, M, N, 1, a, lda, 0, c, N, &params), CATA_OK);
        /* B: the first K columns of A. */
        CHECK_STATUS(NAME(cata_atb)(layout, M, N, K, 1, a, lda, a, lda, 0, d, ldd, &params), CATA_OK);
        for (size_t i = 0; i < N; i++) {
            for (size_t j = 0; j < N; j++) {
                int64_t sum = 0;
                REAL rounded = 0;
                for (size_t r = 0; r < M; r++) {
                    sum += whole[r][i] * whole[r][j];
                    rounded += (REAL)whole[r][i] * (REAL)whole[r][j];
                }
                REAL entry = c[LOCAL(at)(layout, N, i, j)];
                if (uplo == CATA_BOTH || (uplo == CATA_LOWER ? i >= j : i <= j)) {
                    wrong += entry != (REAL)sum;
                } else {
                    touched += entry != (REAL)0.5;
                }
                wrong_atb += j < K && d[LOCAL(at)(layout, ldd, i, j)] != (REAL)sum;
                inexact += rounded != (REAL)sum;
            }
        }
    }
    CHECK(wrong == 0);
    CHECK(touched == 0);
    CHECK(wrong_atb == 0);
    CHECK(inexact > 0); /* or the sums prove nothing */
}

/* Column 1 with a NaN and column 3 with an infinity: as in the classical algorithm, and entries of
 * other columns are the same bytes as without. */
static void LOCAL(test_exact_not_finite)(void)
{
    enum { M = 70, N = 5 };
    REAL *a = LOCAL(make)(M * N, 1), c[N * N], d[N * N];
    cata_ata_params params = {
        .struct_size = sizeof params, .threads = 1, .error_factor = CATA_ERROR_LEAST};
    CHECK_STATUS(NAME(cata_ata)(CATA_ROW_MAJOR, CATA_BOTH, M, N, 1, a, N, 0, c, N, &params), CATA_OK);
    params.scheme = CATA_SCHEME_EXACT; /* which the least error means */
    CHECK_STATUS(NAME(cata_ata)(CATA_ROW_MAJOR, CATA_BOTH, M, N, 1, a, N, 0, d, N, &params), CATA_OK);
    CHECK(memcmp(c, d, sizeof c) == 0);
    a[66 * N + 1] = (REAL)NAN;
    a[2 * N + 3] = (REAL)INFINITY;
    CHECK_STATUS(NAME(cata_ata)(CATA_ROW_MAJOR, CATA_BOTH, M, N, 1, a, N, 0, d, N, &params), CATA_OK);
    for (size_t i = 0; i < N; i++) {
        for (size_t j = 0; j < N; j++) {
            REAL entry = d[i * N + j];
            if (i == 1 || j == 1) {
                CHECK(isnan(entry));
            } else if (i == 3 || j == 3) {
                size_t other = i == 3 ? j : i;
                CHECK(isinf(entry) && (entry > 0) == (a[2 * N + other] > 0));
            } else {
                CHECK(memcmp(&entry, &c[i * N + j], sizeof entry) == 0);
            }
        }
    }
    free(a);
}

/* A batch, by distances and by pointers in another order, against single calls, bit by bit. */
static void LOCAL(test_batched)(int32_t layout, size_t m, size_t n)
{
    enum { COUNT = 7 };
    size_t lda = (layout == CATA_ROW_MAJOR ? n : m) + 2, ldc = n + 1;
    size_t stride_a = LOCAL(len)(layout, m, n, lda) + 3;
    size_t stride_c = LOCAL(len)(layout, n, n, ldc) + 2, len = COUNT * stride_c;
    REAL *a = LOCAL(make)(COUNT * stride_a, 1), *c = LOCAL(make)(len, 2);
    REAL *d = LOCAL(copy)(c, len), *e = LOCAL(copy)(c, len), *to[COUNT];
    const REAL *from[COUNT];
    for (size_t i = 0; i < COUNT; i++) {
        CHECK_STATUS(NAME(cata_ata)(layout, CATA_LOWER, m, n, 2, a + i * stride_a, lda, 1,
                                    c + i * stride_c, ldc, NULL),
                     CATA_OK);
        from[COUNT - 1 - i] = a + i * stride_a;
        to[COUNT - 1 - i] = e + i * stride_c;
    }
    CHECK_STATUS(NAME(cata_ata_batched)(layout, CATA_LOWER, COUNT, m, n, 2, a, lda, stride_a, 1, d,
                                        ldc, stride_c, NULL),
                 CATA_OK);
    CHECK(memcmp(c, d, len * sizeof(REAL)) == 0);
    CHECK_STATUS(NAME(cata_ata_batched_pointers)(layout, CATA_LOWER, COUNT, m, n, 2, from, lda, 1,
                                                 to, ldc, NULL),
                 CATA_OK);
    CHECK(memcmp(c, e, len * sizeof(REAL)) == 0);
    free(a);
    free(c);
    free(d);
    free(e);
}

static void LOCAL(test_all)(int quick)
{
    static const size_t all_sizes[] = {0, 1, 2, 7, 31, 127, 128, 257};
    static const int32_t layouts[] = {CATA_ROW_MAJOR, CATA_COL_MAJOR};
    static const int32_t uplos[] = {CATA_UPPER, CATA_LOWER, CATA_BOTH};
    size_t most = quick ? 5 : 8;
    cata_ata_params one_thread = {.struct_size = sizeof one_thread, .threads = 1};
    const cata_ata_params *params = quick ? &one_thread : NULL;
    for (size_t l = 0; l < 2; l++) {
        for (size_t mi = 0; mi < most; mi++) {
            for (size_t ni = 0; ni < most; ni++) {
                size_t m = all_sizes[mi], n = all_sizes[ni];
                if (m * n > 128 * 128) {
                    continue;
                }
                for (size_t u = 0; u < 3; u++) {
                    LOCAL(test_ata)(layouts[l], uplos[u], m, n, (mi + ni + u) % 2 * 3, params);
                }
                LOCAL(test_atb)(layouts[l], m, n, all_sizes[(mi + ni) % 5], params);
                if (mi < 5 && ni < 5) {
                    LOCAL(test_batched)(layouts[l], m, n);
                }
            }
        }
        /* Every scheme, with its recursion forced on a size it does not divide. */
        for (int32_t scheme = CATA_SCHEME_AUTO; scheme <= CATA_SCHEME_FLOAT; scheme++) {
            cata_ata_params forced;
            CHECK_STATUS(cata_ata_params_init(&forced, sizeof forced), CATA_OK);
            forced.scheme = scheme;
            forced.leaf = 8;
            forced.threads = quick ? 1 : 2;
            forced.error_factor = INFINITY;
            LOCAL(test_ata)(layouts[l], CATA_BOTH, 61, 59, 1, &forced);
            LOCAL(test_atb)(layouts[l], 61, 59, 43, &forced);
        }
    }
    LOCAL(test_centred)();
    LOCAL(test_reproducible)(quick ? 1 : 2);
    LOCAL(test_exact_not_finite)();
}
