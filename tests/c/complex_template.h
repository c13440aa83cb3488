/* The products of complex matrices in one precision. Wants REAL, NAME(base) for the library's
 * function and LOCAL(base) for a name of its own. Included once for each. Entries are small Gaussian
 * integers, so that every sum is exact. */

typedef REAL complex LOCAL(number);

static LOCAL(number) * LOCAL(make)(size_t len, unsigned seed)
{
    /* No room beyond the last element, so that Valgrind sees every step too far. */
    LOCAL(number) *x = malloc(len * sizeof *x + (len == 0));
    if (x == NULL) {
        fputs("out of memory\n", stderr);
        exit(2);
    }
    for (size_t i = 0; i < len; i++) {
        int part[2];
        for (int p = 0; p < 2; p++) {
            seed = seed * 1664525u + 1013904223u;
            part[p] = (int)(seed >> 24) % 9 - 4;
        }
        x[i] = (REAL)part[0] + (REAL)part[1] * I;
    }
    return x;
}

static LOCAL(number) LOCAL(dot)(int32_t layout, size_t m, const LOCAL(number) *a, size_t lda, size_t i,
                                const LOCAL(number) *b, size_t ldb, size_t j)
{
    LOCAL(number) sum = 0;
    for (size_t r = 0; r < m; r++) {
        sum += (LOCAL(number))conj(a[entry_at(layout, lda, r, i)]) * b[entry_at(layout, ldb, r, j)];
    }
    return sum;
}

/* Every element of C's memory: wanted entries are exact, others what they were. */
static void LOCAL(test_aha)(int32_t layout, int32_t uplo, size_t m, size_t n, size_t gap,
                            const cata_ata_params *params)
{
    const size_t lda = (layout == CATA_ROW_MAJOR ? n : m) + 1 + gap, ldc = n + 1 + gap;
    const size_t len = n == 0 ? 0 : (n - 1) * ldc + n;
    LOCAL(number) *a = LOCAL(make)(memory_len(layout, m, n, lda), 1);
    LOCAL(number) *before = LOCAL(make)(len, 2), *c = LOCAL(make)(len, 2);
    CHECK_STATUS(NAME(cata_aha)(layout, uplo, m, n, 2, (const REAL *)a, lda, -3, (REAL *)c, ldc, params),
                 CATA_OK);
    size_t wrong = 0, touched = 0;
    for (size_t at = 0; at < len; at++) {
        const size_t major = at / ldc, minor = at % ldc;
        const size_t i = layout == CATA_ROW_MAJOR ? major : minor;
        const size_t j = layout == CATA_ROW_MAJOR ? minor : major;
        if (minor >= n || (uplo == CATA_LOWER && i < j) || (uplo == CATA_UPPER && i > j)) {
            touched += c[at] != before[at];
            continue;
        }
        LOCAL(number) old = before[at];
        if (uplo == CATA_BOTH && i < j) {
            old = (LOCAL(number))conj(before[entry_at(layout, ldc, j, i)]);
        }
        const LOCAL(number) right = 2 * LOCAL(dot)(layout, m, a, lda, i, a, lda, j) - 3 * old;
        wrong += creal(c[at]) != creal(right) || cimag(c[at]) != (i == j ? 0 : cimag(right));
    }
    CHECK(wrong == 0);
    CHECK(touched == 0);
    free(a);
    free(before);
    free(c);
}

static void LOCAL(test_ahb)(int32_t layout, size_t m, size_t n, size_t k, int overwrite)
{
    const int rows = layout == CATA_ROW_MAJOR;
    const size_t lda = (rows ? n : m) + 2, ldb = (rows ? k : m) + 1, ldc = (rows ? k : n) + 3;
    const size_t len = memory_len(layout, n, k, ldc);
    LOCAL(number) *a = LOCAL(make)(memory_len(layout, m, n, lda), 3);
    LOCAL(number) *b = LOCAL(make)(memory_len(layout, m, k, ldb), 4);
    LOCAL(number) *before = LOCAL(make)(len, 5), *c = LOCAL(make)(len, 5);
    const LOCAL(number) alpha = 2 - 1 * I, beta = overwrite ? 0 : 1 + 2 * I;
    for (size_t at = 0; overwrite && at < len; at++) {
        c[at] = at % ldc < (rows ? k : n) ? (REAL)NAN : before[at];
    }
    CHECK_STATUS(NAME(cata_ahb)(layout, m, n, k, (const REAL *)&alpha, (const REAL *)a, lda,
                                (const REAL *)b, ldb, (const REAL *)&beta, (REAL *)c, ldc, NULL),
                 CATA_OK);
    size_t wrong = 0;
    for (size_t at = 0; at < len; at++) {
        const size_t major = at / ldc, minor = at % ldc;
        LOCAL(number) right = before[at];
        if (minor < (rows ? k : n)) {
            const size_t i = rows ? major : minor, j = rows ? minor : major;
            right = alpha * LOCAL(dot)(layout, m, a, lda, i, b, ldb, j) + beta * right;
        }
        wrong += !(c[at] == right);
    }
    CHECK(wrong == 0);
    free(a);
    free(b);
    free(before);
    free(c);
}

static void LOCAL(test_refusals)(void)
{
    const REAL a[12] = {1}, one[2] = {1, 0};
    REAL c[8] = {7};
    const int32_t row = CATA_ROW_MAJOR;
    CHECK_STATUS(NAME(cata_aha)(row, CATA_BOTH, 3, 2, 1, a, 1, 0, c, 2, NULL), CATA_ERR_SHAPE);
    CHECK(strstr(cata_last_error_message(), "lda") != NULL);
    CHECK_STATUS(NAME(cata_aha)(row, CATA_BOTH, 3, 2, 1, NULL, 2, 0, c, 2, NULL), CATA_ERR_NULL);
    CHECK_STATUS(NAME(cata_aha)(row, 7, 3, 2, 1, a, 2, 0, c, 2, NULL), CATA_ERR_ARGUMENT);
    CHECK_STATUS(NAME(cata_ahb)(row, 3, 2, 2, NULL, a, 2, a, 2, one, c, 2, NULL), CATA_ERR_NULL);
    CHECK(strstr(cata_last_error_message(), "alpha") != NULL);
    CHECK_STATUS(NAME(cata_ahb)(row, 3, 2, 2, one, a, 2, a, 2, NULL, c, 2, NULL), CATA_ERR_NULL);
    CHECK_STATUS(NAME(cata_ahb)(row, 3, 2, 2, one, a, 2, a, 2, one, c, 1, NULL), CATA_ERR_SHAPE);
    CHECK(strstr(cata_last_error_message(), "ldc") != NULL);
    /* A size that fits in memory as reals, but not as complex numbers. */
    const size_t most = (size_t)PTRDIFF_MAX / sizeof(REAL);
    CHECK_STATUS(NAME(cata_aha)(row, CATA_LOWER, most, 1, 1, a, 1, 0, c, 1, NULL), CATA_ERR_SHAPE);
    CHECK(c[0] == 7);
    CHECK_STATUS(NAME(cata_aha)(row, CATA_BOTH, 0, 0, 1, NULL, 1, 0, NULL, 1, NULL), CATA_OK);
}

static void LOCAL(test_all)(int quick)
{
    static const size_t all_sizes[] = {0, 1, 2, 7, 31, 67, 129};
    static const int32_t layouts[] = {CATA_ROW_MAJOR, CATA_COL_MAJOR};
    static const int32_t uplos[] = {CATA_UPPER, CATA_LOWER, CATA_BOTH};
    const size_t most = quick ? 5 : 7;
    cata_ata_params params = {.struct_size = sizeof params, .threads = 1};
    for (size_t l = 0; l < 2; l++) {
        for (size_t m = 0; m < most; m++) {
            for (size_t n = 0; n < most; n++) {
                for (size_t u = 0; u < 3; u++) {
                    params.threads = quick ? 1 : u + 1;
                    params.reproducible = (m + n) % 3 == 0;
                    LOCAL(test_aha)(layouts[l], uplos[u], all_sizes[m], all_sizes[n], u, &params);
                }
                if (!quick) {
                    LOCAL(test_ahb)(layouts[l], all_sizes[m], all_sizes[n], all_sizes[(m + n) % 6],
                                    (m + n) % 2 == 0);
                }
            }
        }
    }
    LOCAL(test_refusals)();
}
